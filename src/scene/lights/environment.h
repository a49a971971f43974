/* Equirectangular environments: lookup, and sampling in proportion to luminance. */
#ifndef TY_SCENE_LIGHTS_ENVIRONMENT_H
#define TY_SCENE_LIGHTS_ENVIRONMENT_H

#include "scene/lights/environment.k.h"

#include <tyndall/scene.h>

/* Pixels and sampling tables of a map, which environments of any rotation and scale share. */
typedef struct ty_environment_map {
    ty_context* context;
    _Atomic int32_t owners;
    float* pixels;  /* 3 floats per texel */
    float* rows;    /* cumulative, table_height + 1 */
    float* columns; /* cumulative per row, table_height x (table_width + 1) */
    int32_t width, height, table_width, table_height;
    double mean[3]; /* over the sphere */
} ty_environment_map;

ty_result ty_environment_map_create(ty_context* context, const ty_image* image, ty_environment_map** out);
ty_environment_map* ty_environment_map_retain(ty_environment_map* map);
void ty_environment_map_release(ty_environment_map* map);
size_t ty_environment_map_bytes(const ty_environment_map* map);

/* An environment light. */
typedef struct ty_environment {
    ty_environment_map* map; /* NULL: constant */
    ty_environment_cell* cells;
    int32_t cells_width, cells_height;
    float rotation_turns;
    float scale;
    float mean[3]; /* mean radiance over the sphere, scale included */
} ty_environment;

/* map: retained; NULL: made of the def's image, if there is one. */
ty_result ty_environment_create(ty_context* context, const ty_light_def* def, ty_environment_map* map,
                                ty_environment** out);
void ty_environment_destroy(ty_context* context, ty_environment* environment);
ty_environment_view ty_environment_get_view(const ty_environment* environment, ty_axis up);
/* Without the map. */
size_t ty_environment_bytes(const ty_environment* environment);

/* Computes the cells, for methods that cluster environments per frame. */
ty_result ty_environment_make_cells(ty_context* context, ty_environment* environment);
static inline size_t ty_environment_cell_count(const ty_environment* environment) {
    return (size_t)environment->cells_width * (size_t)environment->cells_height;
}

#endif
