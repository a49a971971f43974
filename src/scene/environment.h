/* Equirectangular environments: lookup, and sampling in proportion to luminance. */
#ifndef TY_SCENE_ENVIRONMENT_H
#define TY_SCENE_ENVIRONMENT_H

#include "scene/environment.k.h"

#include <tyndall/scene.h>

/* Tables of an environment light; empty for a constant environment. */
typedef struct ty_environment {
    float* pixels;  /* 3 floats per texel */
    float* rows;    /* cumulative, table_height + 1 */
    float* columns; /* cumulative per row, table_height x (table_width + 1) */
    int32_t width, height, table_width, table_height;
    ty_environment_cell* cells;
    int32_t cells_width, cells_height;
    float rotation_turns;
    float scale;
    float mean[3]; /* mean radiance over the sphere, scale included */
} ty_environment;

ty_result ty_environment_create(ty_context* context, const ty_light_def* def, ty_environment** out);
void ty_environment_destroy(ty_context* context, ty_environment* environment);
ty_environment_view ty_environment_get_view(const ty_environment* environment, ty_axis up);
size_t ty_environment_bytes(const ty_environment* environment);

/* Computes the cells, for methods that cluster environments per frame. */
ty_result ty_environment_make_cells(ty_context* context, ty_environment* environment);
static inline size_t ty_environment_cell_count(const ty_environment* environment) {
    return (size_t)environment->cells_width * (size_t)environment->cells_height;
}

#endif
