/* Irradiance from media on surfaces outside of the field's box, gathered at pixels some distance apart and interpolated
 * between them. */
#ifndef TY_IMAGE_GATHERED_K_H
#define TY_IMAGE_GATHERED_K_H

#include "base/vector.k.h"

/* Pixels between two points along x and y. */
enum { TY_GATHERED_SPACING = 4 };
/* Cosine between normals at which the irradiance of one no longer counts for the other; distance of a point from the
 * tangential plane, relative to that from the camera, at which it does not either; least total weight. */
#define TY_GATHERED_COSINE 0.7f
#define TY_GATHERED_OFF_PLANE 0.01f
#define TY_GATHERED_WEIGHT_MIN 0.05f

/* A point on the surface through the center of a pixel. */
typedef struct ty_gathered_point {
    ty_vec position, normal;
    float distance; /* from the camera, m */
    float irradiance[3];
    int32_t exists; /* 0: no surface, or one inside of the box */
} ty_gathered_point;

/* Points at every TY_GATHERED_SPACING-th pixel along x and y, and at the last. */
typedef struct ty_gathered_view {
    int32_t columns, rows; /* 0: none */
    int32_t width, height; /* of the image, pixels */
    TY_GLOBAL ty_gathered_point* points;
} ty_gathered_view;

/* Weight of a point for the surface around a position, of a normal and at a distance from the camera. */
TY_FN float ty_gathered_weight(TY_GLOBAL const ty_gathered_point* point, ty_vec position, ty_vec normal,
                               float distance) {
    if (point->exists == 0) return 0.0f;
    const float off = fabsf(ty_dot(ty_sub(point->position, position), normal));
    const float cosine = ty_dot(point->normal, normal);
    return ty_maxf(0.0f, 1.0f - off / (TY_GATHERED_OFF_PLANE * distance)) *
           ty_maxf(0.0f, (cosine - TY_GATHERED_COSINE) * (1.0f / (1.0f - TY_GATHERED_COSINE)));
}

/* The pixel of a column or a row of points. */
TY_FN int32_t ty_gathered_pixel(int32_t index, int32_t pixels) {
    const int32_t at = index * TY_GATHERED_SPACING;
    return at < pixels ? at : pixels - 1;
}

/* The points on both sides of a place along an axis, and the weight of the second. */
TY_FN int32_t ty_gathered_between(float place, int32_t count, int32_t pixels, float* weight) {
    const float along = ty_clampf(place - 0.5f, 0.0f, (float)(pixels - 1));
    int32_t first = (int32_t)along / TY_GATHERED_SPACING;
    if (first > count - 2) first = count - 2;
    const float from = (float)ty_gathered_pixel(first, pixels), to = (float)ty_gathered_pixel(first + 1, pixels);
    *weight = ty_clampf((along - from) / (to - from), 0.0f, 1.0f);
    return first;
}

/* Mean over a point and those around it, by tent weights: each has other rays, and their errors differ. */
TY_FN void ty_gathered_smooth(TY_GLOBAL const ty_gathered_view* view, int32_t column, int32_t row,
                              TY_GLOBAL ty_gathered_point* out) {
    TY_GLOBAL const ty_gathered_point* center = &view->points[row * view->columns + column];
    float sum = 0.0f;
    *out = *center;
    if (center->exists == 0) return;
    for (int c = 0; c < 3; ++c) out->irradiance[c] = 0.0f;
    for (int32_t k = 0; k < 9; ++k) {
        const int32_t right = k % 3 - 1, down = k / 3 - 1;
        if (column + right < 0 || column + right >= view->columns || row + down < 0 || row + down >= view->rows)
            continue;
        TY_GLOBAL const ty_gathered_point* point = &view->points[(row + down) * view->columns + column + right];
        const float weight = (right == 0 ? 2.0f : 1.0f) * (down == 0 ? 2.0f : 1.0f) *
                             ty_gathered_weight(point, center->position, center->normal, center->distance);
        if (!(weight > 0.0f)) continue;
        sum += weight;
        for (int c = 0; c < 3; ++c) out->irradiance[c] += weight * point->irradiance[c];
    }
    for (int c = 0; c < 3; ++c) out->irradiance[c] *= 1.0f / sum;
}

#endif
