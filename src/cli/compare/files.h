/* Output files of `tyndall compare`. */
#ifndef TY_CLI_COMPARE_FILES_H
#define TY_CLI_COMPARE_FILES_H

#include "cli/compare/comparison.h"

/* Writes report.html, errors.json, table.md, side.png, a heat_NAME.png for each entry and a view_NAME.png for each
 * image into the folder; CLI_DONE or an exit status after a message. */
int cli_write_comparison(cli_session* session, const cli_comparison* comparison);

/* Writes the members of errors.json into the open object; user is the cli_comparison (cli_session.stats). */
void cli_comparison_json(json_writer* json, const void* user);
/* The text of the scene and its overrides. */
void cli_comparison_scene_json(json_writer* json, const cli_comparison* comparison);

/* A cli_print_fn for the table of table.md; user is the cli_comparison. */
ty_result cli_print_comparison_table(ty_context* context, FILE* file, const void* user);

/* The path folder/prefix NAME extension; the caller frees it. NULL, after a message, when memory is short. */
char* cli_comparison_path(const char* folder, const char* prefix, const char* name, const char* extension);

#endif
