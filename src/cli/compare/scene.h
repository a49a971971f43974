/* Rendering a scene by several methods. */
#ifndef TY_CLI_COMPARE_SCENE_H
#define TY_CLI_COMPARE_SCENE_H

#include "cli/compare/comparison.h"
#include "cli/methods/methods.h"

/* Parses "path,fld" into methods; returns their number, or -1, after a message, for an unknown name. */
int cli_name_methods(const char* words, const ty_method* out[CLI_COMPARE_MAX]);

/* Renders the scene by all applicable methods, records the errors of the others, and compares all with the reference,
 * which is read or rendered; the images are written to the folder. CLI_GO, or an exit status after a message. */
int cli_compare_scene(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                      const cli_compare_request* options);

#endif
