/* Principal ordinates: the directions and points that all light is taken to come from. */
#ifndef TY_METHOD_POP_ORDINATE_H
#define TY_METHOD_POP_ORDINATE_H

#include "base/vector.k.h"
#include "direct/grid_medium.h"

#include <tyndall/pop.h>

enum { TY_POP_PARALLEL = 0, TY_POP_RADIAL = 1 };

/* How a radial ordinate's intensity goes with the cosine about its direction. */
enum { TY_POP_EVEN = 0, TY_POP_SPOT = 1, TY_POP_COSINE = 2 };

typedef struct ty_pop_ordinate {
    int32_t kind;
    float color[3];   /* parallel: irradiance, W m^-2; radial: intensity where it is brightest, W sr^-1 */
    ty_vec direction; /* parallel: the way light travels; radial: the axis of its profile; unit */
    ty_vec position;  /* radial, m */
    float cosine;     /* a_n: mean cosine of the light that comes in about its direction, 0..1; 1: it is a line */
    float least;      /* radial: the distance below which 1 / r^2 is held, m */
    int32_t profile;  /* radial */
    int32_t light;    /* which of ty_light_set.lights it is part of; of VPLs: that lights the surface */
    int32_t shadowed; /* whether surfaces of the scene cast shadows from it */
} ty_pop_ordinate;

/* Lights that go through fine cells at most. */
enum { TY_POP_SHARP_MAX = 8 };

/* Whether a light (an index into ty_light_set.lights) goes through fine cells instead of being an ordinate: in a sharp
 * split, the first eight directional, point and spot lights. */
bool ty_pop_is_sharp(const ty_scene* scene, const ty_pop_def* def, int32_t light);

/* All ordinates of a scene but sharp lights and black ones. Directional lights are one each, and so are point and spot
 * lights; area lights, spheres and glowing triangles are points with the cosine's profile (two of them, back to back,
 * where triangles glow on both sides). Environment lights as importance says: a map as ty_pop_importance's, NULL: all
 * alike. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_pop_ordinates_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_box* box,
                                  const float* importance, ty_pop_ordinate** out, int32_t* count);
void ty_pop_ordinates_destroy(ty_context* context, ty_pop_ordinate* ordinates, int32_t count);

/* Ends a list of `capacity` items of which `filled` are: they move to memory of just their size, and the list goes,
 * whatever happens. */
ty_result ty_pop_ordinates_hand_over(ty_context* context, ty_pop_ordinate* items, int64_t capacity, int32_t filled,
                                     ty_pop_ordinate** out, int32_t* count);

/* Virtual point lights of the scene's surfaces as seen by its directional, point and spot lights, behind the medium (in
 * split mode by its reduced extinction: what surfaces are lit by is all light that keeps its direction): at most
 * def->vpls. All light that surfaces which face some of the medium's box reflect (of directional lights: within eight
 * of its longest sides) is shared out among them, neighbours together, in equal parts by luminance, cosine and
 * distance; each VPL stands where the surface is nearest to the middle of its part, and its a_n is (1 - w / N)^beta
 * with w / N the part of the sphere that its share of the surfaces takes, seen from the middle of the medium: bright or
 * far, it is small. *out as above. */
ty_result ty_pop_vpls_create(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                             ty_pop_ordinate** out, int32_t* count);

/* Sec. 5.2, on a grid of 16^3 cells in the part of the camera's frustum that sees the medium's box. Importance goes
 * from the eye as light goes from an ordinate (U, R and S of ty_pop_sweep), to where surfaces end it; what a cell
 * scatters towards the eye of light from a direction counts by the transmittance of that way out, reduced as ordinates'
 * is, and what it turns aside by that of diffusion, 1 / (1 + 3/4 tau). map: TY_POP_IMPORTANCE_WIDTH x _HEIGHT, mean 1
 * over the sphere, turned as an environment of rotation 0; smoothed over about a texel, and where def->history has a
 * map half of it is that. It is updated. All 1 where the camera sees nothing that scatters. medium: a coarse one is
 * quicker, and of a fine one only some cells are looked at. Errors: TY_ERROR_MEMORY. */
ty_result ty_pop_importance_find(const ty_scene* scene, const ty_pop_def* def, const ty_grid_medium* medium,
                                 float* map);

#endif
