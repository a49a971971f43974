/* Closed triangle meshes that media fill. */
#ifndef TY_SCENE_SHELL_H
#define TY_SCENE_SHELL_H

#include "scene/mesh.h"

#include <tyndall/scene.h>

struct ty_shell {
    ty_context* context;
    _Atomic int32_t owners;
    ty_triangles* triangles;
    ty_mesh* mesh;
};

size_t ty_shell_bytes(const ty_shell* shell);

#endif
