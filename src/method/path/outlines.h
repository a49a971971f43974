/* Pixels that outlines of emitters cross: emission that the camera sees itself is most of their noise. */
#ifndef TY_METHOD_PATH_OUTLINES_H
#define TY_METHOD_PATH_OUTLINES_H

#include "method/path/driver.h"

/* Memory for them, if any surface of a run over pixels emits; otherwise run->outlines and the request's stay NULL.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_path_prepare_outlines(ty_path_run* run);

/* Finds them, once, by a few rays through each item. Random numbers are not those of paths, so that the choice leaves
 * the mean of samples. */
void ty_path_find_outlines(ty_path_run* run);

#endif
