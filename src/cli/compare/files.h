/* What `tyndall compare` writes. */
#ifndef TY_CLI_COMPARE_FILES_H
#define TY_CLI_COMPARE_FILES_H

#include "cli/compare/comparison.h"

/* report.html, errors.json, table.md, side.png, a heat_NAME.png for each entry and a view_NAME.png for each image, in
 * the folder; CLI_DONE or an exit status after a message. */
int cli_write_comparison(cli_session* session, const cli_comparison* comparison);

/* The members of errors.json, into the object that is open; user is the cli_comparison (cli_session.stats). */
void cli_comparison_json(json_writer* json, const void* user);
/* Text of the scene and what was changed in it. */
void cli_comparison_scene_json(json_writer* json, const cli_comparison* comparison);

/* A cli_print_fn, as table.md has it; user is the cli_comparison. */
ty_result cli_print_comparison_table(ty_context* context, FILE* file, const void* user);

/* folder/prefix NAME extension, to be freed; NULL, after a message, when memory is short. */
char* cli_comparison_path(const char* folder, const char* prefix, const char* name, const char* extension);

#endif
