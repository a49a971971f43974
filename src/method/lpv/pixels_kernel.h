/* What images have per instruction set. */
#ifndef TY_METHOD_LPV_PIXELS_KERNEL_H
#define TY_METHOD_LPV_PIXELS_KERNEL_H

#include "base/dispatch.h"
#include "method/lpv/fog.k.h"
#include "method/lpv/upsample.k.h"

/* A ray through the media. */
typedef struct ty_fog_way {
    ty_vec origin, direction; /* unit */
    float far;                /* m, TY_FLOAT_MAX at most */
    float offset;             /* where its first step ends, (0, 1] of a step */
} ty_fog_way;

/* A place on a surface, and what arrives there. */
typedef struct ty_look_place {
    ty_vec point, normal;
    float irradiance[3];
} ty_look_place;

typedef struct ty_pixels_kernels {
    void (*fog)(const ty_fog_request* request, const ty_fog_way* ways, int32_t count, ty_fog* out);
    /* What pixels of a row from (x, y) on, at such distances, see of the media; contrast: as ty_air_upsample_row has
     * it. */
    void (*upsample)(const ty_upsample* from, int32_t x, int32_t y, int32_t count, const float* distance,
                     ty_lpv_seen* out, float* contrast);
    void (*irradiance)(const ty_lattice_look* look, ty_look_place* places, int32_t count);
} ty_pixels_kernels;
TY_DECLARE_KERNELS(ty_pixels_kernels);

#endif
