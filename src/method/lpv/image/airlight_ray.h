/* Airlight along rays through homogeneous media (airlight_homogeneous.c) or media on cells (airlight_heterogeneous.c).
 */
#ifndef TY_METHOD_LPV_IMAGE_AIRLIGHT_RAY_H
#define TY_METHOD_LPV_IMAGE_AIRLIGHT_RAY_H

#include "method/lpv/image/airlight.h"
#include "direct/media/attenuation.k.h"
#include "scene/media/phase.k.h"

enum { TY_AIRLIGHT_SOURCES_MAX = 64 };

/* Optical depth beyond which radiance is neglected. */
#define TY_AIRLIGHT_OPAQUE 20.0f

typedef struct ty_airlight_source {
    const ty_shadow_hierarchy* map;
    const ty_light_view* light;
    int32_t inside; /* a local light inside all media, which are convex: no light crosses a medium's boundary before it
                       scatters */
    float* planes[3]; /* transmittance from the light on cells, as many planes as the medium has; NULL: homogeneous
                         media */
} ty_airlight_source;

struct ty_airlight {
    ty_context* context;
    const ty_scene_view* scene;
    const ty_grid_medium* medium;
    const ty_medium_view* light_media; /* between the lights and where their light scatters: the scene's, or reduced */
    const ty_grid_medium* light_medium;
    int32_t on_cells; /* whether any medium is heterogeneous: then all are evaluated on cells */
    int32_t channels; /* 1: extinction is equal in all channels; 3: it is not */
    uint64_t collide; /* bit mask of the homogeneous media with extinction */
    ty_airlight_source* lights;
    int32_t count;
};

/* The results of a ray. */
typedef struct ty_airlight_sum {
    float radiance[3], transmittance[3];
} ty_airlight_sum;

/* The closest approach of a ray to a local light: at distance `nearest` along the ray it passes at distance `off`, m.
 */
typedef struct ty_closest_approach {
    float nearest, off;
} ty_closest_approach;

/* Minimum distance at which a ray passes a light, relative to the distance along the ray, and in m. */
#define TY_AIRLIGHT_OFFSET_RELATIVE 1e-4f
#define TY_AIRLIGHT_OFFSET_MIN 1e-6f

static inline ty_closest_approach ty_closest_approach_to(ty_vec light, ty_vec origin, ty_vec direction) {
    const ty_vec off = ty_sub(origin, light);
    const float nearest = -ty_dot(off, direction);
    const ty_vec beside = ty_mad(off, direction, nearest);
    const float min_off = TY_AIRLIGHT_OFFSET_RELATIVE * fabsf(nearest) + TY_AIRLIGHT_OFFSET_MIN;
    return (ty_closest_approach){nearest, ty_maxf(sqrtf(ty_dot(beside, beside)), min_off)};
}

/* At most TY_SHADOW_RAYS_MAX rays. */
void ty_airlight_homogeneous(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                             ty_airlight_sum* sums);
void ty_airlight_heterogeneous(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                               ty_airlight_sum* sum);
/* Transmittance from a light to a point, from cells. */
void ty_airlight_heterogeneous_transmittance(const ty_airlight* airlight, const ty_airlight_source* light, ty_vec point,
                                             float transmittance[3]);

#endif
