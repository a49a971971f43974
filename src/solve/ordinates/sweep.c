/* Transport sweep: blocks of rows in wavefronts of independent blocks. */
#include "solve/ordinates/sweep_state.h"

#include "base/arena.h"
#include "base/context.h"
#include "base/parallel.h"
#include "solve/angular/harmonics.h"
#include "solve/ordinates/device/device.h"

#include <string.h>

enum { TERMS_MAX = TY_SCATTERING_ORDER_MAX * TY_SCATTERING_ORDER_MAX };
/* Maximum of all kernels. */
enum { LANES_MAX = 16 };

/* ---- data of all sweeps ---- */

static int32_t round_up(int32_t count, int32_t multiple) {
    return (count + multiple - 1) / multiple * multiple;
}

/* Writable arrays of the box, which is const to the kernels. */
typedef struct tables {
    int32_t *order, *position;
    float *two_mu_over_h[3], *partial_current_weight[3], *y_lm[4], *weighted_y_lm[4];
} tables;

static tables lay_out(ty_sweep* sweep, ty_arena* arena) {
    ty_sweep_box* box = &sweep->box;
    const size_t lanes = (size_t)box->groups * (size_t)box->lanes, padded = (size_t)box->padded;
    const size_t nx = (size_t)box->size[0];
    tables t;
    box->order = t.order = ty_arena_take(arena, sizeof(int32_t) * (size_t)box->terms);
    for (int a = 0; a < 3; ++a) {
        box->two_mu_over_h[a] = t.two_mu_over_h[a] = ty_arena_take(arena, sizeof(float) * lanes);
        box->partial_current_weight[a] = t.partial_current_weight[a] = ty_arena_take(arena, sizeof(float) * lanes);
    }
    box->position = t.position = ty_arena_take(arena, sizeof(int32_t) * (size_t)round_up(box->terms, box->lanes));
    for (int i = 0; i < 4; ++i) {
        box->y_lm[i] = t.y_lm[i] = ty_arena_take(arena, sizeof(float) * (size_t)box->terms * lanes);
        box->weighted_y_lm[i] = t.weighted_y_lm[i] = ty_arena_take(arena, sizeof(float) * padded * lanes);
    }
    for (int o = 0; o < 8; ++o) {
        sweep->dark[o] = ty_arena_take(arena, sizeof(float) * lanes);
        for (int a = 0; a < 3; ++a) box->boundary_radiance[a][o] = sweep->dark[o];
        box->faces_y[o] = ty_arena_take(arena, sizeof(float) * nx * (size_t)box->size[2] * lanes);
        box->faces_z[o] = ty_arena_take(arena, sizeof(float) * nx * (size_t)box->size[1] * lanes);
    }
    const size_t blocks = (size_t)sweep->blocks[0] * (size_t)sweep->blocks[1];
    sweep->sums = ty_arena_take(arena, sizeof(ty_sweep_sums) * blocks);
    sweep->scratch =
        ty_arena_take(arena, sizeof(float) * sweep->scratch_floats * (size_t)ty_context_threads(sweep->context));
    return t;
}

/* True if harmonic l (l + 1) + m changes sign with x: for m >= 0 it varies as cos m phi. */
static bool is_odd(int32_t term) {
    int32_t l = 0;
    while ((l + 1) * (l + 1) <= term) ++l;
    const int32_t m = term - l * (l + 1);
    return m >= 0 ? (m & 1) != 0 : (m & 1) == 0;
}

static void fill_order(const ty_sweep_box* box, const tables* t) {
    for (int32_t term = 0, even = 0, odd = box->even; term < box->terms; ++term)
        t->order[is_odd(term) ? odd++ : even++] = term;
    for (int32_t i = 0; i < round_up(box->terms, box->lanes); ++i) t->position[i] = -1;
    for (int32_t i = 0; i < box->terms; ++i) t->position[box->order[i]] = i;
}

static void fill_direction(const ty_sweep* sweep, const tables* t, const ty_angular_quadrature* set, int32_t bands,
                           int32_t pair, int32_t i) {
    const ty_sweep_box* box = &sweep->box;
    const int32_t lanes = box->groups * box->lanes, d = set->first[2 * pair] + i;
    const double w[3] = {(double)set->direction[0][d], (double)set->direction[1][d], (double)set->direction[2][d]};
    double y[TERMS_MAX];
    ty_harmonics_at(w, bands, y);
    for (int32_t at = 0; at < box->terms; ++at) {
        const int32_t parity_index = at < box->even ? at : round_up(box->even, box->lanes) + at - box->even;
        t->weighted_y_lm[pair][i * box->padded + parity_index] = (float)((double)set->weight[d] * y[box->order[at]]);
        t->y_lm[pair][at * lanes + i] = (float)y[box->order[at]];
    }
}

static void fill(ty_sweep* sweep, const tables* t, const double cell[3], const ty_angular_quadrature* set,
                 int32_t bands) {
    ty_sweep_box* box = &sweep->box;
    fill_order(box, t);
    for (int32_t i = 0; i < box->groups * box->lanes; ++i)
        for (int a = 0; a < 3; ++a) {
            const bool exists = i < box->directions;
            const double cosine = exists ? (double)set->direction[a][i] : cell[a];
            t->two_mu_over_h[a][i] = (float)(2 * cosine / cell[a]);
            const double volume = cell[0] * cell[1] * cell[2];
            t->partial_current_weight[a][i] =
                exists ? (float)(0.5 * (double)t->two_mu_over_h[a][i] * volume * (double)set->weight[i]) : 0;
        }
    for (int32_t pair = 0; pair < 4; ++pair)
        for (int32_t i = 0; i < box->directions; ++i) fill_direction(sweep, t, set, bands, pair, i);
}

/* A sweep without its memory. */
static void begin_sweep(ty_context* context, const int32_t size[3], const ty_angular_quadrature* set, int32_t bands,
                        const float* extinction, ty_sweep* sweep) {
    const ty_sweep_kernels* kernels = TY_BEST_KERNELS(ty_sweep_kernels);
    sweep->context = context;
    sweep->kernels = kernels;
    sweep->box = (ty_sweep_box){.size = {size[0], size[1], size[2]},
                                .lanes = kernels->lanes,
                                .groups = round_up(set->first[1], kernels->lanes) / kernels->lanes,
                                .directions = set->first[1],
                                .terms = bands * bands,
                                .even = bands * (bands + 1) / 2,
                                .extinction = extinction,
                                .whole = {size[0], size[1], size[2]}};
    sweep->box.padded = round_up(sweep->box.even, kernels->lanes) + round_up(bands * (bands - 1) / 2, kernels->lanes);
    for (int a = 0; a < 2; ++a) sweep->blocks[a] = round_up(size[a + 1], TY_SWEEP_BLOCK_ROWS) / TY_SWEEP_BLOCK_ROWS;
    sweep->scratch_floats = kernels->scratch(&sweep->box);
    ty_arena arena = {0};
    lay_out(sweep, &arena);
    sweep->bytes = arena.used;
}

size_t ty_sweep_plan(ty_context* context, const int32_t size[3], const ty_angular_quadrature* set, int32_t bands,
                     const ty_domain* domain, ty_sweep_schedule* schedule) {
    ty_sweep sweep = {0};
    begin_sweep(context, size, set, bands, NULL, &sweep);
    if (domain != NULL) ty_sweep_plan_units(&sweep, domain);
    *schedule = sweep.schedule;
    return ty_sweep_bytes(&sweep);
}

ty_result ty_sweep_create(ty_context* context, const int32_t size[3], const double cell[3],
                          const ty_angular_quadrature* set, int32_t bands, const float* extinction, ty_sweep** out) {
    *out = NULL;
    ty_sweep* sweep = ty_alloc_array(context, 1, sizeof *sweep, true);
    if (sweep == NULL) return TY_ERROR_MEMORY;
    begin_sweep(context, size, set, bands, extinction, sweep);
    ty_arena arena = {0};
    sweep->memory = arena.base = ty_alloc_array(context, sweep->bytes, 1, true);
    if (sweep->memory == NULL) {
        ty_sweep_destroy(sweep);
        return TY_ERROR_MEMORY;
    }
    arena.used = 0;
    const tables t = lay_out(sweep, &arena);
    fill(sweep, &t, cell, set, bands);
    *out = sweep;
    return TY_OK;
}

ty_result ty_sweep_set_boundary_radiance(ty_sweep* sweep, const ty_boundary_radiance* boundary) {
    ty_sweep_box* box = &sweep->box;
    const size_t pitch = (size_t)ty_sweep_pitch(sweep), directions = (size_t)box->directions;
    size_t patches = 0;
    ty_free_array(sweep->context, sweep->boundary, sweep->boundary_floats, sizeof(float));
    sweep->boundary = NULL;
    box->patches = (ty_boundary_radiance){.patches = {1, 1, 1}};
    for (int a = 0; a < 3; ++a)
        for (int o = 0; o < 8; ++o) box->boundary_radiance[a][o] = sweep->dark[o];
    if (boundary->across[0] == NULL) return TY_OK;
    for (int a = 0; a < 3; ++a) patches += (size_t)ty_boundary_patch_count(boundary, a);
    sweep->boundary_floats = 8 * patches * pitch;
    sweep->boundary = ty_alloc_array(sweep->context, sweep->boundary_floats, sizeof(float), true);
    if (sweep->boundary == NULL) return TY_ERROR_MEMORY;
    box->patches = *boundary;
    float* out = sweep->boundary;
    for (int a = 0; a < 3; ++a)
        for (size_t o = 0; o < 8; ++o) {
            box->boundary_radiance[a][o] = out;
            for (size_t p = 0; p < (size_t)ty_boundary_patch_count(boundary, a); ++p, out += pitch)
                memcpy(out, boundary->across[a] + (8 * p + o) * directions, sizeof(float) * directions);
        }
    return TY_OK;
}

void ty_sweep_set_faces(ty_sweep* sweep, const ty_sweep_faces* walls) {
    sweep->box.walls = walls;
}

void ty_sweep_set_closed(ty_sweep* sweep, const uint16_t* closed) {
    sweep->box.closed = closed;
}

const ty_sweep_box* ty_sweep_tables(const ty_sweep* sweep) {
    return &sweep->box;
}

void ty_sweep_destroy(ty_sweep* sweep) {
    if (sweep == NULL) return;
    ty_free_array(sweep->context, sweep->boundary, sweep->boundary_floats, sizeof(float));
    ty_sweep_free_division(sweep);
    ty_sweep_device_destroy(sweep->on_device);
    ty_sweep_free_inflow(sweep);
    if (sweep->memory != NULL) ty_free_array(sweep->context, sweep->memory, sweep->bytes, 1);
    ty_free_array(sweep->context, sweep, 1, sizeof *sweep);
}

int32_t ty_sweep_pitch(const ty_sweep* sweep) {
    return sweep->box.groups * sweep->box.lanes;
}

size_t ty_sweep_bytes(const ty_sweep* sweep) {
    return sizeof *sweep + sweep->bytes + sweep->division_bytes + sweep->inflow_bytes;
}

double ty_sweep_operations(int32_t bands) {
    return 4.0 * bands * bands + 16;
}

/* ---- one sweep ---- */

typedef struct sweep_job {
    ty_sweep* sweep;
    const float* emission;
    float* moments;
    int32_t stage;
} sweep_job;

/* Sets a row of upwind faces across an axis to the boundary radiance of an octant's group of lanes. */
static void set_boundary_row(const ty_sweep_box* box, int axis, int32_t octant, ptrdiff_t group, const int32_t row[3],
                             float* faces) {
    const float* boundary = box->boundary_radiance[axis][octant] + group * box->lanes;
    const ptrdiff_t pitch = (ptrdiff_t)box->groups * box->lanes;
    int32_t at[3] = {box->origin[0], row[1] + box->origin[1], row[2] + box->origin[2]};
    for (int32_t x = 0; x < box->size[0]; ++x, ++at[0])
        memcpy(faces + (ptrdiff_t)x * box->lanes,
               boundary + ty_boundary_patch(&box->patches, box->whole, axis, at) * pitch,
               sizeof(float) * (size_t)box->lanes);
}

void ty_sweep_set_boundary(const ty_sweep_box* box, const ty_sweep_block* block, const bool first[2]) {
    const ptrdiff_t row = (ptrdiff_t)box->size[0] * box->lanes;
    const int32_t begin = 2 * block->pair + (block->unpaired > 0 ? 1 : 0),
                  end = 2 * block->pair + (block->unpaired == 0 ? 1 : 2);
    for (int32_t o = begin; o < end; ++o)
        for (ptrdiff_t g = 0; g < box->groups; ++g) {
            for (int32_t z = block->begin[1]; z < block->end[1] && first[0]; ++z)
                set_boundary_row(box, 1, o, g, (const int32_t[3]){0, 0, z},
                                 box->faces_y[o] + (g * box->size[2] + z) * row);
            for (int32_t y = block->begin[0]; y < block->end[0] && first[1]; ++y)
                set_boundary_row(box, 2, o, g, (const int32_t[3]){0, y, 0},
                                 box->faces_z[o] + (g * box->size[1] + y) * row);
        }
}

/* The wavefront stage of a block is its distance in blocks from the octant's first corner. A block that several pairs
 * of octants reach in the same stage is swept by one after another, so that its moments are sums in a fixed order. */
static void sweep_block(void* user, int64_t index, int32_t worker) {
    const sweep_job* job = user;
    ty_sweep* sweep = job->sweep;
    const int32_t* blocks = sweep->blocks;
    const int32_t at[2] = {(int32_t)(index % blocks[0]), (int32_t)(index / blocks[0])};
    ty_sweep_block block = {.unpaired = -1};
    for (int a = 0; a < 2; ++a) {
        const int32_t end = (at[a] + 1) * TY_SWEEP_BLOCK_ROWS, size = sweep->box.size[a + 1];
        block.begin[a] = at[a] * TY_SWEEP_BLOCK_ROWS;
        block.end[a] = end < size ? end : size;
    }
    int32_t stages[4], distance[4][2], first = 0, last = 0;
    for (int32_t pair = 0; pair < 4; ++pair) {
        for (int a = 0; a < 2; ++a) distance[pair][a] = (pair >> a & 1) != 0 ? blocks[a] - 1 - at[a] : at[a];
        stages[pair] = distance[pair][0] + distance[pair][1];
        if (stages[pair] < stages[first]) first = pair;
        if (stages[pair] >= stages[last]) last = pair;
    }
    for (; block.pair < 4; ++block.pair) {
        if (stages[block.pair] != job->stage) continue;
        block.first = block.pair == first;
        block.last = block.pair == last;
        ty_sweep_set_boundary(&sweep->box, &block,
                              (const bool[2]){distance[block.pair][0] == 0, distance[block.pair][1] == 0});
        sweep->kernels->cross(&sweep->box, &block, job->emission, job->moments,
                              sweep->scratch + sweep->scratch_floats * (size_t)worker, &sweep->sums[index]);
    }
}

static double sum_faces(const ty_sweep_box* box, const float* faces, const float* current_weight, int32_t rows) {
    double sum = 0;
    for (int32_t g = 0; g < box->groups; ++g) {
        double lanes[LANES_MAX] = {0};
        for (ptrdiff_t i = 0; i < (ptrdiff_t)rows * box->size[0]; ++i, faces += box->lanes)
#pragma omp simd
            for (int32_t l = 0; l < box->lanes; ++l) lanes[l] += (double)faces[l];
        for (int32_t l = 0; l < box->lanes; ++l) sum += lanes[l] * (double)current_weight[g * box->lanes + l];
    }
    return sum;
}

static void sum_octant(void* user, int64_t index, int32_t worker) {
    (void)worker;
    ty_sweep* sweep = user;
    const ty_sweep_box* box = &sweep->box;
    sweep->leaving[index] = 0;
    if ((box->periodic & 4) == 0)
        sweep->leaving[index] = sum_faces(box, box->faces_z[index], box->partial_current_weight[2], box->size[1]);
    if ((box->periodic & 2) == 0 && ty_sweep_leaves_across_y(sweep, (int32_t)index))
        sweep->leaving[index] += sum_faces(box, box->faces_y[index], box->partial_current_weight[1], box->size[2]);
}

/* A device sweeps whole boxes without boundary faces, and no transposes. */
static bool may_be_on_device(const ty_sweep* sweep) {
    return sweep->domain == NULL && sweep->box.walls == NULL && sweep->box.closed == NULL;
}

ty_result ty_sweep_run(ty_sweep* sweep, const float* emission, float* moments, double* leaving, double* fixups) {
    const int64_t blocks = (int64_t)sweep->blocks[0] * sweep->blocks[1];
    const ty_sweep_faces* walls = sweep->box.walls;
    ty_result result = TY_OK;
    if (may_be_on_device(sweep) && sweep->on_device == NULL)
        result = ty_sweep_device_create(sweep->context, &sweep->box, &sweep->on_device);
    if (result != TY_OK) return result;
    if (may_be_on_device(sweep) && sweep->on_device != NULL)
        return ty_sweep_device_run(sweep->on_device, emission, moments, leaving, fixups);
    memset(sweep->sums, 0, sizeof *sweep->sums * (size_t)blocks);
    if (walls != NULL) memset(walls->incident_power, 0, sizeof(float) * (size_t)walls->count);
    sweep_job job = {.sweep = sweep, .emission = emission, .moments = moments};
    result = sweep->domain != NULL ? ty_sweep_run_units(sweep, emission, moments) : TY_OK;
    if (result != TY_OK) return result;
    for (; sweep->domain == NULL && job.stage < sweep->blocks[0] + sweep->blocks[1] - 1; ++job.stage)
        ty_parallel_flushed(sweep->context, blocks, sweep_block, &job);
    ty_sweep_sums all = {0};
    for (int64_t i = 0; i < blocks; ++i) {
        all.leaving += sweep->sums[i].leaving;
        all.fixups += sweep->sums[i].fixups;
    }
    if (fixups != NULL) *fixups = (double)all.fixups;
    if (leaving == NULL) return TY_OK;
    ty_parallel_flushed(sweep->context, 8, sum_octant, sweep);
    for (int o = 0; o < 8; ++o) all.leaving += sweep->leaving[o];
    *leaving = all.leaving;
    return TY_OK;
}
