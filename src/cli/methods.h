/* The methods that render scenes: one table for all commands. */
#ifndef TY_CLI_METHODS_H
#define TY_CLI_METHODS_H

#include <tyndall/tyndall.h>

typedef struct cli_method {
    const char* name;
    const char* summary;
    ty_result (*render)(const ty_scene* scene, const ty_path_def* def, ty_image** out, ty_path_stats* stats);
} cli_method;

/* NULL, after a message that names the known ones, if there is none of that name. */
const cli_method* cli_find_method(const char* command, const char* name);

#endif
