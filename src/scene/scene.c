/* Scenes: construction, commit and queries. */
#include "scene/scene.h"

#include "base/context.h"
#include "scene/camera.h"
#include "scene/lights/light.h"
#include "scene/media/medium.h"
#include "scene/settings.h"
#include "scene/surfaces/shape.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/surfaces/texture.h"

#include <stdio.h>

ty_result ty_scene_create(ty_context* context, ty_axis up_axis, ty_scene** out) {
    if (up_axis != TY_AXIS_Y && up_axis != TY_AXIS_Z)
        return ty_fail(context, TY_ERROR_ARGUMENT, "up_axis: %d is not a ty_axis", (int)up_axis);
    ty_scene* scene = ty_alloc_array(context, 1, sizeof *scene, true);
    if (scene == NULL) return TY_ERROR_MEMORY;
    scene->context = context;
    scene->up = up_axis;
    scene->camera = ty_default_camera_def();
    if (up_axis == TY_AXIS_Z) {
        scene->camera.position[1] = -scene->camera.position[2];
        scene->camera.position[2] = 0;
        scene->camera.up[1] = 0;
        scene->camera.up[2] = 1;
    }
    scene->settings = ty_default_settings;
    scene->periodic = ty_default_periodic_def();
    *out = scene;
    return TY_OK;
}

/* Textures of a material, and of a shape. */
enum { MESH_TEXTURES = TY_GLOSS_TEXTURES + 2, SHAPE_TEXTURES = TY_GLOSS_TEXTURES + 1 };

void ty_scene_destroy(ty_scene* scene) {
    if (scene == NULL) return;
    ty_context* context = scene->context;
    ty_scene_drop_commit(scene);
    for (size_t i = 0; i < scene->medium_count; ++i) ty_medium_release(context, &scene->media[i]);
    for (size_t i = 0; i < scene->light_count; ++i) ty_environment_destroy(context, scene->environments[i]);
    for (size_t i = 0; i < scene->mesh_count; ++i) ty_triangle_mesh_destroy(context, scene->meshes[i]);
    ty_free_array(context, scene->meshes, scene->mesh_capacity, sizeof *scene->meshes);
    ty_free_array(context, scene->media, scene->medium_capacity, sizeof *scene->media);
    ty_free_array(context, scene->lights, scene->light_capacity, sizeof *scene->lights);
    ty_free_array(context, scene->environments, scene->environment_capacity, sizeof(ty_environment*));
    for (size_t i = 0; i < SHAPE_TEXTURES * scene->shape_count; ++i)
        ty_texture_release(
            ty_shape_texture(&scene->shapes[i / SHAPE_TEXTURES], (int32_t)(i % SHAPE_TEXTURES))->texture);
    ty_free_array(context, scene->shapes, scene->shape_capacity, sizeof *scene->shapes);
    ty_free_array(context, scene->options, scene->option_capacity, sizeof *scene->options);
    ty_free_array(context, scene, 1, sizeof *scene);
}

ty_result ty_scene_set_camera(ty_scene* scene, const ty_camera_def* def) {
    ty_camera_def own;
    const ty_result result = ty_camera_check(scene->context, &def, &own);
    if (result == TY_OK) scene->camera = *def;
    return result;
}

ty_result ty_scene_add_medium(ty_scene* scene, const ty_medium_def* def) {
    ty_medium_def own;
    const ty_result result = ty_medium_check(scene->context, &def, &own);
    if (result != TY_OK) return result;
    if (scene->medium_count >= TY_MEDIA_MAX)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there are more than %d", TY_MEDIA_MAX);
    if (!ty_grow_array(scene->context, (void**)&scene->media, &scene->medium_capacity, scene->medium_count,
                       sizeof *scene->media))
        return TY_ERROR_MEMORY;
    if (!ty_medium_copy(scene->context, def, &scene->media[scene->medium_count])) return TY_ERROR_MEMORY;
    ++scene->medium_count;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_add_light(ty_scene* scene, const ty_light_def* def) {
    return ty_scene_add_environment(scene, def, NULL);
}

ty_result ty_scene_add_environment(ty_scene* scene, const ty_light_def* def, ty_environment_map* map) {
    ty_context* context = scene->context;
    ty_light_def own;
    ty_result result = ty_light_check(context, &def, &own);
    if (result != TY_OK) return result;
    const size_t count = scene->light_count;
    if (!ty_grow_array(context, (void**)&scene->lights, &scene->light_capacity, count, sizeof *scene->lights) ||
        !ty_grow_array(context, (void**)&scene->environments, &scene->environment_capacity, count,
                       sizeof(ty_environment*)))
        return TY_ERROR_MEMORY;
    ty_environment* environment = NULL;
    if (def->kind == TY_LIGHT_ENVIRONMENT) result = ty_environment_create(context, def, map, &environment);
    if (result != TY_OK) return result;
    scene->lights[count] = *def;
    scene->lights[count].image = NULL;
    scene->environments[count] = environment;
    scene->light_count = count + 1;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_add_shape(ty_scene* scene, const ty_shape_def* def) {
    ty_shape_def own;
    const ty_result result = ty_shape_check(scene->context, &def, &own);
    if (result != TY_OK) return result;
    if (!ty_grow_array(scene->context, (void**)&scene->shapes, &scene->shape_capacity, scene->shape_count,
                       sizeof *scene->shapes))
        return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < SHAPE_TEXTURES; ++i) ty_texture_retain(ty_shape_texture(def, i)->texture);
    scene->shapes[scene->shape_count++] = *def;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_add_mesh(ty_scene* scene, const ty_mesh_def* def) {
    if (!ty_grow_array(scene->context, (void**)&scene->meshes, &scene->mesh_capacity, scene->mesh_count,
                       sizeof *scene->meshes))
        return TY_ERROR_MEMORY;
    const ty_result result = ty_triangle_mesh_create(scene->context, def, &scene->meshes[scene->mesh_count]);
    if (result != TY_OK) return result;
    ++scene->mesh_count;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_copy_lights(const ty_scene* scene, size_t first, ty_scene* to) {
    ty_result result = TY_OK;
    for (size_t i = first; i < scene->light_count && result == TY_OK; ++i)
        result = ty_scene_add_light(to, &scene->lights[i]);
    return result;
}

const ty_scene_view* ty_scene_get_view(const ty_scene* scene) {
    if (scene->committed) return &scene->view;
    ty_fail(scene->context, TY_ERROR_ARGUMENT, "the scene was not committed after its last change");
    return NULL;
}

ty_result ty_scene_check_media(const ty_scene* scene, const char* method, bool repeats) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (view->medium_count == 0)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "%s: the scene has no media", method);
    return repeats ? TY_OK : ty_scene_check_open(scene, method);
}

ty_context* ty_scene_context(const ty_scene* scene) {
    return scene->context;
}

ty_axis ty_scene_up_axis(const ty_scene* scene) {
    return scene->up;
}

void ty_scene_copy_camera(const ty_scene* scene, void* out, size_t bytes) {
    ty_init_def(out, bytes, &scene->camera, sizeof scene->camera);
}

uint64_t ty_scene_hash(const ty_scene* scene) {
    return scene->hash;
}

void ty_scene_set_hash(ty_scene* scene, uint64_t hash) {
    scene->hash = hash;
}

const char* ty_scene_camera_source(const ty_scene* scene) {
    return scene->camera_source;
}

void ty_scene_set_camera_source(ty_scene* scene, const char* source) {
    snprintf(scene->camera_source, sizeof scene->camera_source, "%s", source);
}

/* m; empty when lower is above upper */
typedef struct extent {
    double lower[3], upper[3];
} extent;

static const extent nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void widen(extent* box, const double point[3]) {
    for (int a = 0; a < 3; ++a) {
        box->lower[a] = fmin(box->lower[a], point[a]);
        box->upper[a] = fmax(box->upper[a], point[a]);
    }
}

static void widen_by_surfaces(extent* box, const ty_scene* scene) {
    for (size_t i = 0; i < scene->shape_count; ++i) ty_shape_extent(&scene->shapes[i], box->lower, box->upper);
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        widen(box, scene->meshes[i]->lower);
        widen(box, scene->meshes[i]->upper);
    }
}

/* An empty box becomes a point. */
static void copy_extent(const extent* box, double lower[3], double upper[3]) {
    const bool empty = box->lower[0] > box->upper[0];
    for (int a = 0; a < 3; ++a) {
        lower[a] = empty ? 0 : box->lower[a];
        upper[a] = empty ? 0 : box->upper[a];
    }
}

void ty_scene_surface_extent(const ty_scene* scene, double lower[3], double upper[3]) {
    extent box = nothing;
    widen_by_surfaces(&box, scene);
    copy_extent(&box, lower, upper);
}

void ty_scene_extent(const ty_scene* scene, double lower[3], double upper[3]) {
    extent box = nothing;
    for (size_t i = 0; i < scene->medium_count; ++i) ty_medium_extent(&scene->media[i], box.lower, box.upper);
    widen_by_surfaces(&box, scene);
    copy_extent(&box, lower, upper);
}

/* Grids of media, and textures of meshes and then of shapes, by number; NULL where there is none. */
static const ty_grid* numbered_grid(const ty_scene* scene, size_t number) {
    ty_grid* grids[TY_MEDIUM_GRIDS];
    ty_medium_grids(&scene->media[number / TY_MEDIUM_GRIDS], grids);
    return grids[number % TY_MEDIUM_GRIDS];
}

static const ty_texture* numbered_texture(const ty_scene* scene, size_t number) {
    if (number >= MESH_TEXTURES * scene->mesh_count) {
        number -= MESH_TEXTURES * scene->mesh_count;
        return ty_shape_texture(&scene->shapes[number / SHAPE_TEXTURES], (int32_t)(number % SHAPE_TEXTURES))->texture;
    }
    const ty_material_def* material = &scene->meshes[number / MESH_TEXTURES]->material;
    const size_t texture = number % MESH_TEXTURES;
    if (texture < TY_GLOSS_TEXTURES) return material->gloss.textures[texture].texture;
    return texture == TY_GLOSS_TEXTURES ? material->albedo_texture : material->emission_texture;
}

static size_t count_environment_bytes(const ty_scene* scene) {
    size_t sum = 0;
    for (size_t i = 0; i < scene->light_count; ++i) {
        const ty_environment* environment = scene->environments[i];
        if (environment == NULL) continue;
        sum += ty_environment_bytes(environment);
        bool counted = environment->map == NULL;
        for (size_t j = 0; j < i && !counted; ++j)
            counted = scene->environments[j] != NULL && scene->environments[j]->map == environment->map;
        if (!counted) sum += ty_environment_map_bytes(environment->map);
    }
    return sum;
}

/* Shared data count once. */
static size_t count_bytes(const ty_scene* scene) {
    const ty_committed_surfaces* surfaces = &scene->surfaces;
    const ty_committed_lights* lights = &scene->committed_lights;
    size_t sum = sizeof *scene + lights->capacity * sizeof(ty_light_view) +
                 scene->medium_count * sizeof(ty_medium_view) + surfaces->count * sizeof(ty_surface) +
                 surfaces->mesh_light_count * sizeof(int32_t) + surfaces->gloss_count * sizeof(ty_surface_gloss) +
                 surfaces->face_count * sizeof(ty_shape_face) + ty_accel_bytes(surfaces->accel) +
                 ty_light_tree_bytes(lights->tree);
    sum += count_environment_bytes(scene);
    for (size_t i = 0; i < TY_MEDIUM_GRIDS * scene->medium_count; ++i) {
        const ty_grid* grid = numbered_grid(scene, i);
        bool counted = grid == NULL;
        for (size_t j = 0; j < i && !counted; ++j) counted = numbered_grid(scene, j) == grid;
        if (!counted) sum += ty_grid_get_info(grid).bytes;
    }
    for (size_t i = 0; i < scene->medium_count; ++i) {
        const ty_closed_mesh* shell = scene->media[i].shell;
        bool counted = shell == NULL;
        for (size_t j = 0; j < i && !counted; ++j) counted = scene->media[j].shell == shell;
        if (!counted) sum += ty_closed_mesh_bytes(shell);
    }
    for (size_t i = 0; i < scene->mesh_count; ++i) sum += ty_triangle_mesh_bytes(scene->meshes[i]);
    return sum;
}

static void count_textures(const ty_scene* scene, ty_scene_info* info) {
    for (size_t i = 0; i < MESH_TEXTURES * scene->mesh_count + SHAPE_TEXTURES * scene->shape_count; ++i) {
        const ty_texture* texture = numbered_texture(scene, i);
        bool counted = texture == NULL;
        for (size_t j = 0; j < i && !counted; ++j) counted = numbered_texture(scene, j) == texture;
        if (counted) continue;
        ++info->textures;
        info->texture_bytes += ty_texture_bytes(texture);
    }
}

ty_scene_info ty_scene_get_info(const ty_scene* scene) {
    ty_scene_info info = {.media = (int32_t)scene->medium_count,
                          .lights = (int32_t)scene->light_count,
                          .shapes = (int32_t)scene->shape_count,
                          .meshes = (int32_t)scene->mesh_count,
                          .emitters = scene->view.lights.count,
                          .bounded = scene->medium_count > 0 || scene->shape_count > 0 || scene->mesh_count > 0};
    ty_scene_extent(scene, info.lower, info.upper);
    for (size_t i = 0; i < scene->mesh_count; ++i) info.triangles += (int64_t)scene->meshes[i]->triangle_count;
    count_textures(scene, &info);
    info.bytes = count_bytes(scene) + info.texture_bytes;
    return info;
}

ty_result ty_scene_copy_medium(const ty_scene* scene, int32_t index, void* out, size_t bytes) {
    if (index < 0 || (size_t)index >= scene->medium_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there is no medium %d", (int)index);
    ty_init_def(out, bytes, &scene->media[index], sizeof scene->media[index]);
    return TY_OK;
}

void ty_scene_environment(const ty_scene* scene, float radiance[3]) {
    for (int c = 0; c < 3; ++c) radiance[c] = 0;
    for (size_t i = 0; i < scene->light_count; ++i)
        for (int c = 0; c < 3 && scene->environments[i] != NULL; ++c) radiance[c] += scene->environments[i]->mean[c];
}

ty_result ty_scene_copy_mesh(const ty_scene* scene, int32_t index, void* out, size_t bytes) {
    if (index < 0 || (size_t)index >= scene->mesh_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "meshes: there is no mesh %d", (int)index);
    const ty_triangle_mesh* mesh = scene->meshes[index];
    ty_mesh_def own = ty_default_mesh_def();
    own.vertex_count = (int64_t)mesh->vertex_count;
    own.triangle_count = (int64_t)mesh->triangle_count;
    own.positions = mesh->positions;
    own.normals = mesh->normals;
    for (int set = 0; set < 2; ++set) own.uv[set] = mesh->uv[set];
    own.colors = mesh->colors;
    own.indices = mesh->indices;
    own.material = mesh->material;
    own.origin = mesh->origin;
    ty_init_def(out, bytes, &own, sizeof own);
    return TY_OK;
}
