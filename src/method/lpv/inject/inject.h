/* Injection: the maps of the lights, blockers, light that surfaces reflect, and light that media scatter once. */
#ifndef TY_METHOD_LPV_INJECT_INJECT_H
#define TY_METHOD_LPV_INJECT_INJECT_H

#include "direct/shadow/rsm.h"
#include "method/lpv/job.h"

/* Traces the maps of all directional, point and spot lights, or takes the caller's. */
ty_result ty_lpv_find_maps(ty_lpv_job* job);
void ty_lpv_free_maps(ty_lpv* light);
/* A surface sample with its area: from rays through all layers along three axes, or from the maps of the lights and the
 * camera. */
typedef struct ty_surfel {
    ty_vec position, normal; /* m; unit, of the front side */
    float area;              /* m^2 */
    float albedo[3];
} ty_surfel;

/* A list that owns its surfels. */
typedef struct ty_surfel_list {
    ty_surfel* items;
    size_t count, capacity;
} ty_surfel_list;
void ty_surfel_list_free(ty_context* context, ty_surfel_list* list);

/* Finds the blockers of a lattice from the scene's surfaces, or if it has none, from a caller's maps and view. The
 * caller frees the surfels, also after an error. */
ty_result ty_lpv_find_blockers(ty_lpv_job* job, ty_lattice* lattice, ty_surfel_list* surfels);

/* Surfels of all layers of the scene's surfaces within a box, extended by half a cell for the links that leave it,
 * along three axes with `side` x `side` rays per cell. The areas of all three axes together count each surface once.
 * counter: NULL, or a counter of the rays. Errors: TY_ERROR_MEMORY. Freed with ty_free_array of *capacity. */
ty_result ty_surfels_trace(const ty_scene* scene, const ty_grid_box* box, int32_t side, ty_surfel** out, size_t* count,
                           size_t* capacity, ty_ray_counter* counter);

/* Finds the transmission of the links and the mean albedo around cells. Mode links: by the area that cuts a link. Mode
 * published: by fuzzy blockers, B in two bands on cells shifted by half a cell, as <B | G_j>. Errors: TY_ERROR_MEMORY.
 */
ty_result ty_lattice_find_blockers(ty_lattice* lattice, ty_lpv_mode mode, const ty_surfel* surfels, size_t count);

/* Mode links with a mesh, after ty_lattice_find_blockers: blocks every link whose straight line from cell to cell
 * crosses a surface, which areas alone miss where surfaces are slanted. Only links near partly blocked ones are traced.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_find_crossings(ty_lattice* lattice, const ty_scene* scene, ty_ray_counter* counter);

/* The factor on band l of injected light that reduces ringing (ty_lpv_def.window). */
float ty_lpv_window(const ty_lpv_def* def, int32_t l);

/* Injects light that surfaces reflect, as cosine lobes about the normals in the cells on the lit side, attenuated on
 * the path from the light (TY_LPV_SCATTERING). Adds the injected power, W per channel, to `power`. medium: the fine
 * cells for that attenuation; NULL: vacuum. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_inject_reflected(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* light,
                                      const ty_grid_medium* medium, double power[3]);
/* Injects light that media scatter for the first time, as Henyey-Greenstein lobes about the rays. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_lattice_inject_scattered(ty_lattice* lattice, const ty_lpv_def* def, const ty_lpv_light* light,
                                      const ty_grid_medium* medium, double power[3]);

/* Injects the light of job->light->extended that surfels reflect, as ty_lattice_inject_reflected. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_lpv_inject_extended_reflected(ty_lpv_job* job, ty_lattice* lattice, const ty_surfel_list* surfels,
                                           double power[3]);
/* Injects the light of job->light->extended that media scatter for the first time, and the light that media emit, and
 * stores lattice->uncollided where images need it. Adds the powers, W per channel. Errors: TY_ERROR_MEMORY. */
ty_result ty_lpv_inject_in_media(ty_lpv_job* job, ty_lattice* lattice, double scattered[3], double emitted[3]);

#endif
