#include "solve/ordinates/dsa.h"

#include "base/arena.h"
#include "base/context.h"
#include "comm/regroup.h"
#include "solve/diffusion/cells.k.h"
#include "solve/diffusion/divided/divided.h"
#include "solve/diffusion/images.h"

#include <math.h>
#include <string.h>

struct ty_dsa {
    ty_diffusion_job job;
    ty_diffusion_def def;
    ty_diffusion_out out;
    ty_diffusion_stats stats;
    char* memory;
    size_t bytes;
    float *e, *smoothed[2]; /* laid out as the job's arrays */
    double leakage;         /* leakage of e, W */
    const ty_ordinates_faces* walls;
    float *slope, *offset; /* per side */
    /* Of a part of a box: the job has its cells and its equation, and the solver solves that of the whole. */
    ty_domain* domain; /* NULL: the whole, and the solver is the job */
    ty_diffusion_job* solver;
    ty_diffusion_job whole;
    ty_diffusion_def whole_def;
    ty_domain whole_domain;
    char* whole_memory;
    size_t whole_bytes;
};

/* ---- the diffusion problem ---- */

static void lay_out(ty_dsa* dsa, ty_arena* arena) {
    ty_diffusion_job* job = &dsa->job;
    ty_solve_lay_out(job, arena);
    const ty_box* box = &job->cells.box;
    if (dsa->domain != NULL) {
        job->levels[0] = (ty_level){.box = *box, .children = {1, 1, 1}};
        job->levels[0].d = ty_solve_take_box(arena, box, sizeof(float));
        job->levels[0].f = ty_solve_take_box(arena, box, sizeof(float));
        dsa->e = ty_solve_take_box(arena, box, sizeof(float));
    }
    for (int axis = 0; axis < 3; ++axis) job->levels[0].g[axis] = ty_solve_take_box(arena, box, sizeof(float));
    for (int i = 0; i < 2; ++i) dsa->smoothed[i] = ty_solve_take_box(arena, box, sizeof(float));
    if (dsa->walls->count == 0) return;
    const size_t sides = (size_t)dsa->walls->count;
    dsa->slope = ty_arena_take(arena, sizeof(float) * sides);
    dsa->offset = ty_arena_take(arena, sizeof(float) * sides);
}

/* True if a side of the box is one of the whole. */
static bool ends(const ty_dsa* dsa, int side) {
    if ((dsa->def.periodic >> (side / 2) & 1) != 0) return false;
    return dsa->domain == NULL || ty_domain_neighbour(dsa->domain, side) < 0;
}

/* Weight of a cell in the value on the face to a neighbour, 0..1. */
static float face_weight(float here, float there) {
    return here / (here + there);
}

/* Face couplings: half cells in series, so that at an interface of optically thick and thin cells the face has the
 * value of the thin side. (The mean of both D, as in flux-limited diffusion, would place it in the center of the thick
 * cell.) */
static void couple_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    ty_dsa* dsa = user;
    const ty_diffusion_job* job = &dsa->job;
    const ty_box* box = &job->cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    for (int32_t y = 0; y < box->size[1]; ++y)
        for (int32_t x = 0; x < box->size[0]; ++x) {
            const int32_t cell[3] = {x, y, (int32_t)z};
            const ptrdiff_t at = ty_box_at(box, y, (int32_t)z) + x;
            for (int axis = 0; axis < 3; ++axis) {
                const float here = job->diffusivity[at], below = job->diffusivity[at - steps[axis]];
                job->levels[0].g[axis][at] = cell[axis] > 0 || !ends(dsa, 2 * axis)
                                                 ? 4 * job->cells.coupling[axis] * here * face_weight(below, here)
                                                 : 0;
            }
        }
}

/* ---- boundary faces ---- */

/* Maximum albedo: with white faces around a medium without absorption the fluence would be undetermined up to rounding.
 */
static const float MAX_ALBEDO = 0.995f;

static bool is_on_box(const ty_dsa* dsa, int32_t side, int64_t row) {
    const ty_box* box = &dsa->job.cells.box;
    const ty_ordinates_faces* walls = dsa->walls;
    const int axis = walls->face[side] / 2;
    const int32_t at[3] = {walls->x[side], (int32_t)(row % box->size[1]), (int32_t)(row / box->size[1])};
    return at[axis] == ((walls->face[side] & 1) != 0 ? box->size[axis] - 1 : 0) && ends(dsa, walls->face[side]);
}

ptrdiff_t ty_dsa_face_cell(const ty_dsa* dsa, int32_t side, int64_t row, ptrdiff_t* step) {
    const ty_box* box = &dsa->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    const uint8_t face = dsa->walls->face[side];
    *step = (face & 1) != 0 ? steps[face / 2] : -steps[face / 2];
    return ty_box_at(box, (int32_t)(row % box->size[1]), (int32_t)(row / box->size[1])) + dsa->walls->x[side];
}

/* Closes a face and adds the absorption of the boundary face, in series with the cell's half. */
static void close_face(ty_dsa* dsa, int32_t side, int64_t row) {
    ty_diffusion_job* job = &dsa->job;
    ty_level* level = &job->levels[0];
    const uint8_t face = dsa->walls->face[side];
    const float albedo = ty_minf(dsa->walls->albedo[side], MAX_ALBEDO);
    const float kappa = 0.5f * (1 - albedo) / (1 + albedo), edge = (float)dsa->def.cell[face / 2];
    ptrdiff_t step;
    const ptrdiff_t at = ty_dsa_face_cell(dsa, side, row, &step);
    const float d = job->diffusivity[at];
    dsa->slope[side] = kappa / (1 + kappa * edge / (2 * d));
    if (is_on_box(dsa, side, row))
        level->d[at] -= ty_cell_boundary(job->cells.sides[face].a, job->cells.sides[face].b, d);
    else
        level->g[face / 2][step > 0 ? at + step : at] = 0;
    level->d[at] = ty_maxf(level->d[at], 0) + dsa->slope[side] / edge;
}

/* Ghosts behind boundary faces in the box's own faces along an axis: the flow there goes into the face. Returns the
 * power that set_ghosts counted as leakage. */
static double set_face_ghosts(const ty_dsa* dsa, int axis, float* e) {
    const ty_ordinates_faces* walls = dsa->walls;
    const double* cell = dsa->def.cell;
    const double area = cell[0] * cell[1] * cell[2] / cell[axis];
    double leakage = 0;
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            ptrdiff_t step;
            if (walls->face[side] / 2 != axis || !is_on_box(dsa, (int32_t)side, row)) continue;
            const ptrdiff_t at = ty_dsa_face_cell(dsa, (int32_t)side, row, &step);
            const float d = dsa->job.diffusivity[at], flow = dsa->slope[side] * e[at];
            leakage += area / cell[axis] * (double)(d * (e[at] - e[at + step]));
            e[at + step] = e[at] - (flow + dsa->offset[side]) * (float)cell[axis] / d;
        }
    return leakage;
}

/* No smoothing across faces between cells: the neighbour's term is replaced by a ghost's. */
static void exclude_faces(const ty_dsa* dsa, int axis, const float* from, float* to) {
    const ty_ordinates_faces* walls = dsa->walls;
    const float edge = (float)dsa->def.cell[axis];
    for (int64_t row = 0, side = 0; side < walls->count; ++row)
        for (; side < walls->first[row + 1]; ++side) {
            ptrdiff_t step;
            if (walls->face[side] / 2 != axis || is_on_box(dsa, (int32_t)side, row)) continue;
            const ptrdiff_t at = ty_dsa_face_cell(dsa, (int32_t)side, row, &step);
            const float *d = dsa->job.diffusivity, flow = dsa->slope[side] * from[at];
            to[at] -= 0.5f * face_weight(d[at + step], d[at]) * (from[at + step] - from[at]);
            to[at] -= 0.25f * (flow + dsa->offset[side]) * edge / d[at];
        }
}

const float* ty_dsa_face_slope(const ty_dsa* dsa) {
    return dsa->slope;
}

float* ty_dsa_face_offset(ty_dsa* dsa) {
    return dsa->offset;
}

/* ---- parts ---- */

static ty_halo array_of(const ty_box* box, const float* cells) {
    return (ty_halo){.origin = (void*)cells, .item = sizeof(float), .stride = {1, box->row, box->plane}};
}

/* Fetches the neighbours' cells beside the cuts, or those of the images. */
static void exchange(const ty_dsa* dsa, float* cells) {
    const ty_halo halo = array_of(&dsa->job.cells.box, cells);
    if (dsa->domain != NULL) ty_domain_exchange(dsa->domain, dsa->job.cells.box.size, &halo, 1);
    if (dsa->def.periodic != 0) ty_divided_exchange(&dsa->job, &dsa->job.cells.box, &cells, 1);
}

/* Moves cells of the part to the solver, or back. */
static void move(const ty_dsa* dsa, const float* part, const float* whole, bool back) {
    const ty_halo here = array_of(&dsa->job.cells.box, part), there = array_of(&dsa->whole.cells.box, whole);
    ty_comm* comm = dsa->domain->comm;
    if (back)
        ty_domain_regroup(comm, dsa->whole_def.domain, dsa->domain, &there, &here);
    else
        ty_domain_regroup(comm, dsa->domain, dsa->whole_def.domain, &here, &there);
}

static void lay_out_whole(ty_dsa* dsa, ty_arena* arena) {
    ty_diffusion_job* job = &dsa->whole;
    ty_solve_lay_out(job, arena);
    for (int axis = 0; axis < 3; ++axis)
        job->levels[0].g[axis] = ty_solve_take_box(arena, &job->cells.box, sizeof(float));
}

/* The solver of the whole: divided as multigrid needs it, or on rank 0 where there are too few cells for that. */
static void begin_whole(ty_dsa* dsa) {
    ty_diffusion_def* def = &dsa->whole_def;
    *def = dsa->def;
    def->solver = TY_DIFFUSION_MULTIGRID;
    memcpy(def->size, dsa->domain->cells, sizeof def->size);
    dsa->whole = dsa->job;
    dsa->whole.def = def;
    dsa->solver = &dsa->whole;
    if (ty_diffusion_divide(dsa->domain->comm, def, &dsa->whole_domain)) def->domain = &dsa->whole_domain;
    for (int axis = 0; axis < 3 && def->domain != NULL; ++axis)
        def->size[axis] = def->domain->end[axis] - def->domain->first[axis];
    if (def->domain == NULL && ty_comm_rank(dsa->domain->comm) > 0) return;
    ty_arena arena = {0};
    lay_out_whole(dsa, &arena);
    dsa->whole_bytes = arena.used;
}

static ty_result create_whole(ty_dsa* dsa) {
    if (dsa->whole_bytes == 0) return TY_OK;
    dsa->whole_memory = ty_alloc_array(dsa->job.context, dsa->whole_bytes, 1, true);
    if (dsa->whole_memory == NULL) return TY_ERROR_MEMORY;
    ty_arena arena = {.base = dsa->whole_memory};
    lay_out_whole(dsa, &arena);
    return TY_OK;
}

static void set_up_whole(ty_dsa* dsa) {
    const ty_level *part = &dsa->job.levels[0], *whole = &dsa->whole.levels[0];
    for (int axis = 0; axis < 3; ++axis) move(dsa, part->g[axis], whole->g[axis], false);
    move(dsa, part->d, whole->d, false);
    if (dsa->whole_memory == NULL) return;
    ty_divided_exchange(&dsa->whole, &whole->box, &whole->g[1], 2);
    ty_multigrid_coarsen(&dsa->whole, 0);
}

static void set_up_operator(ty_dsa* dsa) {
    ty_diffusion_job* job = &dsa->job;
    ty_solve_set_cells(job, 1);
    job->stage_count = 1; /* no coarser nonlinear levels: the problem is linear */
    ty_fas_restrict_cells(job);
    ty_fas_linearise(job, 0);
    exchange(dsa, job->diffusivity);
    ty_solve_planes(job, &job->cells.box, couple_plane, dsa);
    for (int64_t row = 0, side = 0; side < dsa->walls->count; ++row)
        for (; side < dsa->walls->first[row + 1]; ++side) close_face(dsa, (int32_t)side, row);
    job->levels[0].diffusivity = NULL;
    ty_diffusion_couple_images(job, &job->levels[0]);
    if (dsa->domain != NULL)
        set_up_whole(dsa);
    else
        ty_multigrid_coarsen(job, 0);
}

/* A solve without its memory, whose size it finds. */
static void begin_dsa(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                      ty_domain* domain, ty_dsa* dsa) {
    dsa->def = *def;
    dsa->walls = walls;
    dsa->def.limiter = TY_LIMITER_NONE;
    dsa->domain = domain;
    /* The solver of a part is another one, and this one's memory is little. */
    dsa->def.solver = domain != NULL ? TY_DIFFUSION_SOR : TY_DIFFUSION_MULTIGRID;
    for (int side = 0; side < 6; ++side)
        if (!ends(dsa, side)) dsa->def.boundary[side].kind = TY_BOUNDARY_REFLECTING;
    dsa->def.source = def->absorption; /* required by the job; the resulting source is unused */
    dsa->job = (ty_diffusion_job){.context = context, .def = &dsa->def, .out = &dsa->out, .stats = &dsa->stats};
    dsa->solver = &dsa->job;
    ty_arena arena = {0};
    lay_out(dsa, &arena);
    dsa->bytes = arena.used;
    if (domain != NULL) begin_whole(dsa);
}

size_t ty_dsa_plan(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                   ty_domain* domain) {
    ty_dsa dsa = {.leakage = 0};
    begin_dsa(context, def, walls, domain, &dsa);
    ty_domain_destroy(&dsa.whole_domain);
    return ty_dsa_bytes(&dsa);
}

ty_result ty_dsa_create(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                        ty_domain* domain, ty_dsa** out) {
    *out = NULL;
    ty_dsa* dsa = ty_alloc_array(context, 1, sizeof *dsa, true);
    if (dsa == NULL) return TY_ERROR_MEMORY;
    begin_dsa(context, def, walls, domain, dsa);
    dsa->memory = ty_alloc_array(context, dsa->bytes, 1, true);
    if (dsa->memory == NULL || create_whole(dsa) != TY_OK) {
        ty_dsa_destroy(dsa);
        return TY_ERROR_MEMORY;
    }
    ty_arena arena = {.base = dsa->memory};
    ty_solve_choose_kernels(&dsa->job);
    ty_solve_choose_kernels(dsa->solver);
    lay_out(dsa, &arena);
    set_up_operator(dsa);
    *out = dsa;
    return TY_OK;
}

void ty_dsa_destroy(ty_dsa* dsa) {
    if (dsa == NULL) return;
    ty_context* context = dsa->job.context;
    if (dsa->memory != NULL) ty_free_array(context, dsa->memory, dsa->bytes, 1);
    if (dsa->whole_memory != NULL) ty_free_array(context, dsa->whole_memory, dsa->whole_bytes, 1);
    ty_domain_destroy(&dsa->whole_domain);
    ty_free_array(context, dsa, 1, sizeof *dsa);
}

size_t ty_dsa_bytes(const ty_dsa* dsa) {
    return sizeof *dsa + dsa->bytes + dsa->whole_bytes;
}

const ty_box* ty_dsa_box(const ty_dsa* dsa) {
    return &dsa->job.cells.box;
}

const float* ty_dsa_diffusivity(const ty_dsa* dsa) {
    return dsa->job.diffusivity;
}

float* ty_dsa_source(ty_dsa* dsa) {
    return dsa->job.levels[0].f;
}

/* ---- solves ---- */

/* Ghosts at those ends of an axis that are the whole's, from the cells inside. Returns the leakage there, W. */
static double set_ghosts(const ty_dsa* dsa, int axis, float* e) {
    const ty_box* box = &dsa->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, step = steps[axis];
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const double* cell = dsa->def.cell;
    const float edge = (float)cell[axis];
    double leakage = 0;
    for (int32_t j = 0; j < box->size[v]; ++j)
        for (int32_t i = 0; i < box->size[u]; ++i)
            for (int end = 0; end < 2; ++end) {
                if (!ends(dsa, 2 * axis + end)) continue;
                const ptrdiff_t at = steps[u] * i + steps[v] * j + (end != 0 ? step * (box->size[axis] - 1) : 0);
                const float d = dsa->job.diffusivity[at], half_thickness = edge / (4 * d);
                const float ghost = e[at] * (1 - half_thickness) / (1 + half_thickness);
                e[end != 0 ? at + step : at - step] = ghost;
                leakage += (double)(d * (e[at] - ghost));
            }
    return leakage * cell[u] * cell[v] / cell[axis];
}

typedef struct smoothing {
    const ty_dsa* dsa;
    const float* from;
    float* to;
    int axis;
} smoothing;

static void smooth_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const smoothing* s = user;
    const ty_box* box = &s->dsa->job.cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, step = steps[s->axis];
    for (int32_t y = 0; y < box->size[1]; ++y) {
        const ptrdiff_t at = ty_box_at(box, y, (int32_t)z);
        const float *d = s->dsa->job.diffusivity + at, *e = s->from + at;
        float* to = s->to + at;
#pragma omp simd
        for (ptrdiff_t i = 0; i < box->size[0]; ++i) {
            const float here = fabsf(d[i]), below = fabsf(d[i - step]), above = fabsf(d[i + step]);
            to[i] = e[i] + 0.5f * (face_weight(below, here) * (e[i - step] - e[i]) +
                                   face_weight(above, here) * (e[i + step] - e[i]));
        }
    }
}

static void smooth_fluence(ty_dsa* dsa) {
    const float* from = dsa->e;
    for (int axis = 0; axis < 3; ++axis) {
        smoothing s = {.dsa = dsa, .from = from, .to = dsa->smoothed[axis & 1], .axis = axis};
        ty_solve_planes(&dsa->job, &dsa->job.cells.box, smooth_plane, &s);
        exclude_faces(dsa, axis, from, s.to);
        if (axis < 2) exchange(dsa, s.to);
        if (axis < 2) set_ghosts(dsa, axis + 1, s.to);
        if (axis < 2) set_face_ghosts(dsa, axis + 1, s.to);
        from = s.to;
    }
}

void ty_dsa_solve(ty_dsa* dsa, double squares, double reduction, int32_t cycles) {
    const float* e = NULL;
    if (dsa->domain != NULL) move(dsa, dsa->job.levels[0].f, dsa->whole.levels[0].f, false);
    if (dsa->domain == NULL || dsa->whole_memory != NULL)
        e = ty_multigrid_solve(dsa->solver, 0, squares, squares * reduction * reduction, cycles);
    if (dsa->domain == NULL) dsa->e = (float*)e;
    if (dsa->domain != NULL) move(dsa, dsa->e, e, true);
    exchange(dsa, dsa->e);
    dsa->leakage = 0;
    for (int axis = 0; axis < 3; ++axis) {
        dsa->leakage += set_ghosts(dsa, axis, dsa->e);
        dsa->leakage -= set_face_ghosts(dsa, axis, dsa->e);
    }
    if (dsa->domain != NULL) ty_comm_sum(dsa->domain->comm, &dsa->leakage, 1);
    smooth_fluence(dsa);
}

const float* ty_dsa_fluence(const ty_dsa* dsa) {
    return dsa->e;
}

const float* ty_dsa_smoothed_fluence(const ty_dsa* dsa) {
    return dsa->smoothed[0];
}

double ty_dsa_leakage(const ty_dsa* dsa) {
    return dsa->leakage;
}

int32_t ty_dsa_cycles(const ty_dsa* dsa) {
    return dsa->stats.cycles;
}
