/* Scene storage, and the flat view for kernels. */
#ifndef TY_SCENE_SCENE_H
#define TY_SCENE_SCENE_H

#include "scene/environment.h"
#include "scene/light_choice.k.h"
#include "scene/light_tree.h"
#include "scene/medium.k.h"
#include "scene/accel.h"
#include "scene/settings.h"

#include <tyndall/scene.h>

/* Kernel view of a scene, as plain arrays. */
typedef struct ty_scene_view {
    const ty_medium_view* media;
    int32_t medium_count;
    ty_light_set lights;
    const ty_accel* mesh;       /* NULL: no surfaces */
    const ty_surface* surfaces; /* shapes, area lights, meshes */
} ty_scene_view;

struct ty_scene {
    ty_context* context;
    ty_axis up;
    ty_camera_def camera;
    ty_render_settings settings;
    ty_scene_option* options;
    size_t option_count, option_capacity;
    uint64_t hash;
    char camera_source[256];

    ty_medium_def* media; /* names and grids owned */
    size_t medium_count, medium_capacity;
    ty_light_def* lights;          /* image is NULL: pixels are in environments */
    ty_environment** environments; /* by light; NULL for other kinds */
    size_t light_count, light_capacity, environment_capacity;
    ty_shape_def* shapes;
    size_t shape_count, shape_capacity;
    ty_triangle_mesh** meshes;
    size_t mesh_count, mesh_capacity;

    bool committed;
    ty_scene_view view;
    ty_medium_view* medium_views;
    ty_light_view* light_views;
    size_t light_view_count;
    ty_light_tree* light_tree;
    int32_t* distant_lights;
    size_t distant_capacity;
    ty_surface* surfaces;
    ty_shape_def* shape_parts; /* shapes and area lights */
    size_t shape_part_count;
    size_t surface_count; /* shape_parts and meshes */
    ty_accel* mesh;
};

/* Set the results of ty_scene_hash and ty_scene_camera_source; source is cut to 255 bytes. */
void ty_scene_set_hash(ty_scene* scene, uint64_t hash);
void ty_scene_set_camera_source(ty_scene* scene, const char* source);

/* View of a committed scene; otherwise NULL, with a message. */
const ty_scene_view* ty_scene_get_view(const ty_scene* scene);
/* Fails unless the scene is committed and has media, which `method` requires. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_scene_check_media(const ty_scene* scene, const char* method);

/* Bounding box of all surfaces, m; a point without surfaces. */
void ty_scene_surface_extent(const ty_scene* scene, double lower[3], double upper[3]);

#endif
