/* A sweep of the part of a box that a rank owns: units in the order of the schedule, radiance at faces from the ranks
 * upwind and to those downwind. A cell's radiance is the same, bit for bit, as in a sweep of the whole box; its moments
 * are sums of the same numbers, octant by octant in the order of the units. */
#include "solve/ordinates/sweep_state.h"

#include "base/arena.h"
#include "base/context.h"
#include "base/parallel.h"

#include <string.h>

/* Tags of messages, by stream. */
enum { TAG_ACROSS_X = 64, TAG_ACROSS_Y = TAG_ACROSS_X + TY_SWEEP_STREAMS_MAX };

/* ---- memory ---- */

static bool is_cut_along_x(const ty_sweep* sweep) {
    return ty_domain_is_cut(sweep->domain, 0);
}

static void lay_out(ty_sweep* sweep, ty_arena* arena) {
    ty_sweep_box* box = &sweep->box;
    const size_t lanes = (size_t)box->groups * (size_t)box->lanes, ny = (size_t)box->size[1];
    const size_t longest = ny > (size_t)box->size[0] ? ny : (size_t)box->size[0];
    sweep->message = ty_arena_take(arena, sizeof(float) * 2 * longest * (size_t)sweep->schedule.planes * lanes);
    if (!is_cut_along_x(sweep)) return;
    for (int o = 0; o < 8; ++o) {
        box->faces_x[o] = ty_arena_take(arena, sizeof(float) * ny * (size_t)box->size[2] * lanes);
        box->unpaired_y_lm[o] = ty_arena_take(arena, sizeof(float) * (size_t)box->unpaired_terms * lanes);
    }
}

/* Weighted harmonics of an octant's directions, without the padding between parities. */
static void fill_unpaired(ty_sweep* sweep, int32_t octant) {
    const ty_sweep_box* box = &sweep->box;
    const int32_t odd_begin = (box->even + box->lanes - 1) / box->lanes * box->lanes;
    float* to = (float*)box->unpaired_y_lm[octant];
    for (int32_t d = 0; d < box->directions; ++d)
        for (int32_t t = 0; t < box->terms; ++t) {
            const int32_t at = t < box->even ? t : odd_begin + t - box->even;
            const float value = box->weighted_y_lm[octant / 2][d * box->padded + at];
            to[d * box->unpaired_terms + t] = t >= box->even && (octant & 1) != 0 ? -value : value;
        }
}

void ty_sweep_plan_units(ty_sweep* sweep, const ty_domain* domain) {
    ty_sweep_box* box = &sweep->box;
    sweep->domain = domain;
    memcpy(box->whole, domain->cells, sizeof box->whole);
    memcpy(box->origin, domain->first, sizeof box->origin);
    box->unpaired_terms = (box->terms + box->lanes - 1) / box->lanes * box->lanes;
    sweep->schedule = ty_sweep_choose_blocks(domain->ranks, box->size[2]);
    ty_arena arena = {0};
    lay_out(sweep, &arena);
    sweep->division_bytes = arena.used;
}

ty_result ty_sweep_divide(ty_sweep* sweep, const ty_domain* domain) {
    if (domain == NULL) return TY_OK;
    ty_sweep_plan_units(sweep, domain);
    const ty_result result = ty_sweep_schedule_make(sweep->context, domain->ranks, domain->at, &sweep->schedule);
    if (result != TY_OK) return result;
    ty_arena arena = {.base = ty_alloc_array(sweep->context, sweep->division_bytes, 1, true)};
    sweep->division_memory = arena.base;
    if (arena.base == NULL) return TY_ERROR_MEMORY;
    lay_out(sweep, &arena);
    for (int32_t o = 0; o < 8 && is_cut_along_x(sweep); ++o) fill_unpaired(sweep, o);
    return TY_OK;
}

void ty_sweep_free_division(ty_sweep* sweep) {
    ty_sweep_schedule_free(sweep->context, &sweep->schedule);
    if (sweep->division_memory != NULL) ty_free_array(sweep->context, sweep->division_memory, sweep->division_bytes, 1);
    sweep->division_memory = NULL;
}

/* ---- faces ---- */

/* A unit's octants [begin, end), its planes, and where its directions go. */
typedef struct unit_range {
    int32_t begin, end, octants; /* octants: 1 or 2 */
    int32_t planes[2];
    bool down[2]; /* along x (of one octant) and y */
} unit_range;

static unit_range range_of(const ty_sweep* sweep, const ty_sweep_unit* unit) {
    const int32_t nz = sweep->box.size[2], begin = unit->block * sweep->schedule.planes;
    const bool unpaired = is_cut_along_x(sweep);
    unit_range r = {.octants = unpaired ? 1 : 2, .planes = {begin, begin + sweep->schedule.planes}};
    if (r.planes[1] > nz) r.planes[1] = nz;
    r.begin = unpaired ? unit->stream : 2 * unit->stream;
    r.end = r.begin + r.octants;
    r.down[0] = (r.begin & 1) != 0;
    r.down[1] = (r.begin & 2) != 0;
    return r;
}

/* The rank upwind or downwind of a unit along an axis; negative: none. */
static int32_t neighbour(const ty_sweep* sweep, const unit_range* r, int axis, bool upwind) {
    return ty_domain_neighbour(sweep->domain, 2 * axis + (r->down[axis] == upwind ? 1 : 0));
}

/* Copies the directions of a unit's faces across an axis to the message, or back; returns their number. */
static size_t copy_faces(ty_sweep* sweep, const unit_range* r, int axis, bool out) {
    const ty_sweep_box* box = &sweep->box;
    const ptrdiff_t row = box->size[1 - axis];
    float* message = sweep->message;
    for (int32_t o = r->begin; o < r->end; ++o)
        for (int32_t g = 0; g < box->groups; ++g) {
            const int32_t left = box->directions - g * box->lanes;
            const size_t count = (size_t)(left < box->lanes ? left : box->lanes);
            float* face = axis == 0 ? box->faces_x[o] : box->faces_y[o];
            face += ((ptrdiff_t)g * box->size[2] + r->planes[0]) * row * box->lanes;
            for (ptrdiff_t i = 0; i < row * (r->planes[1] - r->planes[0]); ++i, face += box->lanes, message += count)
                memcpy(out ? message : face, out ? face : message, count * sizeof(float));
        }
    return (size_t)(message - sweep->message);
}

/* Floats of a unit's faces across an axis. */
static size_t face_floats(const ty_sweep* sweep, const unit_range* r, int axis) {
    const ty_sweep_box* box = &sweep->box;
    return (size_t)r->octants * (size_t)box->directions * (size_t)box->size[1 - axis] *
           (size_t)(r->planes[1] - r->planes[0]);
}

/* The boundary radiance of an octant's faces across x. */
static void set_boundary_across_x(const ty_sweep_box* box, const unit_range* r) {
    const ptrdiff_t pitch = (ptrdiff_t)box->groups * box->lanes, ny = box->size[1];
    for (ptrdiff_t g = 0; g < box->groups; ++g)
        for (int32_t z = r->planes[0]; z < r->planes[1]; ++z)
            for (int32_t y = 0; y < ny; ++y) {
                const int32_t at[3] = {0, y + box->origin[1], z + box->origin[2]};
                const ptrdiff_t patch = ty_boundary_patch(&box->patches, box->whole, 0, at);
                memcpy(box->faces_x[r->begin] + ((g * box->size[2] + z) * ny + y) * box->lanes,
                       box->boundary_radiance[0][r->begin] + patch * pitch + g * box->lanes,
                       sizeof(float) * (size_t)box->lanes);
            }
}

static bool receive_faces(ty_sweep* sweep, const unit_range* r, int axis, int32_t stream) {
    const int32_t from = neighbour(sweep, r, axis, true);
    const int32_t tag = (axis == 0 ? TAG_ACROSS_X : TAG_ACROSS_Y) + stream;
    if (axis == 0 && !is_cut_along_x(sweep)) return true;
    if (from < 0) {
        if (axis == 0) set_boundary_across_x(&sweep->box, r);
        return true;
    }
    const size_t bytes = sizeof(float) * face_floats(sweep, r, axis);
    if (!ty_comm_get(sweep->domain->comm, from, tag, sweep->message, bytes)) return false;
    copy_faces(sweep, r, axis, false);
    return true;
}

static bool send_faces(ty_sweep* sweep, const unit_range* r, int axis, int32_t stream) {
    const int32_t to = neighbour(sweep, r, axis, false);
    const int32_t tag = (axis == 0 ? TAG_ACROSS_X : TAG_ACROSS_Y) + stream;
    if (to < 0 || (axis == 0 && !is_cut_along_x(sweep))) return true;
    const size_t bytes = sizeof(float) * copy_faces(sweep, r, axis, true);
    return ty_comm_put(sweep->domain->comm, to, tag, sweep->message, bytes);
}

bool ty_sweep_leaves_across_y(const ty_sweep* sweep, int32_t octant) {
    return sweep->domain == NULL || ty_domain_neighbour(sweep->domain, (octant & 2) != 0 ? 2 : 3) < 0;
}

/* ---- units ---- */

typedef struct unit_job {
    ty_sweep* sweep;
    const ty_sweep_unit* unit;
    unit_range range;
    const float* emission;
    float* moments;
    int32_t blocks_z; /* of the unit */
    int32_t stage;    /* of the wavefront of blocks in the unit */
} unit_job;

static void sweep_block(void* user, int64_t index, int32_t worker) {
    const unit_job* job = user;
    ty_sweep* sweep = job->sweep;
    const unit_range* r = &job->range;
    const int32_t counts[2] = {sweep->blocks[0], job->blocks_z};
    const int32_t at[2] = {(int32_t)(index % counts[0]), (int32_t)(index / counts[0])};
    const int32_t origin[2] = {0, r->planes[0]}, limit[2] = {sweep->box.size[1], r->planes[1]};
    const int32_t pair = r->begin / 2;
    ty_sweep_block block = {.pair = pair,
                            .unpaired = r->octants == 1 ? r->begin & 1 : -1,
                            .leaves = neighbour(sweep, r, 0, false) < 0,
                            .first = job->unit->first,
                            .last = job->unit->last};
    int32_t stage = 0;
    for (int a = 0; a < 2; ++a) {
        stage += (pair >> a & 1) != 0 ? counts[a] - 1 - at[a] : at[a];
        block.begin[a] = origin[a] + at[a] * TY_SWEEP_BLOCK_ROWS;
        block.end[a] = block.begin[a] + TY_SWEEP_BLOCK_ROWS;
        if (block.end[a] > limit[a]) block.end[a] = limit[a];
    }
    if (stage != job->stage) return;
    const bool down_y = (pair & 1) != 0, down_z = (pair & 2) != 0;
    const bool at_side = down_y ? block.end[0] == sweep->box.size[1] : block.begin[0] == 0;
    const bool at_end = down_z ? block.end[1] == sweep->box.size[2] : block.begin[1] == 0;
    ty_sweep_set_boundary(&sweep->box, &block, (const bool[2]){at_side && neighbour(sweep, r, 1, true) < 0, at_end});
    sweep->kernels->cross(&sweep->box, &block, job->emission, job->moments,
                          sweep->scratch + sweep->scratch_floats * (size_t)worker, &sweep->sums[index]);
}

ty_result ty_sweep_run_units(ty_sweep* sweep, const float* emission, float* moments) {
    for (int32_t u = 0; u < sweep->schedule.count; ++u) {
        const ty_sweep_unit* unit = &sweep->schedule.units[u];
        unit_job job = {
            .sweep = sweep, .unit = unit, .range = range_of(sweep, unit), .emission = emission, .moments = moments};
        const int32_t planes = job.range.planes[1] - job.range.planes[0];
        job.blocks_z = (planes + TY_SWEEP_BLOCK_ROWS - 1) / TY_SWEEP_BLOCK_ROWS;
        for (int axis = 0; axis < 2; ++axis)
            if (!receive_faces(sweep, &job.range, axis, unit->stream)) return TY_ERROR_INTERNAL;
        for (; job.stage < sweep->blocks[0] + job.blocks_z - 1; ++job.stage)
            ty_parallel_flushed(sweep->context, (int64_t)sweep->blocks[0] * job.blocks_z, sweep_block, &job);
        for (int axis = 0; axis < 2; ++axis)
            if (!send_faces(sweep, &job.range, axis, unit->stream)) return TY_ERROR_INTERNAL;
    }
    return TY_OK;
}
