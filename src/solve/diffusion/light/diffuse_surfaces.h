/* Surfaces between cells of diffuse light, lit by uncollided light. */
#ifndef TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_SURFACES_H
#define TY_SOLVE_DIFFUSION_LIGHT_DIFFUSE_SURFACES_H

#include "direct/surfaces/boundary_faces.h"
#include "direct/surfaces/cut_cells.h"
#include "solve/diffusion/diffusion.h"

/* One number per side of the faces. */
typedef struct ty_diffuse_surfaces {
    ty_context* context;
    ty_boundary_faces* faces; /* owned; NULL: no surface closes a face, and nothing else is set */
    size_t count;             /* number of sides */
    float* staircase;         /* total area of the faces over that of the slanted surface */
    float* albedo[3];
    float* radiosity[3]; /* reflected uncollided light and emission, W m^-2 */
    float* forward[3];   /* irradiance of light that has scattered nearly straight on, W m^-2 */
    uint8_t* unlit;      /* of cells: no light reaches it */
    size_t cells;
} ty_diffuse_surfaces;

/* Faces that surfaces close between a medium's cells. Errors: TY_ERROR_MEMORY. Freed with ty_diffuse_surfaces_destroy,
 * also after an error. */
ty_result ty_diffuse_surfaces_find(const ty_scene* scene, const ty_grid_medium* medium, ty_diffuse_surfaces* out);
/* Lights them by samples, some of which may be VPLs. reduced: light that scatters nearly straight on goes on, as in
 * ty_diffuse_light_solve_between. Errors: TY_ERROR_MEMORY. */
ty_result ty_diffuse_surfaces_light(const ty_scene* scene, const ty_grid_medium* medium, bool reduced,
                                    const ty_discrete_light_set* sources, ty_diffuse_surfaces* surfaces);
/* Corrects a first-collision source that was averaged from finer cells: what a surface cuts off goes to the cell behind
 * it, and none is left in unlit cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_diffuse_surfaces_correct_source(const ty_diffuse_surfaces* surfaces, const ty_grid_medium* medium,
                                             const ty_grid_box* fine_box, const ty_light_fluence* lights, int32_t count,
                                             float* const source[3]);
void ty_diffuse_surfaces_destroy(ty_diffuse_surfaces* surfaces);
/* Factor on the largest ratio of flux to fluence: surfaces return light, which leaves it more even. 1 - a / 2, with the
 * sides' mean albedo a; measured in rooms, courts and halls (docs/method/fld.md). */
double ty_diffuse_surfaces_flux_factor(const ty_diffuse_surfaces* surfaces);
/* True if all channels have the same albedo, and channel `channel` has `factor` times the radiosity of `of`. */
bool ty_diffuse_surfaces_are_multiple(const ty_diffuse_surfaces* surfaces, int32_t channel, int32_t of, float factor);
/* True if a channel's surfaces send no light besides what they reflect. */
bool ty_diffuse_surfaces_are_dark(const ty_diffuse_surfaces* surfaces, int32_t channel);
/* A channel's surfaces for the solver. with_radiosity: false without the light that they send besides reflection. */
ty_diffusion_faces ty_diffuse_surfaces_faces(const ty_diffuse_surfaces* surfaces, int32_t channel, bool with_radiosity);

#endif
