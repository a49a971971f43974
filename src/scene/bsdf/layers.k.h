/* Layers above the base, sheen and over it a clear coat, with energy compensation: a reciprocal BSDF in which layers
 * whose albedo is A let down T(wo) = 1 - A(wo) of the light that the base reflects without them.
 *
 * Wide lobes of the base have the form u(wi) u(wo) / (pi u_mean) with u the albedo of a white one; below layers u
 * becomes T u (Kelemen and Szirmay-Kalos 2001). Other lobes f take min(T(wi), T(wo)), which is T where a smooth surface
 * mirrors. The residual albedo
 *
 *     r(wo) = integral of f(wi, wo) (T(wo) - min(T(wi), T(wo))) cos dwi
 *
 * returns by the lobe r(wi) r(wo) / (pi r_mean), like the light that microfacets lose (Kulla and Conty 2017). The
 * integral is a sum over the tables' nodes. */
#ifndef TY_SCENE_BSDF_LAYERS_K_H
#define TY_SCENE_BSDF_LAYERS_K_H

#include "scene/bsdf/state.k.h"

/* Directional albedo of microfacets; white, schlick: values of the tables. */
TY_FN float ty_bsdf_microfacet_albedo(float f0, float f90, float multiple, float white, float schlick) {
    return f0 * (white - schlick) + f90 * schlick + multiple * (1.0f - white);
}

/* Mean over cosine-weighted directions of values that are interpolated between nodes. */
TY_FN float ty_bsdf_node_mean(const ty_bsdf* b, const float values[TY_BSDF_NODES]) {
    float sum = 0.0f;
    for (int32_t j = 0; j < TY_BSDF_NODES; ++j) sum += b->tables->node_weight[j] * values[j];
    return sum;
}

/* The residual albedo of a lobe, for layers that let down `passed` at the nodes; coordinate: of
 * its tables' row. */
TY_FN void ty_bsdf_set_residual(ty_bsdf* b, int32_t lobe, float coordinate, const float passed[TY_BSDF_NODES]) {
    const float y = ty_clampf(coordinate, 0.0f, 1.0f) * (float)(TY_BSDF_NODE_ROUGHNESSES - 1);
    const int32_t row = y < (float)(TY_BSDF_NODE_ROUGHNESSES - 2) ? (int32_t)y : TY_BSDF_NODE_ROUGHNESSES - 2;
    TY_GLOBAL const float* smoother = b->tables->source[lobe * TY_BSDF_NODE_ROUGHNESSES + row];
    TY_GLOBAL const float* rougher = b->tables->source[lobe * TY_BSDF_NODE_ROUGHNESSES + row + 1];
    const float fraction = y - (float)row;
    for (int32_t k = 0; k < TY_BSDF_NODES; ++k) {
        float sum = 0.0f;
        for (int32_t j = 0; j < TY_BSDF_NODES; ++j) {
            const int32_t at = k * TY_BSDF_NODES + j;
            sum += ty_lerpf(smoother[at], rougher[at], fraction) * ty_maxf(passed[k] - passed[j], 0.0f);
        }
        b->residual[lobe][k] = sum;
    }
    b->residual_out[lobe] = ty_bsdf_at_cosine(b->residual[lobe], b->wo.z);
    b->residual_mean[lobe] = ty_maxf(ty_bsdf_node_mean(b, b->residual[lobe]), 1e-9f);
}

/* The lobes by which the residual albedo of white ones returns. */
TY_FN void ty_bsdf_residual_lobes(const ty_bsdf* b, float cosine, float lobes[TY_BELOW_COUNT]) {
    float fraction;
    const int32_t node = ty_bsdf_node_below(cosine, &fraction);
    for (int32_t i = 0; i < TY_BELOW_COUNT; ++i)
        lobes[i] = ty_lerpf(b->residual[i][node], b->residual[i][node + 1], fraction) * b->residual_out[i] /
                   (TY_PI * b->residual_mean[i]);
}

/* Of microfacets of Schlick's reflectance, which is linear in F0 and F90, from the values of the white lobes. */
TY_FN float ty_bsdf_schlick_mix(float f0, float f90, const float values[TY_BELOW_COUNT]) {
    return f0 * values[TY_BELOW_WHITE] + f90 * values[TY_BELOW_SCHLICK];
}

/* Prepares the means and lobes of a base below sheen and coat. */
TY_FN void ty_bsdf_set_layers(ty_bsdf* b) {
    float white[TY_BSDF_NODES], schlick[TY_BSDF_NODES], sheen[TY_BSDF_NODES];
    float coat_white[TY_BSDF_NODES], coat_schlick[TY_BSDF_NODES];
    float below_coat[TY_BSDF_NODES], passed[TY_BSDF_NODES], lost[TY_BSDF_NODES], below[TY_BSDF_NODES];
    ty_bsdf_node_values(b->tables->node_reflected[0], b->roughness, white);
    ty_bsdf_node_values(b->tables->node_schlick[0], b->roughness, schlick);
    ty_bsdf_node_values(b->tables->node_sheen[0], ty_bsdf_sheen_row(b->sheen_roughness), sheen);
    ty_bsdf_node_values(b->tables->node_reflected[0], b->coat_roughness, coat_white);
    ty_bsdf_node_values(b->tables->node_schlick[0], b->coat_roughness, coat_schlick);
    for (int32_t j = 0; j < TY_BSDF_NODES; ++j) {
        const float coat = ty_bsdf_microfacet_albedo(0.04f, 1.0f, 0.0f, coat_white[j], coat_schlick[j]);
        const float film = ty_bsdf_microfacet_albedo(b->film_f0, b->film_f90, b->film_multiple, white[j], schlick[j]);
        below_coat[j] = 1.0f - b->coat * coat;
        passed[j] = below_coat[j] * (1.0f - b->sheen_scale * sheen[j]);
        lost[j] = passed[j] * (1.0f - white[j]);
        below[j] = passed[j] * (1.0f - film);
    }
    b->lost_mean = ty_maxf(ty_bsdf_node_mean(b, lost), 1e-6f);
    b->below_mean = ty_maxf(ty_bsdf_node_mean(b, below), 1e-6f);
    ty_bsdf_set_residual(b, TY_BELOW_WHITE, b->roughness, passed);
    ty_bsdf_set_residual(b, TY_BELOW_SCHLICK, b->roughness, passed);
    ty_bsdf_set_residual(b, TY_BELOW_SHEEN, ty_bsdf_sheen_row(b->sheen_roughness), below_coat);
}

/* Adds to the BRDF of the lobes below layers the sheen, of which the coat lets down `down`, and residual lobes. */
TY_FN void ty_bsdf_add_layers(const ty_bsdf* b, ty_vec wi, float down, float brdf[3]) {
    float sheen = 0.0f, residual[TY_BELOW_COUNT] = {0.0f, 0.0f, 0.0f};
    if (b->sheen_scale > 0.0f) sheen = ty_sheen_brdf(wi, b->wo, ty_sheen_alpha(b->sheen_roughness)) * down;
    if (b->compensated != 0) {
        ty_bsdf_residual_lobes(b, wi.z, residual);
        if (b->sheen_scale > 0.0f) sheen /= ty_bsdf_sheen_bound(b->tables, wi.z, b->wo.z, b->sheen_roughness);
    }
    for (int c = 0; c < 3; ++c)
        brdf[c] += ty_bsdf_schlick_mix(b->f0[c], b->f90, residual) + b->sheen[c] * (sheen + residual[TY_BELOW_SHEEN]);
}

#endif
