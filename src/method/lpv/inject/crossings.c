/* Exact blocking of links by rays from cell center to cell center. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/inject/inject.h"
#include "method/lpv/lattice/links.h"
#include "scene/scene.h"

/* Offset of the rays from the cell centers, in cells, so that a surface through the centers lies on one side. */
static const double aside[3] = {1e-3, 0.7e-3, 0.4e-3};

typedef struct crossing_job {
    const ty_scene* scene;
    ty_lattice* lattice;
    const uint8_t* near;                 /* per cell: whether any of its links is partly blocked */
    uint8_t* crossed[TY_LPV_HALF_LINKS]; /* per link, indexed as in ty_link_grid */
    ty_link_grid grids[TY_LPV_HALF_LINKS];
    ty_ray_counter* counter;
} crossing_job;

/* A packet of rays and where their results are stored. */
typedef struct crossing_packet {
    ty_ray rays[TY_PACKET];
    uint8_t* out[TY_PACKET];
    int32_t count;
    int64_t traced;
    double seconds;
} crossing_packet;

static void trace(const crossing_job* job, crossing_packet* packet) {
    bool occluded[TY_PACKET];
    if (packet->count == 0) return;
    const double begun = ty_wall_seconds();
    ty_accel_occluded_packet(job->scene->view.mesh, packet->rays, packet->count, occluded);
    packet->seconds += ty_wall_seconds() - begun;
    for (int32_t i = 0; i < packet->count; ++i) *packet->out[i] = occluded[i];
    packet->traced += packet->count;
    packet->count = 0;
}

static ty_ray ray_of(const ty_lattice* lattice, const int32_t step[3], const int32_t from[3]) {
    const float length = sqrtf((float)(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]));
    ty_ray ray = {.far = length * lattice->cell};
    for (int a = 0; a < 3; ++a) {
        ray.origin[a] = (float)(lattice->box.lower[a] + (from[a] + 0.5 + aside[a]) * (double)lattice->cell);
        ray.direction[a] = (float)step[a] / length;
    }
    return ray;
}

/* Traces one layer of the links of one direction. */
static void cross_layer(void* user, int64_t index, int32_t worker) {
    (void)worker;
    crossing_job* job = user;
    const int32_t link = (int32_t)(index % TY_LPV_HALF_LINKS);
    const ty_link_grid* grid = &job->grids[link];
    crossing_packet packet = {.count = 0};
    int32_t place[3] = {0, 0, (int32_t)(index / TY_LPV_HALF_LINKS)};
    if (place[2] >= grid->size[2]) return;
    for (place[1] = 0; place[1] < grid->size[1]; ++place[1])
        for (place[0] = 0; place[0] < grid->size[0]; ++place[0]) {
            int32_t from[3], to[3];
            size_t cell;
            ty_link_ends(grid, place, from, to);
            const bool near = (ty_link_cell(job->lattice, from, &cell) && job->near[cell] != 0) ||
                              (ty_link_cell(job->lattice, to, &cell) && job->near[cell] != 0);
            if (!near) continue;
            packet.rays[packet.count] = ray_of(job->lattice, grid->step, from);
            packet.out[packet.count++] = job->crossed[link] + ty_link_at(grid, place);
            if (packet.count == TY_PACKET) trace(job, &packet);
        }
    trace(job, &packet);
    ty_ray_counter_add(job->counter, packet.traced, packet.seconds);
}

/* Blocks crossed links. Partial blocking of the next links in a row is due to the same surface and is removed. */
static void close_crossed(void* user, int64_t link, int32_t worker) {
    (void)worker;
    const crossing_job* job = user;
    const ty_link_grid* grid = &job->grids[link];
    int32_t place[3];
    for (place[2] = 0; place[2] < grid->size[2]; ++place[2])
        for (place[1] = 0; place[1] < grid->size[1]; ++place[1])
            for (place[0] = 0; place[0] < grid->size[0]; ++place[0]) {
                int32_t other[3];
                if (job->crossed[link][ty_link_at(grid, place)] != 0) {
                    ty_link_set(job->lattice, (int32_t)link, grid, place, 0);
                    continue;
                }
                for (int32_t sign = -1; sign <= 1; sign += 2)
                    if (ty_link_next(grid, place, sign, other) && job->crossed[link][ty_link_at(grid, other)] != 0)
                        ty_link_set(job->lattice, (int32_t)link, grid, place, 255);
            }
}

static void find_near(const ty_lattice* lattice, uint8_t* near) {
    for (int32_t link = 0; link < TY_LPV_LINKS; ++link)
        for (size_t i = 0; i < lattice->cells; ++i) near[i] |= lattice->transmission[link][i] < 255;
}

ty_result ty_lattice_find_crossings(ty_lattice* lattice, const ty_scene* scene, ty_ray_counter* counter) {
    crossing_job job = {.scene = scene, .lattice = lattice, .counter = counter};
    size_t bytes = lattice->cells;
    if (scene->view.mesh == NULL || !lattice->blocked) return TY_OK;
    for (int32_t link = 0; link < TY_LPV_HALF_LINKS; ++link) {
        job.grids[link] = ty_link_grid_of(lattice, link);
        bytes += job.grids[link].count;
    }
    uint8_t* all = ty_alloc_array(lattice->context, bytes, 1, true);
    if (all == NULL) return TY_ERROR_MEMORY;
    find_near(lattice, all);
    job.near = all;
    uint8_t* next = all + lattice->cells;
    for (int32_t link = 0; link < TY_LPV_HALF_LINKS; ++link) {
        job.crossed[link] = next;
        next += job.grids[link].count;
    }
    ty_parallel_flushed(lattice->context, (int64_t)TY_LPV_HALF_LINKS * (lattice->box.size[2] + 1), cross_layer, &job);
    ty_parallel_flushed(lattice->context, TY_LPV_HALF_LINKS, close_crossed, &job);
    ty_free_array(lattice->context, all, bytes, 1);
    return TY_OK;
}
