/* Beams in tubes, slab by slab. */
#include "direct/beam.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "base/isa.h"

enum { BLOCK_ROWS = 16, BLOCK_SIDE = 16 };

static const ty_beam_kernels* choose_kernels(void) {
#if TY_ISA_X86
    static const ty_beam_kernels* const kernels[TY_ISA_COUNT] = {&ty_beam_kernels_v1, &ty_beam_kernels_v3,
                                                                 &ty_beam_kernels_v4};
    return kernels[ty_best_isa()];
#else
    return &ty_beam_kernels_v1;
#endif
}

static size_t tube_count(const ty_beam* beam) {
    return (size_t)beam->tubes[0] * (size_t)beam->tubes[1];
}

/* ---- geometry ---- */

/* Which axes are u, v and w. Where w is the axis of rows, the cells are turned over (ty_beam_pass) so that u and w
 * change places. */
static void choose_axes(const ty_grid_medium* medium, const double way[3], ty_beam* beam) {
    int32_t w = 0;
    for (int32_t a = 1; a < 3; ++a)
        if (fabs(way[a]) / medium->cell[a] > fabs(way[w]) / medium->cell[w]) w = a;
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
    const ty_mesh* mesh;
    const ty_grid_medium* medium;
    ty_beam* beam;
    double way[3];
    double back; /* m from where tubes begin to where rays do, before everything */
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

static float hit_along(const hit_job* job, const ty_hit* hit, const double begin[3]) {
    if (hit->surface < 0) return TY_FLOAT_MAX;
    return (float)(((double)hit->position.x - begin[0]) * job->way[0] +
                   ((double)hit->position.y - begin[1]) * job->way[1] +
                   ((double)hit->position.z - begin[2]) * job->way[2]);
}

/* At most a packet of tubes' rays, one of each tube. */
static void find_packet(const hit_job* job, int32_t column, int32_t count, int32_t row, int32_t ray) {
    const ty_beam* beam = job->beam;
    double begin[TY_PACKET][3];
    ty_ray rays[TY_PACKET];
    ty_hit hits[TY_PACKET];
    for (int32_t i = 0; i < count; ++i) {
        ray_begin(job, column + i, row, ray, begin[i]);
        rays[i].far = TY_FLOAT_MAX;
        for (int a = 0; a < 3; ++a) {
            rays[i].origin[a] = (float)(begin[i][a] - job->back * job->way[a]);
            rays[i].direction[a] = (float)job->way[a];
        }
    }
    ty_mesh_intersect_packet(job->mesh, rays, count, hits);
    float* out = beam->hit + tube_count(beam) * (size_t)ray + (size_t)row * (size_t)beam->tubes[0] + (size_t)column;
    for (int32_t i = 0; i < count; ++i) out[i] = hit_along(job, &hits[i], begin[i]);
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
        beam->along[i] = ty_alloc_array(beam->context, tube_count(beam), sizeof *beam->along[i], false);
        if (beam->along[i] == NULL) return TY_ERROR_MEMORY;
    }
    /* A row without matter, one of means of rows, and three rows of tubes; the last is for what goes nowhere. */
    beam->scratch_size = 5 * ((size_t)beam->size[0] + 4) + (size_t)beam->tubes[0];
    const size_t size = beam->scratch_size * (size_t)ty_context_threads(beam->context);
    beam->scratch = ty_alloc_array(beam->context, size, sizeof *beam->scratch, true);
    if (beam->scratch == NULL) return TY_ERROR_MEMORY;
    if (!shadows) return TY_OK;
    beam->hit = ty_alloc_array(beam->context, TY_BEAM_RAYS * tube_count(beam), sizeof *beam->hit, false);
    return beam->hit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_beam_end(ty_beam* beam) {
    const size_t slabs = (size_t)beam->size[2];
    for (int i = 0; i < 2; ++i) {
        ty_free_array(beam->context, beam->shift[i], slabs, sizeof *beam->shift[i]);
        ty_free_array(beam->context, beam->weight[i], slabs, sizeof *beam->weight[i]);
        ty_free_array(beam->context, beam->along[i], tube_count(beam), sizeof *beam->along[i]);
    }
    ty_free_array(beam->context, beam->hit, TY_BEAM_RAYS * tube_count(beam), sizeof *beam->hit);
    ty_free_array(beam->context, beam->scratch, beam->scratch_size * (size_t)ty_context_threads(beam->context),
                  sizeof *beam->scratch);
}

ty_result ty_beam_begin(const ty_scene_view* scene, const ty_grid_medium* medium, const double outside[2][3],
                        ty_vec direction, ty_beam* beam) {
    hit_job job = {.mesh = scene->mesh, .medium = medium, .beam = beam};
    const double length = sqrt((double)ty_dot(direction, direction));
    job.way[0] = (double)direction.x / length;
    job.way[1] = (double)direction.y / length;
    job.way[2] = (double)direction.z / length;
    *beam = (ty_beam){.context = medium->context, .kernels = choose_kernels()};
    choose_axes(medium, job.way, beam);
    ty_result result = take_tables(beam);
    if (result != TY_OK) return result;
    const int32_t w = beam->axis[2];
    const double per_slab = medium->cell[w] / fabs(job.way[w]);
    beam->backwards = job.way[w] < 0;
    beam->length = (float)per_slab;
    beam->section = medium->cell[0] * medium->cell[1] * medium->cell[2] / per_slab;
    for (int32_t i = 0; i < 2; ++i)
        place_tubes(beam, i, job.way[beam->axis[i]] * per_slab / medium->cell[beam->axis[i]]);
    result = take_tubes(beam, scene->mesh != NULL);
    if (result != TY_OK || scene->mesh == NULL) return result;
    job.back = reach_back(medium, outside);
    ty_parallel_for(beam->context, beam->tubes[1], find_hits, &job);
    return TY_OK;
}

/* ---- slab by slab ---- */

typedef struct pass_job {
    ty_beam* beam;
    const float* extinction; /* turned over where u and w change places */
    float* lit;
    int32_t slab; /* in the beam's order */
} pass_job;

static size_t slab_offset(const ty_beam* beam, int32_t slab) {
    return beam->stride[2] * (size_t)(beam->backwards ? beam->size[2] - 1 - slab : slab);
}

/* Extinction of row v of a slab; that of a row outside is `empty`. */
static const float* cell_row(const ty_beam* beam, const float* slab, int32_t v, const float* empty) {
    return v >= 0 && v < beam->size[1] ? slab + beam->stride[1] * (size_t)v : empty;
}

/* The row of tubes that has rows v, v + 1 and v + 2 of cells, v from -2 on. kept: whether its transmittance goes on,
 * which only one block of rows may see to. */
static void pass_tubes(const pass_job* job, int32_t v, bool kept, float* scratch, float* mean) {
    ty_beam* beam = job->beam;
    const int32_t slab = job->slab, width = beam->size[0] + 4;
    const float* cells = job->extinction + slab_offset(beam, slab);
    const int32_t row = v - beam->shift[1][slab] - beam->first[1];
    const int32_t column = -2 - beam->shift[0][slab] - beam->first[0];
    const size_t at = (size_t)row * (size_t)beam->tubes[0] + (size_t)column;
    ty_beam_row tubes = {
        .count = beam->size[0],
        .length = beam->length,
        .start = beam->length * (float)slab,
        .in = beam->along[slab % 2] + at,
        .out = kept ? beam->along[(slab + 1) % 2] + at : scratch + 5 * width,
        .mean = mean,
        .blend = scratch + width,
    };
    for (int32_t i = 0; i < 3; ++i) tubes.cells[i] = cell_row(beam, cells, v + i, scratch);
    for (int32_t i = 0; i < 2; ++i) memcpy(tubes.weight[i], beam->weight[i][slab], sizeof tubes.weight[i]);
    for (int32_t i = 0; i < TY_BEAM_RAYS && beam->hit != NULL; ++i)
        tubes.hit[i] = beam->hit + tube_count(beam) * (size_t)i + at;
    beam->kernels->tubes(&tubes);
}

static void pass_block(void* user, int64_t index, int32_t worker) {
    const pass_job* job = user;
    ty_beam* beam = job->beam;
    const int32_t begin = (int32_t)index * BLOCK_ROWS, rows = beam->size[1];
    const int32_t end = rows - begin < BLOCK_ROWS ? rows : begin + BLOCK_ROWS;
    float* scratch = beam->scratch + beam->scratch_size * (size_t)worker;
    const unsigned state = ty_flush_denormals();
    for (int32_t v = begin - 2; v < end; ++v) {
        float* mean[3];
        for (int32_t i = 0; i < 3; ++i) mean[i] = scratch + (2 + (v + 6 - i) % 3) * (beam->size[0] + 4);
        pass_tubes(job, v, v >= begin || begin == 0, scratch, mean[0]);
        if (v < begin) continue;
        ty_beam_cells cells = {
            .count = beam->size[0],
            .mean = {mean[0], mean[1], mean[2]},
            .lit = job->lit + slab_offset(beam, job->slab) + beam->stride[1] * (size_t)v,
        };
        for (int32_t i = 0; i < 2; ++i) memcpy(cells.weight[i], beam->weight[i][job->slab], sizeof cells.weight[i]);
        beam->kernels->cells(&cells);
    }
    ty_restore_denormals(state);
}

/* The slab after which a tube's column (or row) overlaps no cells any more; -1: it never did. */
static int32_t last_slab(const ty_beam* beam, int32_t i, int32_t tube) {
    int32_t last = -1;
    for (int32_t slab = 0; slab < beam->size[2]; ++slab) {
        const int32_t cell = tube + beam->first[i] + beam->shift[i][slab];
        if (cell >= -2 && cell < beam->size[i]) last = slab;
    }
    return last;
}

/* Tubes begin with 1 and keep what they had in the last slab that they were in; surfaces do not count. */
static ty_result add_power(const ty_beam* beam, double power[2]) {
    int32_t* last = ty_alloc_array(beam->context, (size_t)beam->tubes[0], sizeof *last, false);
    if (last == NULL) return TY_ERROR_MEMORY;
    for (int32_t column = 0; column < beam->tubes[0]; ++column) last[column] = last_slab(beam, 0, column);
    double sum = 0;
    for (int32_t row = 0; row < beam->tubes[1]; ++row) {
        const int32_t of_row = last_slab(beam, 1, row);
        for (int32_t column = 0; column < beam->tubes[0]; ++column) {
            const int32_t slab = last[column] < of_row ? last[column] : of_row;
            sum += (double)beam->along[(slab + 1) % 2][(size_t)row * (size_t)beam->tubes[0] + (size_t)column];
        }
    }
    ty_free_array(beam->context, last, (size_t)beam->tubes[0], sizeof *last);
    power[0] = beam->section * (double)tube_count(beam);
    power[1] = beam->section * sum;
    return TY_OK;
}

/* ---- cells turned over ---- */

typedef struct turn_job {
    const float* from;
    float* to;
    int32_t size[3]; /* of from */
} turn_job;

/* One y: (x, z) to (z, x), in blocks that stay in the cache. */
static void turn_layer(void* user, int64_t y, int32_t worker) {
    (void)worker;
    const turn_job* job = user;
    const size_t nx = (size_t)job->size[0], ny = (size_t)job->size[1], nz = (size_t)job->size[2];
    for (size_t z0 = 0; z0 < nz; z0 += BLOCK_SIDE)
        for (size_t x0 = 0; x0 < nx; x0 += BLOCK_SIDE)
            for (size_t z = z0; z < nz && z < z0 + BLOCK_SIDE; ++z)
                for (size_t x = x0; x < nx && x < x0 + BLOCK_SIDE; ++x)
                    job->to[z + nz * ((size_t)y + ny * x)] = job->from[x + nx * ((size_t)y + ny * z)];
}

static void turn_over(ty_context* context, const float* from, int32_t nx, int32_t ny, int32_t nz, float* to) {
    turn_job job = {.from = from, .to = to, .size = {nx, ny, nz}};
    ty_parallel_for(context, ny, turn_layer, &job);
}

static void pass_slabs(ty_beam* beam, const float* extinction, float* lit) {
    pass_job job = {.beam = beam, .extinction = extinction, .lit = lit};
    for (size_t i = 0; i < tube_count(beam); ++i) beam->along[0][i] = beam->along[1][i] = 1;
    for (job.slab = 0; job.slab < beam->size[2]; ++job.slab)
        ty_parallel_for(beam->context, (beam->size[1] + BLOCK_ROWS - 1) / BLOCK_ROWS, pass_block, &job);
}

ty_result ty_beam_pass(ty_beam* beam, const ty_grid_medium* medium, const float* extinction, float* lit,
                       double power[2]) {
    if (beam->axis[2] != 0) {
        pass_slabs(beam, extinction, lit);
        return power != NULL ? add_power(beam, power) : TY_OK;
    }
    const int32_t* size = medium->box.size;
    float* turned = ty_alloc_array(beam->context, 2 * medium->cells, sizeof *turned, false);
    if (turned == NULL) return TY_ERROR_MEMORY;
    turn_over(beam->context, extinction, size[0], size[1], size[2], turned);
    pass_slabs(beam, turned, turned + medium->cells);
    turn_over(beam->context, turned + medium->cells, size[2], size[1], size[0], lit);
    ty_free_array(beam->context, turned, 2 * medium->cells, sizeof *turned);
    return power != NULL ? add_power(beam, power) : TY_OK;
}
