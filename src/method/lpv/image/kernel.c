/* The kernels of images; built once per instruction set, with TY_ISA naming it. */
#include "method/lpv/image/kernel.h"

#include "base/float_mode.h"

static void ray_march(const ty_ray_march_request* request, const ty_media_ray* rays, int32_t count,
                      ty_ray_march_result* out) {
    const unsigned state = ty_flush_denormals();
    ty_ray_march ray;
    for (int32_t i = 0; i < count; ++i) {
        ty_ray_march_follow(&ray, request, rays[i].origin, rays[i].direction, rays[i].far, rays[i].offset);
        out[i] = ray.out;
    }
    ty_restore_denormals(state);
}

static void upsample(const ty_lpv_upsample* from, int32_t x, int32_t y, int32_t count, const float* distance,
                     ty_lpv_media_radiance* out, float* contrast) {
    const ty_lpv_upsample_lanes lanes = ty_lpv_upsample_lanes_make();
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < count; i += TY_LPV_UPSAMPLE_WIDTH)
        ty_lpv_upsample_row(&lanes, from, x + i, y,
                            count - i < TY_LPV_UPSAMPLE_WIDTH ? count - i : TY_LPV_UPSAMPLE_WIDTH, distance + i,
                            out + i, contrast + i);
    ty_restore_denormals(state);
}

static void irradiance(const ty_packed_lattices* lattices, ty_irradiance_query* places, int32_t count) {
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < count; ++i)
        ty_packed_irradiance(lattices, places[i].point, places[i].normal, places[i].irradiance);
    ty_restore_denormals(state);
}

const ty_lpv_image_kernels TY_KERNEL_NAME(ty_lpv_image_kernels) = {
    .ray_march = ray_march, .upsample = upsample, .irradiance = irradiance};
