/* Pyramids of nearness, and rays through them. */
#include "direct/shadow/lit.h"

#include "base/context.h"
#include "base/isa.h"
#include "base/parallel.h"
#include "direct/shadow/lit_kernel.h"

/* ---- texels ---- */

/* How much farther a texel's surface may be taken, in texels' widths. */
#define LIT_STEEPEST 4.0f
#define LIT_LEAST 1e-3f

typedef struct lit_job {
    const ty_lit_map* map;
    int32_t face, level;
} lit_job;

static bool is_parallel(const ty_lit_map* map) {
    return map->light.kind == TY_KIND_DIRECTIONAL;
}

static size_t width_at(const ty_lit_map* map, int32_t level) {
    return ((size_t)map->map->side + ((size_t)1 << level) - 1) >> level;
}

static float nearness_of(const ty_lit_map* map, float depth) {
    return is_parallel(map) ? -ty_minf(depth, TY_FLOAT_MAX) : 1.0f / ty_maxf(depth, 1e-30f);
}

static float depth_at(const lit_job* job, int32_t x, int32_t y) {
    const size_t side = (size_t)job->map->map->side;
    return job->map->map->depth[((size_t)job->face * side + (size_t)y) * side + (size_t)x];
}

/* The change of nearness from a texel to the one beside it; INFINITY where there is none to compare with. */
static float change_beside(const lit_job* job, int32_t x, int32_t y, float nearness) {
    const int32_t side = job->map->map->side;
    if (x < 0 || y < 0 || x >= side || y >= side) return INFINITY;
    const float depth = depth_at(job, x, y);
    return isinf(depth) ? INFINITY : fabsf(nearness - nearness_of(job->map, depth));
}

/* The lesser of both sides: the other one may be an edge. */
static float slope_of(const lit_job* job, int32_t x, int32_t y, int32_t along_x, float nearness) {
    const int32_t along_y = 1 - along_x;
    const float slope = ty_minf(change_beside(job, x - along_x, y - along_y, nearness),
                                change_beside(job, x + along_x, y + along_y, nearness));
    return isinf(slope) ? 0.0f : slope;
}

static float texel_width(const lit_job* job, float depth) {
    const ty_light_map* map = job->map->map;
    const double* right = map->right[job->face];
    const double half = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    return (float)(2 * half / map->side) * (is_parallel(job->map) ? 1.0f : depth);
}

static float texel_of(const lit_job* job, int32_t x, int32_t y) {
    const float depth = depth_at(job, x, y), nearness = nearness_of(job->map, depth);
    if (isinf(depth)) return nearness;
    const float width = texel_width(job, depth);
    const float corner = nearness - 0.5f * (slope_of(job, x, y, 1, nearness) + slope_of(job, x, y, 0, nearness));
    return ty_clampf(corner, nearness_of(job->map, depth + LIT_STEEPEST * width),
                     nearness_of(job->map, depth + LIT_LEAST * width));
}

static void fill_texels(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const lit_job* job = user;
    const int32_t side = job->map->map->side;
    float* out = job->map->faces[job->face].texels + row * side;
    for (int32_t x = 0; x < side; ++x) out[x] = texel_of(job, x, (int32_t)row);
}

/* ---- blocks ---- */

static ty_lit_range range_below(const lit_job* job, size_t x, size_t y) {
    const ty_lit_face* face = &job->map->faces[job->face];
    const size_t at = y * width_at(job->map, job->level - 1) + x;
    if (job->level == 1) return (ty_lit_range){face->texels[at], face->texels[at]};
    return face->levels[job->level - 1][at];
}

static void fill_blocks(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const lit_job* job = user;
    const size_t width = width_at(job->map, job->level), below = width_at(job->map, job->level - 1);
    ty_lit_range* out = job->map->faces[job->face].levels[job->level] + (size_t)row * width;
    for (size_t x = 0; x < width; ++x) {
        const size_t low_x = 2 * x, low_y = 2 * (size_t)row;
        ty_lit_range range = range_below(job, low_x, low_y);
        for (size_t i = 1; i < 4; ++i) {
            const size_t next_x = low_x + i % 2, next_y = low_y + i / 2;
            if (next_x >= below || next_y >= below) continue;
            const ty_lit_range other = range_below(job, next_x, next_y);
            range.least = ty_minf(range.least, other.least);
            range.greatest = ty_maxf(range.greatest, other.greatest);
        }
        out[x] = range;
    }
}

/* ---- maps ---- */

/* Linear functions of a point: its place along `axis` (half of a face's side) and its depth. */
static void find_row(double scale, const double axis[3], const double forward[3], double middle, const double origin[3],
                     float row[4]) {
    const double square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    double offset = 0;
    for (int a = 0; a < 3; ++a) {
        const double factor = scale * (axis[a] / square + (forward != NULL ? forward[a] : 0));
        row[a] = (float)factor;
        offset -= factor * origin[a];
    }
    row[3] = (float)(offset + middle);
}

static void place_face(const ty_lit_map* map, int32_t index, ty_lit_face* face) {
    const ty_light_map* of = map->map;
    const double position[3] = {(double)map->light.position.x, (double)map->light.position.y,
                                (double)map->light.position.z};
    const double* origin = is_parallel(map) ? of->origin : position;
    const double* forward = is_parallel(map) ? NULL : of->forward[index];
    const double half = 0.5 * of->side, middle = is_parallel(map) ? half : 0;
    find_row(half, of->right[index], forward, middle, origin, face->to_map);
    find_row(half, of->up[index], forward, middle, origin, face->to_map + 4);
    find_row(1, of->forward[index], NULL, 0, origin, face->to_map + 8);
}

static void find_nearest(const ty_light_map* of, int32_t index, ty_lit_face* face) {
    const size_t texels = (size_t)of->side * (size_t)of->side;
    face->nearest = INFINITY;
    for (size_t i = 0; i < texels; ++i) face->nearest = ty_minf(face->nearest, of->depth[(size_t)index * texels + i]);
}

static void fill_face(ty_lit_map* map, int32_t index) {
    lit_job job = {.map = map, .face = index};
    place_face(map, index, &map->faces[index]);
    find_nearest(map->map, index, &map->faces[index]);
    ty_parallel_flushed(map->context, map->map->side, fill_texels, &job);
    for (job.level = 1; job.level < map->levels; ++job.level)
        ty_parallel_flushed(map->context, (int64_t)width_at(map, job.level), fill_blocks, &job);
}

static bool take_face(const ty_lit_map* map, ty_lit_face* face) {
    size_t count =
        width_at(map, 0) * width_at(map, 0) + width_at(map, 0) % 2; /* levels of pairs begin at even places */
    for (int32_t level = 1; level < map->levels; ++level) {
        face->offset[level] = count;
        count += 2 * width_at(map, level) * width_at(map, level);
    }
    face->nodes = ty_alloc_array(map->context, count, sizeof *face->nodes, false);
    if (face->nodes == NULL) return false;
    face->node_count = count;
    face->texels = face->nodes;
    for (int32_t level = 1; level < map->levels; ++level)
        face->levels[level] = (ty_lit_range*)(face->nodes + face->offset[level]);
    return true;
}

ty_result ty_lit_map_create(ty_context* context, const ty_light_view* light, const ty_light_map* map,
                            ty_lit_map** out) {
    ty_lit_map* lit = ty_alloc_array(context, 1, sizeof *lit, true);
    if (lit == NULL) return TY_ERROR_MEMORY;
    lit->context = context;
    lit->map = map;
    lit->light = *light;
    while (width_at(lit, lit->levels++) > 1) continue;
    bool whole = true;
    for (int32_t i = 0; i < map->faces && whole; ++i) whole = take_face(lit, &lit->faces[i]);
    if (!whole) {
        ty_lit_map_destroy(lit);
        return TY_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < map->faces; ++i) fill_face(lit, i);
    *out = lit;
    return TY_OK;
}

void ty_lit_map_destroy(ty_lit_map* map) {
    if (map == NULL) return;
    for (int32_t i = 0; i < 6; ++i)
        ty_free_array(map->context, map->faces[i].nodes, map->faces[i].node_count, sizeof(float));
    ty_free_array(map->context, map, 1, sizeof *map);
}

/* ---- rays ---- */

/* A ray before a face, and the part of it that surfaces may be before. */
typedef struct face_ray {
    const ty_lit_face* face;
    ty_vec at, way; /* in the map */
    ty_lit_part part;
} face_ray;

static bool find_face(const ty_lit_map* map, int32_t index, ty_vec origin, ty_vec direction, ty_lit_part part,
                      face_ray* out) {
    const ty_lit_face* face = &map->faces[index];
    const float side = (float)map->map->side;
    if (isinf(face->nearest)) return false;
    const ty_vec at = ty_map_point(face->to_map, origin), way = ty_map_direction(face->to_map, direction);
    const bool flat = is_parallel(map);
    *out = (face_ray){.face = face, .at = at, .way = way, .part = part};
    const float span = flat ? side : side * at.z, span_way = flat ? 0.0f : side * way.z;
    return ty_lit_keep(at.z - 0.999f * face->nearest, way.z, &out->part) && ty_lit_keep(at.x, way.x, &out->part) &&
           ty_lit_keep(span - at.x, span_way - way.x, &out->part) && ty_lit_keep(at.y, way.y, &out->part) &&
           ty_lit_keep(span - at.y, span_way - way.y, &out->part);
}

static ty_lit_line line_of(const ty_lit_map* map, const face_ray* ray, float from) {
    ty_vec begin = ty_mad(ray->at, ray->way, from), end = ty_mad(ray->at, ray->way, ray->part.to);
    ty_lit_line line = {.from = from, .length = ray->part.to - from, .depth = {1.0f, 1.0f}};
    if (is_parallel(map)) {
        begin.z = -begin.z;
        end.z = -end.z;
    } else {
        const float near[2] = {1.0f / begin.z, 1.0f / end.z};
        line.depth[0] = begin.z;
        line.depth[1] = end.z;
        begin = ty_vec_make(begin.x * near[0], begin.y * near[0], near[0]);
        end = ty_vec_make(end.x * near[1], end.y * near[1], near[1]);
    }
    line.x = begin.x;
    line.y = begin.y;
    line.near = begin.z;
    line.dx = end.x - begin.x;
    line.dy = end.y - begin.y;
    line.dnear = end.z - begin.z;
    return line;
}

static void walk_face(const ty_lit_map* map, const face_ray* ray, float from, ty_lit_run* run) {
    const ty_lit_line line = line_of(map, ray, from);
    ty_lit_walk(ray->face, &line, map->map->side, map->levels - 1, run);
}

/* Gaps that are this long, relative to the distance, are between neighbouring faces. */
#define LIT_SEAM 1e-5f

int32_t ty_lit_stretches(const ty_lit_map* map, ty_vec origin, ty_vec direction, float from, float to,
                         float stretches[TY_LIT_STRETCHES][2]) {
    ty_lit_part part = {from, to};
    if (!(from < to)) return 0;
    if (map->light.kind == TY_KIND_SPOT &&
        !ty_lit_keep_cone(&map->light, map->light.cos_outer, origin, direction, &part))
        return 0;
    face_ray rays[6];
    int32_t count = 0;
    for (int32_t i = 0; i < map->map->faces; ++i)
        if (find_face(map, i, origin, direction, part, &rays[count])) ++count;
    ty_lit_run run = {.stretches = stretches, .lit = 1, .at = part.from};
    float t = part.from;
    for (;;) {
        int32_t next = -1;
        for (int32_t i = 0; i < count; ++i)
            if (rays[i].part.to > t && (next < 0 || rays[i].part.from < rays[next].part.from)) next = i;
        if (next < 0) break;
        const float begin = ty_maxf(t, rays[next].part.from);
        if (begin - t > LIT_SEAM * begin) ty_lit_turn(&run, t, 1);
        walk_face(map, &rays[next], begin, &run);
        t = rays[next].part.to;
    }
    if (part.to - t > LIT_SEAM * part.to) ty_lit_turn(&run, t, 1);
    ty_lit_turn(&run, part.to, 0);
    return run.count;
}

/* ---- many rays ---- */

static const ty_lit_kernels* choose_kernels(void) {
#if TY_ISA_X86
    static const ty_lit_kernels* const kernels[TY_ISA_COUNT] = {&ty_lit_kernels_v1, &ty_lit_kernels_v3,
                                                                &ty_lit_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_lit_kernels_v1;
#endif
}

/* Maps of one face: which rays have a part before surfaces, and all of those together. */
static void walk_together(const ty_lit_map* map, ty_lit_rays* rays) {
    ty_lit_line lines[TY_LIT_LINES];
    ty_lit_run runs[TY_LIT_LINES];
    ty_lit_part parts[TY_LIT_LINES];
    int32_t which[TY_LIT_LINES], count = 0;
    float ends[TY_LIT_LINES]; /* of what is before surfaces */
    for (int32_t i = 0; i < rays->count; ++i) {
        ty_lit_part part = {rays->from[i], rays->to[i]};
        face_ray ray;
        rays->counts[i] = 0;
        if (!(part.from < part.to)) continue;
        if (map->light.kind == TY_KIND_SPOT &&
            !ty_lit_keep_cone(&map->light, map->light.cos_outer, rays->origin, rays->direction[i], &part))
            continue;
        if (!find_face(map, 0, rays->origin, rays->direction[i], part, &ray)) {
            rays->stretches[i][0][0] = part.from;
            rays->stretches[i][0][1] = part.to;
            rays->counts[i] = 1;
            continue;
        }
        runs[count] = (ty_lit_run){.stretches = rays->stretches[i], .lit = 1, .at = part.from};
        lines[count] = line_of(map, &ray, ray.part.from);
        parts[count] = part;
        ends[count] = ray.part.to;
        which[count++] = i;
    }
    if (count == 0) return;
    choose_kernels()->walk(&map->faces[0], lines, count, map->map->side, map->levels - 1, runs);
    for (int32_t k = 0; k < count; ++k) {
        if (parts[k].to - ends[k] > LIT_SEAM * parts[k].to) ty_lit_turn(&runs[k], ends[k], 1);
        ty_lit_turn(&runs[k], parts[k].to, 0);
        rays->counts[which[k]] = runs[k].count;
    }
}

void ty_lit_stretches_of(const ty_lit_map* map, ty_lit_rays* rays) {
    if (map->map->faces == 1) {
        walk_together(map, rays);
        return;
    }
    for (int32_t i = 0; i < rays->count; ++i)
        rays->counts[i] =
            ty_lit_stretches(map, rays->origin, rays->direction[i], rays->from[i], rays->to[i], rays->stretches[i]);
}

/* ---- points ---- */

/* Where a point lies in the first face that has it; false where none does. */
static bool locate(const ty_lit_map* map, ty_vec point, int32_t* face, ty_vec* at) {
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

/* The plane through a point with a normal, before a face: 1 / depth on it is linear in the place on the map for lights
 * with a place, depth for others. */
typedef struct lit_plane {
    float depth, facing, along[2]; /* at the point: depth, how much it faces the light; its change by the texel */
} lit_plane;

static lit_plane plane_before(const ty_lit_map* map, int32_t face, ty_vec at, ty_vec normal) {
    const ty_light_map* of = map->map;
    const float per_texel = 2.0f / (float)of->side;
    const double n[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    double facing = 0, along[2] = {0, 0};
    for (int a = 0; a < 3; ++a) {
        facing -= n[a] * of->forward[face][a];
        along[0] -= n[a] * of->right[face][a];
        along[1] -= n[a] * of->up[face][a];
    }
    lit_plane plane = {.depth = at.z, .facing = (float)facing};
    for (int i = 0; i < 2; ++i) plane.along[i] = (float)along[i] * per_texel;
    if (!is_parallel(map))
        plane.facing +=
            plane.along[0] * (at.x - 0.5f * (float)of->side) + plane.along[1] * (at.y - 0.5f * (float)of->side);
    return plane;
}

/* Depth on the plane so many texels from the point; INFINITY: the plane is not before the light there. */
static float plane_depth(const ty_lit_map* map, const lit_plane* plane, float x, float y) {
    const float turn = plane->along[0] * x + plane->along[1] * y;
    if (is_parallel(map)) return plane->depth - turn / plane->facing;
    const float facing = plane->facing + turn;
    return facing > 0.0f ? plane->depth * plane->facing / facing : INFINITY;
}

float ty_lit_share(const ty_lit_map* map, ty_vec point, ty_vec normal, float slack, float close, bool* sure) {
    int32_t face;
    ty_vec at;
    *sure = true;
    if (map->light.kind == TY_KIND_SPOT && is_outside_cone(&map->light, point)) return 0.0f;
    if (!locate(map, point, &face, &at)) return 1.0f;
    const lit_job job = {.map = map, .face = face};
    const lit_plane plane = plane_before(map, face, at, normal);
    if (!(plane.facing > 0.0f)) return 0.0f;
    const int32_t last = map->map->side - 1;
    const float x = floorf(at.x - 0.5f), y = floorf(at.y - 0.5f);
    const float across = at.x - 0.5f - x, down = at.y - 0.5f - y;
    float share = 0.0f;
    int32_t lit = 0;
    for (int32_t i = 0; i < 4; ++i) {
        const int32_t column = ty_lit_clamp((int32_t)x + i % 2, 0, last);
        const int32_t row = ty_lit_clamp((int32_t)y + i / 2, 0, last);
        const float nearer = plane_depth(map, &plane, (float)column + 0.5f - at.x, (float)row + 0.5f - at.y) -
                             depth_at(&job, column, row);
        const bool shines = !(nearer > slack);
        if (shines) share += (i % 2 == 0 ? 1.0f - across : across) * (i / 2 == 0 ? 1.0f - down : down);
        lit += shines;
        if (!(nearer <= slack || nearer > close)) *sure = false;
    }
    if (lit != 0 && lit != 4) *sure = false;
    return share;
}
