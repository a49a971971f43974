/* Directional albedos of white microfacets and of sheen, and where the light of these lobes comes from, tabulated when
 * the library is built (make_tables.c). */
#ifndef TY_SCENE_BSDF_TABLES_K_H
#define TY_SCENE_BSDF_TABLES_K_H

#include "scene/bsdf/microfacet.k.h"
#include "scene/bsdf/sheen.k.h"

/* Points along the cosine, the roughness and the index of refraction. */
enum { TY_BSDF_COSINES = 64, TY_BSDF_ROUGHNESSES = 32, TY_BSDF_IORS = 16 };

/* Cosines between which layers (layers.k.h) interpolate, (j / (TY_BSDF_NODES - 1))^2, and the roughnesses of their
 * tables. */
enum { TY_BSDF_NODES = 16, TY_BSDF_NODE_ROUGHNESSES = 16 };

/* Lobes that layers attenuate: GGX of reflectance 1 - (1 - v.h)^5, GGX of reflectance (1 - v.h)^5, white sheen. */
enum { TY_BELOW_WHITE = 0, TY_BELOW_SCHLICK = 1, TY_BELOW_SHEEN = 2, TY_BELOW_COUNT = 3 };

/* Rows of equal roughness, which go from 0 to 1; those of sheen go by ty_bsdf_sheen_row. */
typedef struct ty_bsdf_tables {
    float reflected[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES];  /* GGX of reflectance 1 */
    float schlick[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES];    /* GGX of reflectance (1 - v.h)^5 */
    float sheen[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES];      /* as Estevez and Kulla have it, which may exceed 1 */
    float sheen_kept[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES]; /* after ty_bsdf_sheen_bound */
    float reflected_mean[TY_BSDF_ROUGHNESSES];              /* over cosine-weighted directions */
    float schlick_mean[TY_BSDF_ROUGHNESSES];
    /* The first tables at the nodes. */
    float node_reflected[TY_BSDF_ROUGHNESSES][TY_BSDF_NODES];
    float node_schlick[TY_BSDF_ROUGHNESSES][TY_BSDF_NODES];
    float node_sheen[TY_BSDF_ROUGHNESSES][TY_BSDF_NODES];
    float node_weight[TY_BSDF_NODES]; /* of a node in the mean over cosine-weighted directions */
    /* Rows of lobes, then roughnesses; matrices of albedo towards one node from the cosines about another, whose rows
     * add up to the directional albedo. */
    float source[TY_BELOW_COUNT * TY_BSDF_NODE_ROUGHNESSES][TY_BSDF_NODES * TY_BSDF_NODES];
    /* Rough dielectric interfaces, reflection and refraction by single scattering: a table as those above for each
     * index of refraction, first seen from the rarer side, then from the denser one. */
    float dielectric[2 * TY_BSDF_IORS * TY_BSDF_ROUGHNESSES * TY_BSDF_COSINES];
    float dielectric_mean[2 * TY_BSDF_IORS * TY_BSDF_ROUGHNESSES];
} ty_bsdf_tables;

/* Root of the reflectance at normal incidence, (n - 1) / (n + 1), of the last index of refraction of the tables, n = 4.
 * They are evenly spaced in the root of it, because interfaces that are nearly matched differ most. */
#define TY_BSDF_IOR_LAST 0.6f

/* The index of refraction of a table, at least 1. */
TY_FN float ty_dielectric_table_ior(int32_t i) {
    const float at = (float)i / (float)(TY_BSDF_IORS - 1), root = TY_BSDF_IOR_LAST * at * at;
    return (1.0f + root) / (1.0f - root);
}

/* Number of the table below a relative index of refraction, and the weight of the next one. */
TY_FN float ty_dielectric_row(float eta, int32_t* row) {
    const float root = fabsf(eta - 1.0f) / (eta + 1.0f);
    const float at = sqrtf(ty_minf(root * (1.0f / TY_BSDF_IOR_LAST), 1.0f)) * (float)(TY_BSDF_IORS - 1);
    const int32_t below = at < (float)(TY_BSDF_IORS - 2) ? (int32_t)at : TY_BSDF_IORS - 2;
    *row = below + (eta < 1.0f ? TY_BSDF_IORS : 0);
    return at - (float)below;
}

/* The cosine's coordinate in 0..1, the mean of c and of c (1 + b) / (c + b) for b of the size of alpha: masking is a
 * function of c / alpha at small angles to the surface, Fresnel's reflectance one of c. */
#define TY_BSDF_BEND(roughness) (2.0f * ty_ggx_alpha(roughness))

TY_FN float ty_bsdf_cosine_coordinate(float cosine, float roughness) {
    const float bend = TY_BSDF_BEND(roughness);
    return 0.5f * cosine * ((1.0f + bend) / (cosine + bend) + 1.0f);
}

/* The cosine at a coordinate. */
TY_FN float ty_bsdf_coordinate_cosine(float coordinate, float roughness) {
    const float bend = TY_BSDF_BEND(roughness), half = 0.5f + bend - coordinate;
    return sqrtf(half * half + 2.0f * coordinate * bend) - half;
}

/* Value of a row of means. */
TY_FN float ty_bsdf_mean(TY_GLOBAL const float* table, float roughness) {
    const float y = ty_clampf(roughness, 0.0f, 1.0f) * (float)(TY_BSDF_ROUGHNESSES - 1);
    const int32_t row = y < (float)(TY_BSDF_ROUGHNESSES - 2) ? (int32_t)y : TY_BSDF_ROUGHNESSES - 2;
    return ty_lerpf(table[row], table[row + 1], y - (float)row);
}

/* Bilinear value of a table, given as its first row, at coordinates of cosine and row in 0..1. */
TY_FN float ty_bsdf_bilinear(TY_GLOBAL const float* table, float column_coordinate, float row_coordinate) {
    const float x = column_coordinate * (float)(TY_BSDF_COSINES - 1);
    const float y = ty_clampf(row_coordinate, 0.0f, 1.0f) * (float)(TY_BSDF_ROUGHNESSES - 1);
    const int32_t column = x < (float)(TY_BSDF_COSINES - 2) ? (int32_t)x : TY_BSDF_COSINES - 2;
    const int32_t row = y < (float)(TY_BSDF_ROUGHNESSES - 2) ? (int32_t)y : TY_BSDF_ROUGHNESSES - 2;
    TY_GLOBAL const float* at = table + row * TY_BSDF_COSINES + column;
    const float fraction = x - (float)column;
    return ty_lerpf(ty_lerpf(at[0], at[1], fraction), ty_lerpf(at[TY_BSDF_COSINES], at[TY_BSDF_COSINES + 1], fraction),
                    y - (float)row);
}

/* Value of a table of microfacets. */
TY_FN float ty_bsdf_albedo(TY_GLOBAL const float* table, float cosine, float roughness) {
    return ty_bsdf_bilinear(table, ty_bsdf_cosine_coordinate(ty_clampf(cosine, 0.0f, 1.0f), roughness), roughness);
}

/* The row's coordinate of sheen: the root, because smooth fibres change fast. */
TY_FN float ty_bsdf_sheen_row(float roughness) {
    return sqrtf(ty_maxf(roughness - TY_SHEEN_ROUGHNESS_MIN, 0.0f) * (1.0f / (1.0f - TY_SHEEN_ROUGHNESS_MIN)));
}

/* The roughness of a row's coordinate. */
TY_FN float ty_bsdf_sheen_roughness(float coordinate) {
    return TY_SHEEN_ROUGHNESS_MIN + (1.0f - TY_SHEEN_ROUGHNESS_MIN) * coordinate * coordinate;
}

/* Value of a table of sheen; the cosine's coordinate is its root. */
TY_FN float ty_bsdf_sheen_value(TY_GLOBAL const float* table, float cosine, float roughness) {
    return ty_bsdf_bilinear(table, sqrtf(ty_clampf(cosine, 0.0f, 1.0f)), ty_bsdf_sheen_row(roughness));
}

/* White sheen reflects more than the incident light where fibres are smooth and both directions graze: with energy
 * compensation it is divided by this, the larger of its albedos at both cosines, or 1. */
TY_FN float ty_bsdf_sheen_bound(TY_GLOBAL const ty_bsdf_tables* tables, float cos_i, float cos_o, float roughness) {
    const float larger = ty_maxf(ty_bsdf_sheen_value(tables->sheen[0], cos_i, roughness),
                                 ty_bsdf_sheen_value(tables->sheen[0], cos_o, roughness));
    return ty_maxf(larger, 1.0f);
}

/* ---- nodes ---- */

TY_FN float ty_bsdf_node_cosine(int32_t node) {
    const float x = (float)node * (1.0f / (float)(TY_BSDF_NODES - 1));
    return x * x;
}

/* Node at or below a cosine, but the last, and the fraction of the distance to the next. */
TY_FN int32_t ty_bsdf_node_below(float cosine, float* fraction) {
    const float c = ty_clampf(cosine, 0.0f, 1.0f), x = sqrtf(c) * (float)(TY_BSDF_NODES - 1);
    const int32_t node = x < (float)(TY_BSDF_NODES - 2) ? (int32_t)x : TY_BSDF_NODES - 2;
    const float first = ty_bsdf_node_cosine(node);
    *fraction = (c - first) / (ty_bsdf_node_cosine(node + 1) - first);
    return node;
}

/* Linear interpolation of values at nodes. */
TY_FN float ty_bsdf_at_cosine(const float* values, float cosine) {
    float fraction;
    const int32_t node = ty_bsdf_node_below(cosine, &fraction);
    return ty_lerpf(values[node], values[node + 1], fraction);
}

/* Values at the nodes of a table, given as its first row, at a row's coordinate. */
TY_FN void ty_bsdf_node_values(TY_GLOBAL const float* table, float coordinate, float values[TY_BSDF_NODES]) {
    const float y = ty_clampf(coordinate, 0.0f, 1.0f) * (float)(TY_BSDF_ROUGHNESSES - 1);
    const int32_t row = y < (float)(TY_BSDF_ROUGHNESSES - 2) ? (int32_t)y : TY_BSDF_ROUGHNESSES - 2;
    TY_GLOBAL const float* at = table + row * TY_BSDF_NODES;
    for (int32_t j = 0; j < TY_BSDF_NODES; ++j) values[j] = ty_lerpf(at[j], at[TY_BSDF_NODES + j], y - (float)row);
}

#endif
