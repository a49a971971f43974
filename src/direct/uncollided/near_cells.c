/* Ray marching through the cells next to a point light, within which fluence varies too much for interpolation. */
#include "direct/uncollided/near_cells.h"

#include "base/context.h"
#include "base/float_mode.h"
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
    return ty_mesh_intersect(point->scene->mesh, origin, direction, far, &hit) ? hit.distance : far;
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

/* A ray through the light's own cell and those around it. */
typedef struct near_ray {
    int32_t cell[3], step[3]; /* relative to home */
    double next[3], per_cell[3];
    double at; /* distance, m */
} near_ray;

static void begin_near_ray(const ty_point_light_job* point, const double omega[3], near_ray* ray) {
    ray->at = 0;
    for (int a = 0; a < 3; ++a) {
        const double cell = point->medium->cell[a], low = point->lower[a] + cell * point->home[a];
        ray->cell[a] = 0;
        ray->step[a] = omega[a] > 0 ? 1 : -1;
        ray->next[a] = omega[a] > 0 ? (low + cell) / omega[a] : omega[a] < 0 ? low / omega[a] : INFINITY;
        ray->per_cell[a] = omega[a] != 0 ? cell / fabs(omega[a]) : INFINITY;
    }
}

/* Advances to the next cell; false beyond the near cells. */
static bool step_near_ray(near_ray* ray) {
    const int xy = ray->next[0] < ray->next[1] ? 0 : 1;
    const int a = ray->next[xy] < ray->next[2] ? xy : 2;
    ray->at = ray->next[a];
    ray->next[a] += ray->per_cell[a];
    ray->cell[a] += ray->step[a];
    return abs(ray->cell[a]) <= NEAR;
}

static void follow_near_ray(const ty_point_light_job* point, const double omega[3], double weight, near_sums* sums) {
    const int32_t* size = point->medium->box.size;
    float depth[3] = {0, 0, 0};
    near_ray ray;
    const ty_vec direction = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    const double end = (double)ty_point_light_visible_distance(point, direction, TY_FLOAT_MAX);
    weight *=
        (double)ty_light_profile_at(point->source->profile, point->light, ty_dot(direction, point->source->direction));
    if (!(weight > 0)) return;
    begin_near_ray(point, omega, &ray);
    do {
        const double leave = fmin(end, fmin(ray.next[0], fmin(ray.next[1], ray.next[2])));
        const int32_t x = point->home[0] + ray.cell[0], y = point->home[1] + ray.cell[1],
                      z = point->home[2] + ray.cell[2];
        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) continue;
        if (!(leave > ray.at)) continue;
        const size_t at = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
        const int32_t slot = ray.cell[0] + NEAR + NEAR_SIDE * (ray.cell[1] + NEAR + NEAR_SIDE * (ray.cell[2] + NEAR));
        for (int32_t c = 0; c < point->medium->planes; ++c) {
            const float through = point->extinction[c][at] * (float)(leave - ray.at), decay = ty_decay(through);
            const double light =
                weight * (leave - ray.at) * (double)(ty_decay(depth[c]) * ty_mean_decay(through, decay));
            depth[c] += through;
            sums->light[slot][c][0] += light;
            for (int a = 0; a < 3; ++a) sums->light[slot][c][1 + a] += light * omega[a];
        }
    } while (ray.at < end && step_near_ray(&ray));
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
