/* Where a beam's tubes are, and how far they get before they meet a surface. */
#include "direct/beam.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/stops.h"

size_t ty_beam_tubes(const ty_beam* beam) {
    return (size_t)beam->tubes[0] * (size_t)beam->tubes[1];
}

/* ---- geometry ---- */

int32_t ty_beam_way(const ty_grid_medium* medium, ty_vec direction) {
    const double way[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    int32_t w = 0;
    for (int32_t a = 1; a < 3; ++a)
        if (fabs(way[a]) / medium->cell[a] > fabs(way[w]) / medium->cell[w]) w = a;
    return 2 * w + (way[w] < 0);
}

/* Which axes are u, v and w. Where w is the axis of rows, the cells are turned over (ty_beams_pass) so that u and w
 * change places. */
static void choose_axes(const ty_grid_medium* medium, int32_t w, ty_beam* beam) {
    beam->axis[0] = w == 0 ? 2 : 0;
    beam->axis[1] = w == 1 ? 2 : 1;
    beam->axis[2] = w;
    for (int32_t i = 0; i < 3; ++i) beam->size[i] = medium->box.size[beam->axis[i]];
    const size_t row = (size_t)beam->size[0];
    beam->stride[0] = 1;
    beam->stride[1] = w == 1 ? row * (size_t)beam->size[2] : row;
    beam->stride[2] = w == 1 ? row : row * (size_t)beam->size[1];
}

/* The integral up to x of 1 - |x|, which is what a tube and a cell of width 1 at a distance x overlap. */
static double overlap_integral(double x) {
    if (x <= -1) return 0;
    if (x >= 1) return 1;
    return x < 0 ? 0.5 * (1 + x) * (1 + x) : 1 - 0.5 * (1 - x) * (1 - x);
}

/* What cell `at` has of a tube that moves from `from` to `to`, on the mean over the way. */
static double mean_overlap(double at, double from, double to) {
    if (fabs(to - from) < 1e-6) return fmax(0, 1 - fabs(at - 0.5 * (from + to)));
    return (overlap_integral(at - from) - overlap_integral(at - to)) / (to - from);
}

/* Where tubes are in each slab along u (0) or v (1): slope is how many cells they move from one to the next. */
static void place_tubes(ty_beam* beam, int32_t i, double slope) {
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (int32_t slab = 0; slab < beam->size[2]; ++slab) {
        const double from = slope * slab, to = slope * (slab + 1), whole = floor(fmin(from, to));
        float* weight = beam->weight[i][slab];
        beam->shift[i][slab] = (int32_t)whole;
        for (int cell = 0; cell < 3; ++cell) weight[cell] = (float)mean_overlap(whole + cell, from, to);
        weight[1] = 1 - weight[0] - weight[2];
        low = beam->shift[i][slab] < low ? beam->shift[i][slab] : low;
        high = beam->shift[i][slab] > high ? beam->shift[i][slab] : high;
    }
    beam->first[i] = -high - 2;
    beam->tubes[i] = beam->size[i] + high - low + 2;
}

/* ---- shadows of surfaces ---- */

typedef struct hit_job {
    const ty_accel* mesh;
    const ty_grid_medium* medium;
    ty_beam* beam;
    double way[3], inverse[3];
    double back; /* m from where tubes begin to where rays do, before everything */
    ty_stop_room room;
} hit_job;

/* Where one of a tube's rays, two by two, meets the first slab's near side. */
static void ray_begin(const hit_job* job, int32_t column, int32_t row, int32_t ray, double at[3]) {
    const ty_beam* beam = job->beam;
    const double cells[3] = {column + beam->first[0] + 0.25 + 0.5 * (ray % 2),
                             row + beam->first[1] + 0.25 + 0.5 * (ray / 2), beam->backwards ? beam->size[2] : 0};
    for (int i = 0; i < 3; ++i) {
        const int32_t a = beam->axis[i];
        at[a] = job->medium->box.lower[a] + cells[i] * job->medium->cell[a];
    }
}

static float stop_of(const hit_job* job, const ty_hit* hit, const double begin[3], double enter) {
    if (hit->surface < 0) return TY_FLOAT_MAX;
    const double along = ((double)hit->position.x - begin[0]) * job->way[0] +
                         ((double)hit->position.y - begin[1]) * job->way[1] +
                         ((double)hit->position.z - begin[2]) * job->way[2];
    return along > enter ? (float)along : 0;
}

static ty_stop_span cut_span(const hit_job* job, ty_stop_span span, int32_t axis, const double begin[3]) {
    return ty_stop_cut(span, &job->room, axis, begin[axis], job->inverse[axis]);
}

/* At most a packet of tubes' rays, one of each tube, which begin along u apart. */
static void find_packet(const hit_job* job, int32_t column, int32_t count, int32_t row, int32_t ray) {
    const ty_beam* beam = job->beam;
    float* out = beam->hit + ty_beam_tubes(beam) * (size_t)ray + (size_t)row * (size_t)beam->tubes[0] + (size_t)column;
    double begin[TY_PACKET][3], enter[TY_PACKET];
    int32_t tube[TY_PACKET], traced = 0;
    ty_ray rays[TY_PACKET];
    ty_hit hits[TY_PACKET];
    ty_stop_span across = {-INFINITY, INFINITY};
    ray_begin(job, column, row, ray, begin[0]);
    for (int i = 1; i < 3; ++i) across = cut_span(job, across, beam->axis[i], begin[0]);
    for (int32_t i = 0; i < count; ++i) {
        ray_begin(job, column + i, row, ray, begin[traced]);
        const ty_stop_span span = cut_span(job, across, beam->axis[0], begin[traced]);
        out[i] = TY_STOP_NONE;
        if (!(span.enter < span.leave)) continue;
        enter[traced] = span.enter;
        rays[traced].far = (float)(job->back + span.leave);
        for (int a = 0; a < 3; ++a) {
            rays[traced].origin[a] = (float)(begin[traced][a] - job->back * job->way[a]);
            rays[traced].direction[a] = (float)job->way[a];
        }
        tube[traced++] = i;
    }
    if (traced > 0) ty_accel_intersect_packet(job->mesh, rays, traced, hits);
    for (int32_t i = 0; i < traced; ++i) out[tube[i]] = stop_of(job, &hits[i], begin[i], enter[i]);
}

static void find_hits(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const hit_job* job = user;
    const int32_t tubes = job->beam->tubes[0];
    const unsigned state = ty_flush_denormals();
    for (int32_t ray = 0; ray < TY_BEAM_RAYS; ++ray)
        for (int32_t column = 0; column < tubes; column += TY_PACKET)
            find_packet(job, column, tubes - column < TY_PACKET ? tubes - column : TY_PACKET, (int32_t)row, ray);
    ty_restore_denormals(state);
}

/* One of the tubes' rays. */
static void fill_hits(void* user, int64_t ray, int32_t worker) {
    (void)worker;
    const ty_beam* beam = ((const hit_job*)user)->beam;
    ty_stops_fill(beam->hit + ty_beam_tubes(beam) * (size_t)ray, beam->tubes[0], beam->tubes[1]);
}

/* How far the corner of a box farthest upstream of where tubes begin may be. */
static double reach_back(const ty_grid_medium* medium, const double outside[2][3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double low = fmin(medium->box.lower[a], outside[0][a]), high = fmax(medium->box.upper[a], outside[1][a]);
        square += (high - low) * (high - low);
    }
    return 2 * sqrt(square);
}

/* ---- memory ---- */

static ty_result take_tables(ty_beam* beam) {
    const size_t slabs = (size_t)beam->size[2];
    for (int i = 0; i < 2; ++i) {
        beam->shift[i] = ty_alloc_array(beam->context, slabs, sizeof *beam->shift[i], false);
        beam->weight[i] = ty_alloc_array(beam->context, slabs, sizeof *beam->weight[i], false);
        if (beam->shift[i] == NULL || beam->weight[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static ty_result take_tubes(ty_beam* beam, bool shadows) {
    for (int i = 0; i < 2; ++i) {
        beam->along[i] = ty_alloc_array(beam->context, ty_beam_tubes(beam), sizeof *beam->along[i], false);
        if (beam->along[i] == NULL) return TY_ERROR_MEMORY;
    }
    if (!shadows) return TY_OK;
    beam->hit = ty_alloc_array(beam->context, TY_BEAM_RAYS * ty_beam_tubes(beam), sizeof *beam->hit, false);
    return beam->hit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_beam_end(ty_beam* beam) {
    const size_t slabs = (size_t)beam->size[2];
    for (int i = 0; i < 2; ++i) {
        ty_free_array(beam->context, beam->shift[i], slabs, sizeof *beam->shift[i]);
        ty_free_array(beam->context, beam->weight[i], slabs, sizeof *beam->weight[i]);
        ty_free_array(beam->context, beam->along[i], ty_beam_tubes(beam), sizeof *beam->along[i]);
    }
    ty_free_array(beam->context, beam->hit, TY_BEAM_RAYS * ty_beam_tubes(beam), sizeof *beam->hit);
}

ty_result ty_beam_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                        ty_vec direction, ty_beam* beam) {
    hit_job job = {.mesh = scene->mesh, .medium = medium, .beam = beam};
    const double length = sqrt((double)ty_dot(direction, direction));
    job.way[0] = (double)direction.x / length;
    job.way[1] = (double)direction.y / length;
    job.way[2] = (double)direction.z / length;
    *beam = (ty_beam){.context = medium->context, .kernels = ty_direct_kernels_best()};
    const int32_t way = ty_beam_way(medium, direction);
    choose_axes(medium, way / 2, beam);
    ty_result result = take_tables(beam);
    if (result != TY_OK) return result;
    const int32_t w = beam->axis[2];
    const double per_slab = medium->cell[w] / fabs(job.way[w]);
    beam->backwards = way % 2 != 0;
    beam->length = (float)per_slab;
    beam->section = medium->cell[0] * medium->cell[1] * medium->cell[2] / per_slab;
    for (int32_t i = 0; i < 2; ++i)
        place_tubes(beam, i, job.way[beam->axis[i]] * per_slab / medium->cell[beam->axis[i]]);
    result = take_tubes(beam, scene->mesh != NULL);
    if (result != TY_OK || scene->mesh == NULL) return result;
    job.back = reach_back(medium, outside);
    job.room = ty_stop_room_of(medium);
    for (int a = 0; a < 3; ++a) job.inverse[a] = ty_stop_inverse(job.way[a]);
    ty_parallel_for(beam->context, beam->tubes[1], find_hits, &job);
    ty_parallel_for(beam->context, TY_BEAM_RAYS, fill_hits, &job);
    return TY_OK;
}
