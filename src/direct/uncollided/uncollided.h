/* Uncollided light on the cells of a grid: means over each cell of fluence (W m^-2) and flux vector (W m^-2), with the
 * shadows of all surfaces. Emission of media is not part of it (ty_grid_medium.emission).
 *
 * Parallel light goes through the grid in tubes one cell wide: homogeneous media are exact, absorbed and leaving power
 * add up to the entering power (to rounding), and shadows stay sharp to a cell at any distance. Point lights use
 * optical depths on a lattice of rays that widens with distance; within two cells of the light, rays are marched cell
 * by cell. Both take time proportional to the number of cells. */
#ifndef TY_DIRECT_UNCOLLIDED_UNCOLLIDED_H
#define TY_DIRECT_UNCOLLIDED_UNCOLLIDED_H

#include "direct/uncollided/transpose.h"
#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

typedef struct ty_light_field {
    ty_context* context;
    size_t cells;
    int32_t planes;    /* 3, or 1: all channels are the first one's planes times color */
    float color[3];    /* of a single plane */
    float* fluence[3]; /* per channel; NULL beyond planes */
    float* flux[3][3]; /* per channel along x, y, z; NULL if not requested */
} ty_light_field;

/* An empty field. Errors: TY_ERROR_MEMORY. */
ty_result ty_light_field_create(const ty_grid_medium* medium, bool with_flux, ty_light_field** out);
/* An empty field of one plane for all channels, for a gray medium and sources whose colors are multiples of `color`,
 * which is not black. Errors: TY_ERROR_ARGUMENT (the medium's planes), TY_ERROR_MEMORY. */
ty_result ty_light_field_create_shared(const ty_grid_medium* medium, bool with_flux, const float color[3],
                                       ty_light_field** out);
void ty_light_field_destroy(ty_light_field* field);

/* Power of parallel light without surfaces, per channel, in watts per irradiance (m^2). The difference is the power
 * that cells absorb: the sum of extinction times mean transmittance times volume. */
typedef struct ty_collimated_power {
    double entering[3], leaving[3];
} ty_collimated_power;

/* Adds the light of `count` sources to a field. extinction: planes instead of the medium's own, such as scaled ones;
 * NULL: its own. Errors: TY_ERROR_MEMORY. */
ty_result ty_uncollided_add(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                            const ty_discrete_light* sources, int32_t count, ty_light_field* field);
/* The same with progress (stage "direct light"; NULL: none). After TY_CANCELLED the field has the light of some
 * sources, the last one possibly in part. */
ty_result ty_uncollided_add_with_progress(const ty_scene* scene, const ty_grid_medium* medium,
                                          float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                          ty_light_field* field, ty_progress_fn progress, void* progress_user);

/* The same for one source after another through one extinction: scratch, one per plane of the medium, is reused by the
 * next call. The caller frees it with ty_transpose_scratch_free, also after TY_CANCELLED, when it must not be reused.
 */
ty_result ty_uncollided_add_reusing(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                    const ty_discrete_light* sources, int32_t count, ty_light_field* field,
                                    ty_transpose_scratch scratch[3], ty_progress_fn progress, void* progress_user);

/* Mean transmittance of cells from one source, 0 in shadow: times color (for points, over square distance) it is the
 * fluence, with shadows as sharp as the cells. planes: as many as the medium has. power: of directions, may be NULL.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_uncollided_transmittance(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                      const ty_discrete_light* source, float* const planes[3],
                                      ty_collimated_power* power);
/* The same without surfaces; source->light is not used and may be 0. */
ty_result ty_uncollided_in_media(const ty_grid_medium* medium, const ty_discrete_light* source, float* const planes[3]);

#endif
