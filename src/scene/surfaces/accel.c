/* Acceleration structures by Embree: quads and boxes as one quad mesh, spheres as points with radii, triangle meshes
 * unchanged. */
#include "scene/surfaces/accel.h"

#include "base/context.h"
#include "scene/surfaces/accel_kept.h"
#include "scene/surfaces/traced_shapes.h"

#include <embree3/rtcore.h>
#include <stdatomic.h>
#include <stdio.h>

struct ty_accel {
    ty_context* context;
    RTCDevice device;
    RTCScene scene;
    size_t quad_count, sphere_count;
    ty_quad_face* quads;
    ty_sphere_face* spheres;
    const ty_surface* surfaces; /* of meshes: surface i is Embree geometry MESHES + i */
    int32_t first_mesh;         /* index of surfaces[0] in the scene view */
    _Atomic int64_t bytes;
    _Atomic bool failed; /* a call of Embree failed, in any thread */
    uint64_t version;
    ty_bvh_data* hierarchy;
};

/* Embree geometry IDs: all quads, all spheres, then one per mesh. */
enum { QUADS = 0, SPHERES = 1, MESHES = 2 };

static bool count_memory(void* user, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((ty_accel*)user)->bytes, bytes);
    return true;
}

static void note_error(void* user, enum RTCError code, const char* text) {
    (void)code;
    (void)text;
    atomic_store(&((ty_accel*)user)->failed, true);
}

static ty_result fail_with(ty_accel* mesh, const char* what, enum RTCError code) {
    if (code == RTC_ERROR_OUT_OF_MEMORY)
        return ty_fail(mesh->context, TY_ERROR_MEMORY, "ray tracing structures: not enough memory for %s", what);
    return ty_fail(mesh->context, TY_ERROR_INTERNAL, "ray tracing structures: %s failed (Embree error %d)", what,
                   (int)code);
}

/* Embree keeps an error for each thread. */
static ty_result fail(ty_accel* mesh, const char* what) {
    return fail_with(mesh, what, rtcGetDeviceError(mesh->device));
}

/* Quads of all quad and box shapes, four corners each, counter-clockwise seen from the front. */
static ty_result add_quads(ty_accel* mesh, const ty_shape_def* shapes, size_t count) {
    mesh->quad_count = ty_traced_quad_count(shapes, count);
    if (mesh->quad_count == 0) return TY_OK;
    mesh->quads = ty_alloc_array(mesh->context, mesh->quad_count, sizeof *mesh->quads, false);
    if (mesh->quads == NULL) return TY_ERROR_MEMORY;
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_QUAD);
    float* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                             4 * mesh->quad_count);
    unsigned* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                4 * sizeof(unsigned), mesh->quad_count);
    if (corners == NULL || indices == NULL) {
        rtcReleaseGeometry(geometry);
        return fail(mesh, "allocating quads");
    }
    for (unsigned i = 0; i < 4 * mesh->quad_count; ++i) indices[i] = i;
    ty_traced_quads(shapes, count, mesh->quads, corners);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(mesh->scene, geometry, QUADS);
    rtcReleaseGeometry(geometry);
    return TY_OK;
}

static ty_result add_spheres(ty_accel* mesh, const ty_shape_def* shapes, size_t count) {
    mesh->sphere_count = ty_traced_sphere_count(shapes, count);
    if (mesh->sphere_count == 0) return TY_OK;
    mesh->spheres = ty_alloc_array(mesh->context, mesh->sphere_count, sizeof *mesh->spheres, false);
    if (mesh->spheres == NULL) return TY_ERROR_MEMORY;
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    float* points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float),
                                            mesh->sphere_count);
    if (points == NULL) {
        rtcReleaseGeometry(geometry);
        return fail(mesh, "allocating spheres");
    }
    ty_traced_spheres(shapes, count, mesh->spheres, points);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(mesh->scene, geometry, SPHERES);
    rtcReleaseGeometry(geometry);
    return TY_OK;
}

/* Field offsets of N rays and hits in the structures that Embree passes to filters, in rows of N. */
enum { RAY_ORIGIN = 0, RAY_DIRECTION = 4, RAY_FAR = 8, RAY_ID = 10 };
enum { HIT_U = 3, HIT_V = 4, HIT_PRIMITIVE = 5, HIT_GEOMETRY = 6 };

static float row(const void* rows, unsigned field, unsigned count, unsigned i) {
    return ((const float*)rows)[field * count + i];
}

/* Embree filter: stochastic alpha test. */
static void filter_alpha(const struct RTCFilterFunctionNArguments* args) {
    const ty_surface* surface = args->geometryUserPtr;
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] == 0) continue;
        const unsigned triangle = ((const unsigned*)args->hit)[HIT_PRIMITIVE * args->N + i];
        float ray[6];
        for (unsigned a = 0; a < 3; ++a) {
            ray[a] = row(args->ray, RAY_ORIGIN + a, args->N, i);
            ray[3 + a] = row(args->ray, RAY_DIRECTION + a, args->N, i);
        }
        if (!ty_hit_is_present(surface, ray, triangle, row(args->hit, HIT_U, args->N, i),
                               row(args->hit, HIT_V, args->N, i)))
            args->valid[i] = 0;
    }
}

static ty_result add_triangles(ty_accel* mesh, const ty_triangle_mesh* triangles, unsigned id,
                               const ty_surface* surface) {
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, triangles->positions, 0,
                               3 * sizeof(float), triangles->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles->indices, 0,
                               3 * sizeof(uint32_t), triangles->triangle_count);
    if (surface->alpha_mode != TY_ALPHA_OPAQUE) {
        rtcSetGeometryUserData(geometry, (void*)surface); /* read only */
        rtcSetGeometryIntersectFilterFunction(geometry, filter_alpha);
        rtcSetGeometryOccludedFilterFunction(geometry, filter_alpha);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(mesh->scene, geometry, id);
    rtcReleaseGeometry(geometry);
    return rtcGetDeviceError(mesh->device) == RTC_ERROR_NONE ? TY_OK : fail(mesh, "taking triangles");
}

/* TBB sets up a device's arena in the first build. If memory runs out there, all other threads that came meanwhile wait
 * for ever: so one thread builds an empty scene first. */
static bool start_arena(RTCDevice device) {
    RTCScene empty = rtcNewScene(device);
    if (empty == NULL) return false;
    rtcJoinCommitScene(empty);
    rtcReleaseScene(empty);
    return rtcGetDeviceError(device) == RTC_ERROR_NONE;
}

static _Atomic uint64_t accels_made;

static ty_result begin_accel(ty_context* context, ty_accel** out) {
    ty_accel* mesh = ty_alloc_array(context, 1, sizeof *mesh, true);
    if (mesh == NULL) return TY_ERROR_MEMORY;
    mesh->context = context;
    mesh->version = 2 * atomic_fetch_add(&accels_made, 1) + 1; /* odd, as no address is */
    char config[64];
    /* All of TBB's slots are for threads of the context, which join the build, so that TBB starts none of its own: it
     * ends the process when the system has no thread to give. */
    const int threads = (int)ty_context_threads(context);
    snprintf(config, sizeof config, "threads=%d,user_threads=%d,start_threads=0,set_affinity=0", threads, threads);
    mesh->device = rtcNewDevice(config);
    if (mesh->device == NULL) {
        const ty_result result = fail(mesh, "starting Embree");
        ty_accel_destroy(mesh);
        return result;
    }
    rtcSetDeviceErrorFunction(mesh->device, note_error, mesh);
    if (!start_arena(mesh->device)) {
        const ty_result result = fail(mesh, "starting Embree");
        ty_accel_destroy(mesh);
        return result;
    }
    rtcSetDeviceMemoryMonitorFunction(mesh->device, count_memory, mesh);
    mesh->scene = rtcNewScene(mesh->device);
    /* Filters per query, for ty_accel_all_hits_packet. */
    rtcSetSceneFlags(mesh->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    *out = mesh;
    return TY_OK;
}

static void join_build(void* user, int64_t index, int32_t worker) {
    (void)index;
    (void)worker;
    ty_accel* mesh = user;
    if (!atomic_load(&mesh->failed)) rtcJoinCommitScene(mesh->scene);
}

/* If a thread failed, whether it built or only joined, this one builds what is not built. */
static ty_result build(ty_accel* mesh) {
    ty_parallel_for(mesh->context, ty_context_threads(mesh->context), join_build, mesh);
    if (!atomic_load(&mesh->failed)) return TY_OK;
    rtcGetDeviceError(mesh->device); /* forgets this thread's own */
    rtcJoinCommitScene(mesh->scene);
    const enum RTCError code = rtcGetDeviceError(mesh->device);
    return code == RTC_ERROR_NONE ? TY_OK : fail_with(mesh, "building", code);
}

/* Builds the scene, or destroys everything if adding geometry failed. */
static ty_result finish_accel(ty_accel* mesh, ty_result result, ty_accel** out) {
    if (result == TY_OK) result = build(mesh);
    if (result == TY_OK)
        *out = mesh;
    else
        ty_accel_destroy(mesh);
    return result;
}

ty_result ty_accel_create(ty_context* context, const ty_accel_input* input, ty_accel** out) {
    *out = NULL;
    if (input->shape_count + input->mesh_count == 0) return TY_OK;
    ty_accel* mesh = NULL;
    ty_result result = begin_accel(context, &mesh);
    if (result != TY_OK) return result;
    mesh->surfaces = input->surfaces + input->shape_count;
    mesh->first_mesh = (int32_t)input->shape_count;
    result = add_quads(mesh, input->shapes, input->shape_count);
    if (result == TY_OK) result = add_spheres(mesh, input->shapes, input->shape_count);
    for (size_t i = 0; i < input->mesh_count && result == TY_OK; ++i)
        result = add_triangles(mesh, input->meshes[i], MESHES + (unsigned)i, &mesh->surfaces[i]);
    return finish_accel(mesh, result, out);
}

void ty_accel_destroy(ty_accel* mesh) {
    if (mesh == NULL) return;
    ty_context* context = mesh->context;
    ty_bvh_destroy(mesh->hierarchy);
    if (mesh->scene != NULL) rtcReleaseScene(mesh->scene);
    if (mesh->device != NULL) rtcReleaseDevice(mesh->device);
    ty_free_array(context, mesh->quads, mesh->quad_count, sizeof *mesh->quads);
    ty_free_array(context, mesh->spheres, mesh->sphere_count, sizeof *mesh->spheres);
    ty_free_array(context, mesh, 1, sizeof *mesh);
}

uint64_t ty_accel_version(const ty_accel* mesh) {
    return mesh->version;
}

ty_bvh_data** ty_accel_hierarchy(ty_accel* mesh) {
    return &mesh->hierarchy;
}

size_t ty_accel_bytes(const ty_accel* mesh) {
    if (mesh == NULL) return 0;
    return sizeof *mesh + (size_t)atomic_load(&mesh->bytes) + mesh->quad_count * sizeof *mesh->quads +
           mesh->sphere_count * sizeof *mesh->spheres;
}

/* Fills a ty_hit from Embree's result; position is initially a point on the ray. */
static void fill_hit(const ty_accel* mesh, unsigned geometry, unsigned primitive, float b1, float b2, ty_hit* hit) {
    if (geometry >= MESHES)
        ty_hit_on_triangle(&mesh->surfaces[geometry - MESHES], mesh->first_mesh + (int32_t)(geometry - MESHES),
                           primitive, b1, b2, hit);
    else if (geometry == SPHERES)
        ty_hit_on_sphere(&mesh->spheres[primitive], hit);
    else
        ty_hit_on_quad(&mesh->quads[primitive], hit);
}

static struct RTCRay make_ray(ty_vec origin, ty_vec direction, float far) {
    return (struct RTCRay){.org_x = origin.x,
                           .org_y = origin.y,
                           .org_z = origin.z,
                           .dir_x = direction.x,
                           .dir_y = direction.y,
                           .dir_z = direction.z,
                           .tfar = far,
                           .mask = 0xffffffffu};
}

bool ty_accel_intersect(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit query = {
        .ray = make_ray(origin, direction, far),
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}},
    };
    rtcIntersect1(mesh->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit->distance = query.ray.tfar;
    hit->position = ty_mad(origin, direction, hit->distance);
    fill_hit(mesh, query.hit.geomID, query.hit.primID, query.hit.u, query.hit.v, hit);
    return true;
}

bool ty_accel_occluded(const ty_accel* mesh, ty_vec origin, ty_vec direction, float far) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = make_ray(origin, direction, far);
    rtcOccluded1(mesh->scene, &context, &ray);
    return ray.tfar < 0.0f;
}

/* ---- packets ---- */

static void set_packet_ray(struct RTCRay16* packet, int32_t i, const ty_ray* ray) {
    packet->org_x[i] = ray->origin[0];
    packet->org_y[i] = ray->origin[1];
    packet->org_z[i] = ray->origin[2];
    packet->dir_x[i] = ray->direction[0];
    packet->dir_y[i] = ray->direction[1];
    packet->dir_z[i] = ray->direction[2];
    packet->tnear[i] = 0.0f;
    packet->tfar[i] = ray->far;
    packet->time[i] = 0.0f;
    packet->mask[i] = 0xffffffffu;
    packet->id[i] = (unsigned)i;
    packet->flags[i] = 0;
}

/* Prefetches the indices of a triangle: the latency of many triangles is paid once. Other geometries are few. */
static void prefetch_triangle(const ty_accel* mesh, unsigned geometry, unsigned triangle) {
    if (geometry >= MESHES && geometry != RTC_INVALID_GEOMETRY_ID)
        __builtin_prefetch(mesh->surfaces[geometry - MESHES].indices + 3 * (size_t)triangle);
}

/* Prefetches the corners; after prefetch_triangle. */
static void prefetch_corners(const ty_accel* mesh, unsigned geometry, unsigned triangle) {
    if (geometry < MESHES || geometry == RTC_INVALID_GEOMETRY_ID) return;
    const ty_surface* surface = &mesh->surfaces[geometry - MESHES];
    const uint32_t* corners = surface->indices + 3 * (size_t)triangle;
    for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(surface->positions + 3 * (size_t)corners[corner]);
}

/* Closest hits; geometry RTC_INVALID_GEOMETRY_ID: miss. */
static void intersect_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, struct RTCRayHit16* packet) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    _Alignas(64) int32_t valid[TY_PACKET];
    for (int32_t i = 0; i < TY_PACKET; ++i) {
        valid[i] = i < count ? -1 : 0;
        packet->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        packet->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        if (i < count) set_packet_ray(&packet->ray, i, &rays[i]);
    }
    rtcIntersect16(valid, mesh->scene, &context, packet);
}

void ty_accel_intersect_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_hit* hits) {
    struct RTCRayHit16 packet;
    intersect_packet(mesh, rays, count, &packet);
    for (int32_t i = 0; i < count; ++i) prefetch_triangle(mesh, packet.hit.geomID[i], packet.hit.primID[i]);
    for (int32_t i = 0; i < count; ++i) prefetch_corners(mesh, packet.hit.geomID[i], packet.hit.primID[i]);
    for (int32_t i = 0; i < count; ++i) {
        if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
            hits[i] = (ty_hit){.distance = packet.ray.tfar[i], .surface = -1};
            continue;
        }
        hits[i].distance = packet.ray.tfar[i];
        hits[i].position = ty_mad(ty_vec_load(rays[i].origin), ty_vec_load(rays[i].direction), hits[i].distance);
        fill_hit(mesh, packet.hit.geomID[i], packet.hit.primID[i], packet.hit.u[i], packet.hit.v[i], &hits[i]);
    }
}

void ty_accel_distance_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, float* distances) {
    struct RTCRayHit16 packet;
    intersect_packet(mesh, rays, count, &packet);
    for (int32_t i = 0; i < count; ++i)
        distances[i] = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? packet.ray.tfar[i] : INFINITY;
}

void ty_accel_occluded_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, bool* occluded) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    struct RTCRay16 packet;
    _Alignas(64) int32_t valid[TY_PACKET];
    for (int32_t i = 0; i < TY_PACKET; ++i) {
        valid[i] = i < count ? -1 : 0;
        if (i < count) set_packet_ray(&packet, i, &rays[i]);
    }
    rtcOccluded16(valid, mesh->scene, &context, &packet);
    for (int32_t i = 0; i < count; ++i) occluded[i] = packet.tfar[i] < 0.0f;
}

/* ---- all hits ---- */

/* Query of ty_accel_all_hits_packet, with the output. */
typedef struct all_hits_query {
    struct RTCIntersectContext context; /* first, so that Embree's context pointer points to this struct */
    ty_all_hits* hits;
} all_hits_query;

/* Inserts a hit in order of distance, then of geometry and primitive ID, independently of Embree's traversal order. */
static void insert_hit(ty_all_hits* hits, uint32_t ray, ty_hit_record layer) {
    ty_hit_record* row = hits->layer[ray];
    int32_t at = hits->count[ray];
    while (at > 0 && (row[at - 1].distance > layer.distance ||
                      (row[at - 1].distance == layer.distance &&
                       (row[at - 1].geometry > layer.geometry ||
                        (row[at - 1].geometry == layer.geometry && row[at - 1].primitive > layer.primitive)))))
        --at;
    if (at == TY_ALL_HITS_MAX) return;
    if (hits->count[ray] < TY_ALL_HITS_MAX) ++hits->count[ray];
    for (int32_t i = hits->count[ray] - 1; i > at; --i) row[i] = row[i - 1];
    row[at] = layer;
}

/* Embree filter: records the hit and rejects it, so that traversal continues. */
static void collect_hits(const struct RTCFilterFunctionNArguments* args) {
    ty_all_hits* hits = ((all_hits_query*)args->context)->hits;
    const unsigned *ids = (const unsigned*)args->ray + RAY_ID * args->N, *hit = (const unsigned*)args->hit;
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] == 0) continue;
        insert_hit(hits, ids[i],
                   (ty_hit_record){.distance = row(args->ray, RAY_FAR, args->N, i),
                                   .b1 = row(args->hit, HIT_U, args->N, i),
                                   .b2 = row(args->hit, HIT_V, args->N, i),
                                   .geometry = hit[HIT_GEOMETRY * args->N + i],
                                   .primitive = hit[HIT_PRIMITIVE * args->N + i]});
        args->valid[i] = 0;
    }
}

void ty_accel_all_hits_packet(const ty_accel* mesh, const ty_ray* rays, int32_t count, ty_all_hits* out) {
    all_hits_query query = {.hits = out};
    rtcInitIntersectContext(&query.context);
    query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    query.context.filter = collect_hits;
    struct RTCRay16 packet;
    _Alignas(64) int32_t valid[TY_PACKET];
    for (int32_t i = 0; i < TY_PACKET; ++i) {
        valid[i] = i < count ? -1 : 0;
        out->count[i] = 0;
        if (i < count) set_packet_ray(&packet, i, &rays[i]);
    }
    rtcOccluded16(valid, mesh->scene, &query.context, &packet);
    for (int32_t i = 0; i < count; ++i)
        for (int32_t k = 0; k < out->count[i]; ++k)
            prefetch_triangle(mesh, out->layer[i][k].geometry, out->layer[i][k].primitive);
    for (int32_t i = 0; i < count; ++i)
        for (int32_t k = 0; k < out->count[i]; ++k)
            prefetch_corners(mesh, out->layer[i][k].geometry, out->layer[i][k].primitive);
}

void ty_accel_complete_hit(const ty_accel* mesh, const ty_ray* ray, const ty_hit_record* layer, ty_hit* hit) {
    hit->distance = layer->distance;
    hit->position = ty_mad(ty_vec_load(ray->origin), ty_vec_load(ray->direction), layer->distance);
    fill_hit(mesh, layer->geometry, layer->primitive, layer->b1, layer->b2, hit);
}

/* ---- closed surfaces ---- */

/* Query of ty_accel_crossings, with the output. */
typedef struct crossing_query {
    struct RTCIntersectContext context; /* first, so that Embree's context pointer points to this struct */
    ty_crossing_ray ray;
    ty_crossing_list list;
} crossing_query;

/* Embree intersection function: records a crossing and reports no hit, so that traversal continues. */
static void cross_closed_triangle(const struct RTCIntersectFunctionNArguments* args) {
    const ty_triangle_mesh* triangles = args->geometryUserPtr;
    const uint32_t* corners = triangles->indices + 3 * (size_t)args->primID;
    crossing_query* query = (crossing_query*)args->context;
    ty_crossing crossing;
    if (ty_crossing_find(&query->ray, triangles->positions + 3 * (size_t)corners[0],
                         triangles->positions + 3 * (size_t)corners[1], triangles->positions + 3 * (size_t)corners[2],
                         &crossing))
        ty_crossing_insert(&query->list, crossing);
}

static void bound_closed_triangle(const struct RTCBoundsFunctionArguments* args) {
    float low[3], high[3];
    ty_closed_triangle_bounds(args->geometryUserPtr, args->primID, low, high);
    *args->bounds_o = (struct RTCBounds){.lower_x = low[0],
                                         .lower_y = low[1],
                                         .lower_z = low[2],
                                         .upper_x = high[0],
                                         .upper_y = high[1],
                                         .upper_z = high[2]};
}

static ty_result add_closed_mesh(ty_accel* mesh, const ty_triangle_mesh* triangles) {
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)triangles->triangle_count);
    rtcSetGeometryUserData(geometry, (void*)triangles); /* read only */
    rtcSetGeometryBoundsFunction(geometry, bound_closed_triangle, NULL);
    rtcSetGeometryIntersectFunction(geometry, cross_closed_triangle);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(mesh->scene, geometry, MESHES);
    rtcReleaseGeometry(geometry);
    return rtcGetDeviceError(mesh->device) == RTC_ERROR_NONE ? TY_OK : fail(mesh, "taking a shell");
}

ty_result ty_accel_create_closed(ty_context* context, const ty_triangle_mesh* triangles, ty_accel** out) {
    ty_accel* mesh = NULL;
    const ty_result result = begin_accel(context, &mesh);
    return result == TY_OK ? finish_accel(mesh, add_closed_mesh(mesh, triangles), out) : result;
}

int32_t ty_accel_crossings(const ty_accel* closed, ty_vec origin, ty_vec direction,
                           ty_crossing crossings[TY_CROSSINGS_MAX], int32_t* beyond) {
    crossing_query query = {.ray = ty_crossing_ray_begin(origin, direction), .list = {.crossings = crossings}};
    rtcInitIntersectContext(&query.context);
    struct RTCRayHit ray = {
        .ray = make_ray(origin, direction, TY_FLOAT_MAX),
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}},
    };
    rtcIntersect1(closed->scene, &query.context, &ray);
    *beyond = query.list.beyond;
    return query.list.count;
}
