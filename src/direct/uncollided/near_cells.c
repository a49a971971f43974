/* Ray marching through the cells next to a point light, within which fluence varies too much for interpolation. */
#include "direct/uncollided/near_cells.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "base/voxel_dda.h"
#include "direct/uncollided/point_light.k.h"

/* Cells within NEAR of the light's own, by NEAR_RAYS^2 rays for each of the six faces of a cube. */
enum { NEAR = 2, NEAR_SIDE = 2 * NEAR + 1, NEAR_CELLS = NEAR_SIDE * NEAR_SIDE * NEAR_SIDE };
enum { NEAR_RAYS = 48, NEAR_RAYS_ONE_OF_MANY = 16 };

float ty_point_light_visible_distance(const ty_point_light_job* point, ty_vec direction, float far) {
    if (point->scene->mesh == NULL) return far;
    ty_hit hit;
    ty_vec origin = point->source->position;
    const float side = ty_dot(point->source->direction, direction) < 0 ? -point->lift : point->lift;
    if (point->lift > 0) origin = ty_mad(origin, point->source->direction, side);
    return ty_accel_intersect(point->scene->mesh, origin, direction, far, &hit) ? hit.distance : far;
}

bool ty_near_cells_contain(const ty_point_light_job* point, const int32_t cell[3]) {
    for (int a = 0; a < 3; ++a)
        if (abs(cell[a] - point->home[a]) > NEAR) return false;
    return true;
}

void ty_near_cells_range(const ty_point_light_job* point, int32_t axis, int32_t range[2]) {
    range[0] = point->home[axis] - NEAR;
    range[1] = point->home[axis] + NEAR + 1;
}

typedef struct near_sums {
    double light[NEAR_CELLS][3][4]; /* per channel: fluence and flux, times the cell's volume over intensity */
} near_sums;

/* A ray from the light's own cell, which is voxel 0, through those around it. */
static ty_voxel_dda begin_near_ray(const ty_point_light_job* point, const double omega[3]) {
    ty_voxel_dda ray;
    for (int a = 0; a < 3; ++a) {
        const double cell = point->medium->cell[a], low = point->lower[a] + cell * point->home[a];
        ty_voxel_dda_set(&ray, a, 0, omega[a], low, low + cell, cell);
    }
    return ray;
}

/* The cells of the box along a ray from the light. */
enum { PATH_MAX_CELLS = 3 * NEAR_SIDE };
typedef struct near_path {
    double omega[3], weight; /* solid angle times relative intensity */
    int32_t count, slot[PATH_MAX_CELLS];
    size_t at[PATH_MAX_CELLS]; /* offsets in planes */
    double length[PATH_MAX_CELLS];
} near_path;

/* Appends `length` m of a cell that is given relative to home. */
static void append_cell(const ty_point_light_job* point, const int32_t from_home[3], double length, near_path* path) {
    const int32_t* size = point->medium->box.size;
    const int32_t x = point->home[0] + from_home[0], y = point->home[1] + from_home[1],
                  z = point->home[2] + from_home[2];
    if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return;
    path->at[path->count] = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
    path->slot[path->count] =
        from_home[0] + NEAR + NEAR_SIDE * (from_home[1] + NEAR + NEAR_SIDE * (from_home[2] + NEAR));
    path->length[path->count++] = length;
}

/* The path along path->omega, of the solid angle path->weight; false: the light does not shine there. */
static bool find_path(const ty_point_light_job* point, near_path* path) {
    const double* omega = path->omega;
    const ty_vec direction = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    const double end = (double)ty_point_light_visible_distance(point, direction, TY_FLOAT_MAX);
    path->count = 0;
    path->weight *=
        (double)ty_light_profile_at(point->source->profile, point->light, ty_dot(direction, point->source->direction));
    if (!(path->weight > 0)) return false;
    ty_voxel_dda ray = begin_near_ray(point, omega);
    bool near = true;
    for (double enter = 0; near && enter < end;) {
        const int axis = ty_voxel_dda_axis(&ray);
        const double face = ray.next[axis], leave = fmin(end, face);
        if (leave > enter) append_cell(point, ray.voxel, leave - enter, path);
        enter = face;
        ty_voxel_dda_advance(&ray, axis);
        near = abs(ray.voxel[axis]) <= NEAR;
    }
    return true;
}

static void add_path(const ty_point_light_job* point, const near_path* path, near_sums* sums) {
    for (int32_t c = 0; c < point->medium->planes; ++c) {
        float depth = 0;
        for (int32_t i = 0; i < path->count; ++i) {
            const double length = path->length[i];
            const float through = point->extinction[c][path->at[i]] * (float)length, decay = ty_attenuation(through);
            const double light =
                path->weight * length * (double)(ty_attenuation(depth) * ty_mean_attenuation(through, decay));
            depth += through;
            double* sum = sums->light[path->slot[i]][c];
            sum[0] += light;
            for (int a = 0; a < 3; ++a) sum[1 + a] += light * path->omega[a];
        }
    }
}

/* The path of ray i: in equal steps of tangents on a cube's faces, weighted by solid angle; false: it is dark. */
static bool find_ray(const ty_point_light_job* point, int32_t side, int32_t i, near_path* path) {
    const int32_t face = i / (side * side), w = face / 2;
    const double p = 2 * (i % side + 0.5) / side - 1, q = 2 * (i / side % side + 0.5) / side - 1;
    const double length = sqrt(1 + p * p + q * q);
    path->omega[w] = (face % 2 == 0 ? 1 : -1) / length;
    path->omega[(w + 1) % 3] = p / length;
    path->omega[(w + 2) % 3] = q / length;
    path->weight = 4.0 / (side * side) / (length * length * length);
    return find_path(point, path);
}

static int32_t rays_per_side(const ty_point_light_job* point) {
    return point->source->is_point != 0 ? NEAR_RAYS : NEAR_RAYS_ONE_OF_MANY;
}

static void follow_near_rays(const ty_point_light_job* point, near_sums* sums) {
    const int32_t side = rays_per_side(point);
    near_path path;
    for (int32_t i = 0; i < 6 * side * side; ++i)
        if (find_ray(point, side, i, &path)) add_path(point, &path, sums);
}

static void add_near(const ty_point_light_job* point, const near_sums* sums) {
    const ty_grid_medium* medium = point->medium;
    const int32_t* size = medium->box.size;
    const double volume = medium->cell[0] * medium->cell[1] * medium->cell[2];
    for (int32_t slot = 0; slot < NEAR_CELLS; ++slot) {
        const int32_t x = point->home[0] + slot % NEAR_SIDE - NEAR;
        const int32_t y = point->home[1] + slot / NEAR_SIDE % NEAR_SIDE - NEAR;
        const int32_t z = point->home[2] + slot / (NEAR_SIDE * NEAR_SIDE) - NEAR;
        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) continue;
        const size_t at = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
        for (int32_t c = 0; c < point->out.planes; ++c) {
            const double* light = sums->light[slot][c < medium->planes ? c : 0];
            const double intensity = (double)point->out.color[c] / volume;
            point->out.fluence[c][at] += (float)(intensity * light[0]);
            for (int a = 0; a < 3 && point->out.flux != NULL; ++a)
                point->out.flux[c][a][at] += (float)(intensity * light[1 + a]);
        }
    }
}

static bool is_beside_box(const ty_point_light_job* point) {
    for (int a = 0; a < 3; ++a)
        if (point->home[a] < -NEAR || point->home[a] >= point->medium->box.size[a] + NEAR) return false;
    return true;
}

ty_result ty_near_cells_add(const ty_point_light_job* point) {
    if (!is_beside_box(point)) return TY_OK;
    near_sums* sums = ty_alloc_array(point->medium->context, 1, sizeof *sums, true);
    if (sums == NULL) return TY_ERROR_MEMORY;
    const unsigned state = ty_flush_denormals();
    follow_near_rays(point, sums);
    add_near(point, sums);
    ty_restore_denormals(state);
    ty_free_array(point->medium->context, sums, 1, sizeof *sums);
    return TY_OK;
}

/* ---- the adjoint ---- */

/* With light = weight length t m(x) in a cell, t' = t exp(-x) behind it, and * for derivatives of a loss (collimated_
 * adjoint.c): x* = t (light* m' - t'* exp(-x)), t* = light* m + t'* exp(-x). */
static void return_path(const ty_point_light_job* point, const near_path* path, const float* weight, float* gradient,
                        float* light) {
    double before[PATH_MAX_CELLS], behind = 0;
    float depth = 0;
    for (int32_t i = 0; i < path->count; ++i) {
        before[i] = (double)ty_attenuation(depth);
        depth += point->extinction[0][path->at[i]] * (float)path->length[i];
    }
    for (int32_t i = path->count - 1; i >= 0; --i) {
        const double length = path->length[i], by_light = path->weight * length * (double)weight[path->at[i]];
        const float x = point->extinction[0][path->at[i]] * (float)length, decay = ty_attenuation(x);
        const float m = ty_mean_attenuation(x, decay), slope = ty_mean_attenuation_slope(x, decay, m);
        gradient[path->at[i]] += (float)(length * before[i] * (by_light * (double)slope - behind * (double)decay));
        light[path->at[i]] += (float)(path->weight * length * before[i] * (double)m);
        behind = by_light * (double)m + behind * (double)decay;
    }
}

void ty_near_cells_return(const ty_point_light_job* point, const float* weight, float* gradient, float* light) {
    const int32_t side = rays_per_side(point);
    near_path path;
    if (!is_beside_box(point)) return;
    for (int32_t i = 0; i < 6 * side * side; ++i)
        if (find_ray(point, side, i, &path)) return_path(point, &path, weight, gradient, light);
}
