/* Geometry of the tubes of parallel light, and their occlusion by surfaces. */
#include "direct/uncollided/collimated.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/occlusion.h"

size_t ty_collimated_tubes(const ty_collimated* beam) {
    return (size_t)beam->tubes[0] * (size_t)beam->tubes[1];
}

/* ---- geometry ---- */

int32_t ty_collimated_sweep_axis(const ty_grid_medium* medium, ty_vec direction) {
    const double omega[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    int32_t w = 0;
    for (int32_t a = 1; a < 3; ++a)
        if (fabs(omega[a]) / medium->cell[a] > fabs(omega[w]) / medium->cell[w]) w = a;
    return 2 * w + (omega[w] < 0);
}

/* Chooses the axes u, v and w. Where w is the axis of rows, cells are transposed (ty_collimated_sweep) so that u and w
 * change places. */
static void choose_axes(const ty_grid_medium* medium, int32_t w, ty_collimated* beam) {
    beam->axis[0] = w == 0 ? 2 : 0;
    beam->axis[1] = w == 1 ? 2 : 1;
    beam->axis[2] = w;
    for (int32_t i = 0; i < 3; ++i) beam->size[i] = medium->box.size[beam->axis[i]];
    const size_t row = (size_t)beam->size[0];
    beam->stride[0] = 1;
    beam->stride[1] = w == 1 ? row * (size_t)beam->size[2] : row;
    beam->stride[2] = w == 1 ? row : row * (size_t)beam->size[1];
}

/* The integral up to x of max(0, 1 - |x|), the overlap of a tube and a cell of width 1 at distance x. */
static double overlap_integral(double x) {
    if (x <= -1) return 0;
    if (x >= 1) return 1;
    return x < 0 ? 0.5 * (1 + x) * (1 + x) : 1 - 0.5 * (1 - x) * (1 - x);
}

double ty_tube_overlap(double at, double from, double to) {
    if (fabs(to - from) < 1e-6) return fmax(0, 1 - fabs(at - 0.5 * (from + to)));
    return (overlap_integral(at - from) - overlap_integral(at - to)) / (to - from);
}

/* Tube shifts in each slab along u (0) or v (1). slope: cells per slab. */
static void find_tube_shifts(ty_collimated* beam, int32_t i, double slope) {
    int32_t min_shift = INT32_MAX, max_shift = INT32_MIN;
    for (int32_t slab = 0; slab < beam->size[2]; ++slab) {
        const double from = slope * slab, to = slope * (slab + 1), whole = floor(fmin(from, to));
        float* weight = beam->weight[i][slab];
        beam->shift[i][slab] = (int32_t)whole;
        for (int cell = 0; cell < 3; ++cell) weight[cell] = (float)ty_tube_overlap(whole + cell, from, to);
        weight[1] = 1 - weight[0] - weight[2];
        min_shift = beam->shift[i][slab] < min_shift ? beam->shift[i][slab] : min_shift;
        max_shift = beam->shift[i][slab] > max_shift ? beam->shift[i][slab] : max_shift;
    }
    beam->first[i] = -max_shift - 2;
    beam->tubes[i] = beam->size[i] + max_shift - min_shift + 2;
}

/* ---- shadows of surfaces ---- */

typedef struct hit_job {
    const ty_accel* mesh;
    const ty_grid_medium* medium;
    ty_collimated* beam;
    double omega[3], inverse[3];
    double start_distance; /* m by which shadow rays start upstream of all surfaces */
    ty_occlusion_box box;
} hit_job;

/* The point where one of a tube's 2 x 2 rays meets the near side of the first slab. */
static void ray_begin(const hit_job* job, int32_t column, int32_t row, int32_t ray, double at[3]) {
    const ty_collimated* beam = job->beam;
    const double cells[3] = {column + beam->first[0] + 0.25 + 0.5 * (ray % 2),
                             row + beam->first[1] + 0.25 + 0.5 * (ray / 2), beam->backwards ? beam->size[2] : 0};
    for (int i = 0; i < 3; ++i) {
        const int32_t a = beam->axis[i];
        at[a] = job->medium->box.lower[a] + cells[i] * job->medium->cell[a];
    }
}

static float occlusion_of(const hit_job* job, const ty_hit* hit, const double begin[3], double enter) {
    if (hit->surface < 0) return TY_FLOAT_MAX;
    const double along = ((double)hit->position.x - begin[0]) * job->omega[0] +
                         ((double)hit->position.y - begin[1]) * job->omega[1] +
                         ((double)hit->position.z - begin[2]) * job->omega[2];
    return along > enter ? (float)along : 0;
}

static ty_occlusion_span clip_span(const hit_job* job, ty_occlusion_span span, int32_t axis, const double begin[3]) {
    return ty_occlusion_clip(span, &job->box, axis, begin[axis], job->inverse[axis]);
}

/* Traces one ray each of up to a packet of adjacent tubes. */
static void find_packet(const hit_job* job, int32_t column, int32_t count, int32_t row, int32_t ray) {
    const ty_collimated* beam = job->beam;
    float* out =
        beam->hit + ty_collimated_tubes(beam) * (size_t)ray + (size_t)row * (size_t)beam->tubes[0] + (size_t)column;
    double begin[TY_PACKET][3], enter[TY_PACKET];
    int32_t tube[TY_PACKET], traced = 0;
    ty_ray rays[TY_PACKET];
    ty_hit hits[TY_PACKET];
    ty_occlusion_span across = {-INFINITY, INFINITY};
    ray_begin(job, column, row, ray, begin[0]);
    for (int i = 1; i < 3; ++i) across = clip_span(job, across, beam->axis[i], begin[0]);
    for (int32_t i = 0; i < count; ++i) {
        ray_begin(job, column + i, row, ray, begin[traced]);
        const ty_occlusion_span span = clip_span(job, across, beam->axis[0], begin[traced]);
        out[i] = TY_OCCLUSION_UNDEFINED;
        if (!(span.enter < span.leave)) continue;
        enter[traced] = span.enter;
        rays[traced].far = (float)(job->start_distance + span.leave);
        for (int a = 0; a < 3; ++a) {
            rays[traced].origin[a] = (float)(begin[traced][a] - job->start_distance * job->omega[a]);
            rays[traced].direction[a] = (float)job->omega[a];
        }
        tube[traced++] = i;
    }
    if (traced > 0) ty_accel_intersect_packet(job->mesh, rays, traced, hits);
    for (int32_t i = 0; i < traced; ++i) out[tube[i]] = occlusion_of(job, &hits[i], begin[i], enter[i]);
}

static void find_hits(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hit_job* job = user;
    const int32_t tubes = job->beam->tubes[0];
    const unsigned state = ty_flush_denormals();
    for (int32_t ray = 0; ray < TY_TUBE_RAYS; ++ray)
        for (int32_t column = 0; column < tubes; column += TY_PACKET)
            find_packet(job, column, tubes - column < TY_PACKET ? tubes - column : TY_PACKET, (int32_t)row, ray);
    ty_restore_denormals(state);
}

/* Fills in the undefined distances of one of the tubes' rays. */
static void fill_hits(void* user, int64_t ray, int32_t worker) {
    (void)worker;
    const ty_collimated* beam = ((const hit_job*)user)->beam;
    ty_occlusion_fill(beam->hit + ty_collimated_tubes(beam) * (size_t)ray, beam->tubes[0], beam->tubes[1]);
}

/* An upper bound of the distance from the tubes' start to the most upstream corner of a box. */
static double start_distance_of(const ty_grid_medium* medium, const double outside[2][3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double min_shift = fmin(medium->box.lower[a], outside[0][a]),
                     max_shift = fmax(medium->box.upper[a], outside[1][a]);
        square += (max_shift - min_shift) * (max_shift - min_shift);
    }
    return 2 * sqrt(square);
}

/* ---- memory ---- */

static ty_result allocate_tables(ty_collimated* beam) {
    const size_t slabs = (size_t)beam->size[2];
    for (int i = 0; i < 2; ++i) {
        beam->shift[i] = ty_alloc_array(beam->context, slabs, sizeof *beam->shift[i], false);
        beam->weight[i] = ty_alloc_array(beam->context, slabs, sizeof *beam->weight[i], false);
        if (beam->shift[i] == NULL || beam->weight[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static ty_result allocate_tubes(ty_collimated* beam, bool shadows) {
    for (int i = 0; i < 2; ++i) {
        beam->along[i] = ty_alloc_array(beam->context, ty_collimated_tubes(beam), sizeof *beam->along[i], false);
        if (beam->along[i] == NULL) return TY_ERROR_MEMORY;
    }
    if (!shadows) return TY_OK;
    beam->hit = ty_alloc_array(beam->context, TY_TUBE_RAYS * ty_collimated_tubes(beam), sizeof *beam->hit, false);
    return beam->hit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_collimated_end(ty_collimated* beam) {
    const size_t slabs = (size_t)beam->size[2];
    for (int i = 0; i < 2; ++i) {
        ty_free_array(beam->context, beam->shift[i], slabs, sizeof *beam->shift[i]);
        ty_free_array(beam->context, beam->weight[i], slabs, sizeof *beam->weight[i]);
        ty_free_array(beam->context, beam->along[i], ty_collimated_tubes(beam), sizeof *beam->along[i]);
    }
    ty_free_array(beam->context, beam->hit, TY_TUBE_RAYS * ty_collimated_tubes(beam), sizeof *beam->hit);
}

ty_result ty_collimated_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                              ty_vec direction, ty_collimated* beam) {
    hit_job job = {.mesh = scene->mesh, .medium = medium, .beam = beam};
    const double length = sqrt((double)ty_dot(direction, direction));
    job.omega[0] = (double)direction.x / length;
    job.omega[1] = (double)direction.y / length;
    job.omega[2] = (double)direction.z / length;
    *beam = (ty_collimated){.context = medium->context, .kernels = TY_BEST_KERNELS(ty_direct_kernels)};
    const int32_t sweep = ty_collimated_sweep_axis(medium, direction);
    choose_axes(medium, sweep / 2, beam);
    ty_result result = allocate_tables(beam);
    if (result != TY_OK) return result;
    const int32_t w = beam->axis[2];
    const double per_slab = medium->cell[w] / fabs(job.omega[w]);
    beam->backwards = sweep % 2 != 0;
    beam->length = (float)per_slab;
    beam->section = medium->cell[0] * medium->cell[1] * medium->cell[2] / per_slab;
    for (int32_t i = 0; i < 2; ++i)
        find_tube_shifts(beam, i, job.omega[beam->axis[i]] * per_slab / medium->cell[beam->axis[i]]);
    result = allocate_tubes(beam, scene->mesh != NULL);
    if (result != TY_OK || scene->mesh == NULL) return result;
    job.start_distance = start_distance_of(medium, outside);
    job.box = ty_occlusion_box_of(medium);
    for (int a = 0; a < 3; ++a) job.inverse[a] = ty_occlusion_inverse(job.omega[a]);
    ty_parallel_for(beam->context, beam->tubes[1], find_hits, &job);
    ty_parallel_for(beam->context, TY_TUBE_RAYS, fill_hits, &job);
    return TY_OK;
}
