#include "bench/embree.h"

#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

enum { PACKET = 16, BLOCK_RAYS = 4096 };

struct bench_embree {
    RTCDevice device;
    RTCScene scene;
};

bench_embree* bench_embree_create(const ty_mesh_def* meshes, int32_t count, bool robust, int32_t threads) {
    bench_embree* embree = calloc(1, sizeof *embree);
    if (embree == NULL) return NULL;
    char config[64];
    snprintf(config, sizeof config, "threads=%d,start_threads=0,set_affinity=0", (int)threads);
    embree->device = rtcNewDevice(config);
    if (embree->device == NULL) {
        free(embree);
        return NULL;
    }
    embree->scene = rtcNewScene(embree->device);
    if (robust) rtcSetSceneFlags(embree->scene, RTC_SCENE_FLAG_ROBUST);
    for (int32_t i = 0; i < count; ++i) {
        RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, meshes[i].positions, 0,
                                   3 * sizeof(float), (size_t)meshes[i].vertex_count);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, meshes[i].indices, 0,
                                   3 * sizeof(uint32_t), (size_t)meshes[i].triangle_count);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(embree->scene, geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(embree->scene);
    if (rtcGetDeviceError(embree->device) == RTC_ERROR_NONE) return embree;
    bench_embree_destroy(embree);
    return NULL;
}

void bench_embree_destroy(bench_embree* embree) {
    if (embree == NULL) return;
    rtcReleaseScene(embree->scene);
    rtcReleaseDevice(embree->device);
    free(embree);
}

/* Flush denormals to zero, as Embree recommends. */
static unsigned enter_thread(void) {
#if defined(__SSE2__)
    const unsigned state = _mm_getcsr();
    _mm_setcsr(state | 0x8040u);
    return state;
#else
    return 0;
#endif
}

static void leave_thread(unsigned state) {
#if defined(__SSE2__)
    _mm_setcsr(state);
#else
    (void)state;
#endif
}

static struct RTCIntersectContext make_context(bool coherent) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

static struct RTCRay make_ray(const ty_ray* ray) {
    return (struct RTCRay){.org_x = ray->origin[0],
                           .org_y = ray->origin[1],
                           .org_z = ray->origin[2],
                           .dir_x = ray->direction[0],
                           .dir_y = ray->direction[1],
                           .dir_z = ray->direction[2],
                           .tfar = ray->far,
                           .mask = 0xffffffffu};
}

static void fill_packet(const ty_ray* rays, int32_t count, int32_t valid[PACKET], struct RTCRay16* packet) {
    for (int32_t i = 0; i < PACKET; ++i) {
        valid[i] = i < count ? -1 : 0;
        if (i >= count) continue;
        packet->org_x[i] = rays[i].origin[0];
        packet->org_y[i] = rays[i].origin[1];
        packet->org_z[i] = rays[i].origin[2];
        packet->dir_x[i] = rays[i].direction[0];
        packet->dir_y[i] = rays[i].direction[1];
        packet->dir_z[i] = rays[i].direction[2];
        packet->tnear[i] = 0.0f;
        packet->tfar[i] = rays[i].far;
        packet->mask[i] = 0xffffffffu;
        packet->flags[i] = 0;
    }
}

static void trace_packet(const bench_embree* embree, const ty_ray* rays, int32_t count, bench_embree_hit* hits) {
    struct RTCIntersectContext context = make_context(true);
    struct RTCRayHit16 packet;
    _Alignas(64) int32_t valid[PACKET];
    fill_packet(rays, count, valid, &packet.ray);
    for (int32_t i = 0; i < PACKET; ++i) packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect16(valid, embree->scene, &context, &packet);
    for (int32_t i = 0; i < count; ++i) {
        hits[i].distance = packet.ray.tfar[i];
        hits[i].geometry = packet.hit.geomID[i];
        if (hits[i].geometry == RTC_INVALID_GEOMETRY_ID) continue;
        hits[i].primitive = packet.hit.primID[i];
        hits[i].u = packet.hit.u[i];
        hits[i].v = packet.hit.v[i];
        hits[i].normal[0] = packet.hit.Ng_x[i];
        hits[i].normal[1] = packet.hit.Ng_y[i];
        hits[i].normal[2] = packet.hit.Ng_z[i];
    }
}

static void shadow_packet(const bench_embree* embree, const ty_ray* rays, int32_t count, bool* shadowed) {
    struct RTCIntersectContext context = make_context(true);
    struct RTCRay16 packet;
    _Alignas(64) int32_t valid[PACKET];
    fill_packet(rays, count, valid, &packet);
    rtcOccluded16(valid, embree->scene, &context, &packet);
    for (int32_t i = 0; i < count; ++i) shadowed[i] = packet.tfar[i] < 0.0f;
}

static void trace_one(const bench_embree* embree, const ty_ray* ray, bench_embree_hit* hit) {
    struct RTCIntersectContext context = make_context(false);
    struct RTCRayHit query = {.ray = make_ray(ray), .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(embree->scene, &context, &query);
    *hit = (bench_embree_hit){.distance = query.ray.tfar,
                              .geometry = query.hit.geomID,
                              .primitive = query.hit.primID,
                              .u = query.hit.u,
                              .v = query.hit.v,
                              .normal = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}};
}

static bool shadow_one(const bench_embree* embree, const ty_ray* ray) {
    struct RTCIntersectContext context = make_context(false);
    struct RTCRay query = make_ray(ray);
    rtcOccluded1(embree->scene, &context, &query);
    return query.tfar < 0.0f;
}

typedef struct job {
    const bench_embree* embree;
    const ray_set* set;
    bench_embree_hit* hits;
    bool* shadowed;
} job;

static void trace_block(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const job* j = user;
    const int64_t begin = index * BLOCK_RAYS,
                  end = begin + BLOCK_RAYS < j->set->count ? begin + BLOCK_RAYS : j->set->count;
    const int64_t step = j->set->coherent ? PACKET : 1;
    const unsigned state = enter_thread();
    for (int64_t at = begin; at < end; at += step) {
        const ty_ray* rays = j->set->rays + at;
        const int32_t count = end - at < step ? (int32_t)(end - at) : (int32_t)step;
        if (j->set->coherent && j->set->shadow)
            shadow_packet(j->embree, rays, count, j->shadowed + at);
        else if (j->set->coherent)
            trace_packet(j->embree, rays, count, j->hits + at);
        else if (j->set->shadow)
            j->shadowed[at] = shadow_one(j->embree, rays);
        else
            trace_one(j->embree, rays, &j->hits[at]);
    }
    leave_thread(state);
}

void bench_embree_trace(ty_context* context, const bench_embree* embree, const ray_set* set, bench_embree_hit* hits,
                        bool* shadowed) {
    job j = {embree, set, hits, shadowed};
    ty_parallel_for(context, (set->count + BLOCK_RAYS - 1) / BLOCK_RAYS, trace_block, &j);
}
