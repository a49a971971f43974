/* Octahedral map of directions (Meyer et al. 2010): the square [-1, 1]^2, whose edges are glued to themselves. */
#ifndef TY_BASE_OCTAHEDRAL_K_H
#define TY_BASE_OCTAHEDRAL_K_H

#include "base/vector.k.h"

/* Unit direction of coordinates in [-1, 1]. */
TY_FN ty_vec ty_octahedral_direction(float u, float v) {
    const float z = 1.0f - fabsf(u) - fabsf(v);
    const float fold = ty_maxf(0.0f, -z);
    const ty_vec d = ty_vec_make(u + (u >= 0.0f ? -fold : fold), v + (v >= 0.0f ? -fold : fold), z);
    return ty_scale(d, 1.0f / sqrtf(ty_dot(d, d)));
}

/* Solid angle of a cell about a direction, sr, on a map of n x n cells. */
TY_FN float ty_octahedral_angle(ty_vec d, int32_t n) {
    const float sum = fabsf(d.x) + fabsf(d.y) + fabsf(d.z), side = 2.0f / (float)n;
    return sum * sum * sum * side * side;
}

/* Coordinates of any nonzero vector. */
TY_FN void ty_octahedral_map(ty_vec d, float* u, float* v) {
    const float scale = 1.0f / (fabsf(d.x) + fabsf(d.y) + fabsf(d.z));
    const float x = d.x * scale, y = d.y * scale;
    *u = d.z >= 0.0f ? x : (x >= 0.0f ? 1.0f : -1.0f) * (1.0f - fabsf(y));
    *v = d.z >= 0.0f ? y : (y >= 0.0f ? 1.0f : -1.0f) * (1.0f - fabsf(x));
}

/* Maps a cell of the border ring (i or j is -1 or n) to the cell it duplicates; other cells are unchanged. */
TY_FN void ty_octahedral_wrap(int32_t n, int32_t* i, int32_t* j) {
    if (*i < 0 || *i >= n) {
        *i = *i < 0 ? 0 : n - 1;
        *j = n - 1 - *j;
    }
    if (*j < 0 || *j >= n) {
        *j = *j < 0 ? 0 : n - 1;
        *i = n - 1 - *i;
    }
}

/* Center direction of a cell of a map of n x n cells, row by row. */
TY_FN ty_vec ty_octahedral_texel(int32_t n, int32_t cell) {
    const float side = 2.0f / (float)n;
    return ty_octahedral_direction(((float)(cell % n) + 0.5f) * side - 1.0f, ((float)(cell / n) + 0.5f) * side - 1.0f);
}

/* The four cells around a direction, and their bilinear weights. */
TY_FN void ty_octahedral_around(int32_t n, ty_vec d, int32_t cell[4], float weight[4]) {
    float u, v;
    ty_octahedral_map(d, &u, &v);
    const float x = (u + 1.0f) * 0.5f * (float)n - 0.5f, y = (v + 1.0f) * 0.5f * (float)n - 0.5f;
    const int32_t i = (int32_t)floorf(x), j = (int32_t)floorf(y);
    const float fx = x - (float)i, fy = y - (float)j;
    for (int32_t k = 0; k < 4; ++k) {
        int32_t at[2] = {i + (k & 1), j + (k >> 1)};
        ty_octahedral_wrap(n, &at[0], &at[1]);
        cell[k] = at[0] + n * at[1];
        weight[k] = ((k & 1) != 0 ? fx : 1.0f - fx) * (k >> 1 != 0 ? fy : 1.0f - fy);
    }
}

#endif
