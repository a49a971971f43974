/* A beam of uncollided light through the cells of an interior. */
#include "scene/bsdf/fresnel.k.h"
#include "solve/enclosed/body.h"

#include <math.h>

/* Internal reflections at most; transmittance below which the remaining light collides in its cell. */
enum { MAX_REFLECTIONS = 8 };
static const float min_transmittance = 0.01f;

typedef struct beam {
    const ty_enclosed_body* body;
    ty_enclosed_sums* sums;
    ty_vec origin, direction;
    float power[3], start; /* W; the brightest channel at the start */
    float unscattered[3];  /* W at the last surface, and optical depth since, by the true extinction */
    float depth[3];
    float y[TY_SH_TERMS_MAX];
    size_t cell; /* where it collides: the last cell inside */
    bool ended;
} beam;

static float brightest(const float power[3]) {
    return ty_maxf(power[0], ty_maxf(power[1], power[2]));
}

/* (1 - exp(-x)) / x for x >= 0, of which y is the exponential. */
static float mean_transmittance(float x, float y) {
    return x > 0.01f ? (1 - y) / x : 1 - x * (0.5f - x * (1 / 6.0f));
}

/* Fluence along a segment, and the power that collides there; length TY_FLOAT_MAX: all of it. */
static void collide(beam* b, float length) {
    const ty_enclosed_body* body = b->body;
    const bool last = !(length < TY_FLOAT_MAX);
    for (int c = 0; c < 3; ++c) {
        const float sigma = ty_enclosed_scaled(body, c, b->cell), x = sigma * length;
        const float transmittance = last ? 0 : ty_expf(-x);
        const float fluence =
            last ? (sigma > 0 ? b->power[c] / sigma : 0) : b->power[c] * length * mean_transmittance(x, transmittance);
        float* moments = b->sums->moments[c] + b->cell * (size_t)body->terms;
        b->power[c] *= transmittance;
        b->depth[c] += body->extinction[c][b->cell] * length;
        for (int32_t t = 0; t < body->terms; ++t) moments[t] += fluence * b->y[t];
    }
    b->ended = last || brightest(b->power) == 0;
}

/* Marches to the surface, or until the light is gone; *hit: of the surface. False if no surface ends the ray. */
static bool march(beam* b, ty_hit* hit) {
    const ty_enclosed_body* body = b->body;
    const float origin[3] = {b->origin.x, b->origin.y, b->origin.z};
    const float direction[3] = {b->direction.x, b->direction.y, b->direction.z};
    int32_t at[3], step[3];
    float next[3], step_t[3], t = 0, end = TY_FLOAT_MAX;
    bool knows_end = false, found = false;
    for (int a = 0; a < 3; ++a) {
        const float edge = (float)body->cell[a], low = (float)body->lower[a];
        at[a] = (int32_t)floorf((origin[a] - low) / edge);
        step[a] = direction[a] < 0 ? -1 : 1;
        step_t[a] = direction[a] != 0 ? edge / fabsf(direction[a]) : TY_FLOAT_MAX;
        const float face = low + edge * (float)(at[a] + (direction[a] > 0 ? 1 : 0));
        next[a] = direction[a] != 0 ? ty_maxf((face - origin[a]) / direction[a], 0) : TY_FLOAT_MAX;
    }
    for (;;) {
        bool within = true;
        for (int a = 0; a < 3; ++a) within = within && at[a] >= 0 && at[a] < body->size[a];
        const size_t cell =
            within ? ((size_t)at[2] * (size_t)body->size[1] + (size_t)at[1]) * (size_t)body->size[0] + (size_t)at[0]
                   : 0;
        if (within && body->inside[cell] != 0) {
            b->cell = cell;
        } else if (!knows_end) {
            knows_end = true;
            found = ty_enclosed_meet_surface(body, b->origin, b->direction, TY_FLOAT_MAX, hit);
            end = found ? ty_maxf(hit->distance, t) : t;
        }
        const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
        const float leave = ty_minf(next[axis], end);
        collide(b, leave - t);
        if (b->ended || leave >= end) return found;
        if (brightest(b->power) < min_transmittance * b->start) {
            collide(b, TY_FLOAT_MAX);
            return found;
        }
        t = leave;
        at[axis] += step[axis];
        next[axis] += step_t[axis];
    }
}

/* Splits the light at the surface into refracted and reflected light; the beam ends at other surfaces, which absorb it.
 */
static void meet_surface(beam* b, const ty_hit* hit) {
    const ty_interior* interior = &b->body->scene->interiors[b->body->interior];
    const float cosine = ty_dot(b->direction, hit->normal);
    float reflectance = 0;
    if (hit->surface == interior->surface && cosine > 0)
        reflectance = ty_fresnel_dielectric(ty_minf(cosine, 1), 1 / interior->ior);
    for (int c = 0; c < 3; ++c) {
        b->sums->leaving[c] += (double)(b->power[c] * (1 - reflectance));
        b->power[c] *= reflectance;
        b->unscattered[c] *= ty_expf(-b->depth[c]);
        b->depth[c] = 0;
        b->sums->unscattered[c] += (double)(b->unscattered[c] * (1 - reflectance));
        b->unscattered[c] *= reflectance;
    }
    b->direction = ty_normalize(ty_reflect(ty_scale(b->direction, -1), hit->normal));
    b->origin = ty_hit_leave(hit, b->direction);
    b->ended = !(brightest(b->power) > min_transmittance * b->start);
}

void ty_enclosed_trace_beam(const ty_enclosed_body* body, ty_enclosed_sums* sums, int32_t side, ty_vec direction,
                            const float irradiance[3]) {
    const ty_enclosed_side* s = &body->sides[side];
    const float cosine = -ty_dot(direction, s->normal), ior = body->scene->interiors[body->interior].ior;
    beam b = {.body = body, .sums = sums, .cell = (size_t)s->cell};
    if (!(cosine > 0)) return;
    const float entering = 1 - ty_fresnel_dielectric(ty_minf(cosine, 1), ior);
    for (int c = 0; c < 3; ++c) {
        b.power[c] = b.unscattered[c] = irradiance[c] * cosine * s->area * entering;
        sums->entering[c] += (double)b.power[c];
    }
    b.start = brightest(b.power);
    if (!(b.start > 0)) return;
    b.direction = ty_refract(ty_scale(direction, -1), s->normal, ior);
    b.origin = ty_mad(s->position, s->normal, -s->margin);
    for (int i = 0; i < MAX_REFLECTIONS && !b.ended; ++i) {
        ty_hit hit;
        ty_sh_all(b.direction, b.y);
        if (!march(&b, &hit)) break;
        if (!b.ended) meet_surface(&b, &hit);
    }
    for (int c = 0; c < 3; ++c) sums->leaving[c] += (double)b.power[c];
}
