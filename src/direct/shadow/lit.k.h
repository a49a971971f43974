/* A straight way across a face of a map, block by block. */
#ifndef TY_DIRECT_LIT_K_H
#define TY_DIRECT_LIT_K_H

#include "direct/shadow/lit.h"

/* A part of a ray, m. */
typedef struct ty_lit_part {
    float from, to;
} ty_lit_part;

/* Cuts a part to where value + t slope >= 0; false if nothing is left. */
TY_FN bool ty_lit_keep(float value, float slope, ty_lit_part* part) {
    if (slope > 0.0f)
        part->from = ty_maxf(part->from, -value / slope);
    else if (slope < 0.0f)
        part->to = ty_minf(part->to, -value / slope);
    else if (value < 0.0f)
        return false;
    return part->from < part->to;
}

/* Cuts a part to the cone about a spot's axis of this cosine, >= 0 but for rounding, which is convex; false if nothing
 * is left. */
TY_FN bool ty_lit_keep_cone(const ty_light_view* light, float cosine, ty_vec origin, ty_vec direction,
                            ty_lit_part* part) {
    const ty_vec off = ty_sub(origin, light->position);
    const float ahead = ty_dot(off, light->direction), along = ty_dot(direction, light->direction);
    if (!ty_lit_keep(ahead, along, part)) return false;
    const double square = (double)cosine * (double)cosine;
    const double a = (double)along * (double)along - square;
    const double b = (double)ahead * (double)along - square * (double)ty_dot(off, direction);
    const double c = (double)ahead * (double)ahead - square * (double)ty_dot(off, off);
    const double root = b * b - a * c;
    if (a == 0) return ty_lit_keep((float)c, (float)(2 * b), part);
    if (root <= 0) return a > 0;
    const double q = -(b + copysign(sqrt(root), b));
    const double first = fmin(q / a, c / q), second = fmax(q / a, c / q);
    /* Within the double cone, or, where a ray goes along it, beyond one of its halves. */
    if (a < 0 || along < 0) part->to = ty_minf(part->to, (float)(a < 0 ? second : first));
    if (a < 0 || along > 0) part->from = ty_maxf(part->from, (float)(a < 0 ? first : second));
    return part->from < part->to;
}

/* Stretches as they are found; what lies between them is dark. */
typedef struct ty_lit_run {
    float (*stretches)[2];
    int32_t count;
    int32_t lit; /* whether the last one goes on */
    float at;    /* where it began, or the last one ended */
} ty_lit_run;

/* Joins two of the stretches, those nearest to one another. */
TY_FN void ty_lit_join(ty_lit_run* run) {
    int32_t best = 1;
    for (int32_t i = 2; i < run->count; ++i)
        if (run->stretches[i][0] - run->stretches[i - 1][1] < run->stretches[best][0] - run->stretches[best - 1][1])
            best = i;
    run->stretches[best - 1][1] = run->stretches[best][1];
    for (int32_t i = best + 1; i < run->count; ++i)
        for (int k = 0; k < 2; ++k) run->stretches[i - 1][k] = run->stretches[i][k];
    --run->count;
}

TY_FN void ty_lit_append(ty_lit_run* run, float from, float to) {
    if (!(from < to)) return;
    if (run->count > 0 && !(run->stretches[run->count - 1][1] < from)) {
        run->stretches[run->count - 1][1] = to;
        return;
    }
    if (run->count == TY_LIT_STRETCHES) ty_lit_join(run);
    run->stretches[run->count][0] = from;
    run->stretches[run->count++][1] = to;
}

/* From t on it is lit, or dark. */
TY_FN void ty_lit_turn(ty_lit_run* run, float t, int32_t lit) {
    if (run->lit == lit) return;
    t = ty_maxf(t, run->at);
    if (run->lit != 0) ty_lit_append(run, run->at, t);
    run->lit = lit;
    run->at = t;
}

/* A part of a ray before a face: at u in [0, 1] it is above texel x + u dx, y + u dy. */
typedef struct ty_lit_line {
    float x, y, near; /* near: nearness */
    float dx, dy, dnear;
    float from, length; /* along the ray, m */
    float depth[2];     /* at the ends; 1 both for directional lights */
} ty_lit_line;

TY_FN float ty_lit_line_at(const ty_lit_line* line, float u) {
    const float ahead = u * line->depth[0];
    return line->from + line->length * ahead / (ahead + (1.0f - u) * line->depth[1]);
}

/* Within a texel, from u to `leave`: both ends are lit or dark, or it changes where the line passes its depth. */
TY_FN void ty_lit_pass_texel(const ty_lit_line* line, float texel, float u, float leave, ty_lit_run* run) {
    const float over = line->near + u * line->dnear - texel, over_leave = line->near + leave * line->dnear - texel;
    const int32_t lit = over >= 0.0f, lit_leave = over_leave >= 0.0f;
    if (lit != run->lit) ty_lit_turn(run, ty_lit_line_at(line, u), lit);
    if (lit == lit_leave) return;
    const float share = over / (over - over_leave);
    ty_lit_turn(run, ty_lit_line_at(line, u + (leave - u) * share), lit_leave);
}

/* Whether a line from u to `leave` is before all of a block (1), behind all of it (0), or neither (-1). */
TY_FN int32_t ty_lit_compare(const ty_lit_line* line, ty_lit_range range, float u, float leave) {
    const float a = line->near + u * line->dnear, b = line->near + leave * line->dnear;
    if (ty_minf(a, b) >= range.greatest) return 1;
    return ty_maxf(a, b) < range.least ? 0 : -1;
}

/* Differences of places that are too small are made a little larger: no line is along an axis. */
TY_FN float ty_lit_slanting(float d) {
    return fabsf(d) < 1e-6f ? 1e-6f : d;
}

TY_FN int32_t ty_lit_clamp(int32_t value, int32_t low, int32_t high) {
    return value < low ? low : value > high ? high : value;
}

/* The level that a line begins at: of blocks that are not much larger than it is long. */
TY_FN int32_t ty_lit_first_level(const ty_lit_line* line, int32_t top) {
    const float reach = 2.0f * ty_maxf(fabsf(ty_lit_slanting(line->dx)), fabsf(ty_lit_slanting(line->dy)));
    int32_t level = 0;
    while (level < top && reach > (float)(4 << level)) ++level;
    return level;
}

/* Up where a block ends that four blocks make, else at the same level; down where a block is partly lit. */
TY_FN void ty_lit_walk(const ty_lit_face* face, const ty_lit_line* line, int32_t side, int32_t top, ty_lit_run* run) {
    const float dx = ty_lit_slanting(line->dx), dy = ty_lit_slanting(line->dy);
    const float per_x = 1.0f / dx, per_y = 1.0f / dy;
    const int32_t ahead_x = dx > 0.0f, ahead_y = dy > 0.0f;
    int32_t x = ty_lit_clamp((int32_t)line->x, 0, side - 1), y = ty_lit_clamp((int32_t)line->y, 0, side - 1);
    int32_t level = ty_lit_first_level(line, top);
    float u = 0.0f;
    for (;;) {
        const int32_t block_x = x >> level, block_y = y >> level;
        const int32_t edge_x = (block_x + ahead_x) << level, edge_y = (block_y + ahead_y) << level;
        const float u_x = ((float)edge_x - line->x) * per_x, u_y = ((float)edge_y - line->y) * per_y;
        const float leave = ty_maxf(u, ty_minf(ty_minf(u_x, u_y), 1.0f));
        if (level == 0) {
            ty_lit_pass_texel(line, face->texels[(size_t)y * (size_t)side + (size_t)x], u, leave, run);
        } else {
            const size_t width = ((size_t)side + ((size_t)1 << level) - 1) >> level;
            const ty_lit_range range = face->levels[level][(size_t)block_y * width + (size_t)block_x];
            const int32_t lit = ty_lit_compare(line, range, u, leave);
            if (lit < 0) {
                --level;
                continue;
            }
            if (lit != run->lit) ty_lit_turn(run, ty_lit_line_at(line, u), lit);
        }
        if (leave >= 1.0f) return;
        const int32_t last = (1 << level) - 1;
        int32_t block;
        if (u_x < u_y) {
            x = ahead_x != 0 ? edge_x : edge_x - 1;
            y = ty_lit_clamp((int32_t)(line->y + leave * dy), block_y << level, (block_y << level) + last);
            block = block_x;
        } else {
            y = ahead_y != 0 ? edge_y : edge_y - 1;
            x = ty_lit_clamp((int32_t)(line->x + leave * dx), block_x << level, (block_x << level) + last);
            block = block_y;
        }
        if (x < 0 || y < 0 || x >= side || y >= side) return;
        if (level < top && (block & 1) == (u_x < u_y ? ahead_x : ahead_y)) ++level;
        u = leave;
    }
}

#endif
