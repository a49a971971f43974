/* Pixels that outlines of emitters cross: emission that the camera sees itself is most of their noise. */
#ifndef TY_METHOD_PATH_OUTLINES_H
#define TY_METHOD_PATH_OUTLINES_H

#include "method/path/driver.h"

/* Finds them by a few rays through each item of a run over pixels; run->outlines and the request's stay NULL if there
 * are none. Random numbers are not those of paths, so that the choice leaves the mean of samples. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_path_find_outlines(ty_path_run* run);

#endif
