/* Light on cells that scatters once, with the phase function as it is. */
#ifndef TY_DIRECT_SINGLE_SINGLE_K_H
#define TY_DIRECT_SINGLE_SINGLE_K_H

#include "direct/lights/discrete_light.h"
#include "direct/uncollided/attenuation.k.h"
#include "direct/single/forward.k.h"
#include "scene/medium.k.h"
#include "scene/phase.k.h"

/* Uncollided light of one source, or of many together. */
typedef struct ty_light_fluence {
    int32_t kind;                      /* one of the below */
    ty_discrete_light sample;          /* TY_FLUENCE_DIRECTIONAL: its direction; TY_FLUENCE_POINT: its position */
    TY_GLOBAL const float* fluence[3]; /* per channel, W m^-2 */
    TY_GLOBAL const float*
        unscattered[3]; /* TY_FLUENCE_DIRECTIONAL and _LAMP, where lobe_order is set: U of forward.k.h; fluence is R */
    TY_GLOBAL const float* next_order[3]; /* S */
    int32_t lobe_order; /* L of forward.k.h, where these are there; 0: all of fluence comes along one line */
    TY_GLOBAL const float* flux[3][3]; /* TY_FLUENCE_P1: along x, y, z */
    int32_t shared;                    /* whether all channels are the first one's planes, times color (as in a
                                          ty_light_field of one plane) */
    float color[3];
} ty_light_fluence;

/* Of TY_FLUENCE_P1 only the mean direction is known: light scatters as (fluence + 3 g flux . way) / (4 pi), not below
 * 0, which is exact for isotropic scattering. TY_FLUENCE_ISOTROPIC scatters as fluence / (4 pi), whatever g is: it is
 * made so for an eye. */
enum { TY_FLUENCE_DIRECTIONAL = 0, TY_FLUENCE_POINT = 1, TY_FLUENCE_P1 = 2, TY_FLUENCE_ISOTROPIC = 3 };

/* A channel's fluence of a light, without its factor. */
TY_FN TY_GLOBAL const float* ty_light_fluence_plane(const ty_light_fluence* light, int32_t channel, float* factor) {
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
        const float first = ty_lerp_exact(row[0], row[p->step[0]], p->share[0]);
        row += p->step[1];
        layer[k] = ty_lerp_exact(first, ty_lerp_exact(row[0], row[p->step[0]], p->share[0]), p->share[1]);
    }
    return ty_lerp_exact(layer[0], layer[1], p->share[2]);
}

/* Which of a light's fluences passes: R (all of it, where there are no lobe_order), U and S. */
enum { TY_FLUENCE_ORDER_L = 0, TY_FLUENCE_UNSCATTERED = 1, TY_FLUENCE_NEXT_ORDER = 2, TY_FLUENCE_COUNT = 3 };

/* What lights scatter along a way, per scattering coefficient. */
typedef struct ty_single_radiance {
    float first[3]; /* what scatters there for the first time; of lights without lobe_order, all of it */
    float again[3]; /* what is part of the multiply scattered light, which may be below 0 */
    float aside[3]; /* with a fit: what of both is seen through what scatters nearly straight on, too */
} ty_single_radiance;

/* Of a light with lobe_order where phase functions are fitted: what goes about straight scatters by the fit, and is
 * seen through as much that does. Within the peak, what the fit lacks there comes to it; beyond it, where it is good
 * for what scatters often, the phase function is as it is. */
TY_FN void ty_single_fitted(ty_forward forward, float mu, float g, TY_GLOBAL const ty_forward_fit* fit, float color,
                            int32_t c, ty_single_radiance* sent) {
    const float t = ty_forward_peak_weight(mu), unscattered = forward.phi_unscattered * ty_hg(mu, g);
    const float lacking = t > 0.0f ? t * ty_forward_fit_deficit(forward, mu, g, fit) : 0.0f;
    sent->first[c] += color * unscattered;
    sent->again[c] += color * (lacking - unscattered);
    sent->aside[c] += color * forward.phi_order_l * ty_forward_blended_phase(fit, mu, g);
}

/* A light with lobe_order: adds what its three fluences, times passing, scatter at cosine mu. */
TY_FN void ty_single_with_lobe(const ty_light_fluence* light, const ty_cell_point* at, float mu,
                               const float passing[TY_FLUENCE_COUNT][3], const float g[3],
                               TY_GLOBAL const ty_forward_fit* fit, ty_single_radiance* sent) {
    const int32_t planes = light->shared != 0 ? 1 : 3;
    float fluence[TY_FLUENCE_COUNT][3];
    for (int32_t c = 0; c < planes; ++c) {
        fluence[TY_FLUENCE_ORDER_L][c] = ty_cell_value(light->fluence[c], at);
        fluence[TY_FLUENCE_UNSCATTERED][c] = ty_cell_value(light->unscattered[c], at);
        fluence[TY_FLUENCE_NEXT_ORDER][c] = ty_cell_value(light->next_order[c], at);
    }
    for (int32_t c = 2; c >= 0; --c) {
        const int32_t plane = planes == 1 ? 0 : c;
        const float color = planes == 1 ? light->color[c] : 1.0f;
        const ty_forward forward = {fluence[TY_FLUENCE_UNSCATTERED][plane] * passing[TY_FLUENCE_UNSCATTERED][c],
                                    fluence[TY_FLUENCE_ORDER_L][plane] * passing[TY_FLUENCE_ORDER_L][c],
                                    fluence[TY_FLUENCE_NEXT_ORDER][plane] * passing[TY_FLUENCE_NEXT_ORDER][c], 1.0f};
        if (fit->bands > 0) {
            ty_single_fitted(forward, mu, g[c], fit, color, c, sent);
            continue;
        }
        sent->first[c] += color * ty_forward_unscattered(forward, mu, g[c]);
        sent->again[c] +=
            color * (light->lobe_order == 1 ? ty_forward_scattered(forward, mu, g[c])
                                            : ty_forward_scattered_order(forward, mu, g[c], light->lobe_order));
    }
}

/* The cosine between light's way at a point and `way`. */
TY_FN float ty_light_fluence_cosine(const ty_light_fluence* light, ty_vec point, ty_vec omega) {
    if (light->kind != TY_FLUENCE_POINT) return ty_dot(light->sample.direction, omega);
    const ty_vec off = ty_sub(point, light->sample.position);
    return ty_dot(off, omega) / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f));
}

/* Adds the light that a point scatters along `way`. passing: times which the light's fluences are there. */
TY_FN void ty_single_scattered(const ty_light_fluence* light, ty_vec point, const ty_cell_point* at, ty_vec omega,
                               const float passing[TY_FLUENCE_COUNT][3], const float g[3],
                               TY_GLOBAL const ty_forward_fit* fit, ty_single_radiance* sent) {
    if (light->lobe_order != 0) {
        ty_single_with_lobe(light, at, ty_light_fluence_cosine(light, point, omega), passing, g, fit, sent);
        return;
    }
    const int32_t planes = light->shared != 0 ? 1 : 3;
    float fluence[3], forward[3] = {0.0f, 0.0f, 0.0f};
    for (int32_t c = 0; c < planes; ++c) {
        fluence[c] = ty_cell_value(light->fluence[c], at);
        if (light->kind == TY_FLUENCE_P1)
            forward[c] = ty_cell_value(light->flux[c][0], at) * omega.x +
                         ty_cell_value(light->flux[c][1], at) * omega.y +
                         ty_cell_value(light->flux[c][2], at) * omega.z;
    }
    for (int32_t c = 2; c >= 0 && light->shared != 0; --c) {
        fluence[c] = fluence[0] * light->color[c];
        forward[c] = forward[0] * light->color[c];
    }
    if (light->kind >= TY_FLUENCE_P1) {
        float* to = fit->bands > 0 ? sent->aside : sent->first;
        for (int32_t c = 0; c < 3; ++c)
            to[c] += passing[TY_FLUENCE_ORDER_L][c] * TY_INV_4PI * ty_maxf(0.0f, fluence[c] + 3.0f * g[c] * forward[c]);
        return;
    }
    const float mu = ty_light_fluence_cosine(light, point, omega);
    float phase = 0.0f;
    for (int32_t c = 0; c < 3; ++c) {
        if (c == 0 || g[c] != g[c - 1]) phase = ty_hg(mu, g[c]);
        sent->first[c] += passing[TY_FLUENCE_ORDER_L][c] * phase * fluence[c];
    }
}

#endif
