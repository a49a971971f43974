/* What an environment's light is, cell by cell. */
#include "scene/environment.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"

enum { CELLS_WIDTH = 256, CELLS_HEIGHT = 128 };

/* Cosine and sine of the turn of a column's middle. */
typedef struct column_turn {
    float cosine, sine;
} column_turn;

/* A row of texels, or of cells. */
typedef struct row_place {
    double across, height; /* of its directions */
    double solid_angle;    /* of a column, sr */
} row_place;

static row_place place_of(int32_t row, int32_t columns, int32_t rows) {
    const double down = TY_PI_F64 * (row + 0.5) / rows;
    const double share = cos(TY_PI_F64 * row / rows) - cos(TY_PI_F64 * (row + 1) / rows);
    return (row_place){.across = sin(down), .height = cos(down), .solid_angle = 2 * TY_PI_F64 * share / columns};
}

static void fill_turns(const ty_environment* env, int32_t columns, column_turn* turns) {
    for (int32_t x = 0; x < columns; ++x) {
        const double angle = 2 * TY_PI_F64 * (0.5 - (x + 0.5) / columns + (double)env->rotation_turns);
        turns[x] = (column_turn){(float)cos(angle), (float)sin(angle)};
    }
}

/* Adds radiance of a row, and its luminance times cosine and sine of the turn (0, 1) and by itself (2). */
static void add_light(const row_place* place, const float color[3], const float flow[3], float scale, int32_t columns,
                      ty_environment_cell* cell) {
    const double weight = place->solid_angle * (double)scale;
    for (int c = 0; c < 3; ++c) cell->color[c] += (float)(weight * (double)color[c]);
    cell->flow[0] += (float)(weight * place->across * (double)flow[0]);
    cell->flow[1] += (float)(weight * place->across * (double)flow[1]);
    cell->flow[2] += (float)(weight * place->height * (double)flow[2]);
    cell->solid_angle += (float)(place->solid_angle * columns);
}

static void add_radiance(const float radiance[3], column_turn turn, float color[3], float flow[3]) {
    const float bright = ty_luminance(radiance[0], radiance[1], radiance[2]);
    for (int c = 0; c < 3; ++c) color[c] += radiance[c];
    flow[0] += bright * turn.cosine;
    flow[1] += bright * turn.sine;
    flow[2] += bright;
}

/* Cells of whole texels; the last ones of a row or column may have fewer. */
static void sum_texels(ty_environment* env, const column_turn* turns) {
    const int32_t wide = (env->width + CELLS_WIDTH - 1) / CELLS_WIDTH;
    const int32_t high = (env->height + CELLS_HEIGHT - 1) / CELLS_HEIGHT;
    for (int32_t y = 0; y < env->height; ++y) {
        const row_place place = place_of(y, env->width, env->height);
        const float* row = env->pixels + 3 * (size_t)env->width * (size_t)y;
        ty_environment_cell* cells = env->cells + (size_t)env->cells_width * (size_t)(y / high);
        for (int32_t x = 0; x < env->width; x += wide) {
            const int32_t end = x + wide < env->width ? x + wide : env->width;
            float color[3] = {0, 0, 0}, flow[3] = {0, 0, 0};
            for (int32_t i = x; i < end; ++i) add_radiance(row + 3 * (size_t)i, turns[i], color, flow);
            add_light(&place, color, flow, env->scale, end - x, &cells[x / wide]);
        }
    }
}

/* Cells finer than the map, or of a constant: what is in their middles. */
static void look_up_cells(ty_environment* env, const column_turn* turns) {
    const ty_environment_view view = ty_environment_get_view(env, TY_AXIS_Z);
    for (int32_t y = 0; y < env->cells_height; ++y) {
        const row_place place = place_of(y, env->cells_width, env->cells_height);
        for (int32_t x = 0; x < env->cells_width; ++x) {
            const float across = (float)place.across;
            const ty_vec look = ty_vec_make(across * turns[x].cosine, across * turns[x].sine, (float)place.height);
            float radiance[3], color[3] = {0, 0, 0}, flow[3] = {0, 0, 0};
            ty_environment_radiance(&view, look, radiance);
            add_radiance(radiance, turns[x], color, flow);
            add_light(&place, color, flow, 1, 1, &env->cells[(size_t)env->cells_width * (size_t)y + (size_t)x]);
        }
    }
}

ty_result ty_environment_make_cells(ty_context* context, ty_environment* env) {
    const bool texels = env->pixels != NULL && env->width >= CELLS_WIDTH && env->height >= CELLS_HEIGHT;
    const int32_t wide = texels ? (env->width + CELLS_WIDTH - 1) / CELLS_WIDTH : 1;
    const int32_t high = texels ? (env->height + CELLS_HEIGHT - 1) / CELLS_HEIGHT : 1;
    env->cells_width = texels ? (env->width + wide - 1) / wide : CELLS_WIDTH;
    env->cells_height = texels ? (env->height + high - 1) / high : CELLS_HEIGHT;
    const size_t columns = (size_t)(texels ? env->width : env->cells_width);
    env->cells = ty_alloc_array(context, ty_environment_cell_count(env), sizeof *env->cells, true);
    column_turn* turns = ty_alloc_array(context, columns, sizeof *turns, false);
    const bool enough = env->cells != NULL && turns != NULL;
    if (enough) {
        fill_turns(env, (int32_t)columns, turns);
        if (texels)
            sum_texels(env, turns);
        else
            look_up_cells(env, turns);
    }
    ty_free_array(context, turns, columns, sizeof *turns);
    return enough ? TY_OK : TY_ERROR_MEMORY;
}
