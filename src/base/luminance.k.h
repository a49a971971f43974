/* Luminance of linear colours with the primaries of sRGB (Rec. ITU-R BT.709). */
#ifndef TY_BASE_LUMINANCE_K_H
#define TY_BASE_LUMINANCE_K_H

#include "base/kernel.h"

TY_FN float ty_luminance(float r, float g, float b) {
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

TY_FN float ty_luminance_of(const float rgb[3]) {
    return ty_luminance(rgb[0], rgb[1], rgb[2]);
}

#if !defined(__OPENCL_C_VERSION__)
TY_FN double ty_luminance_f64(const double rgb[3]) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}
#endif

#endif
