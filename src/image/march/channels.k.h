/* Values of an image's channels from the sums over a pixel's rays. */
#ifndef TY_IMAGE_CHANNELS_K_H
#define TY_IMAGE_CHANNELS_K_H

#include "image/march/kernel.h"

/* A pixel's value of component c of a group of channels. background: radiance added to the color. */
TY_FN float ty_pixel_value(const ty_march_pixel* pixel, uint32_t aov, int32_t c, int32_t spp, float background) {
    const float inverse_spp = 1.0f / (float)spp;
    switch (aov) {
    case TY_AOV_TRANSMITTANCE: return pixel->transmittance[c] * inverse_spp;
    case TY_AOV_DEPTH: return pixel->hits > 0.0f ? pixel->depth / pixel->hits : 0.0f;
    case TY_AOV_SINGLE: return pixel->single[c] * inverse_spp;
    case TY_AOV_MULTIPLE: return ty_maxf(0.0f, pixel->multiple[c] * inverse_spp);
    default: break;
    }
    return (pixel->unscattered[c] + pixel->single[c] + ty_maxf(0.0f, pixel->multiple[c])) * inverse_spp + background;
}

#endif
