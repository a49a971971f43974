/* Ranks other than 0 of commands that trace paths or solve. */
#ifndef TY_CLI_METHODS_HELP_PATHS_H
#define TY_CLI_METHODS_HELP_PATHS_H

#include "cli/options/options.h"
#include "cli/session/session.h"

/* Reads the scene, as rank 0 does, traces paths for rank 0, and takes part in its solves; then closes the session, and
 * returns the exit status. scene_path NULL: there is none, and no work. follows: the scene changes as that of rank 0
 * does (ty_queue_tell). */
int cli_help_paths(cli_session* session, const char* scene_path, const cli_list* overrides, bool follows);

#endif
