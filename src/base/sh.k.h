/* Real spherical harmonics up to band 4, in the order l (l + 1) + m, without the Condon-Shortley phase. */
#ifndef TY_BASE_SH_K_H
#define TY_BASE_SH_K_H

#include "base/vector.k.h"

/* Bands and terms of light propagating through cells; and the maximum. */
enum { TY_SH_BANDS = 3, TY_SH_TERMS = 9, TY_SH_BANDS_MAX = 5, TY_SH_TERMS_MAX = 25 };

/* Y_0; factors of Y_1 to Y_4, by order. */
#define TY_SH_0 0.282094792f  /* 1 / (2 sqrt(pi)) */
#define TY_SH_1 0.488602512f  /* sqrt(3 / (4 pi)) */
#define TY_SH_2 1.092548431f  /* sqrt(15 / (4 pi)) */
#define TY_SH_20 0.315391565f /* sqrt(5 / (16 pi)) */
#define TY_SH_30 0.373176333f /* sqrt(7 / (16 pi)) */
#define TY_SH_31 0.457045799f /* sqrt(21 / (32 pi)) */
#define TY_SH_32 1.445305721f /* sqrt(105 / (16 pi)) */
#define TY_SH_33 0.590043590f /* sqrt(35 / (32 pi)) */
#define TY_SH_40 0.105785547f /* sqrt(9 / (256 pi)) */
#define TY_SH_41 0.669046544f /* sqrt(45 / (32 pi)) */
#define TY_SH_42 0.473087348f /* sqrt(45 / (64 pi)) */
#define TY_SH_43 1.770130769f /* sqrt(315 / (32 pi)) */
#define TY_SH_44 0.625835735f /* sqrt(315 / (256 pi)) */

/* The first bands * bands functions, of 1 to 3 bands, at a unit vector. */
TY_FN void ty_sh_at(ty_vec w, int32_t bands, float y[TY_SH_TERMS]) {
    y[0] = TY_SH_0;
    y[1] = TY_SH_1 * w.y;
    y[2] = TY_SH_1 * w.z;
    y[3] = TY_SH_1 * w.x;
    if (bands < 3) return;
    y[4] = TY_SH_2 * w.x * w.y;
    y[5] = TY_SH_2 * w.y * w.z;
    y[6] = TY_SH_20 * (3.0f * w.z * w.z - 1.0f);
    y[7] = TY_SH_2 * w.x * w.z;
    y[8] = 0.5f * TY_SH_2 * (w.x * w.x - w.y * w.y);
}

/* All five bands. */
TY_FN void ty_sh_all(ty_vec w, float y[TY_SH_TERMS_MAX]) {
    ty_sh_at(w, TY_SH_BANDS, y);
    const float x2 = w.x * w.x, y2 = w.y * w.y, z2 = w.z * w.z;
    y[9] = TY_SH_33 * w.y * (3.0f * x2 - y2);
    y[10] = 2.0f * TY_SH_32 * w.x * w.y * w.z;
    y[11] = TY_SH_31 * w.y * (5.0f * z2 - 1.0f);
    y[12] = TY_SH_30 * w.z * (5.0f * z2 - 3.0f);
    y[13] = TY_SH_31 * w.x * (5.0f * z2 - 1.0f);
    y[14] = TY_SH_32 * w.z * (x2 - y2);
    y[15] = TY_SH_33 * w.x * (x2 - 3.0f * y2);
    y[16] = 4.0f * TY_SH_44 * w.x * w.y * (x2 - y2);
    y[17] = TY_SH_43 * w.y * w.z * (3.0f * x2 - y2);
    y[18] = 2.0f * TY_SH_42 * w.x * w.y * (7.0f * z2 - 1.0f);
    y[19] = TY_SH_41 * w.y * w.z * (7.0f * z2 - 3.0f);
    y[20] = TY_SH_40 * (z2 * (35.0f * z2 - 30.0f) + 3.0f);
    y[21] = TY_SH_41 * w.x * w.z * (7.0f * z2 - 3.0f);
    y[22] = TY_SH_42 * (x2 - y2) * (7.0f * z2 - 1.0f);
    y[23] = TY_SH_43 * w.x * w.z * (x2 - 3.0f * y2);
    y[24] = TY_SH_44 * (x2 * (x2 - 3.0f * y2) - y2 * (3.0f * x2 - y2));
}

/* Convolution factor of band l for max(0, cosine) about a vector (Ramamoorthi and Hanrahan 2001). The cosine's integral
 * is pi. */
TY_FN float ty_sh_cosine(int32_t l) {
    return l == 0 ? TY_PI : l == 1 ? TY_PI * 2.0f / 3.0f : TY_PI / 4.0f;
}

/* Band of a term. */
TY_FN int32_t ty_sh_band(int32_t term) {
    return term == 0 ? 0 : term < 4 ? 1 : term < 9 ? 2 : term < 16 ? 3 : 4;
}

#endif
