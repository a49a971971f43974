/* Light on cells that scatters once, with the phase function as it is. */
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

#endif
