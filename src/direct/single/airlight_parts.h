/* What airlight is made of: one ray through even media (airlight_even.c), or through media on cells
 * (airlight_cells.c). */
#ifndef TY_DIRECT_AIRLIGHT_PARTS_H
#define TY_DIRECT_AIRLIGHT_PARTS_H

#include "direct/single/airlight.h"
#include "direct/media/attenuation.k.h"
#include "scene/phase.k.h"

enum { TY_AIR_LIGHTS_MAX = 64 };

/* Optical depth behind which nothing is seen. */
#define TY_AIR_UNSEEN 20.0f

typedef struct ty_air_light {
    const ty_lit_map* map;
    const ty_light_view* light;
    int32_t inside; /* a lamp within all media, which are convex: its light crosses but the medium where it scatters */
    float* planes[3]; /* transmittance of media on cells from the light, as many planes as the medium has; NULL: even */
} ty_air_light;

struct ty_airlight {
    ty_context* context;
    const ty_scene_view* scene;
    const ty_grid_medium* medium;
    int32_t on_cells; /* whether any of the media varies: then all are taken on cells */
    int32_t channels; /* 1: media dim all channels alike, 3: they do not */
    uint64_t collide; /* even media, one bit each: those with extinction */
    ty_air_light* lights;
    int32_t count;
};

/* A ray's results. */
typedef struct ty_air_sum {
    float radiance[3], transmittance[3];
} ty_air_sum;

/* A ray about a lamp: `off` beside it at its nearest, which is at `nearest`, m along the ray. */
typedef struct ty_air_pass {
    float nearest, off;
} ty_air_pass;

/* Rays are taken to pass a lamp at least this far off, in parts of its distance, and m. */
#define TY_AIR_OFF 1e-4f
#define TY_AIR_OFF_LEAST 1e-6f

static inline ty_air_pass ty_air_pass_by(ty_vec lamp, ty_vec origin, ty_vec direction) {
    const ty_vec off = ty_sub(origin, lamp);
    const float nearest = -ty_dot(off, direction);
    const ty_vec beside = ty_mad(off, direction, nearest);
    const float least = TY_AIR_OFF * fabsf(nearest) + TY_AIR_OFF_LEAST;
    return (ty_air_pass){nearest, ty_maxf(sqrtf(ty_dot(beside, beside)), least)};
}

/* At most TY_LIT_LINES rays. */
void ty_air_even(const ty_airlight* airlight, ty_vec origin, const ty_air_ray* rays, int32_t count, ty_air_sum* sums);
void ty_air_cells(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                  ty_air_sum* sum);
/* Transmittance of media on cells from a light to a point. */
void ty_air_cells_reach(const ty_airlight* airlight, const ty_air_light* light, ty_vec point, float transmittance[3]);

#endif
