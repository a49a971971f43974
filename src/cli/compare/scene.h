/* A scene, rendered by methods. */
#ifndef TY_CLI_COMPARE_SCENE_H
#define TY_CLI_COMPARE_SCENE_H

#include "cli/compare/comparison.h"
#include "cli/methods.h"

/* The methods that "path,fld" names: how many; -1, after a message, when one is not known. */
int cli_name_methods(const char* words, const cli_method* out[CLI_COMPARE_MAX]);

/* Renders the scene by what applies to it, takes down why others do not, and compares all with the reference, which is
 * read or rendered; images are in the folder then. CLI_GO, or an exit status after a message. */
int cli_compare_scene(cli_session* session, cli_comparison* comparison, const ty_scene* scene,
                      const cli_compare_request* options);

#endif
