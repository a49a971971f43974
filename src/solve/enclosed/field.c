/* The field of all light of an interior, from its cells continued to those beyond the surface, so that paths find
 * values up to the surface. */
#include "base/parallel.h"
#include "scene/bsdf/fresnel.k.h"
#include "solve/enclosed/body.h"

#include <math.h>

/* Neighbours along an axis: the cell beside and the one behind it. */
typedef struct pair {
    size_t near, far;
    bool has_near, has_far;
} pair;

static pair find_pair(const ty_enclosed_body* body, const int32_t at[3], int axis, int32_t step) {
    const size_t steps[3] = {1, (size_t)body->size[0], (size_t)body->size[0] * (size_t)body->size[1]};
    const int32_t one = at[axis] + step, two = one + step;
    const size_t here = ((size_t)at[2] * (size_t)body->size[1] + (size_t)at[1]) * (size_t)body->size[0] + (size_t)at[0];
    pair p = {.near = here + (size_t)step * steps[axis], .far = here + 2 * (size_t)step * steps[axis]};
    p.has_near = one >= 0 && one < body->size[axis] && body->inside[p.near] != 0;
    p.has_far = p.has_near && two >= 0 && two < body->size[axis] && body->inside[p.far] != 0;
    return p;
}

/* Mean over the axes of linear continuations, at least half of the cell beside. */
static void continue_cell(ty_enclosed_body* body, const int32_t at[3], size_t cell) {
    const size_t terms = (size_t)body->terms;
    int32_t count = 0;
    for (int i = 0; i < 6; ++i) {
        const pair p = find_pair(body, at, i / 2, (i & 1) != 0 ? 1 : -1);
        if (!p.has_near) continue;
        ++count;
        for (int c = 0; c < 3; ++c) {
            float* field = body->field[c];
            const float near = field[p.near * terms], far = p.has_far ? field[p.far * terms] : near;
            const float factor = near > 0 ? fminf(fmaxf(2 - far / near, 0.5f), 1.5f) : 1;
            for (size_t t = 0; t < terms; ++t) field[cell * terms + t] += factor * field[p.near * terms + t];
        }
    }
    for (int c = 0; c < 3 && count > 0; ++c)
        for (size_t t = 0; t < terms; ++t) body->field[c][cell * terms + t] /= (float)count;
    body->near_cell[cell] = count > 0;
}

void ty_enclosed_fill_field(ty_enclosed_body* body) {
    const size_t terms = (size_t)body->terms;
    for (size_t i = 0; i < body->cells; ++i) {
        const bool inside = body->inside[i] != 0;
        body->near_cell[i] = inside;
        for (int c = 0; c < 3; ++c)
            for (size_t t = 0; t < terms; ++t) {
                const size_t at = i * terms + t;
                body->field[c][at] =
                    inside ? body->of_lights[c][at] + body->of_surfaces[c][at] + body->solved[c][t * body->cells + i]
                           : 0;
            }
    }
    for (size_t i = 0; i < body->cells; ++i) {
        const int32_t at[3] = {(int32_t)(i % (size_t)body->size[0]),
                               (int32_t)(i / (size_t)body->size[0] % (size_t)body->size[1]),
                               (int32_t)(i / ((size_t)body->size[0] * (size_t)body->size[1]))};
        if (body->inside[i] == 0) continue_cell(body, at, i);
    }
}

/* ---- balance ---- */

/* Directions per side, and points per direction, at equal steps of the probability of a collision. */
enum { DIRECTIONS = 6, POINTS = 4, TASKS = 16 };

typedef struct emergence {
    const ty_enclosed_body* body;
    const ty_enclosed_field* field;
    const ty_sobol* sobol;
    double power[TASKS][3];
} emergence;

/* Distance from a side to the surface beyond along an inward direction. */
static float depth_of(const ty_enclosed_body* body, const ty_enclosed_side* side, ty_vec inward) {
    const ty_vec origin = ty_mad(side->position, side->normal, -side->margin);
    ty_hit hit;
    return ty_enclosed_meet_surface(body, origin, inward, TY_FLOAT_MAX, &hit) ? hit.distance : 0;
}

/* Adds the radiance of scattered light that leaves a side against a direction outside, as paths gather it. */
static void add_direction(const emergence* e, const ty_enclosed_side* side, ty_vec w, double power[3]) {
    const ty_enclosed_body* body = e->body;
    const float ior = body->scene->interiors[body->interior].ior;
    const float transmitted = 1 - ty_fresnel_dielectric(ty_minf(ty_dot(w, side->normal), 1), ior);
    const ty_vec inward = ty_refract(w, side->normal, ior);
    const double factor = (double)(side->area * TY_PI * transmitted / (DIRECTIONS * POINTS * ior * ior));
    const float depth = depth_of(body, side, inward);
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < POINTS; ++i) {
            const float sigma = body->extinction[c][side->cell], scattering = body->scattering[c][side->cell];
            const float distance = -log1pf(-((float)i + 0.5f) / POINTS) / ty_maxf(sigma, 1e-6f);
            const ty_vec point = ty_mad(side->position, inward, distance);
            float radiance[3];
            if (i > 0 && distance > depth) break;
            ty_enclosed_radiance(e->field, point, ty_scale(inward, -1), radiance);
            power[c] += factor * (double)(radiance[c] * scattering / ty_maxf(sigma, 1e-6f));
        }
}

static void add_sides(void* user, int64_t task, int32_t worker) {
    (void)worker;
    emergence* e = user;
    for (int32_t i = (int32_t)task; i < e->body->side_count; i += TASKS) {
        const ty_enclosed_side* side = &e->body->sides[i];
        for (int32_t k = 0; k < DIRECTIONS && side->cell >= 0; ++k) {
            ty_sampler random = ty_sampler_begin(e->sobol, e->body->def->seed, (uint64_t)i, (uint32_t)k);
            const float square = ty_sobol_next(&random), turn = ty_sobol_next(&random);
            add_direction(e, side, ty_direction_about(side->normal, sqrtf(1 - square), turn), e->power[task]);
        }
    }
}

void ty_enclosed_balance_field(ty_enclosed_body* body, const ty_enclosed_field* field, const double leaving[3]) {
    ty_sobol sobol;
    ty_sobol_matrices(&sobol);
    emergence e = {.body = body, .field = field, .sobol = &sobol};
    ty_parallel_flushed(body->context, TASKS, add_sides, &e);
    for (int c = 0; c < 3; ++c) {
        double power = 0;
        for (int task = 0; task < TASKS; ++task) power += e.power[task][c];
        const double scattered = leaving[c] - body->unscattered[0][c] - body->unscattered[1][c];
        const float factor = power > 0 ? (float)fmin(fmax(scattered / power, 0.1), 10) : 1;
        for (size_t i = 0; i < body->cells * (size_t)body->terms; ++i) body->field[c][i] *= factor;
    }
}
