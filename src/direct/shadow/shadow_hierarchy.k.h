/* Hierarchical traversal of a straight line across a face. */
#ifndef TY_DIRECT_SHADOW_SHADOW_HIERARCHY_K_H
#define TY_DIRECT_SHADOW_SHADOW_HIERARCHY_K_H

#include "direct/shadow/shadow_hierarchy.h"

/* An interval of a ray, m. */
typedef struct ty_ray_interval {
    float from, to;
} ty_ray_interval;

/* Clips an interval to value + t slope >= 0; false if it becomes empty. */
TY_FN bool ty_ray_interval_clip(float value, float slope, ty_ray_interval* interval) {
    if (slope > 0.0f)
        interval->from = ty_maxf(interval->from, -value / slope);
    else if (slope < 0.0f)
        interval->to = ty_minf(interval->to, -value / slope);
    else if (value < 0.0f)
        return false;
    return interval->from < interval->to;
}

/* Clips an interval to the cone around a spot light's axis with this cosine of its half angle, at least 0 up to
 * rounding, so that the cone is convex; false if it becomes empty. */
TY_FN bool ty_ray_interval_clip_cone(const ty_light_view* light, float cosine, ty_vec origin, ty_vec direction,
                                     ty_ray_interval* interval) {
    const ty_vec off = ty_sub(origin, light->position);
    const float ahead = ty_dot(off, light->direction), along = ty_dot(direction, light->direction);
    if (!ty_ray_interval_clip(ahead, along, interval)) return false;
    const double square = (double)cosine * (double)cosine;
    const double a = (double)along * (double)along - square;
    const double b = (double)ahead * (double)along - square * (double)ty_dot(off, direction);
    const double c = (double)ahead * (double)ahead - square * (double)ty_dot(off, off);
    const double root = b * b - a * c;
    if (a == 0) return ty_ray_interval_clip((float)c, (float)(2 * b), interval);
    if (root <= 0) return a > 0;
    const double q = -(b + copysign(sqrt(root), b));
    const double first = fmin(q / a, c / q), second = fmax(q / a, c / q);
    /* The ray is inside the double cone between the roots, or, if it runs along the axis, outside them. */
    if (a < 0 || along < 0) interval->to = ty_minf(interval->to, (float)(a < 0 ? second : first));
    if (a < 0 || along > 0) interval->from = ty_maxf(interval->from, (float)(a < 0 ? first : second));
    return interval->from < interval->to;
}

/* The lit segments found so far; the gaps between them are in shadow. */
typedef struct ty_lit_segments {
    float (*segments)[2];
    int32_t count;
    int32_t lit; /* whether the last segment is still open */
    float at;    /* start of the open segment, or end of the last one */
} ty_lit_segments;

/* Merges the two segments with the shortest gap. */
TY_FN void ty_lit_segments_merge(ty_lit_segments* list) {
    int32_t best = 1;
    for (int32_t i = 2; i < list->count; ++i)
        if (list->segments[i][0] - list->segments[i - 1][1] < list->segments[best][0] - list->segments[best - 1][1])
            best = i;
    list->segments[best - 1][1] = list->segments[best][1];
    for (int32_t i = best + 1; i < list->count; ++i)
        for (int k = 0; k < 2; ++k) list->segments[i - 1][k] = list->segments[i][k];
    --list->count;
}

TY_FN void ty_lit_segments_append(ty_lit_segments* list, float from, float to) {
    if (!(from < to)) return;
    if (list->count > 0 && !(list->segments[list->count - 1][1] < from)) {
        list->segments[list->count - 1][1] = to;
        return;
    }
    if (list->count == TY_LIT_SEGMENTS_MAX) ty_lit_segments_merge(list);
    list->segments[list->count][0] = from;
    list->segments[list->count++][1] = to;
}

/* Switches to lit or to shadow at distance t. */
TY_FN void ty_lit_segments_switch(ty_lit_segments* list, float t, int32_t lit) {
    if (list->lit == lit) return;
    t = ty_maxf(t, list->at);
    if (list->lit != 0) ty_lit_segments_append(list, list->at, t);
    list->lit = lit;
    list->at = t;
}

/* A ray's interval projected on a face: at u in [0, 1] it is over texel (x + u dx, y + u dy). */
typedef struct ty_shadow_line {
    float x, y, inverse_depth; /* at u = 0 */
    float dx, dy, inverse_depth_change;
    float from, length; /* along the ray, m */
    float depth[2];     /* at both ends; 1 for directional lights */
} ty_shadow_line;

TY_FN float ty_shadow_line_distance(const ty_shadow_line* line, float u) {
    const float ahead = u * line->depth[0];
    return line->from + line->length * ahead / (ahead + (1.0f - u) * line->depth[1]);
}

/* Crosses one texel from u to `leave`; visibility changes where the line crosses the texel's depth. */
TY_FN void ty_shadow_cross_texel(const ty_shadow_line* line, float texel, float u, float leave, ty_lit_segments* list) {
    const float above = line->inverse_depth + u * line->inverse_depth_change - texel,
                above_leave = line->inverse_depth + leave * line->inverse_depth_change - texel;
    const int32_t lit = above >= 0.0f, lit_leave = above_leave >= 0.0f;
    if (lit != list->lit) ty_lit_segments_switch(list, ty_shadow_line_distance(line, u), lit);
    if (lit == lit_leave) return;
    const float fraction = above / (above - above_leave);
    ty_lit_segments_switch(list, ty_shadow_line_distance(line, u + (leave - u) * fraction), lit_leave);
}

/* Compares the line between u and `leave` with a block: 1 in front of all texels, 0 behind all of them, -1 undecided.
 */
TY_FN int32_t ty_shadow_compare(const ty_shadow_line* line, ty_shadow_range range, float u, float leave) {
    const float a = line->inverse_depth + u * line->inverse_depth_change,
                b = line->inverse_depth + leave * line->inverse_depth_change;
    if (ty_minf(a, b) >= range.max) return 1;
    return ty_maxf(a, b) < range.min ? 0 : -1;
}

/* Bounds a slope away from 0, so that no line is parallel to an axis. */
TY_FN float ty_shadow_slope(float d) {
    return fabsf(d) < 1e-6f ? 1e-6f : d;
}

TY_FN int32_t ty_shadow_clamp(int32_t value, int32_t low, int32_t high) {
    return value < low ? low : value > high ? high : value;
}

/* The start level: its blocks are about as large as the line is long. */
TY_FN int32_t ty_shadow_first_level(const ty_shadow_line* line, int32_t top) {
    const float reach = 2.0f * ty_maxf(fabsf(ty_shadow_slope(line->dx)), fabsf(ty_shadow_slope(line->dy)));
    int32_t level = 0;
    while (level < top && reach > (float)(4 << level)) ++level;
    return level;
}

/* Traverses the hierarchy: one level up at the edge of a parent block, one level down where a block is undecided. */
TY_FN void ty_shadow_traverse(const ty_shadow_face* face, const ty_shadow_line* line, int32_t side, int32_t top,
                              ty_lit_segments* list) {
    const float dx = ty_shadow_slope(line->dx), dy = ty_shadow_slope(line->dy);
    const float per_x = 1.0f / dx, per_y = 1.0f / dy;
    const int32_t ahead_x = dx > 0.0f, ahead_y = dy > 0.0f;
    int32_t x = ty_shadow_clamp((int32_t)line->x, 0, side - 1), y = ty_shadow_clamp((int32_t)line->y, 0, side - 1);
    int32_t level = ty_shadow_first_level(line, top);
    float u = 0.0f;
    for (;;) {
        const int32_t block_x = x >> level, block_y = y >> level;
        const int32_t edge_x = (block_x + ahead_x) << level, edge_y = (block_y + ahead_y) << level;
        const float u_x = ((float)edge_x - line->x) * per_x, u_y = ((float)edge_y - line->y) * per_y;
        const float leave = ty_maxf(u, ty_minf(ty_minf(u_x, u_y), 1.0f));
        if (level == 0) {
            ty_shadow_cross_texel(line, face->texels[(size_t)y * (size_t)side + (size_t)x], u, leave, list);
        } else {
            const size_t width = ((size_t)side + ((size_t)1 << level) - 1) >> level;
            const ty_shadow_range range = face->levels[level][(size_t)block_y * width + (size_t)block_x];
            const int32_t lit = ty_shadow_compare(line, range, u, leave);
            if (lit < 0) {
                --level;
                continue;
            }
            if (lit != list->lit) ty_lit_segments_switch(list, ty_shadow_line_distance(line, u), lit);
        }
        if (leave >= 1.0f) return;
        const int32_t last = (1 << level) - 1;
        int32_t block;
        if (u_x < u_y) {
            x = ahead_x != 0 ? edge_x : edge_x - 1;
            y = ty_shadow_clamp((int32_t)(line->y + leave * dy), block_y << level, (block_y << level) + last);
            block = block_x;
        } else {
            y = ahead_y != 0 ? edge_y : edge_y - 1;
            x = ty_shadow_clamp((int32_t)(line->x + leave * dx), block_x << level, (block_x << level) + last);
            block = block_y;
        }
        if (x < 0 || y < 0 || x >= side || y >= side) return;
        if (level < top && (block & 1) == (u_x < u_y ? ahead_x : ahead_y)) ++level;
        u = leave;
    }
}

#endif
