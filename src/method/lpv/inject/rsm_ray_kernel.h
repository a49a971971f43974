/* Rays from lights through texels, many at once; built once per instruction set. */
#ifndef TY_METHOD_LPV_INJECT_RSM_RAY_KERNEL_H
#define TY_METHOD_LPV_INJECT_RSM_RAY_KERNEL_H

#include "base/dispatch.h"
#include "base/vector.k.h"
#include "direct/media/attenuation.k.h"

/* Neighbouring texels of a row that form a packet. */
enum { TY_RSM_RAYS = 64 };

typedef struct ty_rsm_rays {
    int32_t count;
    size_t first; /* index of the first texel */
    float origin[3][TY_RSM_RAYS], direction[3][TY_RSM_RAYS];
    float length[TY_RSM_RAYS];    /* to the surface, m; INFINITY: none */
    float measure[TY_RSM_RAYS];   /* solid angle or area times falloff, so that times color it is W; 0: unlit */
    float normal[3][TY_RSM_RAYS]; /* of the surface, or opposite to the ray */
    float jitter[TY_RSM_RAYS];    /* 0..1 */
    float begin[TY_RSM_RAYS], end[TY_RSM_RAYS];   /* interval in the lattice, m; begin = end: empty */
    float enter[TY_RSM_RAYS], leave[TY_RSM_RAYS]; /* interval in the medium's box, m */
} ty_rsm_rays;

/* The origin, direction or normal of ray i. */
static inline ty_vec ty_rsm_ray_vec(const float columns[3][TY_RSM_RAYS], int32_t i) {
    return ty_vec_make(columns[0][i], columns[1][i], columns[2][i]);
}

/* A face of a map. */
typedef struct ty_rsm_face {
    int32_t side, parallel, spot;
    ty_vec origin, forward, right, up; /* as in ty_rsm; origin: the light's position if not parallel */
    ty_vec axis;                       /* of a spot light */
    float cos_outer, cos_inner;
    float area; /* of a texel, at distance 1 if rays are not parallel */
} ty_rsm_face;

/* Segments of rays in a medium that is homogeneous in its box. */
typedef struct ty_ray_segments {
    int32_t channels;
    float extinction[3], scattering[3]; /* 1/m */
    float samples, per_metre;           /* maximum number of segments per ray, and segments per metre */
    float lower[3], cell;               /* of the lattice, m */
    int32_t size[3];
    float near_end; /* distance from a ray's end within which points are moved off the surface, m */
} ty_ray_segments;

typedef struct ty_segment_splats {
    int32_t cell[TY_RSM_RAYS]; /* -1: no scattering */
    float weight[3][TY_RSM_RAYS];
} ty_segment_splats;

typedef struct ty_rsm_ray_kernels {
    /* Origins, directions and weights of the rays from texel (x, y) on; scales `length` from depth to distance. */
    void (*rays)(const ty_rsm_face* face, int32_t x, int32_t y, ty_rsm_rays* rays);
    /* The interval of [0, length] in a box. */
    void (*clip)(const ty_rsm_rays* rays, const float lower[3], const float upper[3], float* begin, float* end);
    /* One segment of each ray. */
    void (*part)(const ty_ray_segments* parts, const ty_rsm_rays* rays, int32_t part, ty_segment_splats* out);
} ty_rsm_ray_kernels;
TY_DECLARE_KERNELS(ty_rsm_ray_kernels);

/* The distance from a segment's start below which the fraction u of its scattering lies, m. */
TY_FN float ty_scattering_distance(float u, float length, float extinction) {
    const float across = extinction * length;
    const float far = -ty_logf(1.0f - u * (1.0f - ty_attenuation(across))) / ty_maxf(extinction, 1e-30f);
    return across < 1e-2f ? u * length : ty_minf(far, length);
}

#endif
