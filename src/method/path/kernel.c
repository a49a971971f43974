/* The path tracer's kernel; built once per instruction set, with TY_ISA naming it. */
#include "method/path/path.k.h"

#include "base/float_mode.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

static void start(ty_path* path, const ty_path_request* request, int64_t item) {
    if (request->kind == TY_PATH_PIXELS) {
        const int32_t x = request->crop[0] + (int32_t)(item % request->crop[2]);
        const int32_t y = request->crop[1] + (int32_t)(item / request->crop[2]);
        const float dx = ty_sobol_next(&path->random), dy = ty_sobol_next(&path->random);
        path->origin = request->camera.origin;
        path->direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
    } else if (request->kind == TY_PATH_RAYS) {
        const double* ray = request->rays + 6 * item;
        const double length = sqrt(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5]);
        path->origin = ty_vec_make((float)ray[0], (float)ray[1], (float)ray[2]);
        path->direction = ty_vec_make((float)(ray[3] / length), (float)(ray[4] / length), (float)(ray[5] / length));
    } else {
        float point[3];
        int64_t rest = item;
        for (int a = 0; a < 3; ++a) {
            const int64_t index = rest % request->size[a];
            rest /= request->size[a];
            const float offset = request->cell[a] > 0 ? ty_sobol_next(&path->random) : 0.5f;
            point[a] = (float)(request->lower[a] + request->cell[a] * ((double)index + (double)offset));
        }
        ty_path_begin_fluence(path, ty_vec_make(point[0], point[1], point[2]));
    }
}

/* The number that an item's random numbers come from: a pixel's does not depend on the crop. */
static uint64_t random_item(const ty_path_request* request, int64_t item) {
    if (request->kind != TY_PATH_PIXELS) return (uint64_t)item;
    const int64_t x = request->crop[0] + item % request->crop[2], y = request->crop[1] + item / request->crop[2];
    return (uint64_t)(y * request->width + x);
}

/* What the path's first ray meets. The random numbers are others than the path's, whose light stays what it is. */
static void look(const ty_path* path, uint64_t number, uint32_t sample, ty_path_aov_sums* parts) {
    const ty_scene_view* scene = path->request->scene;
    ty_sampler random = ty_sampler_begin(path->request->sobol, ~path->request->seed, number, sample);
    ty_intersection end;
    const bool hits =
        scene->mesh != NULL && ty_accel_intersect(scene->mesh, path->origin, path->direction, TY_FLOAT_MAX, &end.hit);
    const float far = hits ? end.hit.distance : TY_FLOAT_MAX;
    float transmittance[3], scattered[3] = {1.0f, 1.0f, 1.0f}, glow[3] = {0.0f, 0.0f, 0.0f};
    ty_transmittance(scene->media, scene->medium_count, path->origin, path->direction, far, &random, transmittance);
    ty_spans spans;
    ty_collision collision;
    ty_spans_find(scene->media, scene->medium_count, path->origin, path->direction, far, &spans);
    const bool collides = spans.count > 0 && ty_delta_tracking(scene->media, &spans, path->origin, path->direction,
                                                               &random, scattered, glow, &collision);
    for (int c = 0; c < 3; ++c) {
        parts->transmittance[c] += (double)transmittance[c];
        if (collides) parts->albedo[c] += (double)scattered[c];
    }
    if (!hits) return;
    ty_surface_evaluate(&scene->surfaces[end.hit.surface], &end.hit, path->direction, &end.point);
    parts->normal[0] += (double)end.point.ns.x;
    parts->normal[1] += (double)end.point.ns.y;
    parts->normal[2] += (double)end.point.ns.z;
    parts->depth += (double)far;
    parts->hits += 1;
}

static void add_sample(const ty_path* path, ty_path_sums* sum, ty_path_aov_sums* parts) {
    for (int c = 0; c < 3; ++c) {
        double value = 0;
        for (int part = 0; part < TY_PATH_CLASS_COUNT; ++part) value += (double)path->radiance[part][c];
        sum->mean[c] += value;
        sum->square[c] += value * value;
        if (parts == NULL) continue;
        parts->uncollided[c] += (double)path->radiance[TY_PATH_UNCOLLIDED][c];
        parts->single[c] += (double)path->radiance[TY_PATH_SINGLE][c];
        parts->multiple[c] += (double)path->radiance[TY_PATH_MULTIPLE][c];
    }
}

TY_PATH_KERNEL(TY_JOIN(ty_path_kernel_, TY_ISA)) {
    const unsigned thread_state = ty_flush_denormals();
    uint64_t vertices = 0;
    for (int64_t item = begin; item < end; ++item) {
        const uint64_t number = random_item(request, item);
        ty_path_aov_sums* part = parts != NULL ? &parts[item - begin] : NULL;
        for (uint32_t i = first_sample; i < first_sample + count; ++i) {
            ty_path path;
            ty_path_begin(&path, request, number, i);
            start(&path, request, item);
            if (part != NULL && request->look != 0) look(&path, number, i, part);
            vertices += ty_path_follow(&path);
            add_sample(&path, &sums[item - begin], part);
        }
    }
    ty_restore_denormals(thread_state);
    return vertices;
}
