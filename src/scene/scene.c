/* Scenes: adding, committing, asking. */
#include "scene/scene.h"

#include "base/context.h"
#include "scene/camera.h"
#include "scene/light.h"
#include "scene/medium.h"
#include "scene/shape.h"

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
    scene->settings = (ty_render_settings){.method = "path", .spp = 64};
    *out = scene;
    return TY_OK;
}

static void drop_commit(ty_scene* scene) {
    ty_context* context = scene->context;
    ty_free_array(context, scene->medium_views, (size_t)scene->view.medium_count, sizeof(ty_medium_view));
    ty_free_array(context, scene->light_views, scene->light_view_count, sizeof(ty_light_view));
    ty_free_array(context, scene->surfaces, scene->surface_count, sizeof(ty_surface));
    ty_mesh_destroy(scene->mesh);
    scene->medium_views = NULL;
    scene->light_views = NULL;
    scene->surfaces = NULL;
    scene->mesh = NULL;
    scene->light_view_count = scene->surface_count = 0;
    scene->view = (ty_scene_view){.media = NULL};
    scene->committed = false;
}

void ty_scene_destroy(ty_scene* scene) {
    if (scene == NULL) return;
    ty_context* context = scene->context;
    drop_commit(scene);
    for (size_t i = 0; i < scene->medium_count; ++i) {
        ty_free_text(context, (char*)scene->media[i].name);
        ty_grid_destroy(scene->media[i].density_grid);
    }
    for (size_t i = 0; i < scene->light_count; ++i) ty_environment_destroy(context, scene->environments[i]);
    ty_free_array(context, scene->media, scene->medium_capacity, sizeof *scene->media);
    ty_free_array(context, scene->lights, scene->light_capacity, sizeof *scene->lights);
    ty_free_array(context, scene->environments, scene->environment_capacity, sizeof(ty_environment*));
    ty_free_array(context, scene->shapes, scene->shape_capacity, sizeof *scene->shapes);
    ty_free_array(context, scene, 1, sizeof *scene);
}

ty_result ty_scene_set_camera(ty_scene* scene, const ty_camera_def* def) {
    const ty_result result = ty_camera_check(scene->context, def);
    if (result == TY_OK) scene->camera = *def;
    return result;
}

ty_result ty_scene_add_medium(ty_scene* scene, const ty_medium_def* def) {
    const ty_result result = ty_medium_check(scene->context, def);
    if (result != TY_OK) return result;
    if (scene->medium_count >= TY_MEDIA_MAX)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there are more than %d", TY_MEDIA_MAX);
    if (!ty_grow_array(scene->context, (void**)&scene->media, &scene->medium_capacity, scene->medium_count,
                       sizeof *scene->media))
        return TY_ERROR_MEMORY;
    ty_medium_def copy = *def;
    copy.name = ty_copy_text(scene->context, def->name);
    if (copy.name == NULL) return TY_ERROR_MEMORY;
    ty_grid_retain(copy.density_grid);
    scene->media[scene->medium_count++] = copy;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_add_light(ty_scene* scene, const ty_light_def* def) {
    ty_context* context = scene->context;
    ty_result result = ty_light_check(context, def);
    if (result != TY_OK) return result;
    const size_t count = scene->light_count;
    if (!ty_grow_array(context, (void**)&scene->lights, &scene->light_capacity, count, sizeof *scene->lights) ||
        !ty_grow_array(context, (void**)&scene->environments, &scene->environment_capacity, count,
                       sizeof(ty_environment*)))
        return TY_ERROR_MEMORY;
    ty_environment* environment = NULL;
    if (def->kind == TY_LIGHT_ENVIRONMENT) result = ty_environment_create(context, def, &environment);
    if (result != TY_OK) return result;
    scene->lights[count] = *def;
    scene->lights[count].image = NULL;
    scene->environments[count] = environment;
    scene->light_count = count + 1;
    scene->committed = false;
    return TY_OK;
}

ty_result ty_scene_add_shape(ty_scene* scene, const ty_shape_def* def) {
    const ty_result result = ty_shape_check(scene->context, def);
    if (result != TY_OK) return result;
    if (!ty_grow_array(scene->context, (void**)&scene->shapes, &scene->shape_capacity, scene->shape_count,
                       sizeof *scene->shapes))
        return TY_ERROR_MEMORY;
    scene->shapes[scene->shape_count++] = *def;
    scene->committed = false;
    return TY_OK;
}

/* An area light as the black surface that it is. */
static ty_shape_def area_light_shape(const ty_light_def* light) {
    ty_shape_def shape = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        shape.origin[a] = light->position[a];
        shape.u[a] = light->u[a];
        shape.v[a] = light->v[a];
        shape.albedo[a] = 0;
        shape.emission[a] = light->color[a];
    }
    return shape;
}

static ty_result commit_media(ty_scene* scene) {
    if (scene->medium_count == 0) return TY_OK;
    scene->medium_views = ty_alloc_array(scene->context, scene->medium_count, sizeof(ty_medium_view), false);
    if (scene->medium_views == NULL) return TY_ERROR_MEMORY;
    scene->view.medium_count = (int32_t)scene->medium_count;
    for (size_t i = 0; i < scene->medium_count; ++i) {
        scene->medium_views[i] = ty_medium_get_view(&scene->media[i]);
        if (scene->medium_views[i].has_grid) scene->view.has_grids = 1;
    }
    scene->view.media = scene->medium_views;
    return TY_OK;
}

/* Lights of their own, then one per quad or sphere of emissive surfaces. */
static ty_result commit_lights(ty_scene* scene, const ty_shape_def* shapes) {
    size_t count = 0;
    for (size_t i = 0; i < scene->light_count; ++i) count += scene->lights[i].kind != TY_LIGHT_AREA;
    for (size_t i = 0; i < scene->surface_count; ++i)
        if (ty_shape_emits(&shapes[i]))
            count += shapes[i].kind == TY_SHAPE_SPHERE ? 1 : (size_t)ty_shape_quad_count(&shapes[i]);
    if (count == 0) return TY_OK;
    scene->light_views = ty_alloc_array(scene->context, count, sizeof(ty_light_view), false);
    if (scene->light_views == NULL) return TY_ERROR_MEMORY;
    scene->light_view_count = count;
    size_t at = 0;
    for (size_t i = 0; i < scene->light_count; ++i)
        if (scene->lights[i].kind != TY_LIGHT_AREA)
            scene->light_views[at++] = ty_light_get_view(&scene->lights[i], scene->environments[i], scene->up);
    for (size_t i = 0; i < scene->surface_count; ++i) {
        if (!ty_shape_emits(&shapes[i])) continue;
        scene->surfaces[i].first_light = (int32_t)at;
        double origin[3], u[3], v[3];
        if (shapes[i].kind == TY_SHAPE_SPHERE) {
            const double radius = ty_shape_sphere(&shapes[i], origin);
            scene->light_views[at++] = ty_light_sphere_view(origin, radius, shapes[i].emission);
        }
        for (int32_t q = 0; q < ty_shape_quad_count(&shapes[i]); ++q) {
            ty_shape_quad(&shapes[i], q, origin, u, v);
            scene->light_views[at++] = ty_light_quad_view(origin, u, v, shapes[i].emission);
        }
    }
    const ty_scene_info info = ty_scene_get_info(scene);
    ty_light_set_choice(scene->light_views, count, info.lower, info.upper);
    scene->view.lights = scene->light_views;
    scene->view.light_count = (int32_t)count;
    return TY_OK;
}

static ty_result commit_surfaces(ty_scene* scene, const ty_shape_def* shapes) {
    if (scene->surface_count == 0) return TY_OK;
    scene->surfaces = ty_alloc_array(scene->context, scene->surface_count, sizeof(ty_surface), false);
    if (scene->surfaces == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < scene->surface_count; ++i) {
        memcpy(scene->surfaces[i].albedo, shapes[i].albedo, sizeof shapes[i].albedo);
        memcpy(scene->surfaces[i].emission, shapes[i].emission, sizeof shapes[i].emission);
        scene->surfaces[i].first_light = -1;
    }
    scene->view.surfaces = scene->surfaces;
    const ty_result result = ty_mesh_create(scene->context, shapes, scene->surface_count, &scene->mesh);
    scene->view.mesh = scene->mesh;
    return result;
}

ty_result ty_scene_commit(ty_scene* scene) {
    drop_commit(scene);
    size_t count = scene->shape_count;
    for (size_t i = 0; i < scene->light_count; ++i) count += scene->lights[i].kind == TY_LIGHT_AREA;
    ty_shape_def* shapes = ty_alloc_array(scene->context, count, sizeof *shapes, false);
    if (shapes == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < scene->shape_count; ++i) shapes[i] = scene->shapes[i];
    size_t at = scene->shape_count;
    for (size_t i = 0; i < scene->light_count; ++i)
        if (scene->lights[i].kind == TY_LIGHT_AREA) shapes[at++] = area_light_shape(&scene->lights[i]);
    scene->surface_count = count;
    ty_result result = commit_media(scene);
    if (result == TY_OK) result = commit_surfaces(scene, shapes);
    if (result == TY_OK) result = commit_lights(scene, shapes);
    ty_free_array(scene->context, shapes, count, sizeof *shapes);
    if (result != TY_OK) {
        drop_commit(scene);
        return result;
    }
    scene->committed = true;
    return TY_OK;
}

const ty_scene_view* ty_scene_get_view(const ty_scene* scene) {
    if (scene->committed) return &scene->view;
    ty_fail(scene->context, TY_ERROR_ARGUMENT, "the scene was not committed after its last change");
    return NULL;
}

ty_context* ty_scene_context(const ty_scene* scene) {
    return scene->context;
}

ty_axis ty_scene_up_axis(const ty_scene* scene) {
    return scene->up;
}

ty_camera_def ty_scene_camera(const ty_scene* scene) {
    return scene->camera;
}

ty_render_settings ty_scene_render_settings(const ty_scene* scene) {
    return scene->settings;
}

void ty_scene_set_render_settings(ty_scene* scene, const ty_render_settings* settings) {
    scene->settings = *settings;
}

uint64_t ty_scene_hash(const ty_scene* scene) {
    return scene->hash;
}

void ty_scene_set_hash(ty_scene* scene, uint64_t hash) {
    scene->hash = hash;
}

static void widen(ty_scene_info* info, const double point[3]) {
    for (int a = 0; a < 3; ++a) {
        info->lower[a] = fmin(info->lower[a], point[a]);
        info->upper[a] = fmax(info->upper[a], point[a]);
    }
}

static void widen_by_shape(ty_scene_info* info, const ty_shape_def* shape) {
    double origin[3], u[3], v[3], point[3];
    if (shape->kind == TY_SHAPE_SPHERE) {
        const double radius = ty_shape_sphere(shape, origin);
        for (int side = -1; side <= 1; side += 2) {
            for (int a = 0; a < 3; ++a) point[a] = origin[a] + side * radius;
            widen(info, point);
        }
    }
    for (int32_t q = 0; q < ty_shape_quad_count(shape); ++q) {
        ty_shape_quad(shape, q, origin, u, v);
        for (int corner = 0; corner < 4; ++corner) {
            for (int a = 0; a < 3; ++a) point[a] = origin[a] + (corner & 1 ? u[a] : 0) + (corner & 2 ? v[a] : 0);
            widen(info, point);
        }
    }
}

ty_scene_info ty_scene_get_info(const ty_scene* scene) {
    ty_scene_info info = {.media = (int32_t)scene->medium_count,
                          .lights = (int32_t)scene->light_count,
                          .shapes = (int32_t)scene->shape_count,
                          .bounded = scene->medium_count > 0 || scene->shape_count > 0,
                          .lower = {INFINITY, INFINITY, INFINITY},
                          .upper = {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < scene->medium_count; ++i) ty_medium_extent(&scene->media[i], info.lower, info.upper);
    for (size_t i = 0; i < scene->shape_count; ++i) widen_by_shape(&info, &scene->shapes[i]);
    for (int a = 0; a < 3 && !info.bounded; ++a) info.lower[a] = info.upper[a] = 0;
    info.bytes = sizeof *scene + scene->light_view_count * sizeof(ty_light_view) +
                 scene->medium_count * sizeof(ty_medium_view) + scene->surface_count * sizeof(ty_surface) +
                 ty_mesh_bytes(scene->mesh);
    for (size_t i = 0; i < scene->medium_count; ++i) {
        bool counted = scene->media[i].density_grid == NULL;
        for (size_t j = 0; j < i && !counted; ++j)
            counted = scene->media[j].density_grid == scene->media[i].density_grid;
        if (!counted) info.bytes += ty_grid_get_info(scene->media[i].density_grid).bytes;
    }
    for (size_t i = 0; i < scene->light_count; ++i)
        if (scene->environments[i] != NULL) info.bytes += ty_environment_bytes(scene->environments[i]);
    return info;
}

ty_result ty_scene_get_medium(const ty_scene* scene, int32_t index, ty_medium_def* out) {
    if (index < 0 || (size_t)index >= scene->medium_count)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there is no medium %d", (int)index);
    *out = scene->media[index];
    return TY_OK;
}
