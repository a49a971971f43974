/* Lookups for those who know how far the medium goes. */
#ifndef TY_IMPULSE_LOOK_H
#define TY_IMPULSE_LOOK_H

#include <tyndall/impulse.h>

/* ty_impulse_look where light leaves the medium: none of the bounces from the second on is brighter than `most` times
 * the one before it. */
void ty_impulse_look_within(const ty_impulse* tables, ty_impulse_emitter emitter, const ty_impulse_medium* medium,
                            float distance, float cosine, int32_t bounces, float most, ty_impulse_response* out);

#endif
