/* The solid dielectrics around a point of a path, nested by priority (Schmidt and Budge 2002). */
#ifndef TY_SCENE_INSIDE_K_H
#define TY_SCENE_INSIDE_K_H

#include "scene/scene.h"

enum { TY_INSIDE_MAX = 8 };

/* Interiors that were entered and not left, in any order; one that was entered twice is listed twice. Further ones than
 * TY_INSIDE_MAX are forgotten. */
typedef struct ty_inside {
    int32_t top; /* the interior that fills the point: that of highest priority; 0: none */
    int32_t count;
    int32_t number[TY_INSIDE_MAX];
} ty_inside;

TY_FN void ty_inside_find_top(TY_GLOBAL const ty_interior* interiors, ty_inside* inside) {
    inside->top = 0;
    for (int32_t i = 0; i < inside->count; ++i) {
        const int32_t number = inside->number[i], priority = interiors[number].priority;
        const int32_t best = interiors[inside->top].priority;
        if (priority > best || (priority == best && number < inside->top)) inside->top = number;
    }
}

TY_FN void ty_inside_enter(TY_GLOBAL const ty_interior* interiors, int32_t interior, ty_inside* inside) {
    if (inside->count < TY_INSIDE_MAX) inside->number[inside->count++] = interior;
    ty_inside_find_top(interiors, inside);
}

/* Leaving an interior that was not entered changes nothing. */
TY_FN void ty_inside_leave(TY_GLOBAL const ty_interior* interiors, int32_t interior, ty_inside* inside) {
    int32_t i = 0;
    while (i < inside->count && inside->number[i] != interior) ++i;
    if (i == inside->count) return;
    inside->number[i] = inside->number[--inside->count];
    ty_inside_find_top(interiors, inside);
}

/* State beyond a hit of a dielectric's boundary. */
TY_FN ty_inside ty_inside_beyond(TY_GLOBAL const ty_interior* interiors, const ty_inside* inside, int32_t interior,
                                 const ty_hit* hit, ty_vec direction) {
    ty_inside beyond = *inside;
    if (ty_dot(hit->normal, direction) < 0.0f)
        ty_inside_enter(interiors, interior, &beyond);
    else
        ty_inside_leave(interiors, interior, &beyond);
    return beyond;
}

#endif
