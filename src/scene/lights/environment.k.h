/* Lookup and sampling of an equirectangular environment. */
#ifndef TY_SCENE_LIGHTS_ENVIRONMENT_K_H
#define TY_SCENE_LIGHTS_ENVIRONMENT_K_H

#include "base/vector.k.h"
#include "scene/media/phase.k.h"

/* Light of a cell of the sphere, about 1.4 degrees wide. */
typedef struct ty_environment_cell {
    float color[3];            /* integral of radiance over solid angle, W m^-2 */
    float vector_luminance[3]; /* luminance times unit direction to the light: x, horizontal perpendicular to x, up (z
                      up: x, y, z; y up: x, -z, y) */
    float solid_angle;         /* sr */
} ty_environment_cell;

typedef struct ty_environment_view {
    TY_GLOBAL const float* pixels; /* 3 per texel; NULL: constant */
    TY_GLOBAL const float* rows;
    TY_GLOBAL const float* columns;
    int32_t width, height;             /* of pixels */
    int32_t table_width, table_height; /* of the sampling tables */
    int32_t up;                        /* 1: y, 2: z */
    float turns;                       /* rotation about the up axis in turns, counter-clockwise from above */
    float scale;
    float constant[3];                          /* radiance where pixels is NULL; otherwise the mean over the sphere */
    TY_GLOBAL const ty_environment_cell* cells; /* row by row, like pixels */
    int32_t cells_width, cells_height;
} ty_environment_view;

/* Map coordinates of the direction wi to the environment: u in [0, 1), v in [0, 1] from the top. */
TY_FN void ty_environment_uv(TY_GLOBAL const ty_environment_view* env, ty_vec wi, float* u, float* v) {
    const float height = env->up == 2 ? wi.z : wi.y;
    /* Counter-clockwise seen from above: from x towards -z when y is up, from x towards y when z is up. */
    const float angle = ty_atan2_over_2pi(env->up == 2 ? wi.y : -wi.z, wi.x);
    const float turn_fraction = 0.5f - (angle - env->turns);
    const float horizontal = sqrtf(ty_maxf(0.0f, 1.0f - height * height));
    *u = turn_fraction - floorf(turn_fraction);
    *v = 2.0f * ty_atan2_over_2pi(horizontal, height);
}

/* Radiance arriving from unit direction wi: bilinear, periodic in u, clamped at the poles. */
TY_FN void ty_environment_radiance(TY_GLOBAL const ty_environment_view* env, ty_vec wi, float radiance[3]) {
    if (env->pixels == NULL) {
        for (int c = 0; c < 3; ++c) radiance[c] = env->constant[c];
        return;
    }
    float u, v;
    ty_environment_uv(env, wi, &u, &v);
    const float x = u * (float)env->width - 0.5f;
    const float y = ty_clampf(v * (float)env->height - 0.5f, 0.0f, (float)(env->height - 1));
    const float fx = floorf(x), fy = floorf(y);
    int32_t x0 = (int32_t)fx, y0 = (int32_t)fy;
    int32_t x1 = x0 + 1;
    const int32_t y1 = y0 + 1 < env->height ? y0 + 1 : y0;
    x0 = x0 < 0 ? x0 + env->width : x0;
    x1 = x1 >= env->width ? x1 - env->width : x1;
    TY_GLOBAL const float* top = env->pixels + 3 * (size_t)env->width * (size_t)y0;
    TY_GLOBAL const float* bottom = env->pixels + 3 * (size_t)env->width * (size_t)y1;
    for (int c = 0; c < 3; ++c) {
        const float a = ty_lerpf(top[3 * x0 + c], top[3 * x1 + c], x - fx);
        const float b = ty_lerpf(bottom[3 * x0 + c], bottom[3 * x1 + c], x - fx);
        radiance[c] = env->scale * ty_lerpf(a, b, y - fy);
    }
}

/* Last entry of cumulative[0..count] not above u, and the fraction of the interval to the next. */
TY_FN int32_t ty_find_interval(TY_GLOBAL const float* cumulative, int32_t count, float u, float* fraction) {
    int32_t low = 0, high = count;
    while (high - low > 1) {
        const int32_t mid = (low + high) / 2;
        if (cumulative[mid] <= u)
            low = mid;
        else
            high = mid;
    }
    const float width = cumulative[low + 1] - cumulative[low];
    *fraction = width > 0.0f ? (u - cumulative[low]) / width : 0.5f;
    return low;
}

TY_FN float ty_environment_pdf_at(TY_GLOBAL const ty_environment_view* env, int32_t column, int32_t row) {
    TY_GLOBAL const float* columns = env->columns + (size_t)row * ((size_t)env->table_width + 1);
    const float mass = (env->rows[row + 1] - env->rows[row]) * (columns[column + 1] - columns[column]);
    const float top = cosf(TY_PI * (float)row / (float)env->table_height);
    const float bottom = cosf(TY_PI * (float)(row + 1) / (float)env->table_height);
    return mass * (float)env->table_width / (2.0f * TY_PI * (top - bottom));
}

/* Probability density of ty_environment_sample for wi, 1/sr. */
TY_FN float ty_environment_pdf(TY_GLOBAL const ty_environment_view* env, ty_vec wi) {
    if (env->pixels == NULL) return TY_INV_4PI;
    float u, v;
    ty_environment_uv(env, wi, &u, &v);
    const int32_t column = (int32_t)ty_minf(u * (float)env->table_width, (float)(env->table_width - 1));
    const int32_t row = (int32_t)ty_minf(v * (float)env->table_height, (float)(env->table_height - 1));
    return ty_environment_pdf_at(env, column, row);
}

/* Samples a direction wi, uniform in solid angle within a table cell; returns its probability density. */
TY_FN float ty_environment_sample(TY_GLOBAL const ty_environment_view* env, float u, float v, ty_vec* wi) {
    if (env->pixels == NULL) {
        *wi = ty_direction_about(ty_vec_make(0, 0, 1), 1.0f - 2.0f * u, v);
        return TY_INV_4PI;
    }
    float in_row, in_column;
    const int32_t row = ty_find_interval(env->rows, env->table_height, v, &in_row);
    const int32_t column =
        ty_find_interval(env->columns + (size_t)row * ((size_t)env->table_width + 1), env->table_width, u, &in_column);
    const float top = cosf(TY_PI * (float)row / (float)env->table_height);
    const float bottom = cosf(TY_PI * (float)(row + 1) / (float)env->table_height);
    const float height = ty_lerpf(top, bottom, in_row);
    const float horizontal = sqrtf(ty_maxf(0.0f, 1.0f - height * height));
    const float turn_fraction = ((float)column + in_column) / (float)env->table_width;
    const float angle = 0.5f - turn_fraction + env->turns;
    float sine, cosine;
    ty_sincos_2pi(angle - floorf(angle), &sine, &cosine);
    *wi = env->up == 2 ? ty_vec_make(horizontal * cosine, horizontal * sine, height)
                       : ty_vec_make(horizontal * cosine, height, -horizontal * sine);
    return ty_environment_pdf_at(env, column, row);
}

#endif
