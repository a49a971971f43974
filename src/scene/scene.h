/* A scene's insides: what was added, and the flat view that kernels take. */
#ifndef TY_SCENE_SCENE_H
#define TY_SCENE_SCENE_H

#include "scene/environment.h"
#include "scene/light.k.h"
#include "scene/medium.k.h"
#include "scene/mesh.h"

#include <tyndall/scene.h>

/* A Lambertian surface as kernels see it. */
typedef struct ty_surface {
    float albedo[3];
    float emission[3];   /* radiance, on the front */
    int32_t first_light; /* among the scene view's lights, one per quad of the shape; -1: does not emit */
} ty_surface;

/* Everything a kernel needs, as plain arrays. */
typedef struct ty_scene_view {
    const ty_medium_view* media;
    int32_t medium_count;
    int32_t has_grids; /* whether any medium is heterogeneous */
    const ty_light_view* lights;
    int32_t light_count;
    const ty_mesh* mesh;        /* NULL: no surfaces */
    const ty_surface* surfaces; /* by shape */
} ty_scene_view;

struct ty_scene {
    ty_context* context;
    ty_axis up;
    ty_camera_def camera;
    ty_render_settings settings;
    uint64_t hash;

    ty_medium_def* media; /* names and grids owned */
    size_t medium_count, medium_capacity;
    ty_light_def* lights;          /* image is NULL: pixels are in environments */
    ty_environment** environments; /* by light; NULL for other kinds */
    size_t light_count, light_capacity, environment_capacity;
    ty_shape_def* shapes;
    size_t shape_count, shape_capacity;

    bool committed;
    ty_scene_view view;
    ty_medium_view* medium_views;
    ty_light_view* light_views;
    size_t light_view_count;
    ty_surface* surfaces;
    size_t surface_count; /* shapes and area lights */
    ty_mesh* mesh;
};

/* The view of a committed scene; NULL, with a message, of any other. */
const ty_scene_view* ty_scene_get_view(const ty_scene* scene);

#endif
