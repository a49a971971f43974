/* Blockers from the scene's surfaces, or from a caller's maps and view. */
#include "base/context.h"
#include "method/lpv/inject/inject.h"
#include "scene/camera.h"
#include "scene/scene.h"

#include <math.h>

/* across: the cross section that the point represents; facing: cosine between the ray and the normal. */
static void add_point(ty_surfel_list* list, ty_vec position, ty_vec normal, float across, float facing,
                      const float albedo[3]) {
    ty_surfel* surfel = &list->items[list->count++];
    surfel->position = position;
    surfel->normal = normal;
    surfel->area = across / ty_maxf(fabsf(facing), 0.05f);
    for (int c = 0; c < 3; ++c) surfel->albedo[c] = albedo[c];
}

static void add_texel(const ty_lpv_light* source, int32_t face, int32_t x, int32_t y, ty_surfel_list* list) {
    const ty_rsm* rsm = source->rsm;
    const size_t at = ((size_t)face * (size_t)rsm->side + (size_t)y) * (size_t)rsm->side + (size_t)x;
    ty_vec origin, direction;
    if (!isfinite(rsm->depth[at])) return;
    ty_rsm_ray(rsm, source->light, face, (float)x + 0.5f, (float)y + 0.5f, &origin, &direction);
    const ty_vec off = ty_scale(direction, rsm->depth[at]), normal = ty_vec_load(rsm->normal + 3 * at);
    const float distance2 = source->light->kind == TY_KIND_DIRECTIONAL ? 1.0f : ty_dot(off, off);
    add_point(list, ty_add(origin, off), normal, ty_rsm_texel_measure(rsm, source->light, face, x, y) * distance2,
              ty_dot(normal, ty_normalize(direction)), rsm->albedo + 3 * at);
}

static size_t map_texels(const ty_rsm* rsm) {
    return (size_t)rsm->faces * (size_t)rsm->side * (size_t)rsm->side;
}

static void add_map(const ty_lpv_light* source, ty_surfel_list* list) {
    const ty_rsm* rsm = source->rsm;
    for (int32_t face = 0; face < rsm->faces; ++face)
        for (int32_t y = 0; y < rsm->side; ++y)
            for (int32_t x = 0; x < rsm->side; ++x) add_texel(source, face, x, y, list);
}

static void view_size(const ty_lpv_job* job, int32_t size[2]) {
    const ty_camera_def camera = ty_scene_camera(job->scene);
    size[0] = job->def->width > 0 ? job->def->width : camera.resolution[0];
    size[1] = job->def->width > 0 ? job->def->height : camera.resolution[1];
}

static void add_view(const ty_lpv_job* job, ty_surfel_list* list) {
    const ty_lpv_view_def* view = job->def->view;
    const ty_camera_def camera = ty_scene_camera(job->scene);
    int32_t size[2];
    view_size(job, size);
    const ty_camera_view eye = ty_camera_get_view(&camera, size[0], size[1]);
    const size_t width = (size_t)size[0], count = width * (size_t)size[1];
    for (size_t at = 0; at < count; ++at) {
        if (!isfinite(view->distance[at])) continue;
        const ty_vec ray =
            ty_mad(ty_mad(eye.corner, eye.dx, (float)(at % width) + 0.5f), eye.dy, (float)(at / width) + 0.5f);
        const float norm = sqrtf(ty_dot(ray, ray)), distance = view->distance[at];
        const ty_vec direction = ty_scale(ray, 1.0f / norm), normal = ty_vec_load(view->normal + 3 * at);
        const float solid_angle = ty_dot(eye.dx, eye.dx) / (norm * norm * norm);
        add_point(list, ty_mad(eye.origin, direction, distance), normal, solid_angle * distance * distance,
                  ty_dot(normal, direction), view->albedo + 3 * at);
    }
}

/* Surfels from a caller's maps and view. A surface that several of them see counts several times, which overestimates
 * the blocking of partly cut links. */
static ty_result list_view_surfels(ty_lpv_job* job, ty_surfel_list* list) {
    const ty_lpv* light = job->light;
    for (int32_t i = 0; i < light->source_count; ++i)
        if (light->sources[i].rsm->normal != NULL) list->capacity += map_texels(light->sources[i].rsm);
    if (job->def->view != NULL) {
        int32_t size[2];
        view_size(job, size);
        list->capacity += (size_t)size[0] * (size_t)size[1];
    }
    list->items = ty_alloc_array(job->context, list->capacity, sizeof *list->items, false);
    if (list->items == NULL) return TY_ERROR_MEMORY;
    for (int32_t i = 0; i < light->source_count; ++i)
        if (light->sources[i].rsm->normal != NULL) add_map(&light->sources[i], list);
    if (job->def->view != NULL) add_view(job, list);
    return TY_OK;
}

void ty_surfel_list_free(ty_context* context, ty_surfel_list* list) {
    ty_free_array(context, list->items, list->capacity, sizeof *list->items);
    *list = (ty_surfel_list){.items = NULL};
}

ty_result ty_lpv_find_blockers(ty_lpv_job* job, ty_lattice* lattice, ty_surfel_list* surfels) {
    const double begun = ty_wall_seconds();
    const bool own = ty_scene_get_view(job->scene)->mesh != NULL;
    ty_result result = own ? ty_surfels_trace(job->scene, &lattice->box, job->def->block_side, &surfels->items,
                                              &surfels->count, &surfels->capacity, &job->counter)
                           : list_view_surfels(job, surfels);
    if (result == TY_OK) result = ty_lattice_find_blockers(lattice, job->def->mode, surfels->items, surfels->count);
    if (result == TY_OK && own && job->def->mode == TY_LPV_MODE_LINKS)
        result = ty_lattice_find_crossings(lattice, job->scene, &job->counter);
    job->stats.blocker_seconds += ty_wall_seconds() - begun;
    return result;
}
