/* Batches of rays through a scene, for callers outside the kernels. */
#include "base/float_mode.h"
#include "base/context.h"
#include "scene/scene.h"

enum { BLOCK_RAYS = 256 * TY_PACKET };

typedef struct trace_job {
    const ty_accel* mesh;
    const ty_ray* rays;
    int64_t count;
    bool coherent;
    ty_ray_hit* hits; /* or NULL, if only */
    bool* shadowed;   /* is requested */
} trace_job;

_Static_assert(sizeof(ty_hit) == sizeof(ty_ray_hit) && offsetof(ty_hit, surface) == offsetof(ty_ray_hit, surface) &&
                   offsetof(ty_hit, position) == offsetof(ty_ray_hit, position) &&
                   offsetof(ty_hit, margin) == offsetof(ty_ray_hit, margin),
               "kernels and callers see hits alike");

/* Traces at most one packet of rays. */
static void trace_packet(const trace_job* job, int64_t begin, int32_t count) {
    if (job->hits == NULL) {
        ty_accel_occluded_packet(job->mesh, job->rays + begin, count, job->shadowed + begin);
        return;
    }
    ty_hit hits[TY_PACKET];
    ty_accel_intersect_packet(job->mesh, job->rays + begin, count, hits);
    memcpy(&job->hits[begin], hits, (size_t)count * sizeof *hits);
}

static void trace_one(const trace_job* job, int64_t at) {
    const ty_ray* ray = &job->rays[at];
    const ty_vec origin = ty_vec_load(ray->origin), direction = ty_vec_load(ray->direction);
    if (job->hits == NULL) {
        job->shadowed[at] = ty_accel_occluded(job->mesh, origin, direction, ray->far);
        return;
    }
    ty_hit hit = {.distance = ray->far, .surface = -1};
    ty_accel_intersect(job->mesh, origin, direction, ray->far, &hit);
    memcpy(&job->hits[at], &hit, sizeof hit);
}

static void trace_block(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const trace_job* job = user;
    const int64_t begin = index * BLOCK_RAYS;
    const int64_t end = job->count - begin < BLOCK_RAYS ? job->count : begin + BLOCK_RAYS;
    const unsigned state = ty_flush_denormals();
    if (job->coherent)
        for (int64_t at = begin; at < end; at += TY_PACKET)
            trace_packet(job, at, end - at < TY_PACKET ? (int32_t)(end - at) : TY_PACKET);
    else
        for (int64_t at = begin; at < end; ++at) trace_one(job, at);
    ty_restore_denormals(state);
}

static void miss_all(const trace_job* job) {
    for (int64_t i = 0; i < job->count; ++i)
        if (job->hits == NULL)
            job->shadowed[i] = false;
        else
            job->hits[i] = (ty_ray_hit){.distance = job->rays[i].far, .surface = -1};
}

static ty_result trace(const ty_scene* scene, trace_job job) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (job.count < 0)
        return ty_fail(scene->context, TY_ERROR_ARGUMENT, "rays: their count is %lld", (long long)job.count);
    job.mesh = view->mesh;
    if (job.mesh == NULL)
        miss_all(&job);
    else
        ty_parallel_for(scene->context, (job.count + BLOCK_RAYS - 1) / BLOCK_RAYS, trace_block, &job);
    return TY_OK;
}

ty_result ty_scene_trace(const ty_scene* scene, const ty_ray* rays, int64_t count, ty_ray_order order,
                         ty_ray_hit* hits) {
    return trace(scene, (trace_job){.rays = rays, .count = count, .coherent = order == TY_RAYS_COHERENT, .hits = hits});
}

ty_result ty_scene_trace_shadows(const ty_scene* scene, const ty_ray* rays, int64_t count, ty_ray_order order,
                                 bool* shadowed) {
    return trace(
        scene, (trace_job){.rays = rays, .count = count, .coherent = order == TY_RAYS_COHERENT, .shadowed = shadowed});
}
