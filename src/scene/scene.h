/* Scene storage, and the flat view for kernels. */
#ifndef TY_SCENE_SCENE_H
#define TY_SCENE_SCENE_H

#include "scene/lights/environment.h"
#include "scene/lights/light_choice.k.h"
#include "scene/lights/light_tree.h"
#include "scene/media/medium.k.h"
#include "scene/media/periodic.k.h"
#include "scene/surfaces/accel.h"
#include "scene/settings.h"

#include <tyndall/scene.h>

/* A solid dielectric that a path is in between surfaces, or for number 0 the space outside of all. */
typedef struct ty_interior {
    const ty_medium_view* media; /* the dielectric's own absorption, if `absorbs`, then the media in it */
    int32_t medium_count;
    int32_t absorbs;
    int32_t scatters; /* nonzero if any of its media does, or emits */
    int32_t surface;  /* index of the boundary; -1: outside */
    int32_t priority;
    float ior;
} ty_interior;

/* Kernel view of a scene, as plain arrays. */
typedef struct ty_scene_view {
    const ty_medium_view* media;
    int32_t medium_count;
    ty_light_set lights;
    const ty_accel* mesh;         /* NULL: no surfaces */
    const ty_surface* surfaces;   /* shapes, area lights, meshes */
    const ty_interior* interiors; /* by ty_dielectric.interior */
    int32_t interior_count;       /* 0: no surface bounds a dielectric, or is a pane */
    ty_periodic_view periodic;
} ty_scene_view;

/* Parts of a committed scene; commit.c makes them. */
typedef struct ty_committed_media {
    ty_medium_view* views;
    size_t count;
    ty_periodic_view cell;
} ty_committed_media;

/* Shapes, then area lights, then meshes. */
typedef struct ty_committed_surfaces {
    ty_shape_def* shapes; /* shapes and area lights */
    size_t shape_count;
    ty_surface* surfaces;
    ty_surface_gloss* gloss; /* of the glossy surfaces, in their order */
    ty_shape_face* faces;    /* of the textured shapes, in their order */
    size_t face_count;
    size_t count; /* of shapes and meshes */
    size_t gloss_count;
    ty_accel* accel;
    int32_t* mesh_lights; /* light of each triangle of the emissive meshes, one mesh after another; -1: none */
    size_t mesh_light_count;
    int32_t first_mesh_light; /* number of the first light of a mesh */
} ty_committed_surfaces;

/* Explicit lights, then those of shapes and area lights, then those of meshes. */
typedef struct ty_committed_lights {
    ty_light_view* views;
    size_t capacity; /* of views; set.count are used */
    int32_t* distant;
    size_t distant_capacity;
    ty_light_tree* tree;
    ty_light_set set;
} ty_committed_lights;

/* Interiors of dielectrics; interiors.c makes them. */
typedef struct ty_committed_interiors {
    ty_interior* interiors;
    ty_medium_view* media; /* of all interiors; what their pointers name belongs to the committed media */
    size_t count, medium_capacity;
} ty_committed_interiors;

struct ty_scene {
    ty_context* context;
    ty_axis up;
    ty_camera_def camera;
    ty_render_settings settings;
    ty_scene_option* options;
    size_t option_count, option_capacity;
    uint64_t hash;
    char camera_source[256];
    ty_periodic_def periodic;

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
    ty_committed_media committed_media;
    ty_committed_surfaces surfaces;
    ty_committed_lights committed_lights;
    ty_committed_interiors interiors;
};

/* Set the results of ty_scene_hash and ty_scene_camera_source; source is cut to 255 bytes. */
void ty_scene_set_hash(ty_scene* scene, uint64_t hash);
void ty_scene_set_camera_source(ty_scene* scene, const char* source);

/* Releases what commit.c made. */
void ty_scene_drop_commit(ty_scene* scene);

/* Parts of a scene that ty_scene_replace exchanges. */
enum { TY_SCENE_CAMERA = 1, TY_SCENE_SETTINGS = 2, TY_SCENE_MEDIA = 4, TY_SCENE_LIGHTS = 8 };

/* Exchanges parts of a committed scene with those of another one of the same context and up axis, and commits what
 * depends on them; shapes and meshes stay, with their acceleration structure unless area lights were moved. The result
 * is that of a commit of everything. On failure nothing is changed. Scenes that are destroyed in any order may share
 * grids. `other` needs no commit, and is left without one. */
ty_result ty_scene_replace(ty_scene* scene, ty_scene* other, unsigned parts);
/* Adds an environment light with a map that was made before, which is retained; the def has no image. */
ty_result ty_scene_add_environment(ty_scene* scene, const ty_light_def* def, ty_environment_map* map);
/* Adds the lights of a scene from the first-th on, none of them an environment, to another one. */
ty_result ty_scene_copy_lights(const ty_scene* scene, size_t first, ty_scene* to);

/* View of a committed scene; otherwise NULL, with a message. */
const ty_scene_view* ty_scene_get_view(const ty_scene* scene);
/* Fails unless the scene is committed and has media, which `method` requires, and does not repeat, unless the method
 * takes that. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_scene_check_media(const ty_scene* scene, const char* method, bool repeats);
/* Fails if the scene is periodic, which `method` does not take. Errors: TY_ERROR_ARGUMENT. */
ty_result ty_scene_check_open(const ty_scene* scene, const char* method);

/* Bounding box of media, shapes and meshes, m; a point without any. */
void ty_scene_extent(const ty_scene* scene, double lower[3], double upper[3]);
/* Bounding box of all surfaces, m; a point without surfaces. */
void ty_scene_surface_extent(const ty_scene* scene, double lower[3], double upper[3]);

#endif
