/* Light of an environment per cell. */
#include "scene/lights/environment.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"

enum { CELLS_WIDTH = 256, CELLS_HEIGHT = 128 };

/* Cosine and sine of the azimuth of a column's center. */
typedef struct column_azimuth {
    float cosine, sine;
} column_azimuth;

/* A row of texels or cells. */
typedef struct row_geometry {
    double horizontal, vertical; /* horizontal and vertical component of its directions */
    double solid_angle;          /* of one column, sr */
} row_geometry;

static row_geometry geometry_of(int32_t row, int32_t columns, int32_t rows) {
    const double polar_angle = TY_PI_F64 * (row + 0.5) / rows;
    const double fraction = cos(TY_PI_F64 * row / rows) - cos(TY_PI_F64 * (row + 1) / rows);
    return (row_geometry){.horizontal = sin(polar_angle),
                          .vertical = cos(polar_angle),
                          .solid_angle = 2 * TY_PI_F64 * fraction / columns};
}

static void fill_azimuths(const ty_environment* env, int32_t columns, column_azimuth* azimuths) {
    for (int32_t x = 0; x < columns; ++x) {
        const double angle = 2 * TY_PI_F64 * (0.5 - (x + 0.5) / columns + (double)env->rotation_turns);
        azimuths[x] = (column_azimuth){(float)cos(angle), (float)sin(angle)};
    }
}

/* Adds radiance of a row, and its luminance times cosine and sine of the azimuth (0, 1) and unweighted (2). */
static void add_light(const row_geometry* geometry, const float color[3], const float vector_luminance[3], float scale,
                      int32_t columns, ty_environment_cell* cell) {
    const double weight = geometry->solid_angle * (double)scale;
    for (int c = 0; c < 3; ++c) cell->color[c] += (float)(weight * (double)color[c]);
    cell->vector_luminance[0] += (float)(weight * geometry->horizontal * (double)vector_luminance[0]);
    cell->vector_luminance[1] += (float)(weight * geometry->horizontal * (double)vector_luminance[1]);
    cell->vector_luminance[2] += (float)(weight * geometry->vertical * (double)vector_luminance[2]);
    cell->solid_angle += (float)(geometry->solid_angle * columns);
}

static void add_radiance(const float radiance[3], column_azimuth azimuth, float color[3], float vector_luminance[3]) {
    const float luminance = ty_luminance(radiance[0], radiance[1], radiance[2]);
    for (int c = 0; c < 3; ++c) color[c] += radiance[c];
    vector_luminance[0] += luminance * azimuth.cosine;
    vector_luminance[1] += luminance * azimuth.sine;
    vector_luminance[2] += luminance;
}

typedef struct cell_job {
    ty_environment* env;
    const column_azimuth* azimuths;
} cell_job;

/* A row of cells of whole texels; the last of a row or column may have fewer. */
static void sum_texels(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const cell_job* job = user;
    const ty_environment* env = job->env;
    const ty_environment_map* map = env->map;
    const int32_t wide = (map->width + CELLS_WIDTH - 1) / CELLS_WIDTH;
    const int32_t high = (map->height + CELLS_HEIGHT - 1) / CELLS_HEIGHT;
    const int32_t first = high * (int32_t)index, last = first + high < map->height ? first + high : map->height;
    ty_environment_cell* cells = env->cells + (size_t)env->cells_width * (size_t)index;
    for (int32_t y = first; y < last; ++y) {
        const row_geometry geometry = geometry_of(y, map->width, map->height);
        const float* row = map->pixels + 3 * (size_t)map->width * (size_t)y;
        for (int32_t x = 0; x < map->width; x += wide) {
            const int32_t end = x + wide < map->width ? x + wide : map->width;
            float color[3] = {0, 0, 0}, vector_luminance[3] = {0, 0, 0};
            for (int32_t i = x; i < end; ++i)
                add_radiance(row + 3 * (size_t)i, job->azimuths[i], color, vector_luminance);
            add_light(&geometry, color, vector_luminance, env->scale, end - x, &cells[x / wide]);
        }
    }
}

/* A row of cells finer than the map, or of a constant environment: radiance at their centers. */
static void sample_cells(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const cell_job* job = user;
    const ty_environment* env = job->env;
    const ty_environment_view view = ty_environment_get_view(env, TY_AXIS_Z);
    const row_geometry geometry = geometry_of((int32_t)y, env->cells_width, env->cells_height);
    for (int32_t x = 0; x < env->cells_width; ++x) {
        const float horizontal = (float)geometry.horizontal;
        const column_azimuth azimuth = job->azimuths[x];
        const ty_vec wi = ty_vec_make(horizontal * azimuth.cosine, horizontal * azimuth.sine, (float)geometry.vertical);
        float radiance[3], color[3] = {0, 0, 0}, vector_luminance[3] = {0, 0, 0};
        ty_environment_radiance(&view, wi, radiance);
        add_radiance(radiance, azimuth, color, vector_luminance);
        add_light(&geometry, color, vector_luminance, 1, 1,
                  &env->cells[(size_t)env->cells_width * (size_t)y + (size_t)x]);
    }
}

ty_result ty_environment_make_cells(ty_context* context, ty_environment* env) {
    const ty_environment_map* map = env->map;
    const bool texels = map != NULL && map->width >= CELLS_WIDTH && map->height >= CELLS_HEIGHT;
    const int32_t wide = texels ? (map->width + CELLS_WIDTH - 1) / CELLS_WIDTH : 1;
    const int32_t high = texels ? (map->height + CELLS_HEIGHT - 1) / CELLS_HEIGHT : 1;
    env->cells_width = texels ? (map->width + wide - 1) / wide : CELLS_WIDTH;
    env->cells_height = texels ? (map->height + high - 1) / high : CELLS_HEIGHT;
    const size_t columns = (size_t)(texels ? map->width : env->cells_width);
    env->cells = ty_alloc_array(context, ty_environment_cell_count(env), sizeof *env->cells, true);
    column_azimuth* azimuths = ty_alloc_array(context, columns, sizeof *azimuths, false);
    const bool allocated = env->cells != NULL && azimuths != NULL;
    if (allocated) {
        fill_azimuths(env, (int32_t)columns, azimuths);
        cell_job job = {env, azimuths};
        ty_parallel_for(context, env->cells_height, texels ? sum_texels : sample_cells, &job);
    }
    ty_free_array(context, azimuths, columns, sizeof *azimuths);
    return allocated ? TY_OK : TY_ERROR_MEMORY;
}
