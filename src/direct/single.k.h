/* What a ray through cells sees of light that scatters once, with the phase function as it is. */
#ifndef TY_DIRECT_SINGLE_K_H
#define TY_DIRECT_SINGLE_K_H

#include "direct/beam.k.h"
#include "scene/medium.k.h"
#include "scene/phase.k.h"

/* Uncollided light of one source, or of many together. */
typedef struct ty_single_light {
    int32_t kind;  /* one of the below */
    ty_vec toward; /* TY_SINGLE_BEAM: the way light travels, unit; TY_SINGLE_LAMP: where it comes from, m */
    TY_GLOBAL const float* fluence[3]; /* per channel, W m^-2 */
    TY_GLOBAL const float* flux[3][3]; /* TY_SINGLE_MANY: along x, y, z */
    int32_t shared;                    /* whether all channels are the first one's planes, times color (as in a
                                          ty_light_field of one plane) */
    float color[3];
} ty_single_light;

/* Of TY_SINGLE_MANY only the mean direction is known: light scatters as (fluence + 3 g flux . way) / (4 pi), not below
 * 0, which is exact for isotropic scattering. */
enum { TY_SINGLE_BEAM = 0, TY_SINGLE_LAMP = 1, TY_SINGLE_MANY = 2 };

/* A medium on cells with light in it. */
typedef struct ty_single_view {
    int32_t size[3];
    ty_vec lower, per_cell; /* m; cells per m */
    TY_GLOBAL const float* extinction[3];
    TY_GLOBAL const float* scattering[3];
    TY_GLOBAL const float* g[3];
    TY_GLOBAL const ty_single_light* lights;
    int32_t light_count;
} ty_single_view;

/* A point between the middles of cells; beyond the outer ones light is as it is there. */
typedef struct ty_cell_point {
    size_t base;    /* the lowest of eight cells */
    size_t step[3]; /* to the next along each axis, 0 at the upper edge */
    float share[3];
} ty_cell_point;

TY_FN ty_cell_point ty_cell_locate(const int32_t size[3], ty_vec cells) {
    const float at[3] = {cells.x - 0.5f, cells.y - 0.5f, cells.z - 0.5f};
    size_t stride = 1;
    ty_cell_point point;
    point.base = 0;
    for (int32_t a = 0; a < 3; ++a) {
        const float from = ty_clampf(at[a], 0.0f, (float)(size[a] - 1));
        const int32_t cell = (int32_t)from;
        point.share[a] = from - (float)cell;
        point.base += stride * (size_t)cell;
        point.step[a] = cell + 1 < size[a] ? stride : 0;
        stride *= (size_t)size[a];
    }
    return point;
}

TY_FN float ty_cell_value(TY_GLOBAL const float* plane, const ty_cell_point* p) {
    float layer[2];
    for (int k = 0; k < 2; ++k) {
        TY_GLOBAL const float* row = plane + p->base + (k != 0 ? p->step[2] : 0);
        const float first = ty_share_between(row[0], row[p->step[0]], p->share[0]);
        row += p->step[1];
        layer[k] = ty_share_between(first, ty_share_between(row[0], row[p->step[0]], p->share[0]), p->share[1]);
    }
    return ty_share_between(layer[0], layer[1], p->share[2]);
}

/* Light that a point scatters along `way`, per scattering coefficient. */
TY_FN void ty_single_scattered(const ty_single_light* light, ty_vec point, const ty_cell_point* at, ty_vec way,
                               const float g[3], float scattered[3]) {
    const int32_t planes = light->shared != 0 ? 1 : 3;
    float fluence[3], forward[3] = {0.0f, 0.0f, 0.0f};
    for (int32_t c = 0; c < planes; ++c) {
        fluence[c] = ty_cell_value(light->fluence[c], at);
        if (light->kind == TY_SINGLE_MANY)
            forward[c] = ty_cell_value(light->flux[c][0], at) * way.x + ty_cell_value(light->flux[c][1], at) * way.y +
                         ty_cell_value(light->flux[c][2], at) * way.z;
    }
    for (int32_t c = 2; c >= 0 && light->shared != 0; --c) {
        fluence[c] = fluence[0] * light->color[c];
        forward[c] = forward[0] * light->color[c];
    }
    if (light->kind == TY_SINGLE_MANY) {
        for (int32_t c = 0; c < 3; ++c)
            scattered[c] += TY_INV_4PI * ty_maxf(0.0f, fluence[c] + 3.0f * g[c] * forward[c]);
        return;
    }
    ty_vec from = light->toward;
    if (light->kind == TY_SINGLE_LAMP) {
        const ty_vec off = ty_sub(point, light->toward);
        from = ty_scale(off, 1.0f / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f)));
    }
    const float mu = ty_dot(from, way);
    float phase = 0.0f;
    for (int32_t c = 0; c < 3; ++c) {
        if (c == 0 || g[c] != g[c - 1]) phase = ty_hg(mu, g[c]);
        scattered[c] += phase * fluence[c];
    }
}

/* A stretch of the ray within one cell. */
typedef struct ty_cell_walk {
    float at, leave; /* along the ray, m */
    int32_t cell[3], step[3];
    float next[3], per_cell[3];
} ty_cell_walk;

TY_FN void ty_cell_walk_axis(ty_cell_walk* walk, const ty_single_view* view, int32_t a, float o, float d) {
    const float at = o + d * walk->at;
    const int32_t cell = (int32_t)ty_clampf(at, 0.0f, (float)(view->size[a] - 1));
    walk->cell[a] = cell;
    walk->step[a] = d > 0.0f ? 1 : -1;
    walk->next[a] = d != 0.0f ? ((float)(d > 0.0f ? cell + 1 : cell) - o) / d : TY_FLOAT_MAX;
    walk->per_cell[a] = d != 0.0f ? fabsf(1.0f / d) : 0.0f;
}

/* Adds the light that scatters once, and then towards the ray's origin, between *near and far along a ray (direction:
 * unit, away from the eye) to radiance[3], W m^-2 sr^-1, and multiplies transmittance[3] by what passes. Extinction is
 * even in each cell, and there light is taken in the middle of the ray's stretch, between cells' middles. */
TY_FN void ty_single_scattering(const ty_single_view* view, ty_vec origin, ty_vec direction, float near, float far,
                                float radiance[3], float transmittance[3]) {
    const ty_vec from = ty_sub(origin, view->lower);
    const ty_vec o = ty_vec_make(from.x * view->per_cell.x, from.y * view->per_cell.y, from.z * view->per_cell.z);
    const ty_vec d =
        ty_vec_make(direction.x * view->per_cell.x, direction.y * view->per_cell.y, direction.z * view->per_cell.z);
    const ty_vec high = ty_vec_make((float)view->size[0], (float)view->size[1], (float)view->size[2]);
    const ty_vec way = ty_scale(direction, -1.0f);
    if (!ty_clip_box(o, d, ty_vec_make(0, 0, 0), high, &near, &far)) return;
    ty_cell_walk walk;
    walk.at = near;
    ty_cell_walk_axis(&walk, view, 0, o.x, d.x);
    ty_cell_walk_axis(&walk, view, 1, o.y, d.y);
    ty_cell_walk_axis(&walk, view, 2, o.z, d.z);
    while (walk.at < far) {
        const int32_t xy = walk.next[0] < walk.next[1] ? 0 : 1;
        const int32_t axis = walk.next[xy] < walk.next[2] ? xy : 2;
        const float leave = ty_maxf(walk.at, ty_minf(walk.next[axis], far));
        const size_t at = (size_t)walk.cell[0] +
                          (size_t)view->size[0] * ((size_t)walk.cell[1] + (size_t)view->size[1] * (size_t)walk.cell[2]);
        const float middle = 0.5f * (walk.at + leave), length = leave - walk.at;
        if (view->extinction[0][at] > 0.0f || view->extinction[1][at] > 0.0f || view->extinction[2][at] > 0.0f) {
            const ty_cell_point place = ty_cell_locate(view->size, ty_mad(o, d, middle));
            const float g[3] = {view->g[0][at], view->g[1][at], view->g[2][at]};
            float scattered[3] = {0.0f, 0.0f, 0.0f};
            for (int32_t i = 0; i < view->light_count; ++i)
                ty_single_scattered(&view->lights[i], ty_mad(origin, direction, middle), &place, way, g, scattered);
            for (int32_t c = 0; c < 3; ++c) {
                const float depth = view->extinction[c][at] * length, decay = ty_decay(depth);
                radiance[c] +=
                    transmittance[c] * view->scattering[c][at] * scattered[c] * length * ty_mean_decay(depth, decay);
                transmittance[c] *= decay;
            }
        }
        walk.at = leave;
        walk.next[axis] += walk.per_cell[axis];
        walk.cell[axis] += walk.step[axis];
        if ((uint32_t)walk.cell[axis] >= (uint32_t)view->size[axis]) break;
    }
}

#endif
