/* Images: what the camera sees of surfaces, lit by lights and lattices, and of media. Channels: single is airlight,
 * multiple what media scatter of the lattice's light towards the eye. What the lattice brings to surfaces is in
 * neither: light that media scattered there cannot be told from light that other surfaces reflected. albedo is, as path
 * has it, the part of the light that media scatter before the first surface. */
#ifndef TY_METHOD_LPV_PIXELS_H
#define TY_METHOD_LPV_PIXELS_H

#include "direct/single/airlight.h"
#include "method/lpv/lattice.h"

/* The lattices' light, for lookups: finest first. */
typedef struct ty_lpv_light_view {
    ty_lattice* const* lattices;
    int32_t count;
} ty_lpv_light_view;

typedef struct ty_lpv_image_job {
    const ty_scene* scene;
    const ty_lpv_def* def; /* width and height filled in */
    ty_lpv_light_view light;
    const ty_grid_medium* medium;  /* fine; NULL: vacuum */
    const ty_airlight* airlight;   /* NULL: vacuum */
    const ty_lit_map* const* maps; /* of the lights, all that ty_light_set has */
    int32_t map_count;
} ty_lpv_image_job;

/* Makes the image, and fills in the stats' parts of images, rays too. Errors: TY_ERROR_MEMORY; TY_CANCELLED with *out
 * NULL. */
ty_result ty_lpv_image(const ty_lpv_image_job* job, ty_image** out, ty_lpv_stats* stats);

/* Irradiance by the lattices' light at a surface, W m^-2; normal: on the side that is asked for. */
void ty_lpv_irradiance_at(const ty_lpv_light_view* light, ty_vec point, ty_vec normal, float irradiance[3]);

#endif
