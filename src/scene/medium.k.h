/* Media along a ray: where a ray is inside, and the bricks of bounded density that it crosses there. */
#ifndef TY_SCENE_MEDIUM_K_H
#define TY_SCENE_MEDIUM_K_H

#include "base/random.k.h"
#include "base/vector.k.h"
#include "grid/lookup.k.h"

enum { TY_MEDIA_MAX = 64 };

/* Tentative collisions are at least this far apart, relative to the distance: what single precision can tell. */
#define TY_LEAST_STEP 6e-8f

typedef struct ty_medium_view {
    ty_grid_view grid; /* looked at if has_grid */
    int32_t has_grid;
    int32_t bounds;      /* ty_bounds_kind */
    float to_bounds[12]; /* world to where the bounds are the cube [-1, 1]^3 or the unit sphere */
    float to_index[12];  /* world to the grid's index space */
    float sigma_s[3];    /* scale included, at density 1 */
    float sigma_t[3];
    float sigma_t_max; /* over channels */
    float g[3];
    int32_t gray; /* sigma_s, sigma_t and g alike in all channels */
} ty_medium_view;

/* Cuts [*enter, *leave] to where one coordinate is within [low, high]; false if nothing is left. */
TY_FN bool ty_clip_slab(float origin, float direction, float low, float high, float* enter, float* leave) {
    if (direction == 0.0f) return origin >= low && origin <= high;
    const float inverse = 1.0f / direction;
    const float a = (low - origin) * inverse, b = (high - origin) * inverse;
    *enter = ty_maxf(*enter, ty_minf(a, b));
    *leave = ty_minf(*leave, ty_maxf(a, b));
    return *enter < *leave;
}

TY_FN bool ty_clip_box(ty_vec o, ty_vec d, ty_vec low, ty_vec high, float* enter, float* leave) {
    return ty_clip_slab(o.x, d.x, low.x, high.x, enter, leave) && ty_clip_slab(o.y, d.y, low.y, high.y, enter, leave) &&
           ty_clip_slab(o.z, d.z, low.z, high.z, enter, leave);
}

TY_FN bool ty_clip_unit_sphere(ty_vec o, ty_vec d, float* enter, float* leave) {
    const float dd = ty_dot(d, d);
    const float closest = -ty_dot(o, d) / dd;
    const ty_vec at = ty_mad(o, d, closest);
    const float half_square = (1.0f - ty_dot(at, at)) / dd;
    if (half_square <= 0.0f) return false;
    const float half = sqrtf(half_square);
    *enter = ty_maxf(*enter, closest - half);
    *leave = ty_minf(*leave, closest + half);
    return *enter < *leave;
}

/* Where within [*enter, *leave] the ray is inside the medium; false, if nowhere. Bounds are convex: one interval. */
TY_FN bool ty_medium_interval(TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction, float* enter,
                              float* leave) {
    if (medium->bounds != 0) {
        const ty_vec o = ty_map_point(medium->to_bounds, origin), d = ty_map_direction(medium->to_bounds, direction);
        if (medium->bounds == 1) {
            if (!ty_clip_box(o, d, ty_vec_make(-1, -1, -1), ty_vec_make(1, 1, 1), enter, leave)) return false;
        } else if (!ty_clip_unit_sphere(o, d, enter, leave)) {
            return false;
        }
    }
    if (medium->has_grid == 0) return *enter < *leave;
    const ty_vec o = ty_map_point(medium->to_index, origin), d = ty_map_direction(medium->to_index, direction);
    const ty_vec high =
        ty_vec_make((float)medium->grid.size[0], (float)medium->grid.size[1], (float)medium->grid.size[2]);
    return ty_clip_box(o, d, ty_vec_make(-1, -1, -1), high, enter, leave);
}

/* Walks the bricks of a grid along a ray; densities within [enter, leave] lie in [low, high]. */
typedef struct ty_bricks {
    TY_GLOBAL const ty_medium_view* medium;
    ty_vec origin, direction; /* index space; the parameter is the world's */
    float enter, leave, low, high;
    float next[3], step_t[3];
    float end; /* of the whole interval */
    int32_t cell[3], step[3];
    int32_t done;
} ty_bricks;

TY_FN void ty_bricks_begin_axis(ty_bricks* b, int32_t axis, float o, float d, float enter) {
    const int32_t count = b->medium->grid.bricks[axis];
    const float inverse_brick = 1.0f / (float)TY_BRICK;
    const float position = (o + d * enter + 1.0f) * inverse_brick;
    int32_t cell = (int32_t)floorf(position);
    cell = cell < 0 ? 0 : cell >= count ? count - 1 : cell;
    b->cell[axis] = cell;
    b->step[axis] = d > 0.0f ? 1 : -1;
    if (d == 0.0f) {
        b->next[axis] = b->step_t[axis] = TY_FLOAT_MAX;
        return;
    }
    const float inverse = 1.0f / d;
    const float face = (float)(TY_BRICK * (d > 0.0f ? cell + 1 : cell) - 1);
    b->next[axis] = (face - o) * inverse;
    b->step_t[axis] = fabsf((float)TY_BRICK * inverse);
}

TY_FN void ty_bricks_begin(ty_bricks* b, TY_GLOBAL const ty_medium_view* medium, ty_vec origin, ty_vec direction,
                           float enter, float leave) {
    b->medium = medium;
    b->enter = b->leave = enter;
    b->end = leave;
    b->done = 0;
    b->low = b->high = 0.0f;
    if (medium->has_grid == 0) return;
    b->origin = ty_map_point(medium->to_index, origin);
    b->direction = ty_map_direction(medium->to_index, direction);
    ty_bricks_begin_axis(b, 0, b->origin.x, b->direction.x, enter);
    ty_bricks_begin_axis(b, 1, b->origin.y, b->direction.y, enter);
    ty_bricks_begin_axis(b, 2, b->origin.z, b->direction.z, enter);
}

/* Moves to the next brick with any density; false at the end of the interval. A homogeneous medium is one brick. */
TY_FN bool ty_bricks_next(ty_bricks* b) {
    if (b->medium->has_grid == 0) {
        if (b->done != 0) return false;
        b->done = 1;
        b->leave = b->end;
        b->low = b->high = 1.0f;
        return true;
    }
    TY_GLOBAL const ty_grid_view* grid = &b->medium->grid;
    while (b->done == 0) {
        const int32_t xy = b->next[0] < b->next[1] ? 0 : 1;
        const int32_t axis = b->next[xy] < b->next[2] ? xy : 2;
        const float face = b->next[axis];
        TY_GLOBAL const float* extremes =
            grid->extremes +
            2 * ((size_t)b->cell[0] +
                 (size_t)grid->bricks[0] * ((size_t)b->cell[1] + (size_t)grid->bricks[1] * (size_t)b->cell[2]));
        b->low = ty_maxf(extremes[0], 0.0f);
        b->high = extremes[1];
        b->enter = b->leave;
        b->leave = ty_maxf(b->enter, ty_minf(face, b->end));
        b->cell[axis] += b->step[axis];
        b->next[axis] += b->step_t[axis];
        if (face >= b->end || (uint32_t)b->cell[axis] >= (uint32_t)grid->bricks[axis]) {
            b->done = 1;
            b->leave = b->end;
        }
        if (b->high > 0.0f && b->leave > b->enter) return true;
    }
    return false;
}

/* A random estimate of the grid's value at a point in index space, whose mean is the trilinear value: the voxel that a
 * uniform jitter of one voxel's width picks. Null-collision methods are linear in the density, so they stay unbiased.
 */
TY_FN float ty_grid_jittered(TY_GLOBAL const ty_grid_view* grid, ty_vec p, ty_random* random) {
    const uint64_t bits = ty_random_bits(random);
    const float scale = 0x1p-21f;
    const int32_t i = (int32_t)floorf(p.x + (float)(uint32_t)(bits >> 43) * scale);
    const int32_t j = (int32_t)floorf(p.y + (float)(uint32_t)(bits >> 22 & 0x1fffffu) * scale);
    const int32_t k = (int32_t)floorf(p.z + (float)(uint32_t)(bits & 0x1fffffu) * scale);
    return ty_grid_fetch(grid, i, j, k);
}

/* An estimate of the density at parameter t, within the brick's bounds. */
TY_FN float ty_bricks_density(const ty_bricks* b, float t, ty_random* random) {
    if (b->medium->has_grid == 0) return 1.0f;
    const ty_vec p = ty_mad(b->origin, b->direction, t);
    return ty_clampf(ty_grid_jittered(&b->medium->grid, p, random), b->low, b->high);
}

/* The same at a point of the world that is inside the medium. */
TY_FN float ty_medium_density(TY_GLOBAL const ty_medium_view* medium, ty_vec point, ty_random* random) {
    if (medium->has_grid == 0) return 1.0f;
    return ty_maxf(0.0f, ty_grid_jittered(&medium->grid, ty_map_point(medium->to_index, point), random));
}

#endif
