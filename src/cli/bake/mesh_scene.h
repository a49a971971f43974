/* A mesh file as a scene of its own. */
#ifndef TY_CLI_BAKE_MESH_SCENE_H
#define TY_CLI_BAKE_MESH_SCENE_H

#include "cli/session/session.h"

/* Wraps a single mesh file as a scene; overrides can add lights and media. */
ty_result cli_load_mesh_scene(cli_session* session, const char* path, const cli_list* overrides, ty_scene** out);

/* True if two meshes belong to the same node of a file. */
bool cli_same_node(const ty_mesh_def* a, const ty_mesh_def* b);

#endif
