#include "solve/ordinates/dsa.h"

#include "base/arena.h"
#include "base/context.h"
#include "solve/diffusion/cells.k.h"
#include "solve/diffusion/job.h"

#include <math.h>
#include <string.h>

struct ty_dsa {
    ty_diffusion_job job;
    ty_diffusion_def def;
    ty_diffusion_out out;
    ty_diffusion_stats stats;
    char* memory;
    size_t bytes;
    float *e, *smooth[2]; /* as the job's arrays lie */
    double leaving;       /* W, of e */
    const ty_ordinates_faces* walls;
    float *slope, *rest; /* of each side */
};

/* ---- the problem ---- */

static void lay_out(ty_dsa* correction, ty_arena* arena) {
    ty_diffusion_job* job = &correction->job;
    ty_solve_lay_out(job, arena);
    const ty_box* box = &job->cells.box;
    for (int axis = 0; axis < 3; ++axis) job->levels[0].g[axis] = ty_solve_take_box(arena, box, sizeof(float));
    for (int i = 0; i < 2; ++i) correction->smooth[i] = ty_solve_take_box(arena, box, sizeof(float));
    if (correction->walls->count == 0) return;
    const size_t sides = (size_t)correction->walls->count;
    correction->slope = ty_arena_take(arena, sizeof(float) * sides);
    correction->rest = ty_arena_take(arena, sizeof(float) * sides);
}

/* What a cell has of the value on the face to a neighbour: 0..1. */
static float share_of(float here, float there) {
    return here / (here + there);
}

/* Couplings through faces: the half cells in series, so that where thick cells meet thin ones the thin side's value is
 * that of the face. (The mean D of the two, which limited diffusion has, would put it in the middle of the thick cell.)
 */
static void couple_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    ty_dsa* correction = user;
    const ty_diffusion_job* job = &correction->job;
    const ty_box* box = &job->cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    for (int32_t y = 0; y < box->size[1]; ++y)
        for (int32_t x = 0; x < box->size[0]; ++x) {
            const int32_t place[3] = {x, y, (int32_t)z};
            const ptrdiff_t at = ty_box_at(box, y, (int32_t)z) + x;
            for (int axis = 0; axis < 3; ++axis) {
                const float here = job->diffusivity[at], below = job->diffusivity[at - steps[axis]];
                job->levels[0].g[axis][at] =
                    place[axis] > 0 ? 4 * job->cells.coupling[axis] * here * share_of(below, here) : 0;
            }
        }
}

/* ---- walls ---- */

/* White walls around what absorbs nothing would leave it to rounding what the fluence is. */
static const float WHITEST = 0.995f;

static bool is_outer(const ty_dsa* correction, int32_t side, int64_t row) {
    const ty_box* box = &correction->job.cells.box;
    const ty_ordinates_faces* walls = correction->walls;
    const int axis = walls->face[side] / 2;
    const int32_t at[3] = {walls->x[side], (int32_t)(row % box->size[1]), (int32_t)(row / box->size[1])};
    return at[axis] == ((walls->face[side] & 1) != 0 ? box->size[axis] - 1 : 0);
}

ptrdiff_t ty_dsa_face_cell(const ty_dsa* correction, int32_t side, int64_t row, ptrdiff_t* step) {
    const ty_box* box = &correction->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    const uint8_t face = correction->walls->face[side];
    *step = (face & 1) != 0 ? steps[face / 2] : -steps[face / 2];
    return ty_box_at(box, (int32_t)(row % box->size[1]), (int32_t)(row / box->size[1])) + correction->walls->x[side];
}

/* Closes a face, and lets the wall take what it absorbs, of the cell's half and the wall in series. */
static void close_side(ty_dsa* correction, int32_t side, int64_t row) {
    ty_diffusion_job* job = &correction->job;
    ty_level* level = &job->levels[0];
    const uint8_t face = correction->walls->face[side];
    const float albedo = ty_minf(correction->walls->albedo[side], WHITEST);
    const float kappa = 0.5f * (1 - albedo) / (1 + albedo), edge = (float)correction->def.cell[face / 2];
    ptrdiff_t step;
    const ptrdiff_t at = ty_dsa_face_cell(correction, side, row, &step);
    const float d = job->diffusivity[at];
    correction->slope[side] = kappa / (1 + kappa * edge / (2 * d));
    if (is_outer(correction, side, row))
        level->d[at] -= ty_cell_boundary(job->cells.sides[face].a, job->cells.sides[face].b, d);
    else
        level->g[face / 2][step > 0 ? at + step : at] = 0;
    level->d[at] = ty_maxf(level->d[at], 0) + correction->slope[side] / edge;
}

/* Ghosts behind walls in the box's own faces along an axis: what flows there is the wall's. Returns what close_axis
 * took for leaving. */
static double close_walls(const ty_dsa* correction, int axis, float* e) {
    const ty_ordinates_faces* walls = correction->walls;
    const double* cell = correction->def.cell;
    const double area = cell[0] * cell[1] * cell[2] / cell[axis];
    double leaving = 0;
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            ptrdiff_t step;
            if (walls->face[side] / 2 != axis || !is_outer(correction, (int32_t)side, row)) continue;
            const ptrdiff_t at = ty_dsa_face_cell(correction, (int32_t)side, row, &step);
            const float d = correction->job.diffusivity[at], flow = correction->slope[side] * e[at];
            leaving += area / cell[axis] * (double)(d * (e[at] - e[at + step]));
            e[at + step] = e[at] - (flow + correction->rest[side]) * (float)cell[axis] / d;
        }
    return leaving;
}

/* Nothing is smoothed across walls between cells: what was of the next cell becomes a ghost's. */
static void smooth_walls(const ty_dsa* correction, int axis, const float* from, float* to) {
    const ty_ordinates_faces* walls = correction->walls;
    const float edge = (float)correction->def.cell[axis];
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            ptrdiff_t step;
            if (walls->face[side] / 2 != axis || is_outer(correction, (int32_t)side, row)) continue;
            const ptrdiff_t at = ty_dsa_face_cell(correction, (int32_t)side, row, &step);
            const float *d = correction->job.diffusivity, flow = correction->slope[side] * from[at];
            to[at] -= 0.5f * share_of(d[at + step], d[at]) * (from[at + step] - from[at]);
            to[at] -= 0.25f * (flow + correction->rest[side]) * edge / d[at];
        }
}

const float* ty_dsa_face_slope(const ty_dsa* correction) {
    return correction->slope;
}

float* ty_dsa_face_offset(ty_dsa* correction) {
    return correction->rest;
}

static void linearise(ty_dsa* correction) {
    ty_diffusion_job* job = &correction->job;
    ty_solve_set_cells(job, 1);
    job->stage_count = 1; /* no coarser ones: the problem is linear */
    ty_fas_restrict_cells(job);
    ty_fas_linearise(job, 0);
    ty_solve_planes(job, &job->cells.box, couple_plane, correction);
    for (int64_t row = 0, side = 0; side < correction->walls->count; ++row)
        for (; side < correction->walls->first[row + 1]; ++side) close_side(correction, (int32_t)side, row);
    job->levels[0].diffusivity = NULL;
    ty_multigrid_coarsen(job, 0);
}

ty_result ty_dsa_create(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                        ty_dsa** out) {
    *out = NULL;
    ty_dsa* correction = ty_alloc_array(context, 1, sizeof *correction, true);
    if (correction == NULL) return TY_ERROR_MEMORY;
    correction->def = *def;
    correction->walls = walls;
    correction->def.limiter = TY_LIMITER_NONE;
    correction->def.solver = TY_DIFFUSION_MULTIGRID;
    correction->def.source = def->absorption; /* read, but what it makes is not used */
    correction->job = (ty_diffusion_job){
        .context = context, .def = &correction->def, .out = &correction->out, .stats = &correction->stats};
    ty_arena arena = {0};
    lay_out(correction, &arena);
    correction->bytes = arena.used;
    correction->memory = ty_alloc_array(context, correction->bytes, 1, true);
    if (correction->memory == NULL) {
        ty_dsa_destroy(correction);
        return TY_ERROR_MEMORY;
    }
    arena = (ty_arena){.base = correction->memory};
    ty_solve_choose_kernels(&correction->job);
    lay_out(correction, &arena);
    linearise(correction);
    *out = correction;
    return TY_OK;
}

void ty_dsa_destroy(ty_dsa* correction) {
    if (correction == NULL) return;
    ty_context* context = correction->job.context;
    if (correction->memory != NULL) ty_free_array(context, correction->memory, correction->bytes, 1);
    ty_free_array(context, correction, 1, sizeof *correction);
}

size_t ty_dsa_bytes(const ty_dsa* correction) {
    return sizeof *correction + correction->bytes;
}

const ty_box* ty_dsa_box(const ty_dsa* correction) {
    return &correction->job.cells.box;
}

const float* ty_dsa_diffusivity(const ty_dsa* correction) {
    return correction->job.diffusivity;
}

float* ty_dsa_source(ty_dsa* correction) {
    return correction->job.levels[0].f;
}

/* ---- solves ---- */

/* Ghosts at both ends of an axis, of the cells inside. Returns what leaves there, W. */
static double close_axis(const ty_dsa* correction, int axis, float* e) {
    const ty_box* box = &correction->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, step = steps[axis];
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const double* cell = correction->def.cell;
    const float edge = (float)cell[axis];
    double leaving = 0;
    for (int32_t j = 0; j < box->size[v]; ++j)
        for (int32_t i = 0; i < box->size[u]; ++i)
            for (int end = 0; end < 2; ++end) {
                const ptrdiff_t at = steps[u] * i + steps[v] * j + (end != 0 ? step * (box->size[axis] - 1) : 0);
                const float d = correction->job.diffusivity[at], thick = edge / (4 * d);
                const float ghost = e[at] * (1 - thick) / (1 + thick);
                e[end != 0 ? at + step : at - step] = ghost;
                leaving += (double)(d * (e[at] - ghost));
            }
    return leaving * cell[u] * cell[v] / cell[axis];
}

typedef struct smoothing {
    const ty_dsa* correction;
    const float* from;
    float* to;
    int axis;
} smoothing;

static void smooth_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const smoothing* s = user;
    const ty_box* box = &s->correction->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, step = steps[s->axis];
    for (int32_t y = 0; y < box->size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(box, y, (int32_t)z);
        const float *d = s->correction->job.diffusivity + at, *e = s->from + at;
        float* to = s->to + at;
#pragma omp simd
        for (ptrdiff_t i = 0; i < box->size[0]; ++i) {
            const float here = fabsf(d[i]), below = fabsf(d[i - step]), above = fabsf(d[i + step]);
            to[i] = e[i] + 0.5f * (share_of(below, here) * (e[i - step] - e[i]) +
                                   share_of(above, here) * (e[i + step] - e[i]));
        }
    }
}

static void smooth(ty_dsa* correction) {
    const float* from = correction->e;
    for (int axis = 0; axis < 3; ++axis) {
        smoothing s = {.correction = correction, .from = from, .to = correction->smooth[axis & 1], .axis = axis};
        ty_solve_planes(&correction->job, &correction->job.cells.box, smooth_plane, &s);
        smooth_walls(correction, axis, from, s.to);
        if (axis < 2) close_axis(correction, axis + 1, s.to);
        if (axis < 2) close_walls(correction, axis + 1, s.to);
        from = s.to;
    }
}

void ty_dsa_solve(ty_dsa* correction, double squares, double reduction, int32_t cycles) {
    ty_diffusion_job* job = &correction->job;
    correction->e = (float*)ty_multigrid_solve(job, 0, squares, squares * reduction * reduction, cycles);
    correction->leaving = 0;
    for (int axis = 0; axis < 3; ++axis) {
        correction->leaving += close_axis(correction, axis, correction->e);
        correction->leaving -= close_walls(correction, axis, correction->e);
    }
    smooth(correction);
}

const float* ty_dsa_fluence(const ty_dsa* correction) {
    return correction->e;
}

const float* ty_dsa_smoothed_fluence(const ty_dsa* correction) {
    return correction->smooth[0];
}

double ty_dsa_leakage(const ty_dsa* correction) {
    return correction->leaving;
}

int32_t ty_dsa_cycles(const ty_dsa* correction) {
    return correction->stats.cycles;
}
