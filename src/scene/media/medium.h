/* Validation, copies and views of media. */
#ifndef TY_SCENE_MEDIA_MEDIUM_H
#define TY_SCENE_MEDIA_MEDIUM_H

#include "scene/media/medium.k.h"
#include "scene/media/periodic.k.h"

#include <tyndall/scene.h>

/* Fails unless ty_scene_add_medium accepts the medium. */
ty_result ty_medium_check(ty_context* context, const ty_medium_def** given, ty_medium_def* own);
/* Deep copy of a def that retains grids and closed mesh; false, with a message, on allocation failure. */
bool ty_medium_copy(ty_context* context, const ty_medium_def* def, ty_medium_def* out);
void ty_medium_release(ty_context* context, ty_medium_def* copy);

/* All grids of a medium, NULL where it has none. */
enum { TY_MEDIUM_GRIDS = 6 };
void ty_medium_grids(const ty_medium_def* def, ty_grid* grids[TY_MEDIUM_GRIDS]);

/* def must outlive the view. Grids that span a periodic cell go on at its faces. ty_medium_view_destroy is valid even
 * after failure. */
ty_result ty_medium_view_create(ty_context* context, const ty_medium_def* def, const ty_periodic_view* cell,
                                ty_medium_view* view);
void ty_medium_view_destroy(ty_context* context, ty_medium_view* view);
/* Map from the cube [-1, 1]^3, or the unit sphere, to bounds that are a box or a sphere, m. */
ty_affine ty_medium_bounds_map(const ty_medium_def* def);
/* Extends a box, m, to contain the medium. */
void ty_medium_extent(const ty_medium_def* def, double lower[3], double upper[3]);
/* The same, but of grids without bounds the voxels alone, without the half voxel over which they fade. */
void ty_medium_voxel_extent(const ty_medium_def* def, double lower[3], double upper[3]);

#endif
