/* Memory of an irradiance cache. */
#ifndef TY_IMAGE_IRRADIANCE_POINTS_H
#define TY_IMAGE_IRRADIANCE_POINTS_H

#include "direct/surfaces/boundary_faces.h"
#include "image/march/irradiance_cache.h"

/* Points at most; rays from each to others, of each kind of ty_reflect_gather, and from each patch of the box's faces;
 * places on each at which lights are sampled.
 */
enum {
    TY_IRRADIANCE_POINTS_MAX = 1024,
    TY_IRRADIANCE_RAYS = 32,
    TY_IRRADIANCE_GATHER_RAYS = 24,
    TY_IRRADIANCE_PATCH_RAYS = 32,
    TY_IRRADIANCE_PLACES = 8,
    TY_IRRADIANCE_FACE_RAYS = 6 * TY_IRRADIANCE_FACE_PATCHES * TY_IRRADIANCE_PATCH_RAYS
};

/* A cosine-distributed ray from a point or a patch to another point. */
typedef struct ty_irradiance_ray {
    ty_vec origin, direction;
    float distance;   /* m; TY_FLOAT_MAX: nothing is hit */
    int32_t point;    /* that it ends at; -1: none */
    float weight[3];  /* of the point's irradiance: albedo times transmittance, over the number of rays */
    float emitted[3]; /* irradiance of what the surface emits, unless it is a light, W m^-2 */
} ty_irradiance_ray;

typedef struct ty_irradiance_point {
    ty_vec position, normal;
    int32_t inside; /* 1: in the media's box, where the field lights it and it has no rays */
    int32_t places;
    float phase; /* of the rays that gather light of media, (0, 1] */
} ty_irradiance_point;

struct ty_irradiance_cache {
    ty_context* context;
    ty_irradiance_view view;
    uint32_t* keys; /* of the view */
    int32_t* items;
    double area[3];              /* of the box's faces across each axis, m^2 */
    ty_irradiance_point* points; /* view.count of them */
    ty_irradiance_ray* rays;     /* of the points, then of the faces */
    ty_boundary_side* places;    /* of the points, TY_IRRADIANCE_PLACES for each, at which lights are sampled */
    float* irradiance[3];        /* of each ty_reflected_light, with all reflections */
};

/* The rays of a face, patch by patch. */
static inline ty_irradiance_ray* ty_irradiance_face_rays(const ty_irradiance_cache* cache, int face) {
    return cache->rays + (size_t)TY_IRRADIANCE_POINTS_MAX * TY_IRRADIANCE_RAYS +
           (size_t)face * TY_IRRADIANCE_FACE_PATCHES * TY_IRRADIANCE_PATCH_RAYS;
}

/* Adds to the points' irradiance, 3 for each, that of one another's reflection. Errors: TY_ERROR_MEMORY. */
ty_result ty_irradiance_reflect(const ty_irradiance_cache* cache, float* irradiance);

#endif
