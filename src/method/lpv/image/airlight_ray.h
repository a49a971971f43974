/* What airlight is made of: one ray through even media (airlight_even.c), or through media on cells
 * (airlight_cells.c). */
#ifndef TY_METHOD_LPV_IMAGE_AIRLIGHT_RAY_H
#define TY_METHOD_LPV_IMAGE_AIRLIGHT_RAY_H

#include "method/lpv/image/airlight.h"
#include "direct/beam.k.h"
#include "scene/phase.k.h"

enum { TY_AIRLIGHT_SOURCES_MAX = 64 };

/* Optical depth behind which nothing is seen. */
#define TY_AIRLIGHT_OPAQUE 20.0f

typedef struct ty_airlight_source {
    const ty_shadow_hierarchy* map;
    const ty_light_view* light;
    int32_t inside; /* a lamp within all media, which are convex: its light crosses but the medium where it scatters */
    float* planes[3]; /* transmittance of media on cells from the light, as many planes as the medium has; NULL: even */
} ty_airlight_source;

struct ty_airlight {
    ty_context* context;
    const ty_scene_view* scene;
    const ty_grid_medium* medium;
    int32_t on_cells; /* whether any of the media varies: then all are taken on cells */
    int32_t channels; /* 1: media dim all channels alike, 3: they do not */
    uint64_t collide; /* even media, one bit each: those with extinction */
    ty_airlight_source* lights;
    int32_t count;
};

/* A ray's results. */
typedef struct ty_airlight_sum {
    float radiance[3], transmittance[3];
} ty_airlight_sum;

/* A ray about a lamp: `off` beside it at its nearest, which is at `nearest`, m along the ray. */
typedef struct ty_closest_approach {
    float nearest, off;
} ty_closest_approach;

/* Rays are taken to pass a lamp at least this far off, in parts of its distance, and m. */
#define TY_AIRLIGHT_OFFSET_RELATIVE 1e-4f
#define TY_AIRLIGHT_OFFSET_MIN 1e-6f

static inline ty_closest_approach ty_closest_approach_to(ty_vec lamp, ty_vec origin, ty_vec direction) {
    const ty_vec off = ty_sub(origin, lamp);
    const float nearest = -ty_dot(off, direction);
    const ty_vec beside = ty_mad(off, direction, nearest);
    const float least = TY_AIRLIGHT_OFFSET_RELATIVE * fabsf(nearest) + TY_AIRLIGHT_OFFSET_MIN;
    return (ty_closest_approach){nearest, ty_maxf(sqrtf(ty_dot(beside, beside)), least)};
}

/* At most TY_SHADOW_RAYS_MAX rays. */
void ty_airlight_homogeneous(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                             ty_airlight_sum* sums);
void ty_airlight_heterogeneous(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                               ty_airlight_sum* sum);
/* Transmittance of media on cells from a light to a point. */
void ty_airlight_heterogeneous_transmittance(const ty_airlight* airlight, const ty_airlight_source* light, ty_vec point,
                                             float transmittance[3]);

#endif
