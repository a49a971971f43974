/* Blackbody radiance from a table. */
#ifndef TY_SCENE_MEDIA_BLACKBODY_K_H
#define TY_SCENE_MEDIA_BLACKBODY_K_H

#include "base/kernel.h"

#define TY_BLACKBODY_COLDEST 200.0f
#define TY_BLACKBODY_HOTTEST 100000.0f

/* Knots are evenly spaced within each octave of the temperature, so that the bits of a float give the interval. */
enum {
    TY_BLACKBODY_STEPS_LOG2 = 6,
    TY_BLACKBODY_OCTAVES = 9,
    TY_BLACKBODY_KNOTS = (TY_BLACKBODY_OCTAVES << TY_BLACKBODY_STEPS_LOG2) + 1
};

/* Logarithms of X, Y and Z, W m^-2 sr^-1. */
typedef struct ty_blackbody_table {
    float log_xyz[TY_BLACKBODY_KNOTS][3];
} ty_blackbody_table;

/* Linear Rec.709 (white D65) from CIE XYZ, clipped at 0. */
TY_FN void ty_rgb_from_xyz(const float xyz[3], float rgb[3]) {
    rgb[0] = ty_maxf(0.0f, 3.2409699f * xyz[0] - 1.5373832f * xyz[1] - 0.4986108f * xyz[2]);
    rgb[1] = ty_maxf(0.0f, -0.9692436f * xyz[0] + 1.8759675f * xyz[1] + 0.0415551f * xyz[2]);
    rgb[2] = ty_maxf(0.0f, 0.0556301f * xyz[0] - 0.2039770f * xyz[1] + 1.0569715f * xyz[2]);
}

/* ty_blackbody from the table, to 1e-4 of the brightest channel from 800 K up and to 5e-4 below. Interpolates
 * logarithms linearly in 1/T: by Wien's law they are nearly linear. */
TY_FN void ty_blackbody_lookup(TY_GLOBAL const ty_blackbody_table* table, float kelvin, float radiance[3]) {
    if (!(kelvin >= TY_BLACKBODY_COLDEST)) {
        for (int c = 0; c < 3; ++c) radiance[c] = 0.0f;
        return;
    }
    const int shift = 23 - TY_BLACKBODY_STEPS_LOG2;
    const float x = ty_minf(kelvin, TY_BLACKBODY_HOTTEST) * (1.0f / TY_BLACKBODY_COLDEST);
    const uint32_t bits = ty_bits_from_float(ty_maxf(x, 1.0f)), cell = bits >> shift;
    const uint32_t knot = cell - (127u << TY_BLACKBODY_STEPS_LOG2);
    const float low = ty_float_from_bits(cell << shift), high = ty_float_from_bits((cell + 1u) << shift);
    const float fraction = (x - low) / (high - low) * (high / x);
    float xyz[3];
    for (int c = 0; c < 3; ++c)
        xyz[c] = ty_expf(ty_lerpf(table->log_xyz[knot][c], table->log_xyz[knot + 1][c], fraction));
    ty_rgb_from_xyz(xyz, radiance);
}

#endif
