/* Tree of positioned lights, and its input. */
#ifndef TY_SCENE_LIGHTS_LIGHT_TREE_H
#define TY_SCENE_LIGHTS_LIGHT_TREE_H

#include "scene/lights/light_tree.k.h"

#include <tyndall/base.h>

/* Maximum depth of a light below the root. */
enum { TY_LIGHT_TREE_DEPTH = 60 };

/* Bounds of a light. */
typedef struct ty_light_bounds {
    ty_vec lower, upper; /* m */
    float power;         /* peak intensity, mean of the channels, W sr^-1; 0: not in the tree */
    ty_vec axis;         /* unit */
    float cos_o, cos_e;  /* emission reaches at most theta_o + theta_e from the axis; peak intensity up to theta_o, then
                            at most the cosine of the angle beyond theta_o */
    int32_t is_local;    /* local light (point, spot, area, triangle), which media sample along rays */
} ty_light_bounds;

typedef struct ty_light_tree {
    ty_light_node* nodes; /* NULL: no positioned lights */
    uint64_t* trails;     /* per light, from bit 0: 1 where the path from the root takes the second child */
    size_t node_count, light_count;
} ty_light_tree;

/* Returns false, with power 0, for distant lights (directional, environment) and black ones. */
bool ty_light_get_bounds(const ty_light_view* light, ty_light_bounds* out);

/* Light numbers are indices into bounds. Errors: TY_ERROR_MEMORY. */
ty_result ty_light_tree_create(ty_context* context, const ty_light_bounds* bounds, size_t count, ty_light_tree** out);
void ty_light_tree_destroy(ty_context* context, ty_light_tree* tree);
size_t ty_light_tree_bytes(const ty_light_tree* tree);

#endif
