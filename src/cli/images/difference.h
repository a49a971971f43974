/* Differences of images as JSON and as heat maps. */
#ifndef TY_CLI_IMAGES_DIFFERENCE_H
#define TY_CLI_IMAGES_DIFFERENCE_H

#include "cli/text/json.h"

#include <tyndall/tyndall.h>

/* The slots of a ty_difference: R, G, B, all. */
extern const char* const cli_difference_names[4];

/* Writes the members of a difference into the open object. */
void cli_difference_json(json_writer* json, const ty_difference* difference);

/* Writes a PNG of the common pixels: red where a is brighter than b, blue where it is darker, saturated at a difference
 * of 100 % of max(b, mean(b) / 10); green where a value is not finite. */
ty_result cli_write_heat_map(ty_context* context, const ty_image* a, const ty_image* b, const char* path);

#endif
