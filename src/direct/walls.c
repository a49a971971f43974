/* Which faces of cells surfaces close, by rays from middle to middle, and what they are made of. */
#include "direct/walls.h"

#include "base/context.h"
#include "base/parallel.h"
#include "scene/fetch.h"
#include "scene/scene.h"

/* Off cells' middles by this much, in cells, so that surfaces through middles are on one side of them. */
static const double aside[3] = {1e-3, 0.7e-3, 0.4e-3};

typedef struct wall_job {
    const ty_scene* scene;
    const ty_grid_medium* medium;
    ty_walls* walls;
    double lower[3], upper[3]; /* around all surfaces */
    int32_t axis;
} wall_job;

static size_t cell_at(const ty_walls* walls, const int32_t at[3]) {
    return ((size_t)at[2] * (size_t)walls->size[1] + (size_t)at[1]) * (size_t)walls->size[0] + (size_t)at[0];
}

/* From the middle of a cell to that of the next one along an axis, up or down. */
static ty_ray ray_from(const ty_grid_medium* medium, const int32_t at[3], int axis, bool up) {
    ty_ray ray = {.far = (float)medium->cell[axis]};
    for (int a = 0; a < 3; ++a)
        ray.origin[a] = (float)(medium->box.lower[a] + (at[a] + 0.5 + aside[a]) * medium->cell[a]);
    ray.direction[axis] = up ? 1 : -1;
    return ray;
}

/* ---- closed faces ---- */

static bool is_near(const wall_job* job, const ty_ray* first, float length) {
    for (int a = 0; a < 3; ++a) {
        const double begin = (double)first->origin[a], end = begin + (a == job->axis ? (double)length : 0);
        if (end < job->lower[a] || begin > job->upper[a]) return false;
    }
    return true;
}

/* The faces along a line of cells: `packet` of them from the one below cell `begin` on. */
static void close_some(const wall_job* job, const int32_t line[3], int32_t begin, int32_t count) {
    ty_walls* walls = job->walls;
    ty_ray rays[TY_PACKET];
    bool closed[TY_PACKET];
    int32_t at[3] = {line[0], line[1], line[2]};
    for (int32_t i = 0; i < count; ++i) {
        at[job->axis] = begin + i - 1;
        rays[i] = ray_from(job->medium, at, job->axis, true);
    }
    if (!is_near(job, &rays[0], (float)count * rays[0].far)) return;
    ty_accel_occluded_packet(job->scene->view.mesh, rays, count, closed);
    for (int32_t i = 0; i < count; ++i) {
        if (!closed[i]) continue;
        at[job->axis] = begin + i - 1;
        if (at[job->axis] >= 0) walls->closed[cell_at(walls, at)] |= (uint8_t)(1 << (2 * job->axis + 1));
        ++at[job->axis];
        if (at[job->axis] < walls->size[job->axis]) walls->closed[cell_at(walls, at)] |= (uint8_t)(1 << 2 * job->axis);
    }
}

static void close_lines(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const wall_job* job = user;
    const int32_t* size = job->walls->size;
    const int32_t u = job->axis == 0 ? 1 : 0, v = job->axis == 2 ? 1 : 2, faces = size[job->axis] + 1;
    int32_t line[3] = {0, 0, 0};
    line[v] = (int32_t)index;
    for (line[u] = 0; line[u] < size[u]; ++line[u])
        for (int32_t begin = 0; begin < faces; begin += TY_PACKET)
            close_some(job, line, begin, faces - begin < TY_PACKET ? faces - begin : TY_PACKET);
}

/* ---- sides ---- */

static int32_t count_bits(uint8_t bits) {
    int32_t count = 0;
    for (; bits != 0; bits &= (uint8_t)(bits - 1)) ++count;
    return count;
}

static void count_sides(ty_walls* walls) {
    const size_t rows = (size_t)walls->size[1] * (size_t)walls->size[2], cells = (size_t)walls->size[0];
    for (size_t row = 0; row < rows; ++row) {
        walls->first[row] = walls->count;
        for (size_t i = 0; i < cells; ++i) walls->count += count_bits(walls->closed[row * cells + i]);
    }
    walls->first[rows] = walls->count;
}

/* The surface that a side is of; where the ray back from the next cell met it and this one does not, that. */
static void take_side(const wall_job* job, const int32_t at[3], int32_t face, ty_wall* side) {
    const ty_scene_view* view = &job->scene->view;
    const int axis = face / 2;
    const bool up = (face & 1) != 0;
    ty_ray ray = ray_from(job->medium, at, axis, up);
    ty_hit hit;
    ty_vec origin = ty_vec_load(ray.origin), way = ty_vec_load(ray.direction);
    bool met = ty_accel_intersect(view->mesh, origin, way, ray.far, &hit);
    float depth = hit.distance / ray.far;
    if (!met) {
        met = ty_accel_intersect(view->mesh, ty_mad(origin, way, ray.far), ty_scale(way, -1), ray.far, &hit);
        depth = 1 - hit.distance / ray.far;
    }
    *side = (ty_wall){.position = origin, .normal = ty_scale(way, -1), .depth = 0.5f, .stairs = 1};
    if (!met) return;
    side->depth = depth;
    ty_surface_point point;
    ty_surfaces_fetch(view->surfaces, &hit, 1);
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, way, &point);
    side->normal = point.ng;
    side->position = ty_hit_leave(&hit, point.ng);
    side->stairs = fabsf(point.ng.x) + fabsf(point.ng.y) + fabsf(point.ng.z);
    for (int c = 0; c < 3; ++c) {
        side->albedo[c] = ty_minf(point.albedo[c], 1);
        side->emission[c] = point.light < 0 ? point.emission[c] : 0;
    }
}

static void take_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const wall_job* job = user;
    ty_walls* walls = job->walls;
    int32_t side = walls->first[row], at[3] = {0, (int32_t)(row % walls->size[1]), (int32_t)(row / walls->size[1])};
    if (side == walls->first[row + 1]) return;
    for (; at[0] < walls->size[0]; ++at[0]) {
        const uint8_t closed = walls->closed[cell_at(walls, at)];
        for (uint8_t face = 0; face < 6; ++face) {
            if ((closed >> face & 1) == 0) continue;
            walls->x[side] = at[0];
            walls->face[side] = face;
            take_side(job, at, face, &walls->sides[side++]);
        }
    }
}

/* ---- all ---- */

static ty_result take_sides(wall_job* job) {
    ty_walls* walls = job->walls;
    count_sides(walls);
    const size_t count = (size_t)walls->count;
    walls->x = ty_alloc_array(walls->context, count, sizeof *walls->x, false);
    walls->face = ty_alloc_array(walls->context, count, sizeof *walls->face, false);
    walls->sides = ty_alloc_array(walls->context, count, sizeof *walls->sides, false);
    if (walls->x == NULL || walls->face == NULL || walls->sides == NULL) return TY_ERROR_MEMORY;
    ty_parallel_flushed(walls->context, (int64_t)walls->size[1] * walls->size[2], take_row, job);
    return TY_OK;
}

static size_t row_count(const ty_walls* walls) {
    return (size_t)walls->size[1] * (size_t)walls->size[2];
}

ty_result ty_walls_find(const ty_scene* scene, const ty_grid_medium* medium, ty_walls** out) {
    ty_context* context = scene->context;
    *out = NULL;
    if (scene->view.mesh == NULL) return TY_OK;
    ty_walls* walls = ty_alloc_array(context, 1, sizeof *walls, true);
    if (walls == NULL) return TY_ERROR_MEMORY;
    walls->context = context;
    memcpy(walls->size, medium->box.size, sizeof walls->size);
    walls->first = ty_alloc_array(context, row_count(walls) + 1, sizeof *walls->first, false);
    walls->closed = ty_alloc_array(context, medium->cells, 1, true);
    ty_result result = walls->first != NULL && walls->closed != NULL ? TY_OK : TY_ERROR_MEMORY;
    wall_job job = {.scene = scene, .medium = medium, .walls = walls};
    ty_scene_surface_extent(scene, job.lower, job.upper);
    for (; job.axis < 3 && result == TY_OK; ++job.axis)
        ty_parallel_flushed(context, walls->size[job.axis == 2 ? 1 : 2], close_lines, &job);
    if (result == TY_OK) result = take_sides(&job);
    if (result != TY_OK || walls->count == 0)
        ty_walls_destroy(walls);
    else
        *out = walls;
    return result;
}

void ty_walls_destroy(ty_walls* walls) {
    if (walls == NULL) return;
    ty_context* context = walls->context;
    const size_t count = (size_t)walls->count;
    ty_free_array(context, walls->first, row_count(walls) + 1, sizeof *walls->first);
    ty_free_array(context, walls->closed, row_count(walls) * (size_t)walls->size[0], 1);
    ty_free_array(context, walls->x, count, sizeof *walls->x);
    ty_free_array(context, walls->face, count, sizeof *walls->face);
    ty_free_array(context, walls->sides, count, sizeof *walls->sides);
    ty_free_array(context, walls, 1, sizeof *walls);
}

/* Of what a stair sends, the part 1 - 1 / stairs meets other stairs of its surface. */
void ty_wall_of_stairs(const ty_wall* wall, float albedo, float* of_stairs, float* share) {
    const float met = 1 - 1 / wall->stairs;
    *of_stairs = albedo / (1 - met * (1 - albedo));
    *share = 1 - *of_stairs * met;
}
