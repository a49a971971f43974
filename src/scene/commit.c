/* Commits: views of media, surfaces with their acceleration structure, and lights with their tree. Each is made apart
 * from the scene and exchanged when nothing can fail any more. */
#include "base/context.h"
#include "scene/surfaces/gloss.h"
#include "scene/interiors.h"
#include "scene/lights/light.h"
#include "scene/media/medium.h"
#include "scene/periodic.h"
#include "scene/scene.h"
#include "scene/surfaces/shape.h"
#include "scene/surfaces/texture.h"

#include <string.h>

/* ---- media ---- */

static void drop_media(ty_context* context, ty_committed_media* media) {
    for (size_t i = 0; i < media->count; ++i) ty_medium_view_destroy(context, &media->views[i]);
    ty_free_array(context, media->views, media->count, sizeof(ty_medium_view));
    *media = (ty_committed_media){.views = NULL};
}

/* On failure the caller drops what was made; so in all sections below. */
static ty_result commit_media(const ty_scene* scene, ty_committed_media* out) {
    const ty_result found =
        ty_periodic_find_cell(scene->context, &scene->periodic, scene->media, scene->medium_count, &out->cell);
    if (found != TY_OK || scene->medium_count == 0) return found;
    out->views = ty_alloc_array(scene->context, scene->medium_count, sizeof(ty_medium_view), true);
    if (out->views == NULL) return TY_ERROR_MEMORY;
    out->count = scene->medium_count;
    for (size_t i = 0; i < out->count; ++i) {
        const ty_result result = ty_medium_view_create(scene->context, &scene->media[i], &out->cell, &out->views[i]);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* ---- surfaces ---- */

static void drop_surfaces(ty_context* context, ty_committed_surfaces* surfaces) {
    ty_accel_destroy(surfaces->accel);
    ty_free_array(context, surfaces->shapes, surfaces->shape_count, sizeof(ty_shape_def));
    ty_free_array(context, surfaces->surfaces, surfaces->count, sizeof(ty_surface));
    ty_free_array(context, surfaces->gloss, surfaces->gloss_count, sizeof(ty_surface_gloss));
    ty_free_array(context, surfaces->faces, surfaces->face_count, sizeof(ty_shape_face));
    ty_free_array(context, surfaces->mesh_lights, surfaces->mesh_light_count, sizeof(int32_t));
    *surfaces = (ty_committed_surfaces){.shapes = NULL};
}

/* The scene's shapes in order of addition, then the lights of `lit` that are surfaces. */
static ty_result list_shapes(const ty_scene* scene, const ty_scene* lit, ty_committed_surfaces* out) {
    size_t count = scene->shape_count;
    for (size_t i = 0; i < lit->light_count; ++i) count += ty_light_is_surface(&lit->lights[i]);
    out->shapes = ty_alloc_array(scene->context, count, sizeof *out->shapes, false);
    if (out->shapes == NULL) return TY_ERROR_MEMORY;
    out->shape_count = count;
    for (size_t i = 0; i < scene->shape_count; ++i) out->shapes[i] = scene->shapes[i];
    size_t at = scene->shape_count;
    for (size_t i = 0; i < lit->light_count; ++i)
        if (ty_light_is_surface(&lit->lights[i])) out->shapes[at++] = ty_light_shape(&lit->lights[i]);
    return TY_OK;
}

static void set_shape_colors(const ty_shape_def* shape, ty_surface* surface) {
    memcpy(surface->albedo, shape->albedo, sizeof shape->albedo);
    memcpy(surface->emission, shape->emission, sizeof shape->emission);
}

/* Textures and texture coordinates of the shapes that have any. */
static ty_result commit_shape_textures(const ty_scene* scene, ty_committed_surfaces* out) {
    for (size_t i = 0; i < out->shape_count; ++i)
        if (ty_shape_is_textured(&out->shapes[i])) out->face_count += TY_SHAPE_FACES;
    if (out->face_count == 0) return TY_OK;
    out->faces = ty_alloc_array(scene->context, out->face_count, sizeof *out->faces, true);
    if (out->faces == NULL) return TY_ERROR_MEMORY;
    ty_shape_face* next = out->faces;
    for (size_t i = 0; i < out->shape_count; ++i) {
        const ty_shape_def* shape = &out->shapes[i];
        ty_surface* surface = &out->surfaces[i];
        if (!ty_shape_is_textured(shape)) continue;
        ty_shape_get_faces(shape, scene->up, next);
        surface->faces = next;
        surface->round = shape->kind == TY_SHAPE_SPHERE;
        surface->albedo_texture = ty_texture_get_view(shape->albedo_texture.texture);
        memcpy(surface->albedo_map, shape->albedo_texture.map, sizeof surface->albedo_map);
        next += TY_SHAPE_FACES;
    }
    return TY_OK;
}

static ty_result commit_mesh_lights(const ty_scene* scene, ty_committed_surfaces* out) {
    for (size_t i = 0; i < scene->mesh_count; ++i)
        if (ty_triangle_mesh_emits(scene->meshes[i])) out->mesh_light_count += scene->meshes[i]->triangle_count;
    out->mesh_lights = ty_alloc_array(scene->context, out->mesh_light_count, sizeof *out->mesh_lights, false);
    if (out->mesh_lights == NULL) return TY_ERROR_MEMORY;
    size_t at = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        if (!ty_triangle_mesh_emits(scene->meshes[i])) continue;
        out->surfaces[out->shape_count + i].lights = out->mesh_lights + at;
        at += scene->meshes[i]->triangle_count;
    }
    return TY_OK;
}

/* Gloss of a surface; NULL: Lambertian. */
static const ty_gloss_def* gloss_of(const ty_scene* scene, const ty_committed_surfaces* surfaces, size_t i) {
    const size_t shapes = surfaces->shape_count;
    const ty_gloss_def* def = i < shapes ? &surfaces->shapes[i].gloss : &scene->meshes[i - shapes]->material.gloss;
    return ty_gloss_exists(def) ? def : NULL;
}

static ty_result commit_gloss(const ty_scene* scene, ty_committed_surfaces* out) {
    for (size_t i = 0; i < out->count; ++i) out->gloss_count += gloss_of(scene, out, i) != NULL;
    if (out->gloss_count == 0) return TY_OK;
    out->gloss = ty_alloc_array(scene->context, out->gloss_count, sizeof *out->gloss, false);
    if (out->gloss == NULL) return TY_ERROR_MEMORY;
    ty_surface_gloss* next = out->gloss;
    for (size_t i = 0; i < out->count; ++i) {
        const ty_gloss_def* def = gloss_of(scene, out, i);
        if (def == NULL) continue;
        *next = ty_gloss_get_view(def);
        out->surfaces[i].gloss = next++;
    }
    return TY_OK;
}

/* Surfaces and acceleration structure of listed shapes and the scene's meshes. */
static ty_result commit_surfaces(const ty_scene* scene, ty_committed_surfaces* out) {
    out->count = out->shape_count + scene->mesh_count;
    if (out->count == 0) return TY_OK;
    out->surfaces = ty_alloc_array(scene->context, out->count, sizeof(ty_surface), true);
    if (out->surfaces == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < out->shape_count; ++i) {
        double center[3];
        set_shape_colors(&out->shapes[i], &out->surfaces[i]);
        out->surfaces[i].first_light = -1;
        if (out->shapes[i].kind == TY_SHAPE_SPHERE)
            out->surfaces[i].curvature = (float)(1 / ty_shape_sphere(&out->shapes[i], center));
    }
    for (size_t i = 0; i < scene->mesh_count; ++i)
        out->surfaces[out->shape_count + i] = ty_triangle_mesh_get_surface(scene->meshes[i]);
    ty_result result = commit_mesh_lights(scene, out);
    if (result == TY_OK) result = commit_shape_textures(scene, out);
    if (result == TY_OK) result = commit_gloss(scene, out);
    if (result != TY_OK) return result;
    const ty_accel_input parts = {.shapes = out->shapes,
                                  .shape_count = out->shape_count,
                                  .meshes = scene->meshes,
                                  .mesh_count = scene->mesh_count,
                                  .surfaces = out->surfaces};
    return ty_accel_create(scene->context, &parts, &out->accel);
}

/* True if shapes have the same places, whatever their colours. */
static bool same_places(const ty_committed_surfaces* a, const ty_committed_surfaces* b) {
    if (a->shape_count != b->shape_count) return false;
    for (size_t i = 0; i < a->shape_count; ++i) {
        const ty_shape_def *s = &a->shapes[i], *t = &b->shapes[i];
        if (s->kind != t->kind || s->radius != t->radius || memcmp(s->origin, t->origin, sizeof s->origin) != 0 ||
            memcmp(s->u, t->u, sizeof s->u) != 0 || memcmp(s->v, t->v, sizeof s->v) != 0 ||
            memcmp(&s->transform, &t->transform, sizeof s->transform) != 0)
            return false;
    }
    return true;
}

/* ---- lights ---- */

static void drop_lights(ty_context* context, ty_committed_lights* lights) {
    ty_free_array(context, lights->views, lights->capacity, sizeof(ty_light_view));
    ty_free_array(context, lights->distant, lights->distant_capacity, sizeof(int32_t));
    ty_light_tree_destroy(context, lights->tree);
    *lights = (ty_committed_lights){.views = NULL};
}

static size_t shape_light_count(const ty_shape_def* shape) {
    if (!ty_shape_emits(shape)) return 0;
    return shape->kind == TY_SHAPE_SPHERE ? 1 : (size_t)ty_shape_quad_count(shape);
}

/* Lights that are not surfaces. */
static size_t count_explicit(const ty_scene* lit) {
    size_t count = 0;
    for (size_t i = 0; i < lit->light_count; ++i) count += !ty_light_is_surface(&lit->lights[i]);
    return count;
}

static size_t count_shape_lights(const ty_committed_surfaces* surfaces) {
    size_t count = 0;
    for (size_t i = 0; i < surfaces->shape_count; ++i) count += shape_light_count(&surfaces->shapes[i]);
    return count;
}

static void add_shape_lights(const ty_shape_def* shape, ty_light_view* views, size_t* at) {
    if (!ty_shape_emits(shape)) return;
    double origin[3], u[3], v[3];
    if (shape->kind == TY_SHAPE_SPHERE) {
        const double radius = ty_shape_sphere(shape, origin);
        views[(*at)++] = ty_light_sphere_view(origin, radius, shape->emission);
    }
    for (int32_t q = 0; q < ty_shape_quad_count(shape); ++q) {
        ty_shape_quad(shape, q, origin, u, v);
        views[(*at)++] = ty_light_quad_view(origin, u, v, shape->emission);
    }
}

/* shapes: of the lights that are surfaces. */
static void add_surface_lights(const ty_scene* lit, const ty_shape_def* shapes, ty_light_view* views, size_t* at) {
    for (size_t i = 0; i < lit->light_count; ++i) {
        if (!ty_light_is_surface(&lit->lights[i])) continue;
        const size_t first = *at;
        add_shape_lights(shapes++, views, at);
        if (*at > first && lit->lights[i].kind == TY_LIGHT_SPOT) ty_light_set_cone(&lit->lights[i], &views[first]);
    }
}

/* Lights of new surfaces' triangles, which are numbered. */
static void add_mesh_lights(const ty_scene* scene, ty_committed_surfaces* surfaces, ty_light_view* views, size_t* at) {
    surfaces->first_mesh_light = (int32_t)*at;
    int32_t* number = surfaces->mesh_lights;
    for (size_t m = 0; m < scene->mesh_count; ++m) {
        const ty_surface* surface = &surfaces->surfaces[surfaces->shape_count + m];
        if (surface->lights == NULL) continue;
        for (size_t i = 0; i < scene->meshes[m]->triangle_count; ++i) {
            const bool sends = ty_light_triangle_view(surface, (int32_t)i, &views[*at]);
            *number++ = sends ? (int32_t)*at : -1;
            *at += sends;
        }
    }
}

/* Distant lights in a list, the others in a tree. */
static ty_result sort_lights(const ty_scene* lit, size_t count, ty_committed_lights* out) {
    ty_context* context = lit->context;
    ty_light_bounds* bounds = ty_alloc_array(context, count, sizeof *bounds, false);
    out->distant = ty_alloc_array(context, lit->light_count, sizeof(int32_t), false);
    out->distant_capacity = lit->light_count;
    ty_result result = bounds != NULL && out->distant != NULL ? TY_OK : TY_ERROR_MEMORY;
    for (size_t i = 0; i < count && result == TY_OK; ++i) {
        const ty_light_view* light = &out->views[i];
        ty_light_get_bounds(light, &bounds[i]);
        out->set.local_count += ty_light_is_local(light->kind);
        if (light->kind == TY_KIND_DIRECTIONAL || light->kind == TY_KIND_ENVIRONMENT)
            out->distant[out->set.distant_count++] = (int32_t)i;
    }
    if (result == TY_OK) result = ty_light_tree_create(context, bounds, count, &out->tree);
    ty_free_array(context, bounds, count, sizeof *bounds);
    if (result != TY_OK) return result;
    out->set.lights = out->views;
    out->set.count = (int32_t)count;
    out->set.distant = out->distant;
    out->set.nodes = out->tree->nodes;
    out->set.trails = out->tree->trails;
    return TY_OK;
}

/* Lights of `lit` and of surfaces. before: the lights of the same meshes from another commit, whose views are taken;
 * NULL: surfaces are new. The weights of the lights are left to weigh_lights. */
static ty_result commit_lights(const ty_scene* scene, const ty_scene* lit, ty_committed_surfaces* surfaces,
                               const ty_committed_lights* before, ty_committed_lights* out) {
    const size_t capacity = count_explicit(lit) + count_shape_lights(surfaces) + surfaces->mesh_light_count;
    if (capacity == 0) return TY_OK;
    out->views = ty_alloc_array(scene->context, capacity, sizeof(ty_light_view), false);
    if (out->views == NULL) return TY_ERROR_MEMORY;
    out->capacity = capacity;
    size_t at = 0;
    for (size_t i = 0; i < lit->light_count; ++i)
        if (!ty_light_is_surface(&lit->lights[i]))
            out->views[at++] = ty_light_get_view(&lit->lights[i], lit->environments[i], lit->up);
    for (size_t i = 0; i < scene->shape_count; ++i) add_shape_lights(&surfaces->shapes[i], out->views, &at);
    add_surface_lights(lit, surfaces->shapes + scene->shape_count, out->views, &at);
    if (before == NULL) {
        add_mesh_lights(scene, surfaces, out->views, &at);
    } else if (surfaces->mesh_light_count > 0) {
        const size_t first = (size_t)scene->surfaces.first_mesh_light, count = (size_t)before->set.count - first;
        memcpy(out->views + at, before->views + first, count * sizeof *out->views);
        at += count;
    }
    return sort_lights(lit, at, out);
}

static ty_cone cone_of(const ty_light_view* light) {
    return (ty_cone){light->cone, light->direction, light->cos_outer, light->cos_inner};
}

/* Numbers of the lights in surfaces, after `explicit` others, and the cones of spots. */
static void number_lights(const ty_committed_lights* lights, ty_committed_surfaces* surfaces, size_t explicit) {
    int32_t at = (int32_t) explicit;
    for (size_t i = 0; i < surfaces->shape_count; ++i) {
        const int32_t count = (int32_t)shape_light_count(&surfaces->shapes[i]);
        surfaces->surfaces[i].first_light = count > 0 ? at : -1;
        surfaces->surfaces[i].cone = count > 0 ? cone_of(&lights->views[at]) : (ty_cone){.exists = false};
        at += count;
    }
    const int32_t shift = at - surfaces->first_mesh_light;
    for (size_t i = 0; i < surfaces->mesh_light_count && shift != 0; ++i)
        if (surfaces->mesh_lights[i] >= 0) surfaces->mesh_lights[i] += shift;
    surfaces->first_mesh_light = at;
}

/* Probabilities of the lights, which depend on the extent of the scene. */
static void weigh_lights(const ty_scene* scene, ty_committed_lights* lights) {
    if (lights->set.count == 0) return;
    double lower[3], upper[3];
    ty_scene_extent(scene, lower, upper);
    lights->set.tree_probability = ty_light_set_choice(lights->views, (size_t)lights->set.count, lower, upper);
}

/* ---- scenes ---- */

/* Interiors of dielectrics, from parts that may be new. defs: of the media. */
static ty_result commit_interiors(const ty_scene* scene, const ty_medium_def* defs, const ty_committed_media* media,
                                  const ty_committed_surfaces* surfaces, bool warns, ty_committed_interiors* out) {
    const ty_interiors_input input = {.defs = defs, .media = media, .surfaces = surfaces, .meshes = scene->meshes};
    return ty_interiors_create(scene->context, &input, warns, out);
}

static void set_view(ty_scene* scene) {
    scene->view = (ty_scene_view){.media = scene->committed_media.views,
                                  .medium_count = (int32_t)scene->committed_media.count,
                                  .lights = scene->committed_lights.set,
                                  .mesh = scene->surfaces.accel,
                                  .surfaces = scene->surfaces.surfaces,
                                  .interiors = scene->interiors.interiors,
                                  .interior_count = (int32_t)scene->interiors.count,
                                  .periodic = scene->committed_media.cell};
    ty_periodic_bound_cell(scene, &scene->view.periodic);
    scene->committed = true;
}

void ty_scene_drop_commit(ty_scene* scene) {
    drop_media(scene->context, &scene->committed_media);
    drop_surfaces(scene->context, &scene->surfaces);
    drop_lights(scene->context, &scene->committed_lights);
    ty_interiors_destroy(scene->context, &scene->interiors);
    scene->view = (ty_scene_view){.media = NULL};
    scene->committed = false;
}

ty_result ty_scene_commit(ty_scene* scene) {
    ty_scene_drop_commit(scene);
    ty_result result = list_shapes(scene, scene, &scene->surfaces);
    if (result == TY_OK) result = commit_media(scene, &scene->committed_media);
    if (result == TY_OK) result = commit_surfaces(scene, &scene->surfaces);
    if (result == TY_OK) result = commit_lights(scene, scene, &scene->surfaces, NULL, &scene->committed_lights);
    if (result == TY_OK)
        result =
            commit_interiors(scene, scene->media, &scene->committed_media, &scene->surfaces, true, &scene->interiors);
    if (result == TY_OK)
        result = ty_periodic_check(scene, &scene->committed_media.cell, &scene->committed_lights, &scene->interiors);
    if (result != TY_OK) {
        ty_scene_drop_commit(scene);
        return result;
    }
    number_lights(&scene->committed_lights, &scene->surfaces, count_explicit(scene));
    weigh_lights(scene, &scene->committed_lights);
    set_view(scene);
    return TY_OK;
}

/* ---- replaced parts ---- */

#define EXCHANGE(type, a, b)                                                                                           \
    do {                                                                                                               \
        type kept = (a);                                                                                               \
        (a) = (b);                                                                                                     \
        (b) = kept;                                                                                                    \
    } while (false)

/* Commits of replaced parts. */
typedef struct replacement {
    ty_committed_media media;
    ty_committed_surfaces surfaces; /* if `kept`, only its shapes */
    ty_committed_lights lights;
    ty_committed_interiors interiors;
    bool kept; /* surfaces stay, perhaps in other colours */
} replacement;

static ty_result prepare_lights(ty_scene* scene, const ty_scene* other, replacement* out) {
    ty_result result = list_shapes(scene, other, &out->surfaces);
    if (result != TY_OK) return result;
    out->kept = same_places(&scene->surfaces, &out->surfaces);
    if (!out->kept) {
        result = commit_surfaces(scene, &out->surfaces);
        return result == TY_OK ? commit_lights(scene, other, &out->surfaces, NULL, &out->lights) : result;
    }
    ty_committed_surfaces surfaces = scene->surfaces;
    surfaces.shapes = out->surfaces.shapes;
    return commit_lights(scene, other, &surfaces, &scene->committed_lights, &out->lights);
}

static void take_lights(ty_scene* scene, ty_scene* other, replacement* new) {
    if (new->kept)
        EXCHANGE(ty_shape_def*, scene->surfaces.shapes, new->surfaces.shapes);
    else
        EXCHANGE(ty_committed_surfaces, scene->surfaces, new->surfaces);
    for (size_t i = 0; i < scene->surfaces.shape_count; ++i)
        set_shape_colors(&scene->surfaces.shapes[i], &scene->surfaces.surfaces[i]);
    EXCHANGE(ty_committed_lights, scene->committed_lights, new->lights);
    EXCHANGE(ty_light_def*, scene->lights, other->lights);
    EXCHANGE(ty_environment**, scene->environments, other->environments);
    EXCHANGE(size_t, scene->light_count, other->light_count);
    EXCHANGE(size_t, scene->light_capacity, other->light_capacity);
    EXCHANGE(size_t, scene->environment_capacity, other->environment_capacity);
    number_lights(&scene->committed_lights, &scene->surfaces, count_explicit(scene));
}

static void take_media(ty_scene* scene, ty_scene* other, replacement* new) {
    EXCHANGE(ty_committed_media, scene->committed_media, new->media);
    EXCHANGE(ty_medium_def*, scene->media, other->media);
    EXCHANGE(size_t, scene->medium_count, other->medium_count);
    EXCHANGE(size_t, scene->medium_capacity, other->medium_capacity);
    EXCHANGE(ty_periodic_def, scene->periodic, other->periodic);
}

static void take_settings(ty_scene* scene, ty_scene* other) {
    EXCHANGE(ty_render_settings, scene->settings, other->settings);
    EXCHANGE(ty_scene_option*, scene->options, other->options);
    EXCHANGE(size_t, scene->option_count, other->option_count);
    EXCHANGE(size_t, scene->option_capacity, other->option_capacity);
}

static void take_camera(ty_scene* scene, ty_scene* other) {
    EXCHANGE(ty_camera_def, scene->camera, other->camera);
    char source[sizeof scene->camera_source];
    memcpy(source, scene->camera_source, sizeof source);
    memcpy(scene->camera_source, other->camera_source, sizeof source);
    memcpy(other->camera_source, source, sizeof source);
}

ty_result ty_scene_replace(ty_scene* scene, ty_scene* other, unsigned parts) {
    replacement new = {.kept = true};
    ty_result result = TY_OK;
    ty_scene_drop_commit(other);
    const bool media = (parts & TY_SCENE_MEDIA) != 0, lights = (parts & TY_SCENE_LIGHTS) != 0;
    if (media) result = commit_media(other, &new.media);
    if (result == TY_OK && lights) result = prepare_lights(scene, other, &new);
    if (result == TY_OK && (media || lights))
        result =
            commit_interiors(scene, media ? other->media : scene->media, media ? &new.media : &scene->committed_media,
                             lights && !new.kept ? &new.surfaces : &scene->surfaces, false, &new.interiors);
    if (result == TY_OK)
        result = ty_periodic_check(scene, media ? &new.media.cell : &scene->committed_media.cell,
                                   lights ? &new.lights : &scene->committed_lights,
                                   media || lights ? &new.interiors : &scene->interiors);
    if (result == TY_OK) {
        if (media) take_media(scene, other, &new);
        if (lights) take_lights(scene, other, &new);
        if (media || lights) EXCHANGE(ty_committed_interiors, scene->interiors, new.interiors);
        if ((parts & TY_SCENE_SETTINGS) != 0) take_settings(scene, other);
        if ((parts & TY_SCENE_CAMERA) != 0) take_camera(scene, other);
        if (media || lights) weigh_lights(scene, &scene->committed_lights);
        set_view(scene);
    }
    drop_media(scene->context, &new.media);
    drop_surfaces(scene->context, &new.surfaces);
    drop_lights(scene->context, &new.lights);
    ty_interiors_destroy(scene->context, &new.interiors);
    return result;
}
