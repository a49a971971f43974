/* Directional albedos of white microfacets and of sheen, tabulated when the library is built (make_tables.c). */
#ifndef TY_SCENE_BSDF_TABLES_K_H
#define TY_SCENE_BSDF_TABLES_K_H

#include "scene/bsdf/microfacet.k.h"

/* Points along the cosine, the roughness and the index of refraction. */
enum { TY_BSDF_COSINES = 64, TY_BSDF_ROUGHNESSES = 32, TY_BSDF_IORS = 16 };

/* Rows of equal roughness, which go from 0 to 1. */
typedef struct ty_bsdf_tables {
    float reflected[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES]; /* GGX of reflectance 1 */
    float schlick[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES];   /* GGX of reflectance (1 - v.h)^5 */
    float sheen[TY_BSDF_ROUGHNESSES][TY_BSDF_COSINES];
    float reflected_mean[TY_BSDF_ROUGHNESSES]; /* over cosine-weighted directions */
    float schlick_mean[TY_BSDF_ROUGHNESSES];
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

/* Bilinear value of a table, given as its first row. */
TY_FN float ty_bsdf_albedo(TY_GLOBAL const float* table, float cosine, float roughness) {
    const float x = ty_bsdf_cosine_coordinate(ty_clampf(cosine, 0.0f, 1.0f), roughness) * (float)(TY_BSDF_COSINES - 1);
    const float y = ty_clampf(roughness, 0.0f, 1.0f) * (float)(TY_BSDF_ROUGHNESSES - 1);
    const int32_t column = x < (float)(TY_BSDF_COSINES - 2) ? (int32_t)x : TY_BSDF_COSINES - 2;
    const int32_t row = y < (float)(TY_BSDF_ROUGHNESSES - 2) ? (int32_t)y : TY_BSDF_ROUGHNESSES - 2;
    TY_GLOBAL const float* at = table + row * TY_BSDF_COSINES + column;
    const float fraction = x - (float)column;
    return ty_lerpf(ty_lerpf(at[0], at[1], fraction), ty_lerpf(at[TY_BSDF_COSINES], at[TY_BSDF_COSINES + 1], fraction),
                    y - (float)row);
}

#endif
