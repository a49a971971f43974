/* Light in media inside dielectrics, as paths look it up: moments of the radiance on cells. */
#ifndef TY_DIRECT_SINGLE_ENCLOSED_FIELD_K_H
#define TY_DIRECT_SINGLE_ENCLOSED_FIELD_K_H

#include "base/sh.k.h"

/* phi_lm of all light, uncollided or scattered: the integrals of the radiance times Y_lm, W m^-2. */
typedef struct ty_enclosed_field {
    int32_t bands; /* L, 2..TY_SH_BANDS_MAX; 0: the interior has no field */
    int32_t size[3];
    float lower[3], per_cell[3];              /* lower corner of the cells, m; cells per m */
    float legendre[3][TY_SH_BANDS_MAX];       /* moments of the phase function, per channel */
    TY_GLOBAL const float* moments[3];        /* bands^2 per cell, x fastest */
    TY_GLOBAL const unsigned char* near_cell; /* 0: the cell holds no values */
} ty_enclosed_field;

/* Trilinear weight of one of the eight cells around a point, and its number; 0 for cells without values. */
TY_FN float ty_enclosed_corner(TY_GLOBAL const ty_enclosed_field* field, const float at[3], int32_t corner,
                               int32_t* cell) {
    float weight = 1.0f;
    *cell = 0;
    for (int32_t a = 2; a >= 0; --a) {
        const float low = floorf(at[a]);
        const int32_t upper = corner >> a & 1, i = (int32_t)low + upper;
        if (i < 0 || i >= field->size[a]) return 0.0f;
        weight *= upper != 0 ? at[a] - low : 1.0f - (at[a] - low);
        *cell = *cell * field->size[a] + i;
    }
    return field->near_cell[*cell] != 0 ? weight : 0.0f;
}

/* In-scattered radiance over the scattering coefficient, int p psi dw, for light that travels along w. */
TY_FN void ty_enclosed_radiance(TY_GLOBAL const ty_enclosed_field* field, ty_vec point, ty_vec w, float out[3]) {
    const float position[3] = {point.x, point.y, point.z};
    float at[3], y[TY_SH_TERMS_MAX], sum = 0.0f;
    const int32_t terms = field->bands * field->bands;
    for (int32_t a = 0; a < 3; ++a)
        at[a] =
            ty_clampf((position[a] - field->lower[a]) * field->per_cell[a] - 0.5f, -0.5f, (float)field->size[a] - 0.5f);
    ty_sh_all(w, y);
    out[0] = out[1] = out[2] = 0.0f;
    for (int32_t corner = 0; corner < 8; ++corner) {
        int32_t cell;
        const float weight = ty_enclosed_corner(field, at, corner, &cell);
        if (!(weight > 0.0f)) continue;
        sum += weight;
        for (int32_t c = 0; c < 3; ++c) {
            TY_GLOBAL const float* phi = field->moments[c] + (size_t)cell * (size_t)terms;
            float value = 0.0f;
            for (int32_t l = 0, t = 0; l < field->bands; ++l) {
                float band = 0.0f;
                for (; t < (l + 1) * (l + 1); ++t) band += phi[t] * y[t];
                value += field->legendre[c][l] * band;
            }
            out[c] += weight * value;
        }
    }
    for (int32_t c = 0; c < 3; ++c) out[c] = sum > 0.0f ? ty_maxf(out[c] / sum, 0.0f) : 0.0f;
}

#endif
