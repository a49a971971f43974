/* Parts of lights: the directions and points that light is taken to come from where it scatters. */
#ifndef TY_DIRECT_LIGHTS_DISCRETE_LIGHT_H
#define TY_DIRECT_LIGHTS_DISCRETE_LIGHT_H

#include "base/vector.k.h"

#include <tyndall/base.h>

enum { TY_LIGHT_PART_PARALLEL = 0, TY_LIGHT_PART_RADIAL = 1 };

/* How a radial part's intensity goes with the cosine about its direction. */
enum { TY_LIGHT_PART_EVEN = 0, TY_LIGHT_PART_SPOT = 1, TY_LIGHT_PART_COSINE = 2 };

typedef struct ty_light_part {
    int32_t kind;
    float color[3];   /* parallel: irradiance, W m^-2; radial: intensity where it is brightest, W sr^-1 */
    ty_vec direction; /* parallel: the way light travels; radial: the axis of its profile; unit */
    ty_vec position;  /* radial, m */
    float cosine;     /* mean cosine of the light that comes in about its direction, 0..1; 1: it is a line */
    float least;      /* radial: the distance below which 1 / r^2 is held, m */
    int32_t profile;  /* radial */
    int32_t light;    /* which of ty_light_set.lights it is part of; of VPLs: that lights the surface */
    int32_t shadowed; /* whether surfaces of the scene cast shadows from it */
} ty_light_part;

void ty_light_parts_destroy(ty_context* context, ty_light_part* parts, int32_t count);

/* Ends a list of `capacity` items of which `filled` are: they move to memory of just their size, and the list goes,
 * whatever happens. Errors: TY_ERROR_MEMORY. */
ty_result ty_light_parts_trim(ty_context* context, ty_light_part* items, int64_t capacity, int32_t filled,
                              ty_light_part** out, int32_t* count);

#endif
