/* Diffusion between surfaces. A surface closes faces of cells: none of the light passes through them, and each of a
 * face's sides returns light to its own cell. With J the net flux through the half cell to the surface, partial
 * currents J- = phi_f / 4 + J / 2 towards it and J+ = phi_f / 4 - J / 2 = a J- + M away from it, of albedo a and
 * radiosity M besides reflection, make Marshak's boundary condition
 *
 *     J = k phi_f - m,   k = (1 - a) / (2 (1 + a)),   m = 2 M / (1 + a)
 *
 * (a = 0: phi_f / 2 - 2 M). A slanted surface is a staircase, whose faces are s times as large as it is: J through each
 * of them is divided by s. The equations are solved by Picard iterations, with multigrid for their linear problems. */
#include "solve/diffusion/closed_faces.h"

#include "solve/diffusion/cells.k.h"
#include "solve/diffusion/divided/divided.h"

#include <math.h>
#include <string.h>

/* Iterations at most; multigrid cycles of one while the flux is limited (fewer converge slowly where coarse cells reach
 * through surfaces), and of the linear problem; reduction of its residual. Iterations without a residual below GAIN
 * times the smallest so far, after which D is no longer damped. */
enum { ITERATIONS = 100, CYCLES = 6, LINEAR_CYCLES = 20, MAX_STAGNATION = 4 };
static const double REDUCTION = 1e-6, GAIN = 0.9;
static const float DAMPING = 0.3f;

typedef struct closed_job {
    ty_diffusion_job* job;
    ty_limiter limiter;
    float damping;
} closed_job;

static bool is_closed(const ty_diffusion_faces* faces, ptrdiff_t cell, int face) {
    return (faces->closed[cell] >> face & 1) != 0;
}

/* True if a cell lies at an end of the grid. */
static bool is_at_end(const ty_box* box, const int32_t at[3], int face) {
    const int axis = face / 2;
    return at[axis] == ((face & 1) != 0 ? box->size[axis] - 1 : 0) && ty_box_ends(box, face);
}

/* ---- sides ---- */

/* k and m of a side, without the factor 1 / s. */
static double side_conductance(const ty_diffusion_faces* faces, int32_t side) {
    const double albedo = (double)faces->albedo[side];
    return (1 - albedo) / (2 * (1 + albedo));
}

static double side_source(const ty_diffusion_faces* faces, int32_t side) {
    return faces->radiosity != NULL ? 2 * (double)faces->radiosity[side] / (1 + (double)faces->albedo[side]) : 0;
}

/* Net flux to a side, W m^-2, is `sink` phi - `source`: the half cell, of conductance 2 D / h, in series with k / s. */
typedef struct side_flux {
    double sink, source;
} side_flux;

static side_flux flux_to_side(const ty_diffusion_faces* faces, int32_t side, double diffusivity, double edge) {
    const double s = (double)faces->staircase[side], through = 2 * diffusivity / edge;
    const double k = side_conductance(faces, side) / s, m = side_source(faces, side) / s,
                 fraction = through / (k + through);
    return (side_flux){k * fraction, m * fraction};
}

double ty_diffusion_faces_source(const ty_diffusion_faces* faces, const double cell[3], int32_t side) {
    return side_source(faces, side) / (double)faces->staircase[side] / cell[faces->face[side] / 2];
}

/* ---- diffusivity ---- */

/* Difference of phi across two cells along an axis. A closed face has no slope where it is white, and that of the
 * opposite face where it is black. */
static double difference(const closed_job* closed, const int32_t at[3], ptrdiff_t dense, const double* phi, int axis) {
    const ty_cells* cells = &closed->job->cells;
    const ptrdiff_t step = axis == 0 ? 1 : axis == 1 ? cells->box.row : cells->box.plane;
    const ty_diffusion_faces* faces = closed->job->def->faces;
    double slope[2] = {0, 0};
    bool open[2], outside[2];
    for (int up = 0; up < 2; ++up) {
        open[up] = !is_closed(faces, dense, 2 * axis + up);
        outside[up] = open[up] && is_at_end(&cells->box, at, 2 * axis + up);
        if (open[up] && !outside[up]) slope[up] = up != 0 ? phi[step] - phi[0] : phi[0] - phi[-step];
    }
    for (int up = 0; up < 2; ++up) {
        const ty_side* side = &cells->sides[2 * axis + up];
        const ptrdiff_t face = side->step * at[axis == 2 ? 1 : 2] + at[axis == 0 ? 1 : 0];
        if (outside[up] && side->kind == TY_BOUNDARY_MARSHAK) slope[up] = slope[1 - up];
        if (outside[up] && side->kind == TY_BOUNDARY_DIRICHLET)
            slope[up] = (up != 0 ? 2 : -2) * ((double)side->value[face] - phi[0]);
        if (!open[up] && open[1 - up] && !outside[1 - up]) slope[up] = 0.5 * slope[1 - up];
    }
    return slope[0] + slope[1];
}

static void diffuse_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const closed_job* closed = user;
    const ty_diffusion_job* job = closed->job;
    const ty_cells* cells = &job->cells;
    int32_t at[3] = {0, 0, (int32_t)z};
    for (; at[1] < cells->box.size[1]; ++at[1]) {
        const ptrdiff_t row = ty_box_at(&cells->box, at[1], at[2]), dense = ty_box_dense(&cells->box, at[1], at[2]);
        for (at[0] = 0; at[0] < cells->box.size[0]; ++at[0]) {
            const double* phi = (const double*)job->phi + row + at[0];
            const float sigma = ty_maxf(cells->extinction[dense + at[0]], cells->min_extinction);
            float gradient[3] = {0, 0, 0};
            for (int a = 0; a < 3 && closed->limiter != TY_LIMITER_NONE; ++a)
                gradient[a] = (float)difference(closed, at, dense + at[0], phi, a) * cells->half_inverse[a];
            float* d = job->diffusivity + row + at[0];
            *d = ty_filter_diffusivity_update(*d, ty_cell_diffusivity(closed->limiter, cells->larsen_power, sigma,
                                                                      (float)phi[0], gradient[0], gradient[1],
                                                                      gradient[2]));
        }
    }
}

/* ---- equations ---- */

/* The damped D of the linear problem. */
static void damp_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const closed_job* closed = user;
    const ty_diffusion_job* job = closed->job;
    const ty_cells* cells = &job->cells;
    for (int32_t y = 0; y < cells->box.size[1]; ++y) {
        const ptrdiff_t row = ty_box_at(&cells->box, y, (int32_t)z), dense = ty_box_dense(&cells->box, y, (int32_t)z);
        for (int32_t x = 0; x < cells->box.size[0]; ++x)
            job->direction[row + x] =
                ty_damped_diffusivity(job->diffusivity[row + x],
                                      ty_maxf(cells->extinction[dense + x], cells->min_extinction), closed->damping);
    }
}

/* Couplings of a cell, and f without the light that its sides send. */
static double assemble_cell(const closed_job* closed, const int32_t at[3], ptrdiff_t i, ptrdiff_t dense, float* sink) {
    const ty_diffusion_job* job = closed->job;
    const ty_cells* cells = &job->cells;
    const ptrdiff_t steps[3] = {1, cells->box.row, cells->box.plane};
    const double* phi = (const double*)job->phi + i;
    const float absorption = cells->absorption != NULL ? cells->absorption[dense] : 0;
    double f = (double)cells->source[dense] * (double)cells->scale - (double)absorption * phi[0];
    *sink = absorption;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, up = face & 1;
        const ptrdiff_t step = up != 0 ? steps[axis] : -steps[axis];
        const bool is_open = !is_closed(job->def->faces, dense, face);
        float* lower = job->levels[0].g[axis] + i;
        if (up == 0) *lower = 0;
        if (!is_open) continue;
        if (is_at_end(&cells->box, at, face)) {
            const ty_side* side = &cells->sides[face];
            const float w = ty_cell_boundary(side->a, side->b, job->diffusivity[i]);
            const ptrdiff_t value = side->step * at[axis == 2 ? 1 : 2] + at[axis == 0 ? 1 : 0];
            f += (double)w * ((double)side->value[value] - phi[0]);
            *sink += w;
            continue;
        }
        const float coupling = cells->coupling[axis] * (job->diffusivity[i] + job->diffusivity[i + step]);
        f += (double)coupling * (phi[step] - phi[0]);
        if (up == 0) *lower = cells->coupling[axis] * (job->direction[i] + job->direction[i + step]);
    }
    return f;
}

static void assemble_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const closed_job* closed = user;
    const ty_diffusion_job* job = closed->job;
    const ty_diffusion_faces* faces = job->def->faces;
    const ty_box* box = &job->cells.box;
    double squares = 0;
    int32_t at[3] = {0, 0, (int32_t)z};
    for (; at[1] < box->size[1]; ++at[1]) {
        const ptrdiff_t row = ty_box_at(box, at[1], at[2]), dense = ty_box_dense(box, at[1], at[2]);
        int32_t side = faces->first[dense / box->size[0]];
        const int32_t end = faces->first[dense / box->size[0] + 1];
        for (at[0] = 0; at[0] < box->size[0]; ++at[0]) {
            const ptrdiff_t i = row + at[0];
            float sink;
            double f = assemble_cell(closed, at, i, dense + at[0], &sink);
            for (; side < end && faces->x[side] == at[0]; ++side) {
                const double edge = job->def->cell[faces->face[side] / 2];
                const side_flux flux = flux_to_side(faces, side, (double)job->diffusivity[i], edge);
                f += (flux.source * (double)job->cells.scale - flux.sink * ((const double*)job->phi)[i]) / edge;
                sink += (float)(flux.sink / edge);
            }
            job->levels[0].d[i] = sink;
            job->levels[0].f[i] = (float)f;
            squares += f * f;
        }
    }
    job->sums[z].a = squares;
}

/* Sum of squares of the residuals f. */
static double linearise(closed_job* closed) {
    ty_diffusion_job* job = closed->job;
    const ty_box* box = &job->cells.box;
    ty_divided_exchange_fluence(job, box, job->phi, NULL);
    ty_solve_planes(job, box, diffuse_plane, closed);
    ty_solve_planes(job, box, damp_plane, closed);
    ty_divided_exchange(job, box, (float*[]){job->diffusivity, job->direction}, 2);
    ty_solve_planes(job, box, assemble_plane, closed);
    ty_divided_exchange(job, box, &job->levels[0].g[1], 2);
    ty_solve_count(job, box, 2);
    return ty_solve_sum(job, box).a;
}

/* ---- iteration ---- */

typedef struct update_job {
    const ty_diffusion_job* job;
    const float* change;
} update_job;

static void update_plane(void* user, int64_t z, int32_t worker) {
    (void)worker;
    const update_job* update = user;
    update->job->cell_kernels->update(&update->job->cells, update->change, update->job->phi, (int32_t)z);
}

static void iterate(closed_job* closed, double squares) {
    ty_diffusion_job* job = closed->job;
    const bool limited = closed->limiter != TY_LIMITER_NONE;
    ty_multigrid_coarsen(job, 0);
    update_job update = {
        job, ty_multigrid_solve(job, 0, squares, squares * REDUCTION * REDUCTION, limited ? CYCLES : LINEAR_CYCLES)};
    ty_solve_planes(job, &job->cells.box, update_plane, &update);
    ty_solve_count(job, &job->cells.box, 1);
}

ty_result ty_solve_closed(ty_diffusion_job* job) {
    const ty_diffusion_def* def = job->def;
    const int32_t limit = def->iterations > 0 ? def->iterations : ITERATIONS;
    const double cells = (double)ty_box_whole_cells(&job->cells.box);
    closed_job closed = {.job = job, .limiter = TY_LIMITER_NONE};
    if (def->start == NULL) iterate(&closed, linearise(&closed));
    closed.limiter = def->limiter;
    closed.damping = def->limiter != TY_LIMITER_NONE ? DAMPING : 0;
    double smallest = INFINITY;
    int32_t stagnation = 0;
    for (int32_t i = 0;; ++i) {
        const double squares = linearise(&closed), residual = sqrt(squares / cells);
        const ty_result result = ty_solve_note(job, residual);
        if ((job->stats->converged && i >= def->min_iterations) || result != TY_OK || i == limit) return result;
        stagnation = residual < GAIN * smallest ? 0 : stagnation + 1;
        smallest = fmin(smallest, residual);
        if (stagnation >= MAX_STAGNATION) closed.damping = 0;
        iterate(&closed, squares);
        job->stats->iterations = i + 1;
    }
}

/* ---- results ---- */

void ty_solve_store_closed(ty_diffusion_job* job) {
    const ty_diffusion_faces* faces = job->def->faces;
    const ty_box* box = &job->cells.box;
    const double* edge = job->def->cell;
    const double volume = edge[0] * edge[1] * edge[2], unscale = 1 / (double)job->cells.scale;
    double absorbed = 0, emitted = 0;
    for (int32_t z = 0; z < box->size[2]; ++z)
        for (int32_t y = 0; y < box->size[1]; ++y) {
            const ptrdiff_t row = ty_box_at(box, y, z), line = ty_box_dense(box, y, z) / box->size[0];
            for (int32_t side = faces->first[line]; side < faces->first[line + 1]; ++side) {
                const ptrdiff_t i = row + faces->x[side];
                const int axis = faces->face[side] / 2;
                const double s = (double)faces->staircase[side], d = (double)job->diffusivity[i];
                const double phi = ((const double*)job->phi)[i] * unscale;
                const side_flux flux = flux_to_side(faces, side, d, edge[axis]);
                const double net = flux.sink * phi - flux.source, albedo = (double)faces->albedo[side];
                const double irradiance = fmax(0, 0.25 * (phi - net * edge[axis] / (2 * d)) + 0.5 * s * net);
                const double area = volume / edge[axis] / s;
                if (job->out->side_flux != NULL) job->out->side_flux[side] = (float)net;
                if (job->out->side_irradiance != NULL) job->out->side_irradiance[side] = (float)irradiance;
                absorbed += area * (1 - albedo) * irradiance;
                if (faces->radiosity != NULL) emitted += area * (double)faces->radiosity[side];
            }
        }
    ty_divided_add(job, &absorbed);
    ty_divided_add(job, &emitted);
    job->stats->surfaces_absorbed = absorbed;
    job->stats->surfaces_emitted = emitted;
}
