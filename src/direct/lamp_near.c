/* Rays from a lamp, from cell to cell: next to it, light changes too much within cells for anything less. */
#include "direct/lamp_near.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/lamp.k.h"

/* Cells within NEAR of the lamp's own, by NEAR_RAYS^2 rays for each of the six ways. */
enum { NEAR = 2, NEAR_SIDE = 2 * NEAR + 1, NEAR_CELLS = NEAR_SIDE * NEAR_SIDE * NEAR_SIDE };
enum { NEAR_RAYS = 48, NEAR_RAYS_ONE_OF_MANY = 16 };

float ty_lamp_reach(const ty_lamp_job* lamp, ty_vec direction, float far) {
    if (lamp->scene->mesh == NULL) return far;
    ty_hit hit;
    ty_vec origin = lamp->source->position;
    const float side = ty_dot(lamp->source->direction, direction) < 0 ? -lamp->lift : lamp->lift;
    if (lamp->lift > 0) origin = ty_mad(origin, lamp->source->direction, side);
    return ty_accel_intersect(lamp->scene->mesh, origin, direction, far, &hit) ? hit.distance : far;
}

bool ty_lamp_is_near(const ty_lamp_job* lamp, const int32_t cell[3]) {
    for (int a = 0; a < 3; ++a)
        if (abs(cell[a] - lamp->home[a]) > NEAR) return false;
    return true;
}

void ty_lamp_near_range(const ty_lamp_job* lamp, int32_t axis, int32_t range[2]) {
    range[0] = lamp->home[axis] - NEAR;
    range[1] = lamp->home[axis] + NEAR + 1;
}

typedef struct near_sums {
    double light[NEAR_CELLS][3][4]; /* per channel: fluence and flux, times the cell's volume over intensity */
} near_sums;

/* A ray from cell to cell, in the lamp's own and those around it. */
typedef struct near_ray {
    int32_t cell[3], step[3]; /* from home */
    double next[3], per_cell[3];
    double at; /* m */
} near_ray;

static void begin_near_ray(const ty_lamp_job* lamp, const double way[3], near_ray* ray) {
    ray->at = 0;
    for (int a = 0; a < 3; ++a) {
        const double cell = lamp->medium->cell[a], low = lamp->lower[a] + cell * lamp->home[a];
        ray->cell[a] = 0;
        ray->step[a] = way[a] > 0 ? 1 : -1;
        ray->next[a] = way[a] > 0 ? (low + cell) / way[a] : way[a] < 0 ? low / way[a] : INFINITY;
        ray->per_cell[a] = way[a] != 0 ? cell / fabs(way[a]) : INFINITY;
    }
}

/* Moves to the next cell; false past the last of interest. */
static bool step_near_ray(near_ray* ray) {
    const int xy = ray->next[0] < ray->next[1] ? 0 : 1;
    const int a = ray->next[xy] < ray->next[2] ? xy : 2;
    ray->at = ray->next[a];
    ray->next[a] += ray->per_cell[a];
    ray->cell[a] += ray->step[a];
    return abs(ray->cell[a]) <= NEAR;
}

static void follow_near_ray(const ty_lamp_job* lamp, const double way[3], double weight, near_sums* sums) {
    const int32_t* size = lamp->medium->box.size;
    float depth[3] = {0, 0, 0};
    near_ray ray;
    const ty_vec direction = ty_vec_make((float)way[0], (float)way[1], (float)way[2]);
    const double end = (double)ty_lamp_reach(lamp, direction, TY_FLOAT_MAX);
    weight *= (double)ty_source_profile(lamp->light, ty_dot(direction, lamp->source->direction));
    if (!(weight > 0)) return;
    begin_near_ray(lamp, way, &ray);
    do {
        const double leave = fmin(end, fmin(ray.next[0], fmin(ray.next[1], ray.next[2])));
        const int32_t x = lamp->home[0] + ray.cell[0], y = lamp->home[1] + ray.cell[1], z = lamp->home[2] + ray.cell[2];
        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) continue;
        if (!(leave > ray.at)) continue;
        const size_t at = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
        const int32_t slot = ray.cell[0] + NEAR + NEAR_SIDE * (ray.cell[1] + NEAR + NEAR_SIDE * (ray.cell[2] + NEAR));
        for (int32_t c = 0; c < lamp->medium->planes; ++c) {
            const float through = lamp->extinction[c][at] * (float)(leave - ray.at), decay = ty_decay(through);
            const double light =
                weight * (leave - ray.at) * (double)(ty_decay(depth[c]) * ty_mean_decay(through, decay));
            depth[c] += through;
            sums->light[slot][c][0] += light;
            for (int a = 0; a < 3; ++a) sums->light[slot][c][1 + a] += light * way[a];
        }
    } while (ray.at < end && step_near_ray(&ray));
}

/* Rays at equal steps of the tangents, each for its share of the sphere. */
static void follow_near_rays(const ty_lamp_job* lamp, near_sums* sums) {
    const int32_t side = lamp->source->alone != 0 ? NEAR_RAYS : NEAR_RAYS_ONE_OF_MANY;
    for (int32_t i = 0; i < 6 * side * side; ++i) {
        const int32_t face = i / (side * side), w = face / 2;
        const double p = 2 * (i % side + 0.5) / side - 1, q = 2 * (i / side % side + 0.5) / side - 1;
        const double length = sqrt(1 + p * p + q * q);
        double way[3];
        way[w] = (face % 2 == 0 ? 1 : -1) / length;
        way[(w + 1) % 3] = p / length;
        way[(w + 2) % 3] = q / length;
        follow_near_ray(lamp, way, 4.0 / (side * side) / (length * length * length), sums);
    }
}

static void add_near(const ty_lamp_job* lamp, const near_sums* sums) {
    const ty_grid_medium* medium = lamp->medium;
    const int32_t* size = medium->box.size;
    const double volume = medium->cell[0] * medium->cell[1] * medium->cell[2];
    for (int32_t slot = 0; slot < NEAR_CELLS; ++slot) {
        const int32_t x = lamp->home[0] + slot % NEAR_SIDE - NEAR;
        const int32_t y = lamp->home[1] + slot / NEAR_SIDE % NEAR_SIDE - NEAR;
        const int32_t z = lamp->home[2] + slot / (NEAR_SIDE * NEAR_SIDE) - NEAR;
        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2]) continue;
        const size_t at = (size_t)x + (size_t)size[0] * ((size_t)y + (size_t)size[1] * (size_t)z);
        for (int32_t c = 0; c < lamp->out.planes; ++c) {
            const double* light = sums->light[slot][c < medium->planes ? c : 0];
            const double intensity = (double)lamp->out.color[c] / volume;
            lamp->out.fluence[c][at] += (float)(intensity * light[0]);
            for (int a = 0; a < 3 && lamp->out.flux != NULL; ++a)
                lamp->out.flux[c][a][at] += (float)(intensity * light[1 + a]);
        }
    }
}

static bool is_beside_box(const ty_lamp_job* lamp) {
    for (int a = 0; a < 3; ++a)
        if (lamp->home[a] < -NEAR || lamp->home[a] >= lamp->medium->box.size[a] + NEAR) return false;
    return true;
}

ty_result ty_lamp_add_near(const ty_lamp_job* lamp) {
    if (!is_beside_box(lamp)) return TY_OK;
    near_sums* sums = ty_alloc_array(lamp->medium->context, 1, sizeof *sums, true);
    if (sums == NULL) return TY_ERROR_MEMORY;
    const unsigned state = ty_flush_denormals();
    follow_near_rays(lamp, sums);
    add_near(lamp, sums);
    ty_restore_denormals(state);
    ty_free_array(lamp->medium->context, sums, 1, sizeof *sums);
    return TY_OK;
}
