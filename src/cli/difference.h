/* How images differ, as JSON and as heat maps. */
#ifndef TY_CLI_DIFFERENCE_H
#define TY_CLI_DIFFERENCE_H

#include "cli/json.h"

#include <tyndall/tyndall.h>

/* The slots of a ty_difference: R, G, B, all. */
extern const char* const cli_difference_names[4];

/* The members of a difference, into the object that is open. */
void cli_difference_json(json_writer* json, const ty_difference* difference);

/* A PNG of where both images have pixels: red where a is brighter than b, blue where it is darker, full at 100 percent
 * of b or of a tenth of b's mean, whichever is larger; green where a value is not finite. */
ty_result cli_write_heat_map(ty_context* context, const ty_image* a, const ty_image* b, const char* path);

#endif
