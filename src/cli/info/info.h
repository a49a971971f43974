/* The file types of tyndall info; each function prints to stdout and returns an exit status. */
#ifndef TY_CLI_INFO_INFO_H
#define TY_CLI_INFO_INFO_H

#include "cli/session/session.h"
#include "cli/text/json.h"

#include <tyndall/io.h>

int cli_info_scene(cli_session* session, const char* path, const cli_list* overrides, bool json);
/* The plan of its solves by dom and fld among so many ranks. */
int cli_info_ranks(cli_session* session, const char* path, const cli_list* overrides, int32_t ranks, bool as_json);
int cli_info_volume(cli_session* session, const char* path, bool json);
int cli_info_image(cli_session* session, const char* path, bool json);
int cli_info_mesh(cli_session* session, const char* path, bool json);
/* Prints the coefficients of a medium in words (ty_medium_parse); NULL: all named media. */
int cli_info_media(cli_session* session, const char* medium, bool json);

/* A material, printed after its name, or as members of the open object. */
void cli_print_material(const ty_mesh_file_entry* entry);
void cli_write_material(json_writer* json, const ty_mesh_file_entry* entry);

/* The storage of a grid by its name, and what is said before the bytes that it takes. */
const char* cli_storage_name(ty_grid_storage storage);
const char* cli_storage_note(ty_grid_storage storage);

/* Prints "(1, 2, 3)" between label and after. */
void cli_print_vector(const char* label, const double v[3], const char* after);

#endif
