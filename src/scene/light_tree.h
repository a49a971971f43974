/* The tree of lights that have a place, and what it is built from. */
#ifndef TY_SCENE_LIGHT_TREE_H
#define TY_SCENE_LIGHT_TREE_H

#include "scene/light_tree.k.h"

#include <tyndall/base.h>

/* No path from the root to a light has more steps. */
enum { TY_LIGHT_TREE_DEPTH = 60 };

/* What the tree knows of a light. */
typedef struct ty_light_bounds {
    ty_vec lower, upper; /* m */
    float power;         /* intensity where it is highest, mean of the channels, W sr^-1; 0: not in the tree */
    ty_vec axis;         /* unit */
    float cos_o, cos_e;  /* light leaves at up to theta_o + theta_e from the axis; up to theta_o it is as bright as on
                            it, then it may fall off as the cosine of what is beyond theta_o */
    int32_t lamp;        /* whether rays in media pick it (point, spot, area, triangle) */
} ty_light_bounds;

typedef struct ty_light_tree {
    ty_light_node* nodes; /* NULL: no light has a place */
    uint64_t* trails;     /* per light, from bit 0: 1 where the way from the root takes the second child */
    size_t node_count, light_count;
} ty_light_tree;

/* Returns false, with power 0, for lights that have no place (directional, environment) or are black. */
bool ty_light_get_bounds(const ty_light_view* light, ty_light_bounds* out);

/* Light numbers are indices into bounds. Errors: TY_ERROR_MEMORY. */
ty_result ty_light_tree_create(ty_context* context, const ty_light_bounds* bounds, size_t count, ty_light_tree** out);
void ty_light_tree_destroy(ty_context* context, ty_light_tree* tree);
size_t ty_light_tree_bytes(const ty_light_tree* tree);

#endif
