/* Maps of environments with their sampling tables. */
#include "scene/lights/environment.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"

#include <stdatomic.h>

enum { TABLE_WIDTH_MAX = 512 };

/* Weighted luminance of the texels that bilinear lookups within texel (x, y) blend. */
static float luminance_around(const ty_environment_map* env, int32_t x, int32_t y) {
    float sum = 0;
    for (int32_t dy = -1; dy <= 1; ++dy)
        for (int32_t dx = -1; dx <= 1; ++dx) {
            const int32_t row = y + dy < 0 ? 0 : y + dy >= env->height ? env->height - 1 : y + dy;
            const int32_t column = (x + dx + env->width) % env->width;
            const float weight = dx == 0 && dy == 0 ? 1.0f : 0.25f;
            sum += weight * ty_luminance_of(env->pixels + 3 * ((size_t)env->width * (size_t)row + (size_t)column));
        }
    return sum / 3.0f;
}

/* Solid angle of a row of a map with `height` rows, all columns together. */
static double row_solid_angle(int32_t row, int32_t height) {
    return 2.0 * TY_PI_F64 * (cos(TY_PI_F64 * row / height) - cos(TY_PI_F64 * (row + 1) / height));
}

/* Cumulative table of the weights that ends at exactly 1; uniform if all weights are 0. Returns the sum. */
static double accumulate(float* cumulative, const float* weights, int32_t count) {
    double sum = 0, running = 0;
    for (int32_t i = 0; i < count; ++i) sum += weights[i];
    cumulative[0] = 0;
    for (int32_t i = 0; i < count; ++i) {
        running += sum > 0 ? weights[i] / sum : 1.0 / count;
        cumulative[i + 1] = (float)running;
    }
    cumulative[count] = 1;
    return sum;
}

typedef struct table_job {
    ty_environment_map* map;
    float* cells;    /* a row of weights for each worker */
    float* row_sums; /* luminance times solid angle */
} table_job;

/* A row of the table, from the mean luminance around each of its cells. */
static void fill_table_row(void* user, int64_t index, int32_t worker) {
    const table_job* job = user;
    const ty_environment_map* map = job->map;
    const int32_t row = (int32_t)index, w = map->table_width, h = map->table_height;
    float* weights = job->cells + (size_t)w * (size_t)worker;
    for (int32_t i = 0; i < w; ++i) weights[i] = 0;
    const int32_t y0 = (int32_t)((int64_t)row * map->height / h);
    const int32_t y1 = (int32_t)(((int64_t)(row + 1) * map->height + h - 1) / h);
    for (int32_t i = 0; i < w; ++i) {
        const int32_t x0 = (int32_t)((int64_t)i * map->width / w);
        const int32_t x1 = (int32_t)(((int64_t)(i + 1) * map->width + w - 1) / w);
        for (int32_t y = y0; y < y1; ++y)
            for (int32_t x = x0; x < x1; ++x) weights[i] += luminance_around(map, x, y);
        weights[i] /= (float)((x1 - x0) * (y1 - y0));
    }
    const double sum = accumulate(map->columns + ((size_t)w + 1) * (size_t)row, weights, w);
    job->row_sums[row] = (float)(sum * row_solid_angle(row, h));
}

/* Sampling tables; every direction with light has a nonzero probability. */
static ty_result build_tables(ty_context* context, ty_environment_map* map) {
    map->table_width = map->width < TABLE_WIDTH_MAX ? map->width : TABLE_WIDTH_MAX;
    map->table_height = map->height < TABLE_WIDTH_MAX / 2 ? map->height : TABLE_WIDTH_MAX / 2;
    const size_t w = (size_t)map->table_width, h = (size_t)map->table_height;
    const size_t cells = w * (size_t)ty_context_threads(context);
    map->rows = ty_alloc_array(context, h + 1, sizeof(float), true);
    map->columns = ty_alloc_array(context, (w + 1) * h, sizeof(float), true);
    table_job job = {.map = map,
                     .cells = ty_alloc_array(context, cells, sizeof(float), false),
                     .row_sums = ty_alloc_array(context, h, sizeof(float), false)};
    const bool allocated = map->rows != NULL && map->columns != NULL && job.cells != NULL && job.row_sums != NULL;
    if (allocated) {
        ty_parallel_for(context, (int64_t)h, fill_table_row, &job);
        accumulate(map->rows, job.row_sums, (int32_t)h);
    }
    ty_free_array(context, job.cells, cells, sizeof(float));
    ty_free_array(context, job.row_sums, h, sizeof(float));
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}

static size_t pixel_count(const ty_environment_map* env) {
    return (size_t)env->width * (size_t)env->height;
}

/* Copies the pixels, negative and non-finite values as 0, and computes their mean over the sphere. */
static ty_result copy_pixels(ty_context* context, ty_environment_map* env, const ty_image* image) {
    const float* planes[3];
    if (!ty_image_rgb_planes(image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "an environment's image has no R, G and B channels");
    env->width = ty_image_width(image);
    env->height = ty_image_height(image);
    env->pixels = ty_alloc_array(context, pixel_count(env), 3 * sizeof(float), false);
    if (env->pixels == NULL) return TY_ERROR_MEMORY;
    size_t nonfinite_fixed = 0;
    for (int32_t y = 0; y < env->height; ++y) {
        const double weight = row_solid_angle(y, env->height) / (4 * TY_PI_F64 * env->width);
        for (int32_t x = 0; x < env->width; ++x) {
            const size_t at = (size_t)env->width * (size_t)y + (size_t)x;
            for (int c = 0; c < 3; ++c) {
                const float value = planes[c][at];
                const bool good = isfinite(value) && value >= 0;
                nonfinite_fixed += !good;
                env->pixels[3 * at + (size_t)c] = good ? value : 0;
                env->mean[c] += weight * (good ? value : 0);
            }
        }
    }
    if (nonfinite_fixed > 0)
        ty_log(context, TY_LOG_WARNING, "an environment had %zu negative or non-finite values; they count as 0",
               nonfinite_fixed);
    return TY_OK;
}

/* The map is the image's display window: pixels outside are dropped, missing ones are black. */
static ty_result copy_map(ty_context* context, ty_environment_map* env, const ty_image* image) {
    int32_t window[4];
    ty_image_get_frame(image, window);
    if (window[0] == 0 && window[1] == 0 && window[2] == ty_image_width(image) && window[3] == ty_image_height(image))
        return copy_pixels(context, env, image);
    ty_image* filled = NULL;
    ty_result result = ty_image_create_full_frame(context, image, &filled);
    if (result == TY_OK) result = copy_pixels(context, env, filled);
    ty_image_destroy(filled);
    return result;
}

ty_result ty_environment_map_create(ty_context* context, const ty_image* image, ty_environment_map** out) {
    ty_environment_map* map = ty_alloc_array(context, 1, sizeof *map, true);
    if (map == NULL) return TY_ERROR_MEMORY;
    map->context = context;
    atomic_init(&map->owners, 1);
    ty_result result = copy_map(context, map, image);
    if (result == TY_OK) result = build_tables(context, map);
    if (result == TY_OK)
        *out = map;
    else
        ty_environment_map_release(map);
    return result;
}

ty_environment_map* ty_environment_map_retain(ty_environment_map* map) {
    if (map != NULL) atomic_fetch_add(&map->owners, 1);
    return map;
}

void ty_environment_map_release(ty_environment_map* map) {
    if (map == NULL || atomic_fetch_sub(&map->owners, 1) > 1) return;
    ty_context* context = map->context;
    ty_free_array(context, map->pixels, pixel_count(map), 3 * sizeof(float));
    ty_free_array(context, map->rows, (size_t)map->table_height + 1, sizeof(float));
    ty_free_array(context, map->columns, ((size_t)map->table_width + 1) * (size_t)map->table_height, sizeof(float));
    ty_free_array(context, map, 1, sizeof *map);
}

size_t ty_environment_map_bytes(const ty_environment_map* map) {
    return sizeof *map + sizeof(float) * (3 * pixel_count(map) + (size_t)map->table_height + 1 +
                                          ((size_t)map->table_width + 1) * (size_t)map->table_height);
}

/* ---- lights ---- */

ty_result ty_environment_create(ty_context* context, const ty_light_def* def, ty_environment_map* map,
                                ty_environment** out) {
    ty_environment* env = ty_alloc_array(context, 1, sizeof *env, true);
    if (env == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    env->map = ty_environment_map_retain(map);
    if (map == NULL && def->image != NULL) result = ty_environment_map_create(context, def->image, &env->map);
    env->rotation_turns = (float)(remainder(def->rotation, 360) / 360);
    env->scale = def->scale;
    for (int c = 0; c < 3; ++c)
        env->mean[c] = env->map != NULL ? (float)(env->map->mean[c] * env->scale) : def->color[c] * def->scale;
    if (result == TY_OK) result = ty_environment_make_cells(context, env);
    if (result != TY_OK) {
        ty_environment_destroy(context, env);
        return result;
    }
    *out = env;
    return TY_OK;
}

void ty_environment_destroy(ty_context* context, ty_environment* env) {
    if (env == NULL) return;
    ty_environment_map_release(env->map);
    ty_free_array(context, env->cells, ty_environment_cell_count(env), sizeof *env->cells);
    ty_free_array(context, env, 1, sizeof *env);
}

ty_environment_view ty_environment_get_view(const ty_environment* env, ty_axis up) {
    ty_environment_view view = {.up = (int32_t)up,
                                .turns = env->rotation_turns,
                                .scale = env->scale,
                                .constant = {env->mean[0], env->mean[1], env->mean[2]},
                                .cells = env->cells,
                                .cells_width = env->cells_width,
                                .cells_height = env->cells_height};
    const ty_environment_map* map = env->map;
    if (map == NULL) return view;
    view.pixels = map->pixels;
    view.rows = map->rows;
    view.columns = map->columns;
    view.width = map->width;
    view.height = map->height;
    view.table_width = map->table_width;
    view.table_height = map->table_height;
    return view;
}

size_t ty_environment_bytes(const ty_environment* env) {
    return sizeof *env + ty_environment_cell_count(env) * sizeof *env->cells;
}
