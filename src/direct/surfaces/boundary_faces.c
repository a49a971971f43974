/* Closed faces, found by rays between cell centers, and the surfaces that close them. */
#include "direct/surfaces/boundary_faces.h"

#include "base/context.h"
#include "base/parallel.h"
#include "scene/surfaces/fetch.h"
#include "scene/scene.h"

/* Offset of rays from cell centers, in cells, so that a surface through the centers lies on one side of them. */
static const double offset[3] = {1e-3, 0.7e-3, 0.4e-3};

typedef struct face_job {
    const ty_scene* scene;
    const ty_grid_medium* medium;
    ty_boundary_faces* faces;
    double lower[3], upper[3]; /* of all surfaces */
    int32_t axis;
} face_job;

static size_t cell_at(const ty_boundary_faces* faces, const int32_t at[3]) {
    return ((size_t)at[2] * (size_t)faces->size[1] + (size_t)at[1]) * (size_t)faces->size[0] + (size_t)at[0];
}

/* The ray from a cell's center to that of the next cell along an axis. */
static ty_ray ray_from(const ty_grid_medium* medium, const int32_t at[3], int axis, bool up) {
    ty_ray ray = {.far = (float)medium->cell[axis]};
    for (int a = 0; a < 3; ++a)
        ray.origin[a] = (float)(medium->box.lower[a] + (at[a] + 0.5 + offset[a]) * medium->cell[a]);
    ray.direction[axis] = up ? 1 : -1;
    return ray;
}

/* ---- closed faces ---- */

static bool is_near(const face_job* job, const ty_ray* first, float length) {
    for (int a = 0; a < 3; ++a) {
        const double begin = (double)first->origin[a], end = begin + (a == job->axis ? (double)length : 0);
        if (end < job->lower[a] || begin > job->upper[a]) return false;
    }
    return true;
}

/* Tests `count` faces along a line of cells, from the lower face of cell `begin` on. */
static void close_packet(const face_job* job, const int32_t line[3], int32_t begin, int32_t count) {
    ty_boundary_faces* faces = job->faces;
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
        if (at[job->axis] >= 0) faces->closed[cell_at(faces, at)] |= (uint8_t)(1 << (2 * job->axis + 1));
        ++at[job->axis];
        if (at[job->axis] < faces->size[job->axis]) faces->closed[cell_at(faces, at)] |= (uint8_t)(1 << 2 * job->axis);
    }
}

static void close_lines(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const face_job* job = user;
    const int32_t* size = job->faces->size;
    const int32_t u = job->axis == 0 ? 1 : 0, v = job->axis == 2 ? 1 : 2, faces = size[job->axis] + 1;
    int32_t line[3] = {0, 0, 0};
    line[v] = (int32_t)index;
    for (line[u] = 0; line[u] < size[u]; ++line[u])
        for (int32_t begin = 0; begin < faces; begin += TY_PACKET)
            close_packet(job, line, begin, faces - begin < TY_PACKET ? faces - begin : TY_PACKET);
}

/* ---- sides ---- */

static int32_t count_bits(uint8_t bits) {
    int32_t count = 0;
    for (; bits != 0; bits &= (uint8_t)(bits - 1)) ++count;
    return count;
}

static void count_sides(ty_boundary_faces* faces) {
    const size_t rows = (size_t)faces->size[1] * (size_t)faces->size[2], cells = (size_t)faces->size[0];
    for (size_t row = 0; row < rows; ++row) {
        faces->first[row] = faces->count;
        for (size_t i = 0; i < cells; ++i) faces->count += count_bits(faces->closed[row * cells + i]);
    }
    faces->first[rows] = faces->count;
}

/* The surface of a side. Where only the opposite ray from the next cell hits it, that hit is used. */
static void find_side(const face_job* job, const int32_t at[3], int32_t face, ty_boundary_side* side) {
    const ty_scene_view* view = &job->scene->view;
    const int axis = face / 2;
    const bool up = (face & 1) != 0;
    ty_ray ray = ray_from(job->medium, at, axis, up);
    ty_hit hit;
    ty_vec origin = ty_vec_load(ray.origin), omega = ty_vec_load(ray.direction);
    bool occluded_fraction = ty_accel_intersect(view->mesh, origin, omega, ray.far, &hit);
    float depth = hit.distance / ray.far;
    if (!occluded_fraction) {
        occluded_fraction =
            ty_accel_intersect(view->mesh, ty_mad(origin, omega, ray.far), ty_scale(omega, -1), ray.far, &hit);
        depth = 1 - hit.distance / ray.far;
    }
    *side = (ty_boundary_side){.position = origin, .normal = ty_scale(omega, -1), .depth = 0.5f, .staircase_factor = 1};
    if (!occluded_fraction) return;
    side->depth = depth;
    ty_surface_point point;
    ty_surfaces_fetch(view->surfaces, &hit, 1);
    ty_surface_evaluate(&view->surfaces[hit.surface], &hit, omega, &point);
    side->normal = point.ng;
    side->position = ty_hit_leave(&hit, point.ng);
    side->staircase_factor = fabsf(point.ng.x) + fabsf(point.ng.y) + fabsf(point.ng.z);
    for (int c = 0; c < 3; ++c) {
        side->albedo[c] = ty_minf(point.albedo[c], 1);
        side->emission[c] = point.light < 0 ? point.emission[c] : 0;
    }
}

static void find_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const face_job* job = user;
    ty_boundary_faces* faces = job->faces;
    int32_t side = faces->first[row], at[3] = {0, (int32_t)(row % faces->size[1]), (int32_t)(row / faces->size[1])};
    if (side == faces->first[row + 1]) return;
    for (; at[0] < faces->size[0]; ++at[0]) {
        const uint8_t closed = faces->closed[cell_at(faces, at)];
        for (uint8_t face = 0; face < 6; ++face) {
            if ((closed >> face & 1) == 0) continue;
            faces->x[side] = at[0];
            faces->face[side] = face;
            find_side(job, at, face, &faces->sides[side++]);
        }
    }
}

/* ---- all ---- */

static ty_result find_sides(face_job* job) {
    ty_boundary_faces* faces = job->faces;
    count_sides(faces);
    const size_t count = (size_t)faces->count;
    faces->x = ty_alloc_array(faces->context, count, sizeof *faces->x, false);
    faces->face = ty_alloc_array(faces->context, count, sizeof *faces->face, false);
    faces->sides = ty_alloc_array(faces->context, count, sizeof *faces->sides, false);
    if (faces->x == NULL || faces->face == NULL || faces->sides == NULL) return TY_ERROR_MEMORY;
    ty_parallel_flushed(faces->context, (int64_t)faces->size[1] * faces->size[2], find_row, job);
    return TY_OK;
}

static size_t row_count(const ty_boundary_faces* faces) {
    return (size_t)faces->size[1] * (size_t)faces->size[2];
}

ty_result ty_boundary_faces_find(const ty_scene* scene, const ty_grid_medium* medium, ty_boundary_faces** out) {
    ty_context* context = scene->context;
    *out = NULL;
    if (scene->view.mesh == NULL) return TY_OK;
    ty_boundary_faces* faces = ty_alloc_array(context, 1, sizeof *faces, true);
    if (faces == NULL) return TY_ERROR_MEMORY;
    faces->context = context;
    memcpy(faces->size, medium->box.size, sizeof faces->size);
    faces->first = ty_alloc_array(context, row_count(faces) + 1, sizeof *faces->first, false);
    faces->closed = ty_alloc_array(context, medium->cells, 1, true);
    ty_result result = faces->first != NULL && faces->closed != NULL ? TY_OK : TY_ERROR_MEMORY;
    face_job job = {.scene = scene, .medium = medium, .faces = faces};
    ty_scene_surface_extent(scene, job.lower, job.upper);
    for (; job.axis < 3 && result == TY_OK; ++job.axis)
        ty_parallel_flushed(context, faces->size[job.axis == 2 ? 1 : 2], close_lines, &job);
    if (result == TY_OK) result = find_sides(&job);
    if (result != TY_OK || faces->count == 0)
        ty_boundary_faces_destroy(faces);
    else
        *out = faces;
    return result;
}

void ty_boundary_faces_destroy(ty_boundary_faces* faces) {
    if (faces == NULL) return;
    ty_context* context = faces->context;
    const size_t count = (size_t)faces->count;
    ty_free_array(context, faces->first, row_count(faces) + 1, sizeof *faces->first);
    ty_free_array(context, faces->closed, row_count(faces) * (size_t)faces->size[0], 1);
    ty_free_array(context, faces->x, count, sizeof *faces->x);
    ty_free_array(context, faces->face, count, sizeof *faces->face);
    ty_free_array(context, faces->sides, count, sizeof *faces->sides);
    ty_free_array(context, faces, 1, sizeof *faces);
}

bool ty_boundary_contains(const ty_grid_medium* medium, ty_vec point) {
    const float at[3] = {point.x, point.y, point.z};
    bool inside = true;
    for (int a = 0; a < 3; ++a)
        inside = inside && (double)at[a] > medium->box.lower[a] - 0.5 * medium->cell[a] &&
                 (double)at[a] < medium->box.upper[a] + 0.5 * medium->cell[a];
    return inside;
}

/* The fraction 1 - 1 / staircase_factor of the light that a face sends meets other faces of the same staircase. */
void ty_staircase_albedo(const ty_boundary_side* side, float albedo, float* effective_albedo, float* emission_factor) {
    const float occluded_fraction = 1 - 1 / side->staircase_factor;
    *effective_albedo = albedo / (1 - occluded_fraction * (1 - albedo));
    *emission_factor = 1 - *effective_albedo * occluded_fraction;
}
