/* Building min-max hierarchies, and visibility of rays and points. */
#include "direct/shadow/shadow_hierarchy.h"

#include "base/context.h"
#include "base/parallel.h"
#include "direct/shadow/shadow_hierarchy_kernel.h"

/* ---- texels ---- */

/* Depth bias of a texel from the slope of its surface, at most and at least, in texel widths. */
#define STEEPEST_SLOPE 4.0f
#define LEAST_BIAS 1e-3f

typedef struct hierarchy_job {
    const ty_shadow_hierarchy* map;
    int32_t face, level;
} hierarchy_job;

static bool is_parallel(const ty_shadow_hierarchy* map) {
    return map->light.kind == TY_KIND_DIRECTIONAL;
}

static size_t width_at(const ty_shadow_hierarchy* map, int32_t level) {
    return ((size_t)map->map->side + ((size_t)1 << level) - 1) >> level;
}

static inline float inverse_depth_of(bool parallel, float depth) {
    return parallel ? -ty_minf(depth, TY_FLOAT_MAX) : 1.0f / ty_maxf(depth, 1e-30f);
}

static const float* depths_of_row(const hierarchy_job* job, int64_t y) {
    const int64_t side = job->map->map->side;
    return job->map->map->depth + ((int64_t)job->face * side + y) * side;
}

/* Texels of a row that are filled together. */
enum { CHUNK = 256 };

/* Inverse depths of a chunk and the texels around it; INFINITY of empty texels and outside of the face. */
typedef struct texel_chunk {
    float above[CHUNK + 2], center[CHUNK + 2], below[CHUNK + 2]; /* from the texel before the chunk on */
} texel_chunk;

/* The texels from x - 1 to x + CHUNK of a row. */
static inline void find_inverse_depths(const hierarchy_job* job, bool parallel, int64_t x, int64_t y,
                                       float out[CHUNK + 2]) {
    const int64_t side = job->map->map->side, first = x == 0 ? 1 : 0;
    const int64_t end = y < 0 || y >= side ? first : side - x + 1 < CHUNK + 2 ? side - x + 1 : CHUNK + 2;
    const float* depth = depths_of_row(job, end > first ? y : 0);
    out[0] = INFINITY;
#pragma omp simd
    for (int64_t i = first; i < end; ++i) {
        const float inverse_depth = inverse_depth_of(parallel, depth[x - 1 + i]);
        out[i] = depth[x - 1 + i] <= TY_FLOAT_MAX ? inverse_depth : INFINITY;
    }
    for (int64_t i = end; i < CHUNK + 2; ++i) out[i] = INFINITY;
}

/* The smaller change of inverse depth towards both sides, because one side may be a silhouette edge; 0 where both are
 * empty. */
static inline float slope_of(float before, float inverse_depth, float after) {
    const float slope = ty_minf(fabsf(inverse_depth - before), fabsf(inverse_depth - after));
    return slope <= TY_FLOAT_MAX ? slope : 0.0f;
}

/* Width of a texel of parallel rays, else at unit depth, m. */
static float texel_width(const hierarchy_job* job) {
    const ty_rsm* map = job->map->map;
    const double* right = map->right[job->face];
    const double half = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    return (float)(2 * half / map->side);
}

/* Inverse depths at the farthest corners of the texels' surfaces. */
static inline void fill_chunk(const texel_chunk* chunk, bool parallel, float texel, const float* depth, int64_t count,
                              float* out) {
#pragma omp simd
    for (int64_t i = 0; i < count; ++i) {
        const float center = chunk->center[i + 1], width = texel * (parallel ? 1.0f : depth[i]);
        const float corner = center - 0.5f * (slope_of(chunk->center[i], center, chunk->center[i + 2]) +
                                              slope_of(chunk->above[i + 1], center, chunk->below[i + 1]));
        const float biased = ty_clampf(corner, inverse_depth_of(parallel, depth[i] + STEEPEST_SLOPE * width),
                                       inverse_depth_of(parallel, depth[i] + LEAST_BIAS * width));
        out[i] = depth[i] <= TY_FLOAT_MAX ? biased : inverse_depth_of(parallel, depth[i]);
    }
}

static inline void fill_texel_row(const hierarchy_job* job, bool parallel, int64_t row) {
    const int64_t side = job->map->map->side;
    const float texel = texel_width(job);
    float* out = job->map->faces[job->face].texels + row * side;
    for (int64_t x = 0; x < side; x += CHUNK) {
        texel_chunk chunk;
        find_inverse_depths(job, parallel, x, row - 1, chunk.above);
        find_inverse_depths(job, parallel, x, row, chunk.center);
        find_inverse_depths(job, parallel, x, row + 1, chunk.below);
        fill_chunk(&chunk, parallel, texel, depths_of_row(job, row) + x, side - x < CHUNK ? side - x : CHUNK, out + x);
    }
}

static void fill_texels(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hierarchy_job* job = user;
    if (is_parallel(job->map))
        fill_texel_row(job, true, row);
    else
        fill_texel_row(job, false, row);
}

/* ---- blocks ---- */

static ty_shadow_range range_below(const hierarchy_job* job, size_t x, size_t y) {
    const ty_shadow_face* face = &job->map->faces[job->face];
    const size_t at = y * width_at(job->map, job->level - 1) + x;
    if (job->level == 1) return (ty_shadow_range){face->texels[at], face->texels[at]};
    return face->levels[job->level - 1][at];
}

static void fill_blocks(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hierarchy_job* job = user;
    const size_t width = width_at(job->map, job->level), below = width_at(job->map, job->level - 1);
    ty_shadow_range* out = job->map->faces[job->face].levels[job->level] + (size_t)row * width;
    for (size_t x = 0; x < width; ++x) {
        const size_t low_x = 2 * x, low_y = 2 * (size_t)row;
        ty_shadow_range range = range_below(job, low_x, low_y);
        for (size_t i = 1; i < 4; ++i) {
            const size_t next_x = low_x + i % 2, next_y = low_y + i / 2;
            if (next_x >= below || next_y >= below) continue;
            const ty_shadow_range other = range_below(job, next_x, next_y);
            range.min = ty_minf(range.min, other.min);
            range.max = ty_maxf(range.max, other.max);
        }
        out[x] = range;
    }
}

/* ---- maps ---- */

/* One row of the affine map from points to face coordinates or depth; `axis` is half a side of the face. */
static void find_row(double scale, const double axis[3], const double forward[3], double center, const double origin[3],
                     float row[4]) {
    const double square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    double offset = 0;
    for (int a = 0; a < 3; ++a) {
        const double factor = scale * (axis[a] / square + (forward != NULL ? forward[a] : 0));
        row[a] = (float)factor;
        offset -= factor * origin[a];
    }
    row[3] = (float)(offset + center);
}

static void place_face(const ty_shadow_hierarchy* map, int32_t index, ty_shadow_face* face) {
    const ty_rsm* of = map->map;
    const double position[3] = {(double)map->light.position.x, (double)map->light.position.y,
                                (double)map->light.position.z};
    const double* origin = is_parallel(map) ? of->origin : position;
    const double* forward = is_parallel(map) ? NULL : of->forward[index];
    const double half = 0.5 * of->side, center = is_parallel(map) ? half : 0;
    find_row(half, of->right[index], forward, center, origin, face->to_map);
    find_row(half, of->up[index], forward, center, origin, face->to_map + 4);
    find_row(1, of->forward[index], NULL, 0, origin, face->to_map + 8);
}

static void find_nearest(const ty_rsm* of, int32_t index, ty_shadow_face* face) {
    const size_t texels = (size_t)of->side * (size_t)of->side;
    face->nearest = INFINITY;
    for (size_t i = 0; i < texels; ++i) face->nearest = ty_minf(face->nearest, of->depth[(size_t)index * texels + i]);
}

static void fill_face(ty_shadow_hierarchy* map, int32_t index) {
    hierarchy_job job = {.map = map, .face = index};
    place_face(map, index, &map->faces[index]);
    find_nearest(map->map, index, &map->faces[index]);
    ty_parallel_flushed(map->context, map->map->side, fill_texels, &job);
    for (job.level = 1; job.level < map->levels; ++job.level)
        ty_parallel_flushed(map->context, (int64_t)width_at(map, job.level), fill_blocks, &job);
}

static bool take_face(const ty_shadow_hierarchy* map, ty_shadow_face* face) {
    size_t count = width_at(map, 0) * width_at(map, 0) +
                   width_at(map, 0) % 2; /* levels of (min, max) pairs start at even indices */
    for (int32_t level = 1; level < map->levels; ++level) {
        face->offset[level] = count;
        count += 2 * width_at(map, level) * width_at(map, level);
    }
    face->nodes = ty_alloc_array(map->context, count, sizeof *face->nodes, false);
    if (face->nodes == NULL) return false;
    face->node_count = count;
    face->texels = face->nodes;
    for (int32_t level = 1; level < map->levels; ++level)
        face->levels[level] = (ty_shadow_range*)(face->nodes + face->offset[level]);
    return true;
}

ty_result ty_shadow_hierarchy_create(ty_context* context, const ty_light_view* light, const ty_rsm* map,
                                     ty_shadow_hierarchy** out) {
    ty_shadow_hierarchy* lit = ty_alloc_array(context, 1, sizeof *lit, true);
    if (lit == NULL) return TY_ERROR_MEMORY;
    lit->context = context;
    lit->map = map;
    lit->light = *light;
    while (width_at(lit, lit->levels++) > 1) continue;
    bool whole = true;
    for (int32_t i = 0; i < map->faces && whole; ++i) whole = take_face(lit, &lit->faces[i]);
    if (!whole) {
        ty_shadow_hierarchy_destroy(lit);
        return TY_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < map->faces; ++i) fill_face(lit, i);
    *out = lit;
    return TY_OK;
}

void ty_shadow_hierarchy_destroy(ty_shadow_hierarchy* map) {
    if (map == NULL) return;
    for (int32_t i = 0; i < 6; ++i)
        ty_free_array(map->context, map->faces[i].nodes, map->faces[i].node_count, sizeof(float));
    ty_free_array(map->context, map, 1, sizeof *map);
}

/* ---- rays ---- */

/* A ray in the coordinates of a face, and its interval in which surfaces may occlude it. */
typedef struct face_ray {
    const ty_shadow_face* face;
    ty_vec at, omega; /* in face coordinates */
    ty_ray_interval interval;
} face_ray;

static bool find_face(const ty_shadow_hierarchy* map, int32_t index, ty_vec origin, ty_vec direction,
                      ty_ray_interval interval, face_ray* out) {
    const ty_shadow_face* face = &map->faces[index];
    const float side = (float)map->map->side;
    if (isinf(face->nearest)) return false;
    const ty_vec at = ty_map_point(face->to_map, origin), omega = ty_map_direction(face->to_map, direction);
    const bool flat = is_parallel(map);
    *out = (face_ray){.face = face, .at = at, .omega = omega, .interval = interval};
    const float span = flat ? side : side * at.z, span_slope = flat ? 0.0f : side * omega.z;
    return ty_ray_interval_clip(at.z - 0.999f * face->nearest, omega.z, &out->interval) &&
           ty_ray_interval_clip(at.x, omega.x, &out->interval) &&
           ty_ray_interval_clip(span - at.x, span_slope - omega.x, &out->interval) &&
           ty_ray_interval_clip(at.y, omega.y, &out->interval) &&
           ty_ray_interval_clip(span - at.y, span_slope - omega.y, &out->interval);
}

static ty_shadow_line line_of(const ty_shadow_hierarchy* map, const face_ray* ray, float from) {
    ty_vec begin = ty_mad(ray->at, ray->omega, from), end = ty_mad(ray->at, ray->omega, ray->interval.to);
    ty_shadow_line line = {.from = from, .length = ray->interval.to - from, .depth = {1.0f, 1.0f}};
    if (is_parallel(map)) {
        begin.z = -begin.z;
        end.z = -end.z;
    } else {
        const float inverse_depth[2] = {1.0f / begin.z, 1.0f / end.z};
        line.depth[0] = begin.z;
        line.depth[1] = end.z;
        begin = ty_vec_make(begin.x * inverse_depth[0], begin.y * inverse_depth[0], inverse_depth[0]);
        end = ty_vec_make(end.x * inverse_depth[1], end.y * inverse_depth[1], inverse_depth[1]);
    }
    line.x = begin.x;
    line.y = begin.y;
    line.inverse_depth = begin.z;
    line.dx = end.x - begin.x;
    line.dy = end.y - begin.y;
    line.inverse_depth_change = end.z - begin.z;
    return line;
}

static void walk_face(const ty_shadow_hierarchy* map, const face_ray* ray, float from, ty_lit_segments* list) {
    const ty_shadow_line line = line_of(map, ray, from);
    ty_shadow_traverse(ray->face, &line, map->map->side, map->levels - 1, list);
}

/* Gaps up to this length, relative to the distance, are the seam between neighbouring faces. */
#define FACE_SEAM 1e-5f

int32_t ty_shadow_lit_segments(const ty_shadow_hierarchy* map, ty_vec origin, ty_vec direction, float from, float to,
                               float segments[TY_LIT_SEGMENTS_MAX][2]) {
    ty_ray_interval interval = {from, to};
    if (!(from < to)) return 0;
    if (map->light.kind == TY_KIND_SPOT &&
        !ty_ray_interval_clip_cone(&map->light, map->light.cos_outer, origin, direction, &interval))
        return 0;
    face_ray rays[6];
    int32_t count = 0;
    for (int32_t i = 0; i < map->map->faces; ++i)
        if (find_face(map, i, origin, direction, interval, &rays[count])) ++count;
    ty_lit_segments list = {.segments = segments, .lit = 1, .at = interval.from};
    float t = interval.from;
    for (;;) {
        int32_t next = -1;
        for (int32_t i = 0; i < count; ++i)
            if (rays[i].interval.to > t && (next < 0 || rays[i].interval.from < rays[next].interval.from)) next = i;
        if (next < 0) break;
        const float begin = ty_maxf(t, rays[next].interval.from);
        if (begin - t > FACE_SEAM * begin) ty_lit_segments_switch(&list, t, 1);
        walk_face(map, &rays[next], begin, &list);
        t = rays[next].interval.to;
    }
    if (interval.to - t > FACE_SEAM * interval.to) ty_lit_segments_switch(&list, t, 1);
    ty_lit_segments_switch(&list, interval.to, 0);
    return list.count;
}

/* ---- ray packets ---- */

/* Maps of one face: all rays with an interval on the face are traversed together. */
static void walk_together(const ty_shadow_hierarchy* map, ty_shadow_rays* rays) {
    ty_shadow_line lines[TY_SHADOW_RAYS_MAX];
    ty_lit_segments lists[TY_SHADOW_RAYS_MAX];
    ty_ray_interval intervals[TY_SHADOW_RAYS_MAX];
    int32_t which[TY_SHADOW_RAYS_MAX], count = 0;
    float ends[TY_SHADOW_RAYS_MAX]; /* end of each ray's interval on the face */
    for (int32_t i = 0; i < rays->count; ++i) {
        ty_ray_interval interval = {rays->from[i], rays->to[i]};
        face_ray ray;
        rays->counts[i] = 0;
        if (!(interval.from < interval.to)) continue;
        if (map->light.kind == TY_KIND_SPOT &&
            !ty_ray_interval_clip_cone(&map->light, map->light.cos_outer, rays->origin, rays->direction[i], &interval))
            continue;
        if (!find_face(map, 0, rays->origin, rays->direction[i], interval, &ray)) {
            rays->segments[i][0][0] = interval.from;
            rays->segments[i][0][1] = interval.to;
            rays->counts[i] = 1;
            continue;
        }
        lists[count] = (ty_lit_segments){.segments = rays->segments[i], .lit = 1, .at = interval.from};
        lines[count] = line_of(map, &ray, ray.interval.from);
        intervals[count] = interval;
        ends[count] = ray.interval.to;
        which[count++] = i;
    }
    if (count == 0) return;
    TY_BEST_KERNELS(ty_shadow_kernels)->walk(&map->faces[0], lines, count, map->map->side, map->levels - 1, lists);
    for (int32_t k = 0; k < count; ++k) {
        if (intervals[k].to - ends[k] > FACE_SEAM * intervals[k].to) ty_lit_segments_switch(&lists[k], ends[k], 1);
        ty_lit_segments_switch(&lists[k], intervals[k].to, 0);
        rays->counts[which[k]] = lists[k].count;
    }
}

void ty_shadow_lit_segments_of(const ty_shadow_hierarchy* map, ty_shadow_rays* rays) {
    if (map->map->faces == 1) {
        walk_together(map, rays);
        return;
    }
    for (int32_t i = 0; i < rays->count; ++i)
        rays->counts[i] = ty_shadow_lit_segments(map, rays->origin, rays->direction[i], rays->from[i], rays->to[i],
                                                 rays->segments[i]);
}

/* ---- points ---- */

/* The first face that contains a point, and the point's face coordinates; false if no face does. */
static bool locate(const ty_shadow_hierarchy* map, ty_vec point, int32_t* face, ty_vec* at) {
    const float side = (float)map->map->side;
    for (*face = 0; *face < map->map->faces; ++*face) {
        *at = ty_map_point(map->faces[*face].to_map, point);
        if (!is_parallel(map)) {
            if (!(at->z > 0.0f)) continue;
            at->x /= at->z;
            at->y /= at->z;
        }
        if (at->x >= 0.0f && at->x <= side && at->y >= 0.0f && at->y <= side) return true;
    }
    return false;
}

static bool is_outside_cone(const ty_light_view* light, ty_vec point) {
    const ty_vec off = ty_sub(point, light->position);
    return ty_dot(off, light->direction) <= light->cos_outer * sqrtf(ty_dot(off, off));
}

/* The tangent plane of a receiver in face coordinates: 1 / depth is linear in them for local lights, depth for
 * directional lights. */
typedef struct receiver_plane {
    float depth, cosine, along[2]; /* at the receiver: depth, and the cosine with its change per texel */
} receiver_plane;

static receiver_plane plane_before(const ty_shadow_hierarchy* map, int32_t face, ty_vec at, ty_vec normal) {
    const ty_rsm* of = map->map;
    const float per_texel = 2.0f / (float)of->side;
    const double n[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    double cosine = 0, along[2] = {0, 0};
    for (int a = 0; a < 3; ++a) {
        cosine -= n[a] * of->forward[face][a];
        along[0] -= n[a] * of->right[face][a];
        along[1] -= n[a] * of->up[face][a];
    }
    receiver_plane plane = {.depth = at.z, .cosine = (float)cosine};
    for (int i = 0; i < 2; ++i) plane.along[i] = (float)along[i] * per_texel;
    if (!is_parallel(map))
        plane.cosine +=
            plane.along[0] * (at.x - 0.5f * (float)of->side) + plane.along[1] * (at.y - 0.5f * (float)of->side);
    return plane;
}

/* Depth of the plane at an offset in texels; INFINITY if the plane is behind the light there. */
static float plane_depth(const ty_shadow_hierarchy* map, const receiver_plane* plane, float x, float y) {
    const float change = plane->along[0] * x + plane->along[1] * y;
    if (is_parallel(map)) return plane->depth - change / plane->cosine;
    const float cosine = plane->cosine + change;
    return cosine > 0.0f ? plane->depth * plane->cosine / cosine : INFINITY;
}

float ty_shadow_visibility(const ty_shadow_hierarchy* map, ty_vec point, ty_vec normal, float slack, float close,
                           bool* sure) {
    int32_t face;
    ty_vec at;
    *sure = true;
    if (map->light.kind == TY_KIND_SPOT && is_outside_cone(&map->light, point)) return 0.0f;
    if (!locate(map, point, &face, &at)) return 1.0f;
    const hierarchy_job job = {.map = map, .face = face};
    const receiver_plane plane = plane_before(map, face, at, normal);
    if (!(plane.cosine > 0.0f)) return 0.0f;
    const int32_t last = map->map->side - 1;
    const float x = floorf(at.x - 0.5f), y = floorf(at.y - 0.5f);
    const float across = at.x - 0.5f - x, down = at.y - 0.5f - y;
    float fraction = 0.0f;
    int32_t lit = 0;
    for (int32_t i = 0; i < 4; ++i) {
        const int32_t column = ty_shadow_clamp((int32_t)x + i % 2, 0, last);
        const int32_t row = ty_shadow_clamp((int32_t)y + i / 2, 0, last);
        const float nearer = plane_depth(map, &plane, (float)column + 0.5f - at.x, (float)row + 0.5f - at.y) -
                             depths_of_row(&job, row)[column];
        const bool shines = !(nearer > slack);
        if (shines) fraction += (i % 2 == 0 ? 1.0f - across : across) * (i / 2 == 0 ? 1.0f - down : down);
        lit += shines;
        if (!(nearer <= slack || nearer > close)) *sure = false;
    }
    if (lit != 0 && lit != 4) *sure = false;
    return fraction;
}
