/* Lookups in bounded media and in media of one albedo and g. */
#ifndef TY_METHOD_IMPULSE_LOOKUP_H
#define TY_METHOD_IMPULSE_LOOKUP_H

#include "base/vector.k.h"

#include <tyndall/impulse.h>

#include <math.h>

/* ty_impulse_look for a bounded medium: each bounce from the second on is limited to max_ratio times the previous one.
 */
void ty_impulse_lookup_bounded(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                               float distance, float cosine, int32_t bounces, float max_ratio,
                               ty_impulse_response* out);

/* ---- media of one albedo and g ---- */

/* Response of one bin: single and multiple scattering; the last float of `single` is the axis tilt. */
typedef struct ty_impulse_sum {
    float single[TY_IMPULSE_TERMS + 1], multiple[TY_IMPULSE_TERMS + 1];
} ty_impulse_sum;

/* Tables with summed bounces for one albedo and g: a lookup reads two bins, or four for areas. */
typedef struct ty_impulse_merged {
    const ty_impulse_sum* rows;       /* ty_impulse_merged_rows() of them */
    const float* cosines;             /* TY_IMPULSE_ANGLES cosines of areas */
    float near, density, linear_rate; /* map from distances to bins (tables.h) */
} ty_impulse_merged;

size_t ty_impulse_merged_rows(void);
void ty_impulse_merge(const ty_impulse* tables, float albedo, float g, int32_t bounces, float max_ratio,
                      ty_impulse_sum* rows, ty_impulse_merged* out);

/* Equals ty_impulse_lookup_bounded with this sigma_t, 1/m. */
TY_FN void ty_impulse_lookup_merged(const ty_impulse_merged* merged, int32_t emitter, float sigma_t, float distance,
                                    float cosine, ty_impulse_response* out) {
    const bool area = emitter == TY_IMPULSE_AREA;
    const float optical = ty_maxf(sigma_t * distance, 1e-6f), last = TY_IMPULSE_DISTANCES - 1;
    const float position =
        merged->density * (ty_logf(optical / merged->near) + merged->linear_rate * (optical - merged->near));
    const float bin = ty_clampf(position, 0.0f, last);
    const int32_t low = (int32_t)ty_minf(bin, last - 1.0f);
    const float fraction = bin - (float)low, half = ty_expf(-0.5f * optical);
    int32_t left = 0;
    while (area && left < TY_IMPULSE_ANGLES - 2 && cosine >= merged->cosines[left + 1]) ++left;
    const float step = merged->cosines[left + 1] - merged->cosines[left];
    const float right = area ? ty_clampf((cosine - merged->cosines[left]) / step, 0.0f, 1.0f) : 0.0f;
    const int32_t row = (area ? 2 + left : emitter) * TY_IMPULSE_DISTANCES + low;
    const ty_impulse_sum* at = merged->rows + row;
    const ty_impulse_sum* next = at + (area ? TY_IMPULSE_DISTANCES : 0);
    const float near2 = emitter == TY_IMPULSE_DIRECTIONAL ? 1.0f : sigma_t * sigma_t;
    const float single_scale = near2 * half * half / (emitter == TY_IMPULSE_DIRECTIONAL ? 1.0f : optical);
    const float a = (1.0f - right) * (1.0f - fraction), b = (1.0f - right) * fraction, c = right * (1.0f - fraction),
                d = right * fraction;
    for (int l = 0; l < TY_IMPULSE_TERMS; ++l) {
        out->single[l] =
            single_scale * (a * at[0].single[l] + b * at[1].single[l] + c * next[0].single[l] + d * next[1].single[l]);
        out->multiple[l] =
            near2 * half *
            (a * at[0].multiple[l] + b * at[1].multiple[l] + c * next[0].multiple[l] + d * next[1].multiple[l]);
    }
    const int shift = TY_IMPULSE_TERMS;
    const float sine = area ? sqrtf(ty_maxf(0.0f, 1.0f - cosine * cosine)) : 0.0f;
    out->shift = sine * (a * at[0].single[shift] + b * at[1].single[shift] + c * next[0].single[shift] +
                         d * next[1].single[shift]);
}

#endif
