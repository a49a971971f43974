/* Language of the kernels (*.k.h): a C subset for this machine's compilers, OpenCL C 1.2 and CUDA.
 *
 * TY_FN marks a kernel function; TY_FN_CALLED one that is not inlined, because seldom used code would take registers
 * and what compilers inline from its callers; TY_FN_APART one that this machine's compilers build once for all kernels,
 * in a file of its own; TY_GLOBAL a pointer to memory passed in by a launcher. TY_DEVICE is defined where a kernel is
 * built for another device, or for this machine as it is for others (docs/device.md): a file then has all its text. */
#ifndef TY_BASE_KERNEL_H
#define TY_BASE_KERNEL_H

#if !defined(__OPENCL_C_VERSION__)
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#endif

#if defined(__CUDACC__)
#define TY_FN static __device__ inline
#define TY_FN_CALLED static __device__ __noinline__
#define TY_FN_APART static __device__
#define TY_GLOBAL
#elif defined(__OPENCL_C_VERSION__)
#define TY_FN static inline
#define TY_FN_CALLED static
#define TY_FN_APART static
#define TY_GLOBAL __global
#else
#define TY_FN static inline __attribute__((unused))
#define TY_FN_CALLED static __attribute__((unused, noinline))
#if defined(TY_DEVICE)
#define TY_FN_APART static __attribute__((unused))
#else
#define TY_FN_APART
#endif
#define TY_GLOBAL
#endif

#define TY_PI 3.14159265358979323846f
#define TY_FLOAT_MAX 3.402823466e38f

TY_FN float ty_minf(float a, float b) {
    return a < b ? a : b;
}

TY_FN float ty_maxf(float a, float b) {
    return a > b ? a : b;
}

TY_FN float ty_clampf(float value, float low, float high) {
    return ty_minf(ty_maxf(value, low), high);
}

TY_FN float ty_lerpf(float a, float b, float t) {
    return a + t * (b - a);
}

TY_FN float ty_float_from_bits(uint32_t bits) {
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

TY_FN uint32_t ty_bits_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* e^x to 2 ulp for x in [-87, 88]; 0 below, e^88 above. Degree 6 over [-ln 2 / 2, ln 2 / 2] (Taylor, minimax-tuned). */
TY_FN float ty_expf(float x) {
    if (x < -87.0f) return 0.0f;
    const float y = ty_minf(x, 88.0f);
    const float k = floorf(y * 1.44269504f + 0.5f);
    const float r = (y - k * 0.693359375f) + k * 2.12194440e-4f;
    float p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    p = p * r * r + r + 1.0f;
    return p * ty_float_from_bits((uint32_t)((int32_t)k + 127) << 23);
}

/* e^-x for x in [0, 87], exact at 0, to (2 + x) ulp, which is the error from rounding x. Half the work of ty_expf, and
 * branch-free: 2^-x' is split at the nearest integer by adding 1.5 * 2^23, whose low bits then hold the exponent. */
TY_FN float ty_exp_neg(float x) {
    const float shifted = 12582912.0f - x * 1.44269504f;
    const float r = -(shifted - 12582912.0f) - x * 1.44269504f;
    float p = 1.3276472e-3f;
    p = p * r + 9.6755413e-3f;
    p = p * r + 5.5507133e-2f;
    p = p * r + 2.4022120e-1f;
    p = p * r + 6.9314697e-1f;
    p = p * r + 1.0f;
    return ty_float_from_bits(ty_bits_from_float(p) + (ty_bits_from_float(shifted) << 23));
}

/* Natural logarithm to 2 ulp for normal x > 0. */
TY_FN float ty_logf(float x) {
    const uint32_t bits = ty_bits_from_float(x);
    const uint32_t shifted = bits - 0x3f3504f3u; /* sqrt(1/2) */
    const float k = (float)((int32_t)shifted >> 23);
    const float m = ty_float_from_bits((shifted & 0x007fffffu) + 0x3f3504f3u) - 1.0f;
    float p = 7.0376836292e-2f;
    p = p * m - 1.1514610310e-1f;
    p = p * m + 1.1676998740e-1f;
    p = p * m - 1.2420140846e-1f;
    p = p * m + 1.4249322787e-1f;
    p = p * m - 1.6668057665e-1f;
    p = p * m + 2.0000714765e-1f;
    p = p * m - 2.4999993993e-1f;
    p = p * m + 3.3333331174e-1f;
    const float square = m * m;
    float y = m * square * p;
    y += k * -2.12194440e-4f;
    y -= 0.5f * square;
    return m + y + k * 0.693359375f;
}

/* Sine and cosine of 2 pi u, u in [0, 1], to 1.2e-7. */
TY_FN void ty_sincos_2pi(float u, float* sine, float* cosine) {
    const float quarter = floorf(u * 4.0f + 0.5f);
    const float x = (u * 4.0f - quarter) * 1.57079633f;
    const float square = x * x;
    const float s = x + x * square * (-1.6666654611e-1f + square * (8.3321608736e-3f - square * 1.9515295891e-4f));
    const float c = 1.0f - 0.5f * square +
                    square * square * (4.166664568e-2f + square * (-1.388731625e-3f + square * 2.443315712e-5f));
    const int32_t quadrant = (int32_t)quarter & 3;
    const float a = (quadrant & 1) != 0 ? c : s;
    const float b = (quadrant & 1) != 0 ? s : c;
    *sine = (quadrant & 2) != 0 ? -a : a;
    *cosine = quadrant == 1 || quadrant == 2 ? -b : b;
}

#endif
