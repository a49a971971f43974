/* Surfaces through Embree: quads and boxes as one quad mesh, spheres as points with radii. */
#include "scene/mesh.h"

#include "base/context.h"
#include "scene/shape.h"

#include <embree3/rtcore.h>
#include <stdatomic.h>
#include <stdio.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

struct ty_mesh {
    ty_context* context;
    RTCDevice device;
    RTCScene scene;
    unsigned quad_geometry, sphere_geometry; /* ids; RTC_INVALID_GEOMETRY_ID if there are none */
    size_t quad_count, sphere_count;
    int32_t* quad_shape; /* shape of each quad */
    int32_t* quad_part;  /* which quad of its shape it is */
    ty_vec* quad_normal;
    int32_t* sphere_shape;
    ty_vec* centers;
    float* radii;
    _Atomic int64_t bytes;
};

static bool count_memory(void* user, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((ty_mesh*)user)->bytes, bytes);
    return true;
}

static ty_result fail(ty_mesh* mesh, const char* what) {
    return ty_fail(mesh->context, TY_ERROR_INTERNAL, "ray tracing structures: %s failed (Embree error %d)", what,
                   mesh->device == NULL ? 0 : (int)rtcGetDeviceError(mesh->device));
}

/* The quads of all quad and box shapes, four corners each, counter-clockwise seen from the front. */
static ty_result add_quads(ty_mesh* mesh, const ty_shape_def* shapes, size_t count) {
    for (size_t i = 0; i < count; ++i) mesh->quad_count += (size_t)ty_shape_quad_count(&shapes[i]);
    if (mesh->quad_count == 0) return TY_OK;
    mesh->quad_shape = ty_alloc_array(mesh->context, mesh->quad_count, sizeof(int32_t), false);
    mesh->quad_part = ty_alloc_array(mesh->context, mesh->quad_count, sizeof(int32_t), false);
    mesh->quad_normal = ty_alloc_array(mesh->context, mesh->quad_count, sizeof(ty_vec), false);
    if (mesh->quad_shape == NULL || mesh->quad_part == NULL || mesh->quad_normal == NULL) return TY_ERROR_MEMORY;
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_QUAD);
    float* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             3 * sizeof(float), 4 * mesh->quad_count);
    unsigned* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                                4 * sizeof(unsigned), mesh->quad_count);
    if (corners == NULL || indices == NULL) {
        rtcReleaseGeometry(geometry);
        return fail(mesh, "allocating quads");
    }
    size_t quad = 0;
    for (size_t i = 0; i < count; ++i)
        for (int32_t q = 0; q < ty_shape_quad_count(&shapes[i]); ++q, ++quad) {
            double origin[3], u[3], v[3];
            ty_shape_quad(&shapes[i], q, origin, u, v);
            for (int corner = 0; corner < 4; ++corner)
                for (int a = 0; a < 3; ++a)
                    corners[12 * quad + 3 * (size_t)corner + (size_t)a] =
                        (float)(origin[a] + (corner == 1 || corner == 2 ? u[a] : 0) + (corner >= 2 ? v[a] : 0));
            for (unsigned corner = 0; corner < 4; ++corner) indices[4 * quad + corner] = (unsigned)(4 * quad) + corner;
            mesh->quad_shape[quad] = (int32_t)i;
            mesh->quad_part[quad] = q;
            mesh->quad_normal[quad] = ty_shape_normal(u, v);
        }
    rtcCommitGeometry(geometry);
    mesh->quad_geometry = rtcAttachGeometry(mesh->scene, geometry);
    rtcReleaseGeometry(geometry);
    return TY_OK;
}

static ty_result add_spheres(ty_mesh* mesh, const ty_shape_def* shapes, size_t count) {
    for (size_t i = 0; i < count; ++i) mesh->sphere_count += shapes[i].kind == TY_SHAPE_SPHERE;
    if (mesh->sphere_count == 0) return TY_OK;
    mesh->sphere_shape = ty_alloc_array(mesh->context, mesh->sphere_count, sizeof(int32_t), false);
    mesh->centers = ty_alloc_array(mesh->context, mesh->sphere_count, sizeof(ty_vec), false);
    mesh->radii = ty_alloc_array(mesh->context, mesh->sphere_count, sizeof(float), false);
    if (mesh->sphere_shape == NULL || mesh->centers == NULL || mesh->radii == NULL) return TY_ERROR_MEMORY;
    RTCGeometry geometry = rtcNewGeometry(mesh->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    float* points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                                            4 * sizeof(float), mesh->sphere_count);
    if (points == NULL) {
        rtcReleaseGeometry(geometry);
        return fail(mesh, "allocating spheres");
    }
    size_t sphere = 0;
    for (size_t i = 0; i < count; ++i) {
        if (shapes[i].kind != TY_SHAPE_SPHERE) continue;
        double center[3];
        const double radius = ty_shape_sphere(&shapes[i], center);
        for (int a = 0; a < 3; ++a) points[4 * sphere + (size_t)a] = (float)center[a];
        points[4 * sphere + 3] = (float)radius;
        mesh->centers[sphere] = ty_vec_make((float)center[0], (float)center[1], (float)center[2]);
        mesh->radii[sphere] = (float)radius;
        mesh->sphere_shape[sphere++] = (int32_t)i;
    }
    rtcCommitGeometry(geometry);
    mesh->sphere_geometry = rtcAttachGeometry(mesh->scene, geometry);
    rtcReleaseGeometry(geometry);
    return TY_OK;
}

ty_result ty_mesh_create(ty_context* context, const ty_shape_def* shapes, size_t count, ty_mesh** out) {
    *out = NULL;
    if (count == 0) return TY_OK;
    ty_mesh* mesh = ty_alloc_array(context, 1, sizeof *mesh, true);
    if (mesh == NULL) return TY_ERROR_MEMORY;
    mesh->context = context;
    mesh->quad_geometry = mesh->sphere_geometry = RTC_INVALID_GEOMETRY_ID;
    char config[64];
    snprintf(config, sizeof config, "threads=%d,start_threads=0,set_affinity=0", (int)ty_context_threads(context));
    mesh->device = rtcNewDevice(config);
    ty_result result = mesh->device != NULL ? TY_OK : fail(mesh, "starting Embree");
    if (result == TY_OK) {
        rtcSetDeviceMemoryMonitorFunction(mesh->device, count_memory, mesh);
        mesh->scene = rtcNewScene(mesh->device);
        rtcSetSceneFlags(mesh->scene, RTC_SCENE_FLAG_ROBUST);
        result = add_quads(mesh, shapes, count);
    }
    if (result == TY_OK) result = add_spheres(mesh, shapes, count);
    if (result == TY_OK) {
        rtcCommitScene(mesh->scene);
        if (rtcGetDeviceError(mesh->device) != RTC_ERROR_NONE) result = fail(mesh, "building");
    }
    if (result != TY_OK) {
        ty_mesh_destroy(mesh);
        return result;
    }
    *out = mesh;
    return TY_OK;
}

void ty_mesh_destroy(ty_mesh* mesh) {
    if (mesh == NULL) return;
    ty_context* context = mesh->context;
    if (mesh->scene != NULL) rtcReleaseScene(mesh->scene);
    if (mesh->device != NULL) rtcReleaseDevice(mesh->device);
    ty_free_array(context, mesh->quad_shape, mesh->quad_count, sizeof(int32_t));
    ty_free_array(context, mesh->quad_part, mesh->quad_count, sizeof(int32_t));
    ty_free_array(context, mesh->quad_normal, mesh->quad_count, sizeof(ty_vec));
    ty_free_array(context, mesh->sphere_shape, mesh->sphere_count, sizeof(int32_t));
    ty_free_array(context, mesh->centers, mesh->sphere_count, sizeof(ty_vec));
    ty_free_array(context, mesh->radii, mesh->sphere_count, sizeof(float));
    ty_free_array(context, mesh, 1, sizeof *mesh);
}

size_t ty_mesh_bytes(const ty_mesh* mesh) {
    if (mesh == NULL) return 0;
    return sizeof *mesh + (size_t)atomic_load(&mesh->bytes) + mesh->quad_count * (2 * sizeof(int32_t) + sizeof(ty_vec)) +
           mesh->sphere_count * (sizeof(int32_t) + sizeof(ty_vec) + sizeof(float));
}

unsigned ty_mesh_enter_thread(void) {
#if defined(__SSE2__)
    const unsigned state = _mm_getcsr();
    _mm_setcsr(state | 0x8040u); /* flush to zero, denormals are zero */
    return state;
#else
    return 0;
#endif
}

void ty_mesh_leave_thread(unsigned state) {
#if defined(__SSE2__)
    _mm_setcsr(state);
#else
    (void)state;
#endif
}

bool ty_mesh_intersect(const ty_mesh* mesh, ty_vec origin, ty_vec direction, float far, ty_hit* hit) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit query = {
        .ray = {.org_x = origin.x,
                .org_y = origin.y,
                .org_z = origin.z,
                .dir_x = direction.x,
                .dir_y = direction.y,
                .dir_z = direction.z,
                .tfar = far,
                .mask = 0xffffffffu},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}},
    };
    rtcIntersect1(mesh->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit->distance = query.ray.tfar;
    hit->position = ty_mad(origin, direction, hit->distance);
    if (query.hit.geomID == mesh->sphere_geometry) {
        const uint32_t sphere = query.hit.primID;
        hit->normal = ty_normalize(ty_sub(hit->position, mesh->centers[sphere]));
        hit->position = ty_mad(mesh->centers[sphere], hit->normal, mesh->radii[sphere]);
        hit->shape = mesh->sphere_shape[sphere];
        hit->part = 0;
    } else {
        hit->normal = mesh->quad_normal[query.hit.primID];
        hit->shape = mesh->quad_shape[query.hit.primID];
        hit->part = mesh->quad_part[query.hit.primID];
    }
    return true;
}

bool ty_mesh_occluded(const ty_mesh* mesh, ty_vec origin, ty_vec direction, float far) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRay ray = {.org_x = origin.x,
                         .org_y = origin.y,
                         .org_z = origin.z,
                         .dir_x = direction.x,
                         .dir_y = direction.y,
                         .dir_z = direction.z,
                         .tfar = far,
                         .mask = 0xffffffffu};
    rtcOccluded1(mesh->scene, &context, &ray);
    return ray.tfar < 0.0f;
}
