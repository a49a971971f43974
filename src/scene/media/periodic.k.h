/* Rays through a cell that repeats along some axes: they leave by one face and come in by the opposite one. */
#ifndef TY_SCENE_MEDIA_PERIODIC_K_H
#define TY_SCENE_MEDIA_PERIODIC_K_H

#include "base/vector.k.h"

/* Pieces of a ray at most. Only rays that hardly rise or fall have so many; the rest of them is lost. */
enum { TY_PERIODIC_PIECES_MAX = 1 << 16 };

/* The cell of a committed scene. */
typedef struct ty_periodic_view {
    int32_t axes;             /* bit a: the scene repeats along axis a; 0: it does not repeat */
    float lower[3], upper[3]; /* the cell; along other axes all media and surfaces lie within it, m */
} ty_periodic_view;

/* A piece of a ray, from one face of the cell to the next. */
typedef struct ty_periodic_walk {
    ty_vec origin, direction; /* origin: of the piece, in the cell */
    float passed;             /* distance of that origin from the ray's own, m */
    float far;                /* length of the piece, m */
    float left;               /* from the piece's origin to where the ray leaves the scene, m */
    int32_t axis;             /* the piece ends at a face across this axis; -1: where the ray leaves the scene */
    int32_t pieces;
} ty_periodic_walk;

TY_FN void ty_periodic_walk_measure(ty_periodic_walk* walk, TY_GLOBAL const ty_periodic_view* cell) {
    const float o[3] = {walk->origin.x, walk->origin.y, walk->origin.z};
    const float d[3] = {walk->direction.x, walk->direction.y, walk->direction.z};
    walk->far = walk->left;
    walk->axis = -1;
    for (int32_t a = 0; a < 3; ++a) {
        if ((cell->axes >> a & 1) == 0 || d[a] == 0.0f) continue;
        const float t = ty_maxf(((d[a] > 0.0f ? cell->upper[a] : cell->lower[a]) - o[a]) / d[a], 0.0f);
        if (t >= walk->far) continue;
        walk->far = t;
        walk->axis = a;
    }
}

/* The image of a point that lies in the cell. */
TY_FN ty_vec ty_periodic_point(TY_GLOBAL const ty_periodic_view* cell, ty_vec point) {
    float o[3] = {point.x, point.y, point.z};
    for (int32_t a = 0; a < 3; ++a) {
        if ((cell->axes >> a & 1) == 0) continue;
        const float width = cell->upper[a] - cell->lower[a];
        o[a] = ty_clampf(o[a] - width * floorf((o[a] - cell->lower[a]) / width), cell->lower[a], cell->upper[a]);
    }
    return ty_vec_make(o[0], o[1], o[2]);
}

/* Begins at the ray's first piece that may meet anything; false: no piece does. direction is unit. */
TY_FN bool ty_periodic_walk_begin(ty_periodic_walk* walk, TY_GLOBAL const ty_periodic_view* cell, ty_vec origin,
                                  ty_vec direction) {
    const float o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    float enter = 0.0f, leave = TY_FLOAT_MAX;
    for (int32_t a = 0; a < 3; ++a) {
        if ((cell->axes >> a & 1) != 0) continue;
        if (d[a] == 0.0f) {
            if (o[a] < cell->lower[a] || o[a] > cell->upper[a]) return false;
            continue;
        }
        const float low = (cell->lower[a] - o[a]) / d[a], high = (cell->upper[a] - o[a]) / d[a];
        enter = ty_maxf(enter, ty_minf(low, high));
        leave = ty_minf(leave, ty_maxf(low, high));
    }
    if (!(enter < leave)) return false;
    walk->origin = ty_periodic_point(cell, ty_mad(origin, direction, enter));
    walk->direction = direction;
    walk->passed = enter;
    walk->left = leave - enter;
    walk->pieces = 1;
    ty_periodic_walk_measure(walk, cell);
    return true;
}

/* The next piece; false: the ray has left the scene. */
TY_FN bool ty_periodic_walk_next(ty_periodic_walk* walk, TY_GLOBAL const ty_periodic_view* cell) {
    if (walk->axis < 0 || walk->pieces >= TY_PERIODIC_PIECES_MAX) return false;
    float o[3] = {walk->origin.x, walk->origin.y, walk->origin.z};
    const float d[3] = {walk->direction.x, walk->direction.y, walk->direction.z};
    for (int32_t a = 0; a < 3; ++a) {
        o[a] += d[a] * walk->far;
        if (a == walk->axis)
            o[a] = d[a] > 0.0f ? cell->lower[a] : cell->upper[a];
        else if ((cell->axes >> a & 1) != 0)
            o[a] = ty_clampf(o[a], cell->lower[a], cell->upper[a]);
    }
    walk->origin = ty_vec_make(o[0], o[1], o[2]);
    walk->passed += walk->far;
    walk->left -= walk->far;
    ++walk->pieces;
    ty_periodic_walk_measure(walk, cell);
    return true;
}

/* True if the ray was cut off before it left the scene. */
TY_FN bool ty_periodic_walk_is_lost(const ty_periodic_walk* walk) {
    return walk->pieces >= TY_PERIODIC_PIECES_MAX && walk->axis >= 0;
}

#endif
