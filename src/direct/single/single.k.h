/* Single scattering of fluence on cells, with the exact phase function. */
#ifndef TY_DIRECT_SINGLE_SINGLE_K_H
#define TY_DIRECT_SINGLE_SINGLE_K_H

#include "direct/lights/discrete_light.h"
#include "direct/media/attenuation.k.h"
#include "direct/single/forward.k.h"
#include "scene/media/medium.k.h"
#include "scene/media/phase_lobes.k.h"

/* Uncollided fluence of one light, or of many lights together. */
typedef struct ty_light_fluence {
    int32_t kind;  /* one of the kinds below */
    ty_vec anchor; /* TY_FLUENCE_DIRECTIONAL: the sample's direction; TY_FLUENCE_POINT: its position; kernels load one
                      vector for both */
    TY_GLOBAL const float* fluence[3];     /* per channel, W m^-2 */
    TY_GLOBAL const float* unscattered[3]; /* where lobe_order is set: U of forward.k.h, and fluence is R */
    TY_GLOBAL const float* next_order[3];  /* likewise S */
    int32_t lobe_order;                    /* L of forward.k.h; 0: all of the fluence travels along one line */
    TY_GLOBAL const float* legendre;       /* with L above 1: moments by which R and S were made; NULL: g^l */
    TY_GLOBAL const float* flux[3][3];     /* TY_FLUENCE_P1: along x, y, z */
    int32_t shared; /* all channels are the first one's planes times color, as in a ty_light_field of one plane */
    float color[3];
    ty_discrete_light sample; /* of TY_FLUENCE_DIRECTIONAL and TY_FLUENCE_POINT */
    float extent;             /* TY_FLUENCE_POINT: area that the light shows, m^2; 0: it is a point */
} ty_light_fluence;

/* TY_FLUENCE_P1 knows two moments: radiance scatters as (fluence + 3 g flux . omega) / (4 pi), clamped at 0, which is
 * exact for isotropic scattering. TY_FLUENCE_ISOTROPIC scatters as fluence / (4 pi) for any g: it is made for one eye.
 */
enum { TY_FLUENCE_DIRECTIONAL = 0, TY_FLUENCE_POINT = 1, TY_FLUENCE_P1 = 2, TY_FLUENCE_ISOTROPIC = 3 };

/* The fluence of one sample, still without planes. */
TY_FN ty_light_fluence ty_light_fluence_of(const ty_discrete_light* sample) {
    const bool point = sample->kind == TY_DISCRETE_POINT;
    ty_light_fluence light;
    memset(&light, 0, sizeof light);
    light.kind = point ? TY_FLUENCE_POINT : TY_FLUENCE_DIRECTIONAL;
    light.anchor = point ? sample->position : sample->direction;
    light.sample = *sample;
    return light;
}

/* A channel's plane of fluence; *factor: its scale. */
TY_FN TY_GLOBAL const float* ty_light_fluence_plane(const ty_light_fluence* light, int32_t channel, float* factor) {
    *factor = light->color[channel];
    return light->fluence[light->shared != 0 ? 0 : channel];
}

/* Trilinear interpolation between cell centers; constant beyond the outer ones. */
typedef struct ty_cell_point {
    size_t base;    /* lowest of the eight cells */
    size_t step[3]; /* offset to the next cell along each axis, 0 at the upper edge */
    float fraction[3];
} ty_cell_point;

TY_FN ty_cell_point ty_cell_locate(const int32_t size[3], ty_vec cells) {
    const float at[3] = {cells.x - 0.5f, cells.y - 0.5f, cells.z - 0.5f};
    size_t stride = 1;
    ty_cell_point point;
    point.base = 0;
    for (int32_t a = 0; a < 3; ++a) {
        const float from = ty_clampf(at[a], 0.0f, (float)(size[a] - 1));
        const int32_t cell = (int32_t)from;
        point.fraction[a] = from - (float)cell;
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
        const float first = ty_lerp_exact(row[0], row[p->step[0]], p->fraction[0]);
        row += p->step[1];
        layer[k] = ty_lerp_exact(first, ty_lerp_exact(row[0], row[p->step[0]], p->fraction[0]), p->fraction[1]);
    }
    return ty_lerp_exact(layer[0], layer[1], p->fraction[2]);
}

/* The fluences R (the whole fluence where lobe_order is 0), U and S. */
enum { TY_FLUENCE_ORDER_L = 0, TY_FLUENCE_UNSCATTERED = 1, TY_FLUENCE_NEXT_ORDER = 2, TY_FLUENCE_COUNT = 3 };

/* Radiance scattered into a direction, per scattering coefficient. */
typedef struct ty_single_radiance {
    float first[3]; /* first collision; for fluences without a lobe, all of it */
    float again[3]; /* correction of the multiply scattered light, may be negative */
    float aside[3]; /* with a fit: light of both that reaches the eye behind the peak's scattering, too */
} ty_single_radiance;

/* A beam with a lobe where phase functions are fitted. Light within the peak scatters by the fit, and its path to the
 * eye is delta-scaled alike. Within the peak the deficit of the fit is added; outside of it, where the fit is good for
 * multiple scattering, the exact phase function is used. */
TY_FN void ty_single_fitted(ty_forward forward, float mu, float g, TY_GLOBAL const ty_forward_fit* fit, float color,
                            int32_t c, ty_single_radiance* radiance) {
    const float t = ty_forward_peak_weight(mu), unscattered = forward.phi_unscattered * ty_hg(mu, g);
    const float lacking = t > 0.0f ? t * ty_forward_fit_deficit(forward, mu, g, fit) : 0.0f;
    radiance->first[c] += color * unscattered;
    radiance->again[c] += color * (lacking - unscattered);
    radiance->aside[c] += color * forward.phi_order_l * ty_forward_blended_phase(fit, mu, g);
}

/* The mean cosine of a light's directions about that from its anchor, by the solid angle of its extent. */
TY_FN float ty_light_fluence_spread(const ty_light_fluence* light, ty_vec point) {
    if (light->kind != TY_FLUENCE_POINT || !(light->extent > 0.0f)) return 1.0f;
    const ty_vec off = ty_sub(point, light->anchor);
    const float cap = ty_minf(2.0f * TY_PI, light->extent / ty_maxf(ty_dot(off, off), 1e-12f));
    return 1.0f - cap * TY_INV_4PI;
}

/* Adds the scattering at cosine mu of a fluence with a lobe. cosine: ty_light_fluence_spread. passing: transmittances
 * of its three parts. phase: NULL: Henyey-Greenstein of g; else first collisions scatter by it, and g is its mean
 * cosine. */
TY_FN void ty_single_with_lobe(const ty_light_fluence* light, const ty_cell_point* at, float mu, float cosine,
                               const float passing[TY_FLUENCE_COUNT][3], const float g[3],
                               TY_GLOBAL const ty_phase_view* phase, TY_GLOBAL const ty_forward_fit* fit,
                               ty_single_radiance* radiance) {
    const int32_t planes = light->shared != 0 ? 1 : 3;
    float fluence[TY_FLUENCE_COUNT][3], values[3];
    if (phase != NULL) ty_phase_evaluate(phase, ty_clampf(mu, -1.0f, 1.0f), values);
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
                                    fluence[TY_FLUENCE_NEXT_ORDER][plane] * passing[TY_FLUENCE_NEXT_ORDER][c], cosine};
        if (fit->bands > 0) {
            ty_single_fitted(forward, mu, g[c], fit, color, c, radiance);
            continue;
        }
        radiance->first[c] +=
            color * (phase != NULL ? forward.phi_unscattered * values[c] : ty_forward_unscattered(forward, mu, g[c]));
        radiance->again[c] +=
            color * (light->lobe_order == 1
                         ? ty_forward_scattered(forward, mu, g[c])
                         : ty_forward_scattered_order(forward, mu, cosine * g[c], light->legendre, light->lobe_order));
    }
}

/* The cosine between the light's direction of travel at a point and omega. */
TY_FN float ty_light_fluence_cosine(const ty_light_fluence* light, ty_vec point, ty_vec omega) {
    if (light->kind != TY_FLUENCE_POINT) return ty_dot(light->anchor, omega);
    const ty_vec off = ty_sub(point, light->anchor);
    return ty_dot(off, omega) / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f));
}

/* Adds the radiance that a point scatters along omega. passing: factors of the light's fluences there. phase: as
 * above. */
TY_FN void ty_single_scattered(const ty_light_fluence* light, ty_vec point, const ty_cell_point* at, ty_vec omega,
                               const float passing[TY_FLUENCE_COUNT][3], const float g[3],
                               TY_GLOBAL const ty_phase_view* phase, TY_GLOBAL const ty_forward_fit* fit,
                               ty_single_radiance* radiance) {
    if (light->lobe_order != 0) {
        ty_single_with_lobe(light, at, ty_light_fluence_cosine(light, point, omega),
                            ty_light_fluence_spread(light, point), passing, g, phase, fit, radiance);
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
        float* to = fit->bands > 0 ? radiance->aside : radiance->first;
        for (int32_t c = 0; c < 3; ++c)
            to[c] += passing[TY_FLUENCE_ORDER_L][c] * TY_INV_4PI * ty_maxf(0.0f, fluence[c] + 3.0f * g[c] * forward[c]);
        return;
    }
    const float mu = ty_light_fluence_cosine(light, point, omega), cosine = ty_light_fluence_spread(light, point);
    if (phase != NULL) {
        float values[3];
        ty_phase_evaluate(phase, ty_clampf(mu, -1.0f, 1.0f), values);
        for (int32_t c = 0; c < 3; ++c) radiance->first[c] += passing[TY_FLUENCE_ORDER_L][c] * values[c] * fluence[c];
        return;
    }
    float value = 0.0f;
    for (int32_t c = 0; c < 3; ++c) {
        if (c == 0 || g[c] != g[c - 1]) value = ty_hg(mu, cosine * g[c]);
        radiance->first[c] += passing[TY_FLUENCE_ORDER_L][c] * value * fluence[c];
    }
}

#endif
