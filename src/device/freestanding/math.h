/* The part of math.h that kernels use, where there is no C library: the compiler's own functions, and elementary
 * functions that processors have no instruction for. */
#ifndef TY_DEVICE_FREESTANDING_MATH_H
#define TY_DEVICE_FREESTANDING_MATH_H

#define INFINITY __builtin_inff()

#define floorf __builtin_floorf
#define ceilf __builtin_ceilf
#define sqrtf __builtin_sqrtf
#define fabsf __builtin_fabsf
#define copysignf __builtin_copysignf
#define fabs __builtin_fabs
#define floor __builtin_floor
#define sqrt __builtin_sqrt
#define isfinite __builtin_isfinite

/* Those of base/kernel.h, which every kernel has. */
#define expf ty_expf
#define logf ty_logf

#define TY_MATH static inline __attribute__((unused))

/* Sine and cosine of x in [-pi / 4, pi / 4], to 1 ulp (minimax polynomials). */
TY_MATH float ty_math_sine(float x) {
    const float s = x * x;
    return x + x * s * (-1.6666654611e-1f + s * (8.3321608736e-3f - s * 1.9515295891e-4f));
}

TY_MATH float ty_math_cosine(float x) {
    const float s = x * x;
    return 1.0f - 0.5f * s + s * s * (4.166664568e-2f + s * (-1.388731625e-3f + s * 2.443315712e-5f));
}

/* x less the nearest multiple of pi / 2, whose number modulo 4 is *quadrant; to 1e-7 for |x| below 1000. */
TY_MATH float ty_math_reduce(float x, int* quadrant) {
    const float k = floorf(x * 0.636619772f + 0.5f);
    *quadrant = (int)k & 3;
    return ((x - k * 1.5703125f) - k * 4.837512969970703125e-4f) - k * 7.54978995489188e-8f;
}

TY_MATH float ty_math_cosf(float x) {
    int quadrant;
    const float y = ty_math_reduce(x, &quadrant);
    const float value = (quadrant & 1) != 0 ? ty_math_sine(y) : ty_math_cosine(y);
    return quadrant == 1 || quadrant == 2 ? -value : value;
}

TY_MATH float ty_math_tanf(float x) {
    int quadrant;
    const float y = ty_math_reduce(x, &quadrant);
    const float sine = ty_math_sine(y), cosine = ty_math_cosine(y);
    return (quadrant & 1) != 0 ? -cosine / sine : sine / cosine;
}

/* To 2 ulp: the argument is brought into [-tan(pi / 8), tan(pi / 8)]. */
TY_MATH float ty_math_atanf(float x) {
    const float a = fabsf(x);
    const float base = a > 2.414213562f ? 1.57079632679f : a > 0.4142135624f ? 0.785398163397f : 0.0f;
    const float y = a > 2.414213562f ? -1.0f / a : a > 0.4142135624f ? (a - 1.0f) / (a + 1.0f) : a;
    const float s = y * y;
    const float p = (((8.05374449538e-2f * s - 1.38776856032e-1f) * s + 1.99777106478e-1f) * s - 3.33329491539e-1f) * s;
    return copysignf(base + (p * y + y), x);
}

TY_MATH float ty_math_atan2f(float y, float x) {
    const float pi = 3.14159265359f;
    if (x == 0.0f) return y == 0.0f ? 0.0f : copysignf(0.5f * pi, y);
    const float angle = ty_math_atanf(y / x);
    return x > 0.0f ? angle : angle + copysignf(pi, y);
}

#define cosf ty_math_cosf
#define tanf ty_math_tanf
#define atanf ty_math_atanf
#define atan2f ty_math_atan2f

#endif
