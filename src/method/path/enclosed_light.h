/* Light in media inside dielectrics, with the light of other surfaces around them, which paths find. */
#ifndef TY_METHOD_PATH_ENCLOSED_LIGHT_H
#define TY_METHOD_PATH_ENCLOSED_LIGHT_H

#include "solve/enclosed/enclosed.h"

#include <tyndall/path.h>

/* ty_enclosed_solve with `radiance` by one path per ray; path: its seed and max_depth count. *out is NULL where no
 * dielectric holds a medium that scatters, and is freed with ty_enclosed_destroy. Errors: those of ty_enclosed_solve.
 */
ty_result ty_path_solve_enclosed(const ty_scene* scene, const ty_path_def* path, const ty_enclosed_def* def,
                                 ty_enclosed** out, ty_enclosed_stats* stats);

#endif
