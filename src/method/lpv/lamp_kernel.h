/* Rays from lights through texels, many at once; built once per instruction set. */
#ifndef TY_METHOD_LPV_LAMP_KERNEL_H
#define TY_METHOD_LPV_LAMP_KERNEL_H

#include "base/isa.h"
#include "base/vector.k.h"
#include "direct/media/attenuation.k.h"

/* Neighbouring texels of a row. */
enum { TY_LAMP_RAYS = 64 };

typedef struct ty_ray_row {
    int32_t count;
    size_t first; /* the first one's texel */
    float origin[3][TY_LAMP_RAYS], way[3][TY_LAMP_RAYS];
    float length[TY_LAMP_RAYS];                     /* up to the surface, m; INFINITY: there is none */
    float share[TY_LAMP_RAYS];                      /* W by the light's color; 0: it sends nothing there */
    float normal[3][TY_LAMP_RAYS];                  /* of the surface, or against the ray */
    float jitter[TY_LAMP_RAYS];                     /* 0..1 */
    float begin[TY_LAMP_RAYS], end[TY_LAMP_RAYS];   /* the stretch within the lattice, m; alike: there is none */
    float enter[TY_LAMP_RAYS], leave[TY_LAMP_RAYS]; /* the stretch within the medium's box */
} ty_ray_row;

/* A face of a light's map. */
typedef struct ty_lamp_face {
    int32_t side, parallel, spot;
    ty_vec origin, forward, right, up; /* as in ty_light_map; origin: of the light, if not parallel */
    ty_vec axis;                       /* spot */
    float cos_outer, cos_inner;
    float area; /* of a texel, at distance 1 where rays are not parallel */
} ty_lamp_face;

/* Parts of rays, in a medium that is the same everywhere in its box. */
typedef struct ty_lamp_parts {
    int32_t channels;
    float extinction[3], scattering[3]; /* 1/m */
    float samples, per_metre;           /* parts a ray at most, and otherwise a metre */
    float lower[3], cell;               /* of the lattice, m */
    int32_t size[3];
    float near_end; /* how far from its end points are moved off the surface, m */
} ty_lamp_parts;

typedef struct ty_lamp_splats {
    int32_t cell[TY_LAMP_RAYS]; /* -1: nothing is scattered */
    float share[3][TY_LAMP_RAYS];
} ty_lamp_splats;

typedef struct ty_lamp_kernels {
    /* Origins, ways and shares of the texels from (x, y) on; and lengths by the depth in front of `length`. */
    void (*rays)(const ty_lamp_face* face, int32_t x, int32_t y, ty_ray_row* rays);
    /* The stretch of [0, length] in a box. */
    void (*clip)(const ty_ray_row* rays, const float lower[3], const float upper[3], float* begin, float* end);
    /* One part of each ray. */
    void (*part)(const ty_lamp_parts* parts, const ty_ray_row* rays, int32_t part, ty_lamp_splats* out);
} ty_lamp_kernels;

/* The point of a stretch, m from its beginning, up to which share u of what it scatters comes from. */
TY_FN float ty_lamp_place(float u, float length, float extinction) {
    const float across = extinction * length;
    const float far = -ty_logf(1.0f - u * (1.0f - ty_decay(across))) / ty_maxf(extinction, 1e-30f);
    return across < 1e-2f ? u * length : ty_minf(far, length);
}

extern const ty_lamp_kernels ty_lamp_kernels_v1;
#if TY_ISA_X86
extern const ty_lamp_kernels ty_lamp_kernels_v3, ty_lamp_kernels_v4;
#endif
const ty_lamp_kernels* ty_lamp_kernels_best(void);

#endif
