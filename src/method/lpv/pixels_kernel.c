/* The kernels of images; built once per instruction set, with TY_ISA naming it. */
#include "method/lpv/pixels_kernel.h"

#include "base/float_mode.h"

static void fog(const ty_fog_request* request, const ty_fog_way* ways, int32_t count, ty_fog* out) {
    const unsigned state = ty_flush_denormals();
    ty_fog_ray ray;
    for (int32_t i = 0; i < count; ++i) {
        ty_fog_follow(&ray, request, ways[i].origin, ways[i].direction, ways[i].far, ways[i].offset);
        out[i] = ray.out;
    }
    ty_restore_denormals(state);
}

static void upsample(const ty_upsample* from, int32_t x, int32_t y, int32_t count, const float* distance,
                     ty_lpv_seen* out, float* contrast) {
    const ty_air_lanes lanes = ty_air_lanes_make();
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < count; i += TY_AIR_ROW)
        ty_air_upsample_row(&lanes, from, x + i, y, count - i < TY_AIR_ROW ? count - i : TY_AIR_ROW, distance + i,
                            out + i, contrast + i);
    ty_restore_denormals(state);
}

static void irradiance(const ty_lattice_look* look, ty_look_place* places, int32_t count) {
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < count; ++i)
        ty_look_at_surface(look, places[i].point, places[i].normal, places[i].irradiance);
    ty_restore_denormals(state);
}

const ty_pixels_kernels TY_KERNEL_NAME(ty_pixels_kernels) = {
    .fog = fog, .upsample = upsample, .irradiance = irradiance};
