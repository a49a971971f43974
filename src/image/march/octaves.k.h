/* Multiple scattering octaves of lights on cells (Wrenninge, Kulla, Lundqvist 2013): ty_march_octaves of
 * image/march/march.h.
 */
#ifndef TY_IMAGE_OCTAVES_K_H
#define TY_IMAGE_OCTAVES_K_H

#include "image/march/near.k.h"

/* The radiance scattered by octave i = `octave` at a point into direction omega, per metre and per sigma_s: the sum
 * over lights [first, end) of a^i p(c^i g) times their fluence attenuated by b^i sigma_t (Wrenninge, Kulla, Lundqvist
 * 2013). */
TY_FN void ty_octave_scattered(TY_GLOBAL const ty_march_request* request, int32_t octave, ty_vec point,
                               const ty_near_light* lights, int32_t first, int32_t end, ty_vec omega, const float g[3],
                               float radiance[3]) {
    TY_GLOBAL const ty_march_octaves* octaves = &request->octaves;
    TY_GLOBAL const ty_light_fluence* fluences = octaves->lights + (octave - 1) * request->light_count;
    const float a = octaves->scattering[octave], b = octaves->extinction[octave], c_i = octaves->anisotropy[octave];
    const float scaled_g[3] = {c_i * g[0], c_i * g[1], c_i * g[2]};
    ty_single_radiance sent;
    memset(&sent, 0, sizeof sent);
    for (int32_t i = first; i < end; ++i) {
        const ty_near_light* near = &lights[i - first];
        float passing[TY_FLUENCE_COUNT][3] = {{0.0f}};
        for (int32_t c = 0; c < 3; ++c)
            passing[TY_FLUENCE_ORDER_L][c] = near->falloff * ty_attenuation(b * near->depth[c]);
        ty_single_scattered(&fluences[i], point, &near->at, omega, passing, scaled_g, NULL, &request->fit, &sent);
    }
    for (int32_t c = 0; c < 3; ++c) radiance[c] = a * sent.first[c];
}

#endif
