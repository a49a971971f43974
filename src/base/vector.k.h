/* Vectors of three floats, by value. */
#ifndef TY_BASE_VECTOR_K_H
#define TY_BASE_VECTOR_K_H

#include "base/kernel.h"

typedef struct ty_vec {
    float x, y, z;
} ty_vec;

TY_FN ty_vec ty_vec_make(float x, float y, float z) {
    ty_vec v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

TY_FN ty_vec ty_vec_load(TY_GLOBAL const float* p) {
    return ty_vec_make(p[0], p[1], p[2]);
}

TY_FN ty_vec ty_add(ty_vec a, ty_vec b) {
    return ty_vec_make(a.x + b.x, a.y + b.y, a.z + b.z);
}

TY_FN ty_vec ty_sub(ty_vec a, ty_vec b) {
    return ty_vec_make(a.x - b.x, a.y - b.y, a.z - b.z);
}

TY_FN ty_vec ty_scale(ty_vec a, float s) {
    return ty_vec_make(a.x * s, a.y * s, a.z * s);
}

/* a + s b */
TY_FN ty_vec ty_mad(ty_vec a, ty_vec b, float s) {
    return ty_vec_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

TY_FN float ty_dot(ty_vec a, ty_vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

TY_FN ty_vec ty_cross(ty_vec a, ty_vec b) {
    return ty_vec_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

TY_FN ty_vec ty_normalize(ty_vec a) {
    return ty_scale(a, 1.0f / sqrtf(ty_dot(a, a)));
}

/* Two unit vectors that complete unit n to a right-handed orthonormal basis (Duff et al. 2017). */
TY_FN void ty_onb(ty_vec n, ty_vec* s, ty_vec* t) {
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    *s = ty_vec_make(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *t = ty_vec_make(b, sign + n.y * n.y * a, -n.y);
}

/* Unit direction at cosine mu and azimuth `turn` (in turns, 0..1) about unit axis. */
TY_FN ty_vec ty_direction_about(ty_vec axis, float mu, float turn) {
    ty_vec s, t;
    float sine, cosine;
    ty_onb(axis, &s, &t);
    ty_sincos_2pi(turn, &sine, &cosine);
    const float radius = sqrtf(ty_maxf(0.0f, 1.0f - mu * mu));
    return ty_mad(ty_mad(ty_scale(axis, mu), s, radius * cosine), t, radius * sine);
}

/* Affine maps of floats, as ty_affine. */
TY_FN ty_vec ty_map_point(TY_GLOBAL const float* m, ty_vec p) {
    return ty_vec_make(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                       m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}

TY_FN ty_vec ty_map_direction(TY_GLOBAL const float* m, ty_vec d) {
    return ty_vec_make(m[0] * d.x + m[1] * d.y + m[2] * d.z, m[4] * d.x + m[5] * d.y + m[6] * d.z,
                       m[8] * d.x + m[9] * d.y + m[10] * d.z);
}

/* Angle of (x, y) in turns, (-0.5, 0.5], to 2e-6 (minimax polynomial on [0, 1]). */
TY_FN float ty_atan2_over_2pi(float y, float x) {
    const float ax = fabsf(x), ay = fabsf(y);
    const float large = ty_maxf(ax, ay), small = ty_minf(ax, ay);
    const float a = large > 0.0f ? small / large : 0.0f;
    const float s = a * a;
    float r = -0.0117212f;
    r = r * s + 0.05265332f;
    r = r * s - 0.11643287f;
    r = r * s + 0.19354346f;
    r = r * s - 0.33262347f;
    r = (r * s + 0.99997726f) * a * 0.159154943f;
    r = ay > ax ? 0.25f - r : r;
    r = x < 0.0f ? 0.5f - r : r;
    return y < 0.0f ? -r : r;
}

#endif
