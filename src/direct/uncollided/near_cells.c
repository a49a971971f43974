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

/* Adds a ray's light over `length` m of a cell, given relative to home, and the cell's optical depth to the ray's. */
static void add_near_cell(const ty_point_light_job* point, const int32_t from_home[3], const double omega[3],
                          double weight, double length, float depth[3], near_sums* sums) {
    const int32_t* size = point->medium->box.size;
    const int32_t x = point->home[0] + from_home[0], y = point->home[1] + from_home[1],
                  z = point->home[2] + from_home[2];
    if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) return;
    const size_t at = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
    const int32_t slot = from_home[0] + NEAR + NEAR_SIDE * (from_home[1] + NEAR + NEAR_SIDE * (from_home[2] + NEAR));
    for (int32_t c = 0; c < point->medium->planes; ++c) {
        const float through = point->extinction[c][at] * (float)length, decay = ty_attenuation(through);
        const double light = weight * length * (double)(ty_attenuation(depth[c]) * ty_mean_attenuation(through, decay));
        depth[c] += through;
        sums->light[slot][c][0] += light;
        for (int a = 0; a < 3; ++a) sums->light[slot][c][1 + a] += light * omega[a];
    }
}

static void follow_near_ray(const ty_point_light_job* point, const double omega[3], double weight, near_sums* sums) {
    float depth[3] = {0, 0, 0};
    const ty_vec direction = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    const double end = (double)ty_point_light_visible_distance(point, direction, TY_FLOAT_MAX);
    weight *=
        (double)ty_light_profile_at(point->source->profile, point->light, ty_dot(direction, point->source->direction));
    if (!(weight > 0)) return;
    ty_voxel_dda ray = begin_near_ray(point, omega);
    bool near = true;
    for (double enter = 0; near && enter < end;) {
        const int axis = ty_voxel_dda_axis(&ray);
        const double face = ray.next[axis], leave = fmin(end, face);
        if (leave > enter) add_near_cell(point, ray.voxel, omega, weight, leave - enter, depth, sums);
        enter = face;
        ty_voxel_dda_advance(&ray, axis);
        near = abs(ray.voxel[axis]) <= NEAR;
    }
}

/* Rays in equal steps of tangents on a cube's faces, weighted by solid angle. */
static void follow_near_rays(const ty_point_light_job* point, near_sums* sums) {
    const int32_t side = point->source->is_point != 0 ? NEAR_RAYS : NEAR_RAYS_ONE_OF_MANY;
    for (int32_t i = 0; i < 6 * side * side; ++i) {
        const int32_t face = i / (side * side), w = face / 2;
        const double p = 2 * (i % side + 0.5) / side - 1, q = 2 * (i / side % side + 0.5) / side - 1;
        const double length = sqrt(1 + p * p + q * q);
        double omega[3];
        omega[w] = (face % 2 == 0 ? 1 : -1) / length;
        omega[(w + 1) % 3] = p / length;
        omega[(w + 2) % 3] = q / length;
        follow_near_ray(point, omega, 4.0 / (side * side) / (length * length * length), sums);
    }
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
