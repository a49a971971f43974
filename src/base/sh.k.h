/* Real spherical harmonics up to band 2, in the order l (l + 1) + m, without the Condon-Shortley phase. */
#ifndef TY_BASE_SH_K_H
#define TY_BASE_SH_K_H

#include "base/vector.k.h"

enum { TY_SH_BANDS = 3, TY_SH_TERMS = 9 };

/* Y_0; factors of Y_1 and Y_2. */
#define TY_SH_0 0.282094792f  /* 1 / (2 sqrt(pi)) */
#define TY_SH_1 0.488602512f  /* sqrt(3 / (4 pi)) */
#define TY_SH_2 1.092548431f  /* sqrt(15 / (4 pi)) */
#define TY_SH_20 0.315391565f /* sqrt(5 / (16 pi)) */

/* The first bands * bands functions at a unit vector. */
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

/* max(0, cosine) about a vector: what band l of ty_sh_at is to be multiplied by (Ramamoorthi and Hanrahan 2001). Its
 * integral is pi. */
TY_FN float ty_sh_cosine(int32_t l) {
    return l == 0 ? TY_PI : l == 1 ? TY_PI * 2.0f / 3.0f : TY_PI / 4.0f;
}

/* The band of a term. */
TY_FN int32_t ty_sh_band(int32_t term) {
    return term == 0 ? 0 : term < 4 ? 1 : 2;
}

#endif
