/* Rays through the media: multiple scattering by a ray march, single scattering by airlight. */
#ifndef TY_METHOD_LPV_MEDIA_PASS_H
#define TY_METHOD_LPV_MEDIA_PASS_H

#include "method/lpv/image/march_state.h"

/* The pixel that ray (x, y) of the half-resolution pass goes through, in an unbounded image; the pattern repeats every
 * TY_LPV_UPSAMPLE_PERIOD pixels. */
void ty_lpv_media_ray_pixel(int32_t x, int32_t y, int32_t full[2]);
/* The result of a ray march over `distance` m (INFINITY: unbounded), without single scattering. */
ty_lpv_media_radiance ty_lpv_media_radiance_of(const ty_ray_march_result* ray_march, float distance);
/* The ray of a pixel of the image. */
ty_media_ray ty_lpv_media_ray_of(const ty_lpv_march_state* state, int32_t x, int32_t y, float offset);
/* The offset of the first step, in (0, 1] of a step, spread over neighbouring rays. */
float ty_lpv_step_offset(const ty_lpv_march_state* state, int32_t x, int32_t y);

/* Multiple scattering of a tile of rays. */
void ty_lpv_ray_march_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom);
/* Adds single scattering of the light of lights with extent on at most TY_TILE rays. */
void ty_lpv_add_uncollided(const ty_lpv_march_state* state, const ty_media_ray* rays, int32_t count,
                           float (*single)[3]);
/* Single scattering of a tile of rays, after ty_lpv_ray_march_tile. */
void ty_lpv_single_scattering_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom);

#endif
