/* Light on cells that scatters once, with the phase function as it is. */
#ifndef TY_DIRECT_SINGLE_SINGLE_K_H
#define TY_DIRECT_SINGLE_SINGLE_K_H

#include "direct/uncollided/attenuation.k.h"
#include "direct/single/forward.k.h"
#include "scene/medium.k.h"
#include "scene/phase.k.h"

/* Uncollided light of one source, or of many together. */
typedef struct ty_single_light {
    int32_t kind;  /* one of the below */
    ty_vec toward; /* TY_SINGLE_BEAM: the way light travels, unit; TY_SINGLE_LAMP: where it comes from, m */
    TY_GLOBAL const float* fluence[3]; /* per channel, W m^-2 */
    TY_GLOBAL const float*
        straight[3];                /* TY_SINGLE_BEAM and _LAMP, where lobes is set: U of forward.k.h; fluence is R */
    TY_GLOBAL const float* bent[3]; /* S */
    int32_t lobes; /* L of forward.k.h, where these are there; 0: all of fluence comes along one line */
    TY_GLOBAL const float* flux[3][3]; /* TY_SINGLE_MANY: along x, y, z */
    int32_t shared;                    /* whether all channels are the first one's planes, times color (as in a
                                          ty_light_field of one plane) */
    float color[3];
} ty_single_light;

/* Of TY_SINGLE_MANY only the mean direction is known: light scatters as (fluence + 3 g flux . way) / (4 pi), not below
 * 0, which is exact for isotropic scattering. TY_SINGLE_EVEN scatters as fluence / (4 pi), whatever g is: it is made so
 * for an eye. */
enum { TY_SINGLE_BEAM = 0, TY_SINGLE_LAMP = 1, TY_SINGLE_MANY = 2, TY_SINGLE_EVEN = 3 };

/* A channel's fluence of a light, without its factor. */
TY_FN TY_GLOBAL const float* ty_single_plane(const ty_single_light* light, int32_t channel, float* factor) {
    *factor = light->color[channel];
    return light->fluence[light->shared != 0 ? 0 : channel];
}

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

/* Which of a light's fluences passes: R (all of it, where there are no lobes), U and S. */
enum { TY_SINGLE_KEPT = 0, TY_SINGLE_STRAIGHT = 1, TY_SINGLE_BENT = 2, TY_SINGLE_FLUENCES = 3 };

/* What lights scatter along a way, per scattering coefficient. */
typedef struct ty_single_sent {
    float first[3]; /* what scatters there for the first time; of lights without lobes, all of it */
    float again[3]; /* what is part of the multiply scattered light, which may be below 0 */
    float aside[3]; /* with a fit: what of both is seen through what scatters nearly straight on, too */
} ty_single_sent;

/* Of a light with lobes where phase functions are fitted: what goes about straight scatters by the fit, and is seen
 * through as much that does. Within the peak, what the fit lacks there comes to it; beyond it, where it is good for
 * what scatters often, the phase function is as it is. */
TY_FN void ty_single_beside(ty_forward forward, float mu, float g, TY_GLOBAL const ty_forward_fit* fit, float color,
                            int32_t c, ty_single_sent* sent) {
    const float share = ty_forward_share(mu), straight = forward.straight * ty_hg(mu, g);
    const float lacking = share > 0.0f ? share * ty_forward_lacking(forward, mu, g, fit) : 0.0f;
    sent->first[c] += color * straight;
    sent->again[c] += color * (lacking - straight);
    sent->aside[c] += color * forward.kept * ty_forward_aside(fit, mu, g);
}

/* A light with lobes: adds what its three fluences, times passing, scatter at cosine mu. */
TY_FN void ty_single_forward(const ty_single_light* light, const ty_cell_point* at, float mu,
                             const float passing[TY_SINGLE_FLUENCES][3], const float g[3],
                             TY_GLOBAL const ty_forward_fit* fit, ty_single_sent* sent) {
    const int32_t planes = light->shared != 0 ? 1 : 3;
    float fluence[TY_SINGLE_FLUENCES][3];
    for (int32_t c = 0; c < planes; ++c) {
        fluence[TY_SINGLE_KEPT][c] = ty_cell_value(light->fluence[c], at);
        fluence[TY_SINGLE_STRAIGHT][c] = ty_cell_value(light->straight[c], at);
        fluence[TY_SINGLE_BENT][c] = ty_cell_value(light->bent[c], at);
    }
    for (int32_t c = 2; c >= 0; --c) {
        const int32_t plane = planes == 1 ? 0 : c;
        const float color = planes == 1 ? light->color[c] : 1.0f;
        const ty_forward forward = {fluence[TY_SINGLE_STRAIGHT][plane] * passing[TY_SINGLE_STRAIGHT][c],
                                    fluence[TY_SINGLE_KEPT][plane] * passing[TY_SINGLE_KEPT][c],
                                    fluence[TY_SINGLE_BENT][plane] * passing[TY_SINGLE_BENT][c], 1.0f};
        if (fit->bands > 0) {
            ty_single_beside(forward, mu, g[c], fit, color, c, sent);
            continue;
        }
        sent->first[c] += color * ty_forward_straight(forward, mu, g[c]);
        sent->again[c] += color * (light->lobes == 1 ? ty_forward_scattered(forward, mu, g[c])
                                                     : ty_forward_beyond(forward, mu, g[c], light->lobes));
    }
}

/* The cosine between light's way at a point and `way`. */
TY_FN float ty_single_cosine(const ty_single_light* light, ty_vec point, ty_vec way) {
    if (light->kind != TY_SINGLE_LAMP) return ty_dot(light->toward, way);
    const ty_vec off = ty_sub(point, light->toward);
    return ty_dot(off, way) / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f));
}

/* Adds the light that a point scatters along `way`. passing: times which the light's fluences are there. */
TY_FN void ty_single_scattered(const ty_single_light* light, ty_vec point, const ty_cell_point* at, ty_vec way,
                               const float passing[TY_SINGLE_FLUENCES][3], const float g[3],
                               TY_GLOBAL const ty_forward_fit* fit, ty_single_sent* sent) {
    if (light->lobes != 0) {
        ty_single_forward(light, at, ty_single_cosine(light, point, way), passing, g, fit, sent);
        return;
    }
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
    if (light->kind >= TY_SINGLE_MANY) {
        float* to = fit->bands > 0 ? sent->aside : sent->first;
        for (int32_t c = 0; c < 3; ++c)
            to[c] += passing[TY_SINGLE_KEPT][c] * TY_INV_4PI * ty_maxf(0.0f, fluence[c] + 3.0f * g[c] * forward[c]);
        return;
    }
    const float mu = ty_single_cosine(light, point, way);
    float phase = 0.0f;
    for (int32_t c = 0; c < 3; ++c) {
        if (c == 0 || g[c] != g[c - 1]) phase = ty_hg(mu, g[c]);
        sent->first[c] += passing[TY_SINGLE_KEPT][c] * phase * fluence[c];
    }
}

#endif
