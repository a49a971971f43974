/* Items of the row loops of point lights: a ray in a slab, and the optical depth around a cell. */
#ifndef TY_DIRECT_UNCOLLIDED_POINT_ROWS_K_H
#define TY_DIRECT_UNCOLLIDED_POINT_ROWS_K_H

#include "direct/uncollided/kernel.h"

/* Where a ray meets a slab. */
typedef struct ty_ray_place {
    float from;             /* where the ray begins in it, m along w */
    float passed;           /* length since its entry into the box, m along w; not positive: it has not entered yet */
    int32_t base;           /* offset of the first of four cells around the middle of its way */
    int32_t next_u, next_v; /* to the others */
    float t, row_t;         /* their weights along u and v */
} ty_ray_place;

TY_FN ty_ray_place ty_ray_row_place(const ty_ray_row* r, int32_t i, float entry) {
    ty_ray_place p;
    const int32_t last_u = r->size[0] - 1, last_v = r->size[1] - 1;
    const float index = (float)i;
    p.from = ty_minf(r->far, ty_maxf(r->near, entry));
    const float back = 0.5f * (r->far - p.from);
    const float u =
        ty_clampf(r->at[0] + r->at[1] * index - (r->slope[0] + r->slope[1] * index) * back, 0.0f, (float)last_u);
    const float v = ty_clampf(r->row - r->row_slope * back, 0.0f, (float)last_v);
    const int32_t cell_u = (int32_t)u, cell_v = (int32_t)v;
    p.base = cell_u * r->stride[0] + cell_v * r->stride[1];
    p.next_u = cell_u < last_u ? r->stride[0] : 0;
    p.next_v = cell_v < last_v ? r->stride[1] : 0;
    p.t = u - (float)cell_u;
    p.row_t = v - (float)cell_v;
    p.passed = r->near - entry;
    return p;
}

/* Where a cell is from the light. */
typedef struct ty_cell_place {
    float to[3]; /* unit, from the light along u, v, w */
    float per_distance;
    float in_media; /* optical depth at the center over the rays' mean extinction, m */
    float slope[3]; /* as of ty_cell_depth */
} ty_cell_place;

TY_FN ty_cell_place ty_cell_row_place_at(const ty_cell_row_means* c, int32_t i) {
    const float index = (float)i, off = c->off[0] + c->off[1] * index, side = c->side[0] + c->side[1] * index;
    ty_cell_place p;
    p.per_distance = 1.0f / sqrtf(off * off + c->v * c->v + c->w * c->w);
    p.to[0] = off * p.per_distance;
    p.to[1] = c->v * p.per_distance;
    p.to[2] = c->w * p.per_distance;
    const float inside_u = c->outside != 0 ? c->w * side / off : TY_FLOAT_MAX;
    const float inside = ty_minf(inside_u, c->inside);
    const float t = ty_clampf(inside / c->w, 0.0f, 1.0f), outside = 1.0f - t;
    const bool by_u = inside_u < c->inside;
    p.in_media = t / p.per_distance;
    p.slope[0] = p.to[0] * t + (by_u ? outside / p.to[0] : 0.0f);
    p.slope[1] = p.to[1] * t + (!by_u && c->across_v != 0 ? outside / p.to[1] : 0.0f);
    p.slope[2] = p.to[2] * t + (!by_u && c->across_v == 0 ? outside / p.to[2] : 0.0f);
    return p;
}

/* The lattice column at a cell's center: a ray, and the weight of the next one. */
TY_FN int32_t ty_cell_row_column(const ty_cell_row_means* c, int32_t i, float* t) {
    const float at = ty_clampf(c->column[0] + c->column[1] * (float)i, 0.0f, (float)(c->rays - 1));
    const int32_t whole = (int32_t)at, ray = whole < c->rays - 2 ? whole : c->rays - 2;
    *t = at - (float)ray;
    return ray;
}

#endif
