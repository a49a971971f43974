/* Blockers: of the scene's own surfaces, or of what a caller's maps and view show. */
#include "base/context.h"
#include "method/lpv/job.h"
#include "scene/camera.h"
#include "scene/scene.h"

#include <math.h>

/* Points of surfaces that one image sees, as many as it has texels. */
typedef struct seen_list {
    ty_surfel* items;
    size_t count, capacity;
} seen_list;

/* across: the area that the point stands for, across the ray that found it; facing: cosine between that and the
 * normal. */
static void add_point(seen_list* list, ty_vec position, ty_vec normal, float across, float facing,
                      const float albedo[3]) {
    ty_surfel* surfel = &list->items[list->count++];
    surfel->position = position;
    surfel->normal = normal;
    surfel->area = across / ty_maxf(fabsf(facing), 0.05f);
    for (int c = 0; c < 3; ++c) surfel->albedo[c] = albedo[c];
}

static void add_texel(const ty_lpv_source* source, int32_t face, int32_t x, int32_t y, seen_list* list) {
    const ty_light_map* map = source->map;
    const size_t at = ((size_t)face * (size_t)map->side + (size_t)y) * (size_t)map->side + (size_t)x;
    ty_vec origin, direction;
    if (!isfinite(map->depth[at])) return;
    ty_light_map_ray(map, source->light, face, (float)x + 0.5f, (float)y + 0.5f, &origin, &direction);
    const ty_vec off = ty_scale(direction, map->depth[at]), normal = ty_vec_load(map->normal + 3 * at);
    const float distance2 = source->light->kind == TY_KIND_DIRECTIONAL ? 1.0f : ty_dot(off, off);
    add_point(list, ty_add(origin, off), normal, ty_light_map_share(map, source->light, face, x, y) * distance2,
              ty_dot(normal, ty_normalize(direction)), map->albedo + 3 * at);
}

static ty_result take(ty_lpv_job* job, size_t capacity, seen_list* list) {
    list->capacity = capacity;
    list->count = 0;
    list->items = ty_alloc_array(job->context, capacity, sizeof *list->items, false);
    return list->items != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result block_by(ty_lpv_job* job, ty_lattice* lattice, seen_list* list) {
    const ty_result result = ty_lattice_block(lattice, job->def->mode, list->items, list->count);
    ty_free_array(job->context, list->items, list->capacity, sizeof *list->items);
    return result;
}

static ty_result block_by_map(ty_lpv_job* job, ty_lattice* lattice, const ty_lpv_source* source) {
    const ty_light_map* map = source->map;
    seen_list list;
    if (map->normal == NULL) return TY_OK;
    const ty_result result = take(job, (size_t)map->faces * (size_t)map->side * (size_t)map->side, &list);
    if (result != TY_OK) return result;
    for (int32_t face = 0; face < map->faces; ++face)
        for (int32_t y = 0; y < map->side; ++y)
            for (int32_t x = 0; x < map->side; ++x) add_texel(source, face, x, y, &list);
    return block_by(job, lattice, &list);
}

static ty_result block_by_view(ty_lpv_job* job, ty_lattice* lattice) {
    const ty_lpv_view_def* view = job->def->view;
    const ty_camera_def camera = ty_scene_camera(job->scene);
    const int32_t width = job->def->width > 0 ? job->def->width : camera.resolution[0];
    const int32_t height = job->def->width > 0 ? job->def->height : camera.resolution[1];
    const ty_camera_view eye = ty_camera_get_view(&camera, width, height);
    seen_list list;
    const ty_result result = take(job, (size_t)width * (size_t)height, &list);
    if (result != TY_OK) return result;
    for (size_t at = 0; at < list.capacity; ++at) {
        if (!isfinite(view->distance[at])) continue;
        const ty_vec way = ty_mad(ty_mad(eye.corner, eye.dx, (float)(at % (size_t)width) + 0.5f), eye.dy,
                                  (float)(at / (size_t)width) + 0.5f);
        const float stretch = sqrtf(ty_dot(way, way)), distance = view->distance[at];
        const ty_vec direction = ty_scale(way, 1.0f / stretch), normal = ty_vec_load(view->normal + 3 * at);
        const float solid_angle = ty_dot(eye.dx, eye.dx) / (stretch * stretch * stretch);
        add_point(&list, ty_mad(eye.origin, direction, distance), normal, solid_angle * distance * distance,
                  ty_dot(normal, direction), view->albedo + 3 * at);
    }
    return block_by(job, lattice, &list);
}

static ty_result block_by_scene(ty_lpv_job* job, ty_lattice* lattice) {
    seen_list list;
    const ty_result result = ty_surfels_trace(job->scene, &lattice->box, job->def->block_side, &list.items, &list.count,
                                              &list.capacity, &job->counter);
    return result == TY_OK ? block_by(job, lattice, &list) : result;
}

ty_result ty_lpv_find_blockers(ty_lpv_job* job, ty_lattice* lattice) {
    const double begun = ty_wall_seconds();
    ty_result result = TY_OK;
    const bool own = ty_scene_get_view(job->scene)->mesh != NULL;
    if (own) result = block_by_scene(job, lattice);
    if (result == TY_OK && own && job->def->mode == TY_LPV_MODE_LINKS)
        result = ty_lattice_cross(lattice, job->scene, &job->counter);
    for (int32_t i = 0; i < job->light->source_count && job->def->maps != NULL && result == TY_OK; ++i)
        result = block_by_map(job, lattice, &job->light->sources[i]);
    if (result == TY_OK && job->def->view != NULL) result = block_by_view(job, lattice);
    job->stats.blocker_seconds += ty_wall_seconds() - begun;
    return result;
}
