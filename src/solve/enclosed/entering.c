/* Light that enters an interior: of lights, and of other surfaces along rays. */
#include "base/context.h"
#include "base/parallel.h"
#include "scene/bsdf/fresnel.k.h"
#include "solve/enclosed/body.h"

#include <math.h>
#include <string.h>

/* Sums are made by as many tasks, whatever the number of threads, and added in order. */
enum { TASKS = 4 };
/* Maximum number of surfaces of dielectrics that a shadow ray passes. */
enum { MAX_PASSED = 16 };
/* Mean cosine below which a direction of an environment stands for a part of it, not for a sun. */
static const float wide_cosine = 0.999f;

typedef struct entering {
    ty_enclosed_body* body;
    const ty_discrete_light_set* lights;
    int32_t per_side;  /* rays of a side, of which those that meet surfaces are traced */
    int64_t ray_count; /* of surfaces: rays, their sides and their radiance */
    const double *rays, *radiance;
    const int32_t* side;
    const float* passed;
    float shadow_offset; /* of shadow rays from points of surface lights, m */
    ty_enclosed_sums sums[TASKS];
} entering;

/* ---- sums ---- */

static ty_result allocate_sums(entering* e) {
    const size_t items = e->body->cells * (size_t)e->body->terms;
    for (int task = 0; task < TASKS; ++task)
        for (int c = 0; c < 3; ++c) {
            e->sums[task].moments[c] = ty_alloc_array(e->body->context, items, sizeof(float), true);
            if (e->sums[task].moments[c] == NULL) return TY_ERROR_MEMORY;
        }
    return TY_OK;
}

static void free_sums(entering* e) {
    const size_t items = e->body->cells * (size_t)e->body->terms;
    for (int task = 0; task < TASKS; ++task)
        for (int c = 0; c < 3; ++c) ty_free_array(e->body->context, e->sums[task].moments[c], items, sizeof(float));
}

/* Totals as moments of the cells' means. */
static void add_sums(entering* e, int source, float* const moments[3]) {
    ty_enclosed_body* body = e->body;
    const size_t items = body->cells * (size_t)body->terms;
    const float inverse = (float)(1 / (body->cell[0] * body->cell[1] * body->cell[2]));
    for (int c = 0; c < 3; ++c) {
        body->entering[source][c] = body->leaving[source][c] = body->unscattered[source][c] = 0;
        memset(moments[c], 0, sizeof(float) * items);
        for (int task = 0; task < TASKS; ++task) {
            body->entering[source][c] += e->sums[task].entering[c];
            body->leaving[source][c] += e->sums[task].leaving[c];
            body->unscattered[source][c] += e->sums[task].unscattered[c];
            for (size_t i = 0; i < items; ++i) moments[c][i] += inverse * e->sums[task].moments[c][i];
        }
    }
}

/* ---- lights ---- */

/* Follows a ray through other smooth dielectrics, without refraction, to the surface that ends it: origin, where it
 * left the last of them; returns the fraction of light that passes. hit->surface is -1 where nothing ends it. wide: of
 * even light, where what a glass before the surface reflects comes back from its other side, but not what a glass that
 * covers the surface does. */
static float pass_dielectrics(const ty_enclosed_body* body, ty_vec* origin, ty_vec w, float far, bool wide,
                              ty_hit* hit) {
    const ty_scene_view* scene = body->scene;
    float passed = 1;
    for (int i = 0; i < MAX_PASSED && ty_accel_intersect(scene->mesh, *origin, w, far, hit); ++i) {
        const ty_surface_gloss* gloss = scene->surfaces[hit->surface].gloss;
        const bool solid = gloss != NULL && gloss->dielectric.solid != 0;
        if (!solid || gloss->dielectric.interior == body->interior ||
            scene->interiors[gloss->dielectric.interior].scatters != 0)
            return passed;
        const float cosine = ty_dot(hit->normal, w);
        if (!wide || (i == 0 && cosine > 0)) passed *= 1 - ty_fresnel_dielectric(fabsf(cosine), gloss->dielectric.ior);
        *origin = ty_hit_leave(hit, w);
        far -= hit->distance;
    }
    hit->surface = -1;
    return passed;
}

/* Fraction of light that passes along a ray, 0 behind surfaces that end it. */
static float visibility(const ty_enclosed_body* body, ty_vec origin, ty_vec w, float far, bool wide) {
    ty_hit hit;
    const float passed = pass_dielectrics(body, &origin, w, far, wide, &hit);
    return hit.surface < 0 ? passed : 0;
}

/* True for a direction that stands for a part of an environment of some width. */
static bool is_wide(const ty_discrete_light* light) {
    return light->kind == TY_DISCRETE_DIRECTIONAL && light->mean_cosine < wide_cosine;
}

/* Direction of travel and irradiance across the beam of a light at a side, without media outside; false: none. */
static bool light_beam(const entering* e, const ty_enclosed_side* side, const ty_discrete_light* light, ty_vec* w,
                       float irradiance[3]) {
    float factor = 1, far = TY_FLOAT_MAX;
    const ty_vec origin = ty_mad(side->position, side->normal, side->margin);
    *w = light->direction;
    if (light->kind == TY_DISCRETE_POINT) {
        const ty_light_view* view = &e->body->scene->lights.lights[light->light];
        ty_vec off = ty_sub(light->position, side->position);
        const float square = ty_dot(off, off);
        if (!(square > 0)) return false;
        const float mu = -ty_dot(light->direction, off) / sqrtf(square);
        factor = ty_light_profile_at(light->profile, view, mu) / (square + light->area / TY_PI);
        if (light->is_point == 0) off = ty_mad(off, light->direction, mu < 0 ? -e->shadow_offset : e->shadow_offset);
        far = sqrtf(ty_dot(off, off));
        *w = ty_scale(off, -1 / far);
    }
    if (!(ty_dot(*w, side->normal) < 0) || !(factor > 0)) return false;
    factor *= visibility(e->body, origin, ty_scale(*w, -1), far, is_wide(light));
    for (int c = 0; c < 3; ++c) irradiance[c] = factor * light->color[c];
    return factor > 0;
}

static void light_sides(void* user, int64_t task, int32_t worker) {
    (void)worker;
    entering* e = user;
    for (int32_t i = (int32_t)task; i < e->body->side_count; i += TASKS)
        for (int32_t l = 0; l < e->lights->count && e->body->sides[i].cell >= 0; ++l) {
            ty_vec w;
            float irradiance[3];
            if (light_beam(e, &e->body->sides[i], &e->lights->items[l], &w, irradiance))
                ty_enclosed_trace_beam(e->body, &e->sums[task], i, w, irradiance);
        }
}

ty_result ty_enclosed_add_lights(ty_enclosed_body* body, const ty_discrete_light_set* lights) {
    entering e = {.body = body, .lights = lights, .shadow_offset = 1e-3f * (float)body->cell[0]};
    const ty_result result = allocate_sums(&e);
    if (result == TY_OK) ty_parallel_flushed(body->context, TASKS, light_sides, &e);
    if (result == TY_OK) add_sums(&e, 0, body->of_lights);
    free_sums(&e);
    return result;
}

/* ---- other surfaces ---- */

/* Rays over the hemisphere of a side, in proportion to the cosine, that a surface ends; passed: the fraction of its
 * light that dielectrics before it transmit. */
static int64_t find_rays(const ty_enclosed_body* body, const ty_sobol* sobol, int32_t side, int32_t per_side,
                         double* rays, int32_t* sides, float* passed) {
    const ty_enclosed_side* s = &body->sides[side];
    ty_vec u, v;
    int64_t count = 0;
    ty_onb(s->normal, &u, &v);
    for (int32_t i = 0; i < per_side && s->cell >= 0; ++i) {
        ty_sampler random = ty_sampler_begin(sobol, body->def->seed, (uint64_t)side, (uint32_t)i);
        const float square = ty_sobol_next(&random), turn = 2 * TY_PI * ty_sobol_next(&random), r = sqrtf(square);
        ty_vec w = ty_scale(s->normal, sqrtf(1 - square));
        w = ty_normalize(ty_mad(ty_mad(w, u, r * cosf(turn)), v, r * sinf(turn)));
        ty_vec origin = ty_mad(s->position, s->normal, s->margin);
        ty_hit hit;
        passed[count] = pass_dielectrics(body, &origin, w, TY_FLOAT_MAX, true, &hit);
        if (hit.surface < 0) continue;
        double* ray = rays + 6 * count;
        const float numbers[6] = {origin.x, origin.y, origin.z, -w.x, -w.y, -w.z};
        for (int k = 0; k < 6; ++k) ray[k] = (double)numbers[k];
        sides[count++] = side;
    }
    return count;
}

/* Emission that a ray meets, which counts among the lights. */
static void subtract_emission(const ty_enclosed_body* body, const double* ray, double* radiance) {
    const ty_vec origin = ty_vec_make((float)ray[0], (float)ray[1], (float)ray[2]);
    const ty_vec w = ty_vec_make((float)-ray[3], (float)-ray[4], (float)-ray[5]);
    ty_hit hit;
    ty_surface_point point;
    if (!ty_accel_intersect(body->scene->mesh, origin, w, TY_FLOAT_MAX, &hit)) return;
    ty_surface_evaluate(&body->scene->surfaces[hit.surface], &hit, w, &point);
    for (int c = 0; c < 3; ++c) radiance[c] = fmax(0, radiance[c] - (double)point.emission[c]);
}

static void trace_rays(void* user, int64_t task, int32_t worker) {
    (void)worker;
    entering* e = user;
    const ty_enclosed_body* body = e->body;
    for (int64_t i = 0; i < e->ray_count; ++i) {
        const double* ray = e->rays + 6 * i;
        double radiance[3] = {e->radiance[3 * i], e->radiance[3 * i + 1], e->radiance[3 * i + 2]};
        if (e->side[i] % TASKS != task) continue;
        const ty_vec w = ty_vec_make((float)ray[3], (float)ray[4], (float)ray[5]);
        const float cosine = -ty_dot(w, body->sides[e->side[i]].normal);
        float irradiance[3];
        subtract_emission(body, ray, radiance);
        /* Each ray stands for the solid angle pi / (cosine rays). */
        for (int c = 0; c < 3; ++c)
            irradiance[c] = e->passed[i] * (float)radiance[c] * TY_PI / (ty_maxf(cosine, 1e-4f) * (float)e->per_side);
        ty_enclosed_trace_beam(e->body, &e->sums[task], e->side[i], w, irradiance);
    }
}

ty_result ty_enclosed_add_surfaces(ty_enclosed_body* body, const ty_enclosed_field* fields, int32_t per_side,
                                   int64_t* rays) {
    const size_t capacity = (size_t)body->side_count * (size_t)per_side;
    entering e = {.body = body, .per_side = per_side};
    double* ends = ty_alloc_array(body->context, capacity, 6 * sizeof(double), false);
    double* radiance = ty_alloc_array(body->context, capacity, 3 * sizeof(double), false);
    int32_t* sides = ty_alloc_array(body->context, capacity, sizeof *sides, false);
    float* passed = ty_alloc_array(body->context, capacity, sizeof *passed, false);
    ty_sobol sobol;
    ty_sobol_matrices(&sobol);
    ty_result result =
        ends != NULL && radiance != NULL && sides != NULL && passed != NULL ? allocate_sums(&e) : TY_ERROR_MEMORY;
    for (int32_t i = 0; i < body->side_count && result == TY_OK; ++i)
        e.ray_count +=
            find_rays(body, &sobol, i, per_side, ends + 6 * e.ray_count, sides + e.ray_count, passed + e.ray_count);
    if (result == TY_OK && e.ray_count > 0) {
        result = body->def->radiance(body->def->user, fields, ends, e.ray_count, radiance);
        e.rays = ends;
        e.radiance = radiance;
        e.side = sides;
        e.passed = passed;
        if (result == TY_OK) ty_parallel_flushed(body->context, TASKS, trace_rays, &e);
    }
    if (result == TY_OK) add_sums(&e, 1, body->of_surfaces);
    *rays += e.ray_count;
    free_sums(&e);
    ty_free_array(body->context, ends, capacity, 6 * sizeof(double));
    ty_free_array(body->context, radiance, capacity, 3 * sizeof(double));
    ty_free_array(body->context, sides, capacity, sizeof *sides);
    ty_free_array(body->context, passed, capacity, sizeof *passed);
    return result;
}
