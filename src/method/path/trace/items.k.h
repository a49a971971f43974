/* The loop over items and samples of the path tracing kernels. */
#ifndef TY_METHOD_PATH_TRACE_ITEMS_K_H
#define TY_METHOD_PATH_TRACE_ITEMS_K_H

#include "base/float_mode.h"
#include "method/path/trace/column.k.h"

static const uint64_t outline_seed = 0x6c62272e07bb0142u;

/* The dielectrics around the camera are known. */
static void begin_at_camera(ty_path* path) {
    path->origin = path->request->camera.origin;
    if (ty_path_sees_dielectrics(path)) ty_path_set_inside(path, &path->request->camera_inside);
}

/* A thin lens, or a camera that moves while its shutter is open. */
static void begin_at_lens(ty_path* path, float x, float y) {
    const float u = ty_sobol_next(&path->random), v = ty_sobol_next(&path->random);
    const float time = ty_sobol_next(&path->random);
    const ty_camera_view camera = ty_camera_sample(&path->request->camera, u, v, time);
    path->origin = camera.origin;
    path->direction = ty_camera_direction(&camera, x, y);
    ty_path_begin_inside(path);
}

static void start(ty_path* path, const ty_path_request* request, int64_t item) {
    if (request->kind == TY_PATH_PIXELS) {
        const int32_t x = request->crop[0] + (int32_t)(item % request->crop[2]);
        const int32_t y = request->crop[1] + (int32_t)(item / request->crop[2]);
        const float dx = ty_sobol_next(&path->random), dy = ty_sobol_next(&path->random);
        if (request->camera.sampled != 0) {
            begin_at_lens(path, (float)x + dx, (float)y + dy);
            return;
        }
        begin_at_camera(path);
        path->direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
    } else if (request->kind == TY_PATH_RAYS) {
        const double* ray = request->rays + 6 * item;
        const double length = sqrt(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5]);
        path->origin = ty_vec_make((float)ray[0], (float)ray[1], (float)ray[2]);
        ty_path_begin_inside(path);
        /* The path goes against the light; 0 - x, so that no component becomes -0. */
        path->direction =
            ty_vec_make((float)((0 - ray[3]) / length), (float)((0 - ray[4]) / length), (float)((0 - ray[5]) / length));
    } else if (ty_path_takes_columns(request)) {
        ty_path_begin_column(path, request->columns, item);
    } else {
        const float factor[3] = {1.0f, 1.0f, 1.0f};
        float point[3];
        int64_t rest = item;
        for (int a = 0; a < 3; ++a) {
            const int64_t index = rest % request->size[a];
            rest /= request->size[a];
            const float offset = request->cell[a] > 0 ? ty_sobol_next(&path->random) : 0.5f;
            point[a] = (float)(request->lower[a] + request->cell[a] * ((double)index + (double)offset));
        }
        ty_path_begin_fluence(path, ty_vec_make(point[0], point[1], point[2]), factor);
    }
}

/* Index of an item's random sequence. A pixel's does not depend on the crop. */
static uint64_t random_item(const ty_path_request* request, int64_t item) {
    if (request->kind != TY_PATH_PIXELS) return (uint64_t)item;
    const int64_t x = request->crop[0] + item % request->crop[2], y = request->crop[1] + item / request->crop[2];
    return (uint64_t)(y * request->width + x);
}

/* The first surface along the camera's ray, and the transmittance and the albedo at the first collision before it. */
typedef struct first_hit {
    ty_intersection end;
    bool hits, collides;
    float far; /* distance to the surface, m */
    float transmittance[3], scattered[3];
} first_hit;

static void find_first_hit_of_piece(const ty_path* path, ty_vec origin, float far, ty_sampler* random, first_hit* out) {
    const ty_scene_view* scene = path->request->scene;
    float piece[3], emission[3] = {0.0f, 0.0f, 0.0f};
    out->hits = scene->mesh != NULL && ty_accel_intersect(scene->mesh, origin, path->direction, far, &out->end.hit);
    out->far = out->hits ? out->end.hit.distance : far;
    ty_transmittance(scene->media, scene->medium_count, origin, path->direction, out->far, random, piece);
    for (int c = 0; c < 3; ++c) out->transmittance[c] *= piece[c];
    if (out->collides) return;
    ty_spans spans;
    ty_collision collision;
    ty_spans_find(scene->media, scene->medium_count, origin, path->direction, out->far, &spans);
    out->collides = spans.count > 0 && ty_delta_tracking(scene->media, &spans, origin, path->direction, random,
                                                         out->scattered, emission, &collision);
}

static void find_first_hit(const ty_path* path, ty_sampler* random, first_hit* out) {
    const ty_scene_view* scene = path->request->scene;
    out->hits = out->collides = false;
    for (int c = 0; c < 3; ++c) out->transmittance[c] = out->scattered[c] = 1.0f;
    if (TY_PATH_PERIODIC == 0) {
        find_first_hit_of_piece(path, path->origin, TY_FLOAT_MAX, random, out);
        return;
    }
    ty_periodic_walk walk;
    bool more = ty_periodic_walk_begin(&walk, &scene->periodic, path->origin, path->direction);
    for (; more && !out->hits; more = ty_periodic_walk_next(&walk, &scene->periodic)) {
        find_first_hit_of_piece(path, walk.origin, walk.far, random, out);
        out->far += walk.passed;
    }
}

/* Adds the first-hit channels. Separate random numbers leave the path's own sequence unchanged. */
TY_FN_CALLED void ty_path_add_first_hit(const ty_path* path, uint64_t number, uint32_t sample,
                                        ty_path_aov_sums* aov_sums) {
    const ty_scene_view* scene = path->request->scene;
    ty_sampler random = ty_sampler_begin(path->request->sobol, ~path->request->seed, number, sample);
    first_hit first;
    find_first_hit(path, &random, &first);
    for (int c = 0; c < 3; ++c) {
        aov_sums->transmittance[c] += (double)first.transmittance[c];
        if (first.collides) aov_sums->albedo[c] += (double)first.scattered[c];
    }
    if (!first.hits) return;
    ty_intersection* end = &first.end;
    ty_surface_evaluate(&scene->surfaces[end->hit.surface], &end->hit, path->direction, &end->point);
    for (int c = 0; c < 3; ++c) aov_sums->surface_albedo[c] += (double)(first.transmittance[c] * end->point.albedo[c]);
    aov_sums->normal[0] += (double)end->point.ns.x;
    aov_sums->normal[1] += (double)end->point.ns.y;
    aov_sums->normal[2] += (double)end->point.ns.z;
    aov_sums->depth += (double)first.far;
    aov_sums->hits += 1;
}

/* Adds emission of surfaces that the camera sees: the mean over rays of their own, which the samples of a pixel
 * stratify. A ray costs little beside a path, and outlines of small lamps would make most of the noise of a pixel. */
TY_FN_CALLED void ty_path_add_seen_emission(ty_path* path, int64_t item, uint64_t number, uint32_t sample) {
    const ty_path_request* request = path->request;
    const ty_scene_view* scene = request->scene;
    const int32_t x = request->crop[0] + (int32_t)(item % request->crop[2]);
    const int32_t y = request->crop[1] + (int32_t)(item / request->crop[2]);
    for (uint32_t i = 0; i < TY_OUTLINE_RAYS; ++i) {
        const uint32_t ray = (sample * TY_OUTLINE_RAYS + i) & ((1u << TY_SOBOL_BITS) - 1);
        ty_sampler random = ty_sampler_begin(request->sobol, request->seed ^ outline_seed, number, ray);
        const float dx = ty_sobol_next(&random), dy = ty_sobol_next(&random);
        const ty_vec direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
        ty_hit hit;
        ty_surface_look look;
        float transmittance[3];
        if (!ty_accel_intersect(scene->mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit)) continue;
        ty_surface_evaluate_color(&scene->surfaces[hit.surface], &hit, direction, &look);
        if (!(ty_max3(look.emission) > 0.0f)) continue;
        ty_transmittance(scene->media, scene->medium_count, request->camera.origin, direction, hit.distance, &random,
                         transmittance);
        for (int c = 0; c < 3; ++c)
            path->radiance[TY_PATH_UNCOLLIDED][c] += transmittance[c] * look.emission[c] * (1.0f / TY_OUTLINE_RAYS);
    }
}

static void add_sample(const ty_path* path, ty_path_sums* sum, ty_path_aov_sums* aov_sums) {
    for (int c = 0; c < 3; ++c) {
        double value = 0;
        for (int path_class = 0; path_class < TY_PATH_CLASS_COUNT; ++path_class)
            value += (double)path->radiance[path_class][c];
        sum->mean[c] += value;
        sum->square[c] += value * value;
        if (aov_sums == NULL) continue;
        aov_sums->uncollided[c] += (double)path->radiance[TY_PATH_UNCOLLIDED][c];
        aov_sums->single[c] += (double)path->radiance[TY_PATH_SINGLE][c];
        aov_sums->multiple[c] += (double)path->radiance[TY_PATH_MULTIPLE][c];
    }
}

TY_FN TY_PATH_KERNEL(ty_path_sample_items) {
    const unsigned thread_state = ty_flush_denormals();
    uint64_t vertices = 0;
    ty_path_request direct; /* of columns, for direct light */
    if (ty_path_takes_columns(request)) ty_column_request_direct(request, &direct);
    for (int64_t item = begin; item < end; ++item) {
        const bool is_direct = ty_path_takes_columns(request) && ty_column_is_direct(request->columns, item);
        const ty_path_request* own = is_direct ? &direct : request;
        const uint64_t number = random_item(request, item);
        ty_path_aov_sums* sums_of_item = aov_sums != NULL ? &aov_sums[item - begin] : NULL;
        for (uint32_t i = first_sample; i < first_sample + count; ++i) {
            ty_path path;
            ty_path_begin(&path, own, number, i);
            start(&path, own, item);
            if (sums_of_item != NULL && request->first_hit != 0) ty_path_add_first_hit(&path, number, i, sums_of_item);
            if (i >= TY_OUTLINE_FIRST && request->outlines != NULL && request->outlines[item] != 0) {
                path.found = TY_FOUND_SURFACES;
                ty_path_add_seen_emission(&path, item, number, i);
            }
            vertices += ty_path_follow(&path);
            if (own != request) ty_column_keep_direct(&path);
            add_sample(&path, &sums[item - begin], sums_of_item);
        }
    }
    ty_restore_denormals(thread_state);
    return vertices;
}

#endif
