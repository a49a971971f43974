/* Smooth interfaces of dielectrics among the boundary faces of discrete ordinates. A direction that arrives at an
 * interface along the face is reflected into the mirrored one; the angular distribution is that of the sweep before,
 * scaled to the irradiance of the mixed iterate.
 *
 * A curved or slanted interface becomes a staircase of faces, through which a direction w of cosine w.n > 0 to the
 * interface passes sum_a max(0, n_a w_a) times the interface's area: the steps hand the excess over w.n from one to the
 * next. So 1 - R of a face is that of the interface times w.n over this sum, and 0 where w.n <= 0. Its reflection is
 * sent into direction w in proportion to R(-w), so that light that is the same everywhere stays so. */
#ifndef TY_SOLVE_ORDINATES_FRESNEL_FACES_H
#define TY_SOLVE_ORDINATES_FRESNEL_FACES_H

#include "solve/ordinates/diffusive_cells.h"

typedef struct ty_fresnel_faces ty_fresnel_faces;

/* Of the def's walls with an ior, but for those of diffusive cells; *out is NULL without any. Errors: TY_ERROR_MEMORY.
 */
ty_result ty_fresnel_faces_create(ty_context* context, const ty_ordinates_def* def, const ty_sweep* sweep,
                                  const ty_diffusive_cells* diffusive, ty_fresnel_faces** out);
/* All functions take NULL as no interfaces. */
void ty_fresnel_faces_destroy(ty_fresnel_faces* fresnel);
/* True if a side of the def's walls reflects into mirrored directions. */
bool ty_fresnel_faces_mirror(const ty_fresnel_faces* fresnel, int32_t wall);
/* Its reflected fraction of the irradiance of the last sweep. */
double ty_fresnel_faces_albedo(const ty_fresnel_faces* fresnel, int32_t wall);
/* Scales its reflection to an irradiance; returns the reflected flux, W m^-2. */
double ty_fresnel_faces_emit(ty_fresnel_faces* fresnel, int32_t wall, double irradiance);
/* Change of its reflected flux by a sweep: that of an irradiance after it, less that which the sweep emitted. */
float ty_fresnel_faces_change(const ty_fresnel_faces* fresnel, int32_t wall, float irradiance, float before);
/* Albedos of the def's walls for the correction by diffusion: of slanted interfaces, which reflect diffusely, that of
 * even light. */
void ty_fresnel_faces_diffuse(const ty_ordinates_def* def, float* albedo);
/* Adds reflection to the faces of the next sweep. */
void ty_fresnel_faces_attach(ty_fresnel_faces* fresnel, ty_sweep_faces* faces);
/* Takes the angular distribution of the sweep that ended. */
void ty_fresnel_faces_receive(ty_fresnel_faces* fresnel);

#endif
