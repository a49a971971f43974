/* Adjoint of the light of points: derivatives of a weighted sum of its mean fluence in cells by the extinction of each
 * cell and by the strength of the light. It is exact for point_light.h, without surfaces. */
#ifndef TY_DIRECT_UNCOLLIDED_POINT_LIGHT_ADJOINT_H
#define TY_DIRECT_UNCOLLIDED_POINT_LIGHT_ADJOINT_H

#include "direct/uncollided/collimated_adjoint.h"
#include "scene/scene.h"

/* Adds the derivatives as ty_collimated_adjoint, for the points among the sources; loss->transmittance and its scratch
 * are not used. One thread does the work. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_point_light_adjoint(const ty_scene_view* scene, const ty_grid_medium* medium,
                                 const ty_uncollided_loss* loss, float* gradient, double (*strength)[3]);

#endif
