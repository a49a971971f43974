/* Light that has not scattered yet, on the cells of a grid: means over each cell of fluence (W m^-2) and flux vector
 * (W m^-2), with the shadows of all surfaces. What media give off by themselves is not part of it: that is
 * ty_grid_medium.emission.
 *
 * Beams go through the grid in tubes one cell wide, so that a medium of even density is met exactly, what all cells
 * absorb and what leaves is what entered (to rounding), and shadows stay within a cell however far they fall. Lamps
 * keep optical depths on a lattice of rays that widens with distance; within two cells of the lamp, rays are followed
 * from cell to cell. Both take time in proportion to the number of cells. */
#ifndef TY_DIRECT_UNCOLLIDED_UNCOLLIDED_H
#define TY_DIRECT_UNCOLLIDED_UNCOLLIDED_H

#include "direct/uncollided/transpose_scratch.h"
#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

typedef struct ty_light_field {
    ty_context* context;
    size_t cells;
    int32_t planes;    /* 3, or 1: all channels are the first one's planes times color */
    float color[3];    /* of one plane */
    float* fluence[3]; /* per channel; NULL beyond planes */
    float* flux[3][3]; /* per channel along x, y, z; NULL where not asked for */
} ty_light_field;

/* Dark. */
ty_result ty_light_field_create(const ty_grid_medium* medium, bool with_flux, ty_light_field** out);
/* A third of the memory: one plane for all channels, for a medium of one plane and sources whose colors are multiples
 * of `color`, which is not black. Errors: TY_ERROR_ARGUMENT (the medium's planes), TY_ERROR_MEMORY. */
ty_result ty_light_field_create_shared(const ty_grid_medium* medium, bool with_flux, const float color[3],
                                       ty_light_field** out);
void ty_light_field_destroy(ty_light_field* field);

/* What becomes of a beam, per channel, in watts per irradiance (that is, m^2), if there were no surfaces. Without them,
 * the difference is what all cells absorb: the sum of extinction times mean transmittance times volume. */
typedef struct ty_collimated_power {
    double entering[3], leaving[3];
} ty_collimated_power;

/* Adds the light of `count` sources to a field; a caller that wants some of them apart gives them fields of their own.
 * extinction: as many planes as the medium has, in place of the medium's own (reduced, say); NULL: its own.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_uncollided_add(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                            const ty_discrete_light* sources, int32_t count, ty_light_field* field);
/* The same with progress (stage "direct light"; NULL: none), which may end it with TY_CANCELLED: the field then has the
 * light of some sources, and perhaps a part of another one's. */
ty_result ty_uncollided_add_with_progress(const ty_scene* scene, const ty_grid_medium* medium,
                                          float* const extinction[3], const ty_discrete_light* sources, int32_t count,
                                          ty_light_field* field, ty_progress_fn progress, void* progress_user);

/* The same, where one source follows another through one extinction: room, of each plane of the medium, is kept for the
 * next, and freed by the caller (ty_transpose_scratch_free), also after TY_CANCELLED, before which it is of no more
 * use. */
ty_result ty_uncollided_add_reusing(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                    const ty_discrete_light* sources, int32_t count, ty_light_field* field,
                                    ty_transpose_scratch scratch[3], ty_progress_fn progress, void* progress_user);

/* Means over cells of the transmittance from one source, 0 in the shadow of surfaces: times color (for lamps, over
 * distance squared) it is the fluence, with shadows as sharp as the medium's cells. planes: as many as the medium has.
 * power: of beams, may be NULL. Errors: TY_ERROR_MEMORY. */
ty_result ty_uncollided_transmittance(const ty_scene* scene, const ty_grid_medium* medium, float* const extinction[3],
                                      const ty_discrete_light* source, float* const planes[3],
                                      ty_collimated_power* power);
/* The same as if there were no surfaces; source->light is not looked at: it may be 0. */
ty_result ty_uncollided_in_media(const ty_grid_medium* medium, const ty_discrete_light* source, float* const planes[3]);

#endif
