/* Light of cells at points between them. */
#ifndef TY_BAKE_CACHE_LOOK_K_H
#define TY_BAKE_CACHE_LOOK_K_H

#include "bake/cache.h"
#include "scene/phase.k.h"

TY_FN int32_t ty_cache_cell(const ty_cache_view* view, ty_vec at) {
    const int32_t* size = view->size;
    const float m = view->per_metre;
    const int32_t x = (int32_t)ty_clampf((at.x - view->lower[0]) * m, 0.0f, (float)(size[0] - 1));
    const int32_t y = (int32_t)ty_clampf((at.y - view->lower[1]) * m, 0.0f, (float)(size[1] - 1));
    const int32_t z = (int32_t)ty_clampf((at.z - view->lower[2]) * m, 0.0f, (float)(size[2] - 1));
    return x + size[0] * (y + size[1] * z);
}

TY_FN bool ty_cache_sees(const ty_accel* mesh, ty_vec from, ty_vec to) {
    const ty_vec way = ty_sub(to, from);
    const float distance = sqrtf(ty_dot(way, way));
    return !(distance > 0.0f) || !ty_accel_occluded(mesh, from, ty_scale(way, 1.0f / distance), distance);
}

/* The side of a cell that a point sees; -1: it sees neither. */
TY_FN int32_t ty_cache_side(const ty_cache_view* view, const ty_accel* mesh, int32_t cell, ty_vec at) {
    const float* anchor = view->anchor + (size_t)cell * (3 * TY_CACHE_SIDES);
    const uint8_t known = view->known[cell];
    if ((known & 1) != 0 && ty_cache_sees(mesh, at, ty_vec_load(anchor))) return 0;
    if ((known & 2) != 0 && ty_cache_sees(mesh, at, ty_vec_load(anchor + 3))) return 1;
    return -1;
}

/* A random way from a point, by which the cell that one comes to is one of the eight around: the mean is trilinear
 * between cells' middles, even beyond the outermost. */
TY_FN ty_vec ty_cache_jitter(const ty_cache_view* view, ty_sampler* random) {
    const uint64_t bits = ty_rng_bits(random);
    const float half = 0.5f, metres = 1.0f / view->per_metre;
    const ty_vec jitter = ty_vec_make((float)(uint32_t)(bits >> 43) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits >> 22 & 0x1fffffu) * 0x1p-21f - half,
                                      (float)(uint32_t)(bits & 0x1fffffu) * 0x1p-21f - half);
    return ty_scale(jitter, metres);
}

/* The light of one of the cells around a point. Near surfaces that cut cells, or cells from each other, light counts
 * that the point sees where it was gathered. */
TY_FN const float* ty_cache_look(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_sampler* random) {
    int32_t cell = ty_cache_cell(view, ty_add(at, ty_cache_jitter(view, random))), side = 0;
    const int32_t own = ty_cache_cell(view, at);
    const size_t each = (size_t)(TY_CACHE_KINDS * view->floats);
    const bool single = (view->known[own] & ~TY_CACHE_CUT) == 1; /* side: there is no other to be on */
    if ((view->known[own] & TY_CACHE_CUT) != 0 && !(cell == own && single)) {
        side = ty_cache_side(view, mesh, cell, at);
        if (side < 0) {
            side = cell != own && !single ? ty_cache_side(view, mesh, own, at) : 0;
            cell = own;
        }
    }
    return (side == 1 ? view->other : view->light) + (size_t)cell * each;
}

/* ---- on surfaces ---- */

/* Cosines between a surface's normal and that of a wall: below the first the wall says nothing of it, from the second
 * on everything. */
#define TY_WALL_LEAST_LIKE 0.7f
#define TY_WALL_ALIKE 0.95f
/* In cells: walls are flat to this much, and of surfaces closer behind each other one has none. */
#define TY_WALL_FLATNESS 0.05f

/* Whether a point is where cells know of light. */
TY_FN bool ty_cache_holds(const ty_cache_view* view, ty_vec at) {
    const float m = view->per_metre, slack = 1e-3f;
    const float x = (at.x - view->lower[0]) * m, y = (at.y - view->lower[1]) * m, z = (at.z - view->lower[2]) * m;
    return x > -slack && y > -slack && z > -slack && x < (float)view->size[0] + slack &&
           y < (float)view->size[1] + slack && z < (float)view->size[2] + slack;
}

/* The axis that a surface faces along: x, y, z, then their opposites. */
TY_FN int32_t ty_wall_way(ty_vec normal) {
    const float x = fabsf(normal.x), y = fabsf(normal.y), z = fabsf(normal.z);
    if (x >= y && x >= z) return normal.x < 0.0f ? 3 : 0;
    if (y >= z) return normal.y < 0.0f ? 4 : 1;
    return normal.z < 0.0f ? 5 : 2;
}

/* The wall of a cell that faces some way; NULL: there is none. */
TY_FN float* ty_wall_of(const ty_cache_view* view, int32_t cell, int32_t way) {
    const uint32_t ways = view->ways[cell];
    if ((ways >> way & 1u) == 0) return NULL;
    const int32_t before = __builtin_popcount(ways & ((1u << way) - 1u));
    return view->walls + (size_t)(view->first[cell] + before) * TY_WALL_FLOATS;
}

/* Whether a point is in the plane of a wall. */
TY_FN bool ty_wall_is_flush(const ty_cache_view* view, ty_vec place, ty_vec normal, ty_vec at) {
    return fabsf(ty_dot(ty_sub(at, place), normal)) * view->per_metre < TY_WALL_FLATNESS;
}

/* What a wall says of a point on a surface: how much of its word counts. open: whether nothing stands between cells. */
TY_FN float ty_wall_counts(const ty_cache_view* view, const ty_accel* mesh, const float* wall, ty_vec at, ty_vec normal,
                           bool open) {
    if (wall == NULL || !(wall[TY_WALL_WALKS] > 0.0f)) return 0.0f;
    const ty_vec own = ty_vec_load(wall + TY_WALL_NORMAL);
    const ty_vec place = ty_vec_load(wall + TY_WALL_PLACE);
    const float like = ty_dot(own, normal);
    if (!(like > TY_WALL_LEAST_LIKE) || !ty_wall_is_flush(view, place, own, at)) return 0.0f;
    if (!open) {
        /* Off the surfaces, which may be round. */
        const float off = 0.1f / view->per_metre;
        if (!ty_cache_sees(mesh, ty_mad(at, normal, off), ty_mad(place, own, off))) return 0.0f;
    }
    return ty_minf(1.0f, (like - TY_WALL_LEAST_LIKE) / (TY_WALL_ALIKE - TY_WALL_LEAST_LIKE));
}

TY_FN bool ty_cache_is_open(const ty_cache_view* view, ty_vec at) {
    return (view->known[ty_cache_cell(view, at)] & TY_CACHE_CUT) == 0;
}

/* A wall around a point on a surface, beside it along the surface by chance; NULL: nothing is known. */
TY_FN const float* ty_cache_look_wall(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_vec normal,
                                      ty_sampler* random) {
    if (view->ways == NULL || !ty_cache_holds(view, at)) return NULL;
    const int32_t way = ty_wall_way(normal), own = ty_cache_cell(view, at);
    const bool open = ty_cache_is_open(view, at);
    const ty_vec aside = ty_cache_jitter(view, random);
    const int32_t cell = ty_cache_cell(view, ty_mad(ty_add(at, aside), normal, -ty_dot(normal, aside)));
    const float* wall = ty_wall_of(view, cell, way);
    if (ty_wall_counts(view, mesh, wall, at, normal, open) > 0.0f) return wall;
    wall = cell != own ? ty_wall_of(view, own, way) : NULL;
    return ty_wall_counts(view, mesh, wall, at, normal, open) > 0.0f ? wall : NULL;
}

/* The trilinear mean of the walls around a point on a surface: light[kind][channel][term], and the variance of that.
 * Returns how many walks from that point would have as much noise; 0: nothing is known. */
TY_FN float ty_cache_mean_wall(const ty_cache_view* view, const ty_accel* mesh, ty_vec at, ty_vec normal,
                               float light[TY_WALL_LIGHTS], float variance[3]) {
    float part[3], weights = 0.0f, squares = 0.0f;
    int32_t low[3];
    if (view->ways == NULL || !ty_cache_holds(view, at)) return 0.0f;
    const float place[3] = {at.x, at.y, at.z};
    for (int a = 0; a < 3; ++a) {
        const float p = (place[a] - view->lower[a]) * view->per_metre - 0.5f, last = (float)(view->size[a] - 1);
        low[a] = (int32_t)floorf(ty_clampf(p, 0.0f, last));
        part[a] = ty_clampf(p - (float)low[a], 0.0f, (float)(view->size[a] - 1 - low[a]));
    }
    const bool open = ty_cache_is_open(view, at);
    const int32_t way = ty_wall_way(normal);
    for (int t = 0; t < TY_WALL_LIGHTS; ++t) light[t] = 0.0f;
    for (int c = 0; c < 3; ++c) variance[c] = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        float weight = 1.0f;
        int32_t cell = 0;
        for (int a = 2; a >= 0; --a) {
            const int32_t up = corner >> a & 1;
            weight *= up != 0 ? part[a] : 1.0f - part[a];
            cell = cell * view->size[a] + low[a] + up;
        }
        const float* wall = weight > 0.0f ? ty_wall_of(view, cell, way) : NULL;
        weight *= ty_wall_counts(view, mesh, wall, at, normal, open);
        if (!(weight > 0.0f)) continue;
        weights += weight;
        squares += weight * weight / wall[TY_WALL_WALKS];
        for (int t = 0; t < TY_WALL_LIGHTS; ++t) light[t] += weight * wall[TY_WALL_LIGHT + t];
        for (int c = 0; c < 3; ++c) variance[c] += weight * weight * wall[TY_WALL_VARIANCE + c];
    }
    if (!(weights > 0.0f)) return 0.0f;
    for (int t = 0; t < TY_WALL_LIGHTS; ++t) light[t] /= weights;
    for (int c = 0; c < 3; ++c) variance[c] /= weights * weights;
    /* A flat surface is in half of the eight cells. */
    return ty_minf(1.0f, 2.0f * weights) * weights * weights / squares;
}

/* ---- scattering ---- */

/* Radiance scattered against a ray's direction, per scattering coefficient, of one kind of light. Light whose mean
 * direction has length R is taken for a Henyey-Greenstein lobe about it, of that mean cosine: light from one direction
 * alone, even light and all zonal light up to its first harmonic are scattered as they should be, and nothing becomes
 * negative. */
TY_FN void ty_cache_scatter(const ty_cache_view* view, const float* light, ty_vec direction, const float g[3],
                            float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = light[c];
    if (view->floats == TY_CACHE_EVEN) return;
    const float mu = ty_clampf(ty_dot(ty_vec_load(light + 3), direction), -1.0f, 1.0f);
    float lobe = ty_hg(mu, g[0] * light[6]) * (1.0f / TY_INV_4PI);
    for (int c = 0; c < 3; ++c) {
        if (c > 0 && view->floats == TY_CACHE_COLORED) lobe = ty_hg(mu, g[c] * light[6 + c]) * (1.0f / TY_INV_4PI);
        out[c] *= lobe;
    }
}

#endif
