/* Lookups for those who know how far the medium goes, and what all of it is like. */
#ifndef TY_IMPULSE_LOOK_H
#define TY_IMPULSE_LOOK_H

#include "base/vector.k.h"

#include <tyndall/impulse.h>

#include <math.h>

/* ty_impulse_look where light leaves the medium: none of the bounces from the second on is brighter than `most` times
 * the one before it. */
void ty_impulse_look_within(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                            float distance, float cosine, int32_t bounces, float most, ty_impulse_response* out);

/* ---- media of one albedo and g ---- */

/* A bin's response: light that scattered once, and more often; each has one more float, of the first the shift. */
typedef struct ty_impulse_sum {
    float once[TY_IMPULSE_TERMS + 1], more[TY_IMPULSE_TERMS + 1];
} ty_impulse_sum;

/* Tables whose bounces are summed, for one albedo and g: a lookup reads two bins, of areas four. */
typedef struct ty_impulse_merged {
    const ty_impulse_sum* rows; /* ty_impulse_merged_rows() of them */
    const float* cosines;       /* TY_IMPULSE_ANGLES of areas */
    float near, density, even;  /* where distances lie among bins (tables.h) */
} ty_impulse_merged;

size_t ty_impulse_merged_rows(void);
void ty_impulse_merge(const ty_impulse* tables, float albedo, float g, int32_t bounces, float most,
                      ty_impulse_sum* rows, ty_impulse_merged* out);

/* What ty_impulse_look_within gives, for sigma_t 1/m. */
TY_FN void ty_impulse_look_merged(const ty_impulse_merged* merged, int32_t emitter, float sigma_t, float distance,
                                  float cosine, ty_impulse_response* out) {
    const bool area = emitter == TY_IMPULSE_AREA;
    const float optical = ty_maxf(sigma_t * distance, 1e-6f), last = TY_IMPULSE_DISTANCES - 1;
    const float place = merged->density * (ty_logf(optical / merged->near) + merged->even * (optical - merged->near));
    const float bin = ty_clampf(place, 0.0f, last);
    const int32_t low = (int32_t)ty_minf(bin, last - 1.0f);
    const float onward = bin - (float)low, half = ty_expf(-0.5f * optical);
    int32_t left = 0;
    while (area && left < TY_IMPULSE_ANGLES - 2 && cosine >= merged->cosines[left + 1]) ++left;
    const float step = merged->cosines[left + 1] - merged->cosines[left];
    const float right = area ? ty_clampf((cosine - merged->cosines[left]) / step, 0.0f, 1.0f) : 0.0f;
    const int32_t row = (area ? 2 + left : emitter) * TY_IMPULSE_DISTANCES + low;
    const ty_impulse_sum* at = merged->rows + row;
    const ty_impulse_sum* next = at + (area ? TY_IMPULSE_DISTANCES : 0);
    const float near2 = emitter == TY_IMPULSE_DIRECTIONAL ? 1.0f : sigma_t * sigma_t;
    const float once = near2 * half * half / (emitter == TY_IMPULSE_DIRECTIONAL ? 1.0f : optical);
    const float a = (1.0f - right) * (1.0f - onward), b = (1.0f - right) * onward, c = right * (1.0f - onward),
                d = right * onward;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out->single[l] = once * (a * at[0].once[l] + b * at[1].once[l] + c * next[0].once[l] + d * next[1].once[l]);
        out->multiple[l] =
            near2 * half * (a * at[0].more[l] + b * at[1].more[l] + c * next[0].more[l] + d * next[1].more[l]);
    }
    const int shift = TY_IMPULSE_TERMS;
    const float sine = area ? sqrtf(ty_maxf(0.0f, 1.0f - cosine * cosine)) : 0.0f;
    out->shift =
        sine * (a * at[0].once[shift] + b * at[1].once[shift] + c * next[0].once[shift] + d * next[1].once[shift]);
}

#endif
