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

typedef struct mesh_quad {
    int32_t shape, part; /* as in ty_hit */
    ty_vec corner, normal;
    float margin;
} mesh_quad;

typedef struct mesh_sphere {
    int32_t shape;
    ty_vec center;
    float radius, margin;
} mesh_sphere;

struct ty_mesh {
    ty_context* context;
    RTCDevice device;
    RTCScene scene;
    unsigned quad_geometry, sphere_geometry; /* ids; RTC_INVALID_GEOMETRY_ID if there are none */
    size_t quad_count, sphere_count;
    mesh_quad* quads;
    mesh_sphere* spheres;
    _Atomic int64_t bytes;
};

/* How far off a surface to stand, in units of the coordinates whose rounding blurs it: 70 roundings. */
static const float margin_share = 4e-6f;
static const float margin_min = 4e-9f;

static bool count_memory(void* user, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((ty_mesh*)user)->bytes, bytes);
    return true;
}

static ty_result fail(ty_mesh* mesh, const char* what) {
    return ty_fail(mesh->context, TY_ERROR_INTERNAL, "ray tracing structures: %s failed (Embree error %d)", what,
                   mesh->device == NULL ? 0 : (int)rtcGetDeviceError(mesh->device));
}

/* Rounding moves a point off a quad by what it changes of the coordinates that the normal sees: none, if level. */
static float quad_margin(ty_vec normal, const float* corners) {
    ty_vec largest = ty_vec_make(0, 0, 0);
    for (int corner = 0; corner < 4; ++corner)
        largest = ty_vec_make(ty_maxf(largest.x, fabsf(corners[3 * corner])),
                              ty_maxf(largest.y, fabsf(corners[3 * corner + 1])),
                              ty_maxf(largest.z, fabsf(corners[3 * corner + 2])));
    const ty_vec seen = ty_vec_make(fabsf(normal.x), fabsf(normal.y), fabsf(normal.z));
    return ty_maxf(margin_share * ty_dot(seen, largest), margin_min);
}

static float sphere_margin(ty_vec center, float radius) {
    const float largest = ty_maxf(fabsf(center.x), ty_maxf(fabsf(center.y), fabsf(center.z)));
    return ty_maxf(margin_share * (largest + radius), margin_min);
}

/* The quads of all quad and box shapes, four corners each, counter-clockwise seen from the front. */
static ty_result add_quads(ty_mesh* mesh, const ty_shape_def* shapes, size_t count) {
    for (size_t i = 0; i < count; ++i) mesh->quad_count += (size_t)ty_shape_quad_count(&shapes[i]);
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
            mesh->quads[quad] = (mesh_quad){.shape = (int32_t)i,
                                            .part = q,
                                            .corner = ty_vec_load(corners + 12 * quad),
                                            .normal = ty_shape_normal(u, v)};
            mesh->quads[quad].margin = quad_margin(mesh->quads[quad].normal, corners + 12 * quad);
        }
    rtcCommitGeometry(geometry);
    mesh->quad_geometry = rtcAttachGeometry(mesh->scene, geometry);
    rtcReleaseGeometry(geometry);
    return TY_OK;
}

static ty_result add_spheres(ty_mesh* mesh, const ty_shape_def* shapes, size_t count) {
    for (size_t i = 0; i < count; ++i) mesh->sphere_count += shapes[i].kind == TY_SHAPE_SPHERE;
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
    size_t sphere = 0;
    for (size_t i = 0; i < count; ++i) {
        if (shapes[i].kind != TY_SHAPE_SPHERE) continue;
        double center[3];
        float* point = points + 4 * sphere;
        point[3] = (float)ty_shape_sphere(&shapes[i], center);
        for (int a = 0; a < 3; ++a) point[a] = (float)center[a];
        mesh->spheres[sphere++] = (mesh_sphere){.shape = (int32_t)i,
                                                .center = ty_vec_load(point),
                                                .radius = point[3],
                                                .margin = sphere_margin(ty_vec_load(point), point[3])};
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
    ty_free_array(context, mesh->quads, mesh->quad_count, sizeof *mesh->quads);
    ty_free_array(context, mesh->spheres, mesh->sphere_count, sizeof *mesh->spheres);
    ty_free_array(context, mesh, 1, sizeof *mesh);
}

size_t ty_mesh_bytes(const ty_mesh* mesh) {
    if (mesh == NULL) return 0;
    return sizeof *mesh + (size_t)atomic_load(&mesh->bytes) + mesh->quad_count * sizeof *mesh->quads +
           mesh->sphere_count * sizeof *mesh->spheres;
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
        const mesh_sphere* sphere = &mesh->spheres[query.hit.primID];
        hit->normal = ty_normalize(ty_sub(hit->position, sphere->center));
        hit->position = ty_mad(sphere->center, hit->normal, sphere->radius);
        hit->margin = sphere->margin;
        hit->shape = sphere->shape;
        hit->part = 0;
    } else {
        const mesh_quad* quad = &mesh->quads[query.hit.primID];
        hit->normal = quad->normal;
        hit->position = ty_mad(hit->position, hit->normal, ty_dot(hit->normal, ty_sub(quad->corner, hit->position)));
        hit->margin = quad->margin;
        hit->shape = quad->shape;
        hit->part = quad->part;
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
