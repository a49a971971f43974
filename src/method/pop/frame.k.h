/* Where the cells of an ordinate's grid lie: boxes along its direction, or shells about its point. */
#ifndef TY_METHOD_POP_FRAME_K_H
#define TY_METHOD_POP_FRAME_K_H

#include "base/octahedral.k.h"
#include "method/pop/ordinate.h"

/* Cells i, j, k: light travels with k. Parallel: boxes along three axes at right angles. Radial: i and j are
 * coordinates of an octahedral map, whose edges are joined to themselves; shells k grow by a constant factor. */
typedef struct ty_pop_frame {
    int32_t kind;    /* TY_DISCRETE_DIRECTIONAL, TY_DISCRETE_POINT */
    int32_t size[3]; /* radial: size[0] is size[1] */
    ty_vec axis[3];  /* parallel: unit; axis[2] is the ordinate's direction */
    ty_vec origin;   /* parallel: the corner of cell 0, 0, 0; radial: the point; m */
    ty_vec step;     /* parallel: edges of cells, m */
    float inner;     /* radial: radius at which shell 0 begins, m */
    float growth;    /* radial: natural logarithm of the ratio of radii of shells */
} ty_pop_frame;

/* A ring of cells around i and j of radial grids, where whoever keeps them has one. */
TY_FN int32_t ty_pop_ring(const ty_pop_frame* frame) {
    return frame->kind == TY_DISCRETE_POINT ? 1 : 0;
}

/* Cells of a grid with its ring. */
TY_FN size_t ty_pop_ringed_cells(const ty_pop_frame* frame) {
    const size_t ring = 2 * (size_t)ty_pop_ring(frame);
    return ((size_t)frame->size[0] + ring) * ((size_t)frame->size[1] + ring) * (size_t)frame->size[2];
}

/* The radius of a shell's place k, in shells, m. */
TY_FN float ty_pop_radius(const ty_pop_frame* frame, float k) {
    return frame->inner * ty_expf(frame->growth * k);
}

/* The way light travels in column i, j. */
TY_FN ty_vec ty_pop_way(const ty_pop_frame* frame, int32_t i, int32_t j) {
    if (frame->kind == TY_DISCRETE_DIRECTIONAL) return frame->axis[2];
    return ty_octahedral_direction(((float)i + 0.5f) * (2.0f / (float)frame->size[0]) - 1.0f,
                                   ((float)j + 0.5f) * (2.0f / (float)frame->size[1]) - 1.0f);
}

/* The middle of a cell, m. */
TY_FN ty_vec ty_pop_middle(const ty_pop_frame* frame, int32_t i, int32_t j, int32_t k) {
    if (frame->kind == TY_DISCRETE_POINT)
        return ty_mad(frame->origin, ty_pop_way(frame, i, j), ty_pop_radius(frame, (float)k + 0.5f));
    const ty_vec across = ty_mad(frame->origin, frame->axis[0], ((float)i + 0.5f) * frame->step.x);
    return ty_mad(ty_mad(across, frame->axis[1], ((float)j + 0.5f) * frame->step.y), frame->axis[2],
                  ((float)k + 0.5f) * frame->step.z);
}

/* A cell's length along the light's way, m. */
TY_FN float ty_pop_length(const ty_pop_frame* frame, int32_t k) {
    if (frame->kind == TY_DISCRETE_DIRECTIONAL) return frame->step.z;
    return ty_pop_radius(frame, (float)k + 1.0f) - ty_pop_radius(frame, (float)k);
}

/* A point between the middles of ringed cells; beyond the outer ones it is at them. */
typedef struct ty_pop_place {
    size_t base;    /* the lowest of eight cells */
    size_t step[3]; /* to the next along each axis, 0 at the upper edge */
    float share[3];
    float spread; /* times which what radial grids keep is to be taken: 1 / r^2; 1 for parallel ones */
} ty_pop_place;

/* Along one axis of `size` cells; at: in cells. */
TY_FN void ty_pop_place_along(float at, int32_t size, size_t stride, int32_t axis, ty_pop_place* place) {
    const float from = ty_clampf(at - 0.5f, 0.0f, (float)(size - 1));
    const int32_t cell = (int32_t)from;
    place->share[axis] = from - (float)cell;
    place->base += stride * (size_t)cell;
    place->step[axis] = cell + 1 < size ? stride : 0;
}

/* Where a point is. least: the distance below which a radial ordinate's 1 / r^2 is held, m. */
TY_FN ty_pop_place ty_pop_locate(const ty_pop_frame* frame, float least, ty_vec point) {
    ty_pop_place place;
    const ty_vec off = ty_sub(point, frame->origin);
    place.base = 0;
    place.spread = 1.0f;
    if (frame->kind == TY_DISCRETE_DIRECTIONAL) {
        const size_t row = (size_t)frame->size[0], slice = row * (size_t)frame->size[1];
        ty_pop_place_along(ty_dot(off, frame->axis[0]) / frame->step.x, frame->size[0], 1, 0, &place);
        ty_pop_place_along(ty_dot(off, frame->axis[1]) / frame->step.y, frame->size[1], row, 1, &place);
        ty_pop_place_along(ty_dot(off, frame->axis[2]) / frame->step.z, frame->size[2], slice, 2, &place);
        return place;
    }
    const int32_t n = frame->size[0];
    const size_t row = (size_t)n + 2, slice = row * row;
    const float distance = sqrtf(ty_maxf(ty_dot(off, off), 1e-30f)), held = ty_maxf(distance, ty_maxf(least, 1e-6f));
    float u, v;
    ty_octahedral_map(distance > 1e-12f ? off : ty_vec_make(0.0f, 0.0f, 1.0f), &u, &v);
    ty_pop_place_along((u + 1.0f) * 0.5f * (float)n + 1.0f, n + 2, 1, 0, &place);
    ty_pop_place_along((v + 1.0f) * 0.5f * (float)n + 1.0f, n + 2, row, 1, &place);
    ty_pop_place_along(ty_logf(distance / frame->inner) / frame->growth, frame->size[2], slice, 2, &place);
    place.spread = 1.0f / (held * held);
    return place;
}

#endif
