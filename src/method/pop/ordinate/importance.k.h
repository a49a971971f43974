/* Importance from the camera: march along a ray's column of cells, and the lobe by which incident light from a
 * direction contributes to the camera's radiance. */
#ifndef TY_METHOD_POP_ORDINATE_IMPORTANCE_K_H
#define TY_METHOD_POP_ORDINATE_IMPORTANCE_K_H

#include "direct/media/attenuation.k.h"
#include "direct/single/single.k.h"
#include "scene/media/phase.k.h"

/* Medium coefficients at a point, averaged over channels. */
typedef struct ty_pop_occlusion_medium {
    float extinction, scattering; /* 1/m */
    float g;
} ty_pop_occlusion_medium;

typedef struct ty_pop_occlusion_view {
    TY_GLOBAL const float* extinction[3];
    TY_GLOBAL const float* scattering[3];
    TY_GLOBAL const float* g[3];
    int32_t planes, size[3];
    ty_vec lower, upper, per_cell; /* m, cells per m */
} ty_pop_occlusion_view;

TY_FN ty_pop_occlusion_medium ty_pop_occlusion_medium_at(const ty_pop_occlusion_view* view, ty_vec point) {
    ty_pop_occlusion_medium medium;
    const ty_vec from = ty_sub(point, view->lower), to = ty_sub(view->upper, point);
    const float fraction = 1.0f / (float)view->planes;
    medium.extinction = medium.scattering = medium.g = 0.0f;
    if (ty_minf(ty_minf(from.x, from.y), from.z) < 0.0f || ty_minf(ty_minf(to.x, to.y), to.z) < 0.0f) return medium;
    const ty_cell_point at = ty_cell_locate(
        view->size, ty_vec_make(from.x * view->per_cell.x, from.y * view->per_cell.y, from.z * view->per_cell.z));
    for (int32_t c = 0; c < view->planes; ++c) {
        medium.extinction += fraction * ty_cell_value(view->extinction[c], &at);
        medium.scattering += fraction * ty_cell_value(view->scattering[c], &at);
        medium.g += fraction * ty_cell_value(view->g[c], &at);
    }
    return medium;
}

/* Scaled extinction of the l-th moment, sigma_t - g^l sigma_s; negative g counts as 0. */
TY_FN float ty_pop_occlusion_scaled_extinction(const ty_pop_occlusion_medium* medium, int32_t order) {
    const float g = ty_maxf(0.0f, medium->g);
    return ty_maxf(0.0f, medium->extinction - (order == 2 ? g * g : g) * medium->scattering);
}

/* Transmittances of importance of moment 0, 1 and 2 (U, R and S of ty_pop_sweep). */
typedef struct ty_pop_importance_transmittance {
    float uncollided, first, second;
} ty_pop_importance_transmittance;

/* Sums over a segment of a column, each times scattering coefficient and length. */
typedef struct ty_pop_visibility_sample {
    float uncollided;         /* of U */
    float forward;            /* of R - U */
    float forward_second;     /* of S - U */
    float g;                  /* of g R */
    float diffuse;            /* of (1 - g) R: light scattered out of the forward lobe */
    ty_vec weighted_position; /* of R times the position, m */
} ty_pop_visibility_sample;

/* Adds a segment of some length centered at `point`. */
TY_FN void ty_pop_visibility_sample_add(ty_pop_visibility_sample* sum, ty_pop_importance_transmittance* transmittances,
                                        const ty_pop_occlusion_medium* medium, ty_vec point, float length) {
    const float tau[3] = {medium->extinction * length, ty_pop_occlusion_scaled_extinction(medium, 1) * length,
                          ty_pop_occlusion_scaled_extinction(medium, 2) * length};
    const float transmittance[3] = {ty_attenuation(tau[0]), ty_attenuation(tau[1]), ty_attenuation(tau[2])};
    const float weight = medium->scattering * length;
    const float uncollided = weight * transmittances->uncollided * ty_mean_attenuation(tau[0], transmittance[0]);
    const float first = weight * transmittances->first * ty_mean_attenuation(tau[1], transmittance[1]);
    const float second = weight * transmittances->second * ty_mean_attenuation(tau[2], transmittance[2]);
    sum->uncollided += uncollided;
    sum->forward += ty_maxf(0.0f, first - uncollided);
    sum->forward_second += ty_maxf(0.0f, second - uncollided);
    sum->g += first * medium->g;
    sum->diffuse += first * (1.0f - ty_maxf(0.0f, medium->g));
    sum->weighted_position = ty_mad(sum->weighted_position, point, first);
    transmittances->uncollided *= transmittance[0];
    transmittances->first *= transmittance[1];
    transmittances->second *= transmittance[2];
}

/* Scattering lobe of a segment, between incident light and the eye. */
typedef struct ty_pop_importance_lobe {
    float uncollided, g;
    float forward, forward_g, inverse_b; /* forward part: mean cosine b g, and 1 / b */
} ty_pop_importance_lobe;

TY_FN ty_pop_importance_lobe ty_pop_importance_lobe_of(const ty_pop_visibility_sample* sum) {
    const float all = sum->uncollided + sum->forward;
    const float b = ty_clampf(sum->forward_second / ty_maxf(sum->forward, 1e-30f), 1e-3f, 1.0f);
    ty_pop_importance_lobe lobe;
    lobe.uncollided = sum->uncollided;
    lobe.forward = sum->forward;
    lobe.g = ty_clampf(sum->g / ty_maxf(all, 1e-30f), -0.99f, 0.99f);
    lobe.forward_g = b * lobe.g;
    lobe.inverse_b = 1.0f / b;
    return lobe;
}

/* mu: cosine between the eye's ray and the direction towards the light. */
TY_FN float ty_pop_importance_lobe_at(const ty_pop_importance_lobe* lobe, float mu) {
    const float forward = (ty_hg(mu, lobe->forward_g) - TY_INV_4PI) * lobe->inverse_b + TY_INV_4PI;
    return ty_maxf(0.0f, lobe->uncollided * ty_hg(mu, lobe->g) + lobe->forward * forward);
}

#endif
