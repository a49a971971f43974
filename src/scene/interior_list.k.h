/* The interior list of a path: the solid dielectrics around a point, nested by priority (Schmidt and Budge 2002). */
#ifndef TY_SCENE_INTERIOR_LIST_K_H
#define TY_SCENE_INTERIOR_LIST_K_H

#include "scene/scene.h"

enum { TY_INTERIOR_LIST_MAX = 8 };

/* Interiors that were entered and not left, in any order; one that was entered twice is listed twice. Further ones than
 * TY_INTERIOR_LIST_MAX are forgotten. */
typedef struct ty_interior_list {
    int32_t top; /* the interior that fills the point: that of highest priority; 0: none */
    int32_t count;
    int32_t number[TY_INTERIOR_LIST_MAX];
} ty_interior_list;

TY_FN void ty_interior_list_find_top(TY_GLOBAL const ty_interior* interiors, ty_interior_list* inside) {
    inside->top = 0;
    for (int32_t i = 0; i < inside->count; ++i) {
        const int32_t number = inside->number[i], priority = interiors[number].priority;
        const int32_t best = interiors[inside->top].priority;
        if (priority > best || (priority == best && number < inside->top)) inside->top = number;
    }
}

TY_FN void ty_interior_list_enter(TY_GLOBAL const ty_interior* interiors, int32_t interior, ty_interior_list* inside) {
    if (inside->count < TY_INTERIOR_LIST_MAX) inside->number[inside->count++] = interior;
    ty_interior_list_find_top(interiors, inside);
}

/* Leaving an interior that was not entered changes nothing. */
TY_FN void ty_interior_list_leave(TY_GLOBAL const ty_interior* interiors, int32_t interior, ty_interior_list* inside) {
    int32_t i = 0;
    while (i < inside->count && inside->number[i] != interior) ++i;
    if (i == inside->count) return;
    inside->number[i] = inside->number[--inside->count];
    ty_interior_list_find_top(interiors, inside);
}

/* State beyond a hit of a dielectric's boundary. */
TY_FN ty_interior_list ty_interior_list_beyond(TY_GLOBAL const ty_interior* interiors, const ty_interior_list* inside,
                                               int32_t interior, const ty_hit* hit, ty_vec direction) {
    ty_interior_list beyond = *inside;
    if (ty_dot(hit->normal, direction) < 0.0f)
        ty_interior_list_enter(interiors, interior, &beyond);
    else
        ty_interior_list_leave(interiors, interior, &beyond);
    return beyond;
}

#endif
