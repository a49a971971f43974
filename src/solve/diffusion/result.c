#include "solve/diffusion/result.h"

#include "solve/diffusion/cells.k.h"
#include "solve/diffusion/closed_faces.h"

#include <string.h>

static double phi_at(const ty_diffusion_job* job, ptrdiff_t at) {
    return job->def->solver == TY_DIFFUSION_SOR_FLOAT ? (double)((const float*)job->phi)[at]
                                                      : ((const double*)job->phi)[at];
}

/* True if a surface closes a face of the cell at x, y, z. */
static bool is_closed(const ty_diffusion_job* job, const int32_t cell[3], int face) {
    const ty_diffusion_faces* faces = job->def->faces;
    return faces != NULL && (faces->closed[ty_box_dense(&job->cells.box, cell[1], cell[2]) + cell[0]] >> face & 1) != 0;
}

/* Net flux out of the box through the boundary face of a cell, W m^-2 in the solvers' units. */
static double flux_out(const ty_diffusion_job* job, int side, const int32_t cell[3], ptrdiff_t at) {
    const ty_side* s = &job->cells.sides[side];
    const int axis = side / 2;
    if (is_closed(job, cell, side)) return 0;
    const ptrdiff_t face = s->step * cell[axis == 2 ? 1 : 2] + cell[axis == 0 ? 1 : 0];
    const double w = (double)ty_cell_boundary(s->a, s->b, job->diffusivity[at]);
    return w * job->def->cell[axis] * (phi_at(job, at) - (double)s->value[face]);
}

/* Net flux through the lower face of a cell along an axis; for the index after the last cell, through the last face. */
static double flux_below(const ty_diffusion_job* job, int axis, const int32_t cell[3], ptrdiff_t at) {
    const ty_box* box = &job->cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    const ptrdiff_t below = at - steps[axis];
    int32_t cell_below[3] = {cell[0], cell[1], cell[2]};
    --cell_below[axis];
    if (cell[axis] == 0 && ty_box_ends(box, 2 * axis)) return -flux_out(job, 2 * axis, cell, at);
    if (cell[axis] == box->size[axis] && ty_box_ends(box, 2 * axis + 1))
        return flux_out(job, 2 * axis + 1, cell_below, below);
    if (cell[axis] == box->size[axis] ? is_closed(job, cell_below, 2 * axis + 1) : is_closed(job, cell, 2 * axis))
        return 0;
    const double mean = 0.5 * ((double)job->diffusivity[at] + (double)job->diffusivity[below]);
    return mean / job->def->cell[axis] * (phi_at(job, below) - phi_at(job, at));
}

static void store_cells(const ty_diffusion_job* job, int32_t y, int32_t z, ty_plane_sums* sums) {
    const ty_diffusion_def* def = job->def;
    const ty_box* box = &job->cells.box;
    const ptrdiff_t at = ty_box_at(box, y, z), dense = ty_box_dense(box, y, z);
    const double unscale = 1 / (double)job->cells.scale;
    for (int32_t x = 0; x < box->size[0]; ++x) {
        const double phi = phi_at(job, at + x) * unscale;
        job->out->fluence[dense + x] = (float)phi;
        if (job->out->diffusivity != NULL) job->out->diffusivity[dense + x] = job->diffusivity[at + x];
        sums->a += (double)def->source[dense + x];
        if (def->absorption != NULL) sums->b += (double)def->absorption[dense + x] * phi;
    }
}

/* Lower faces of the cells of a row along an axis; the row after the last holds the last faces. */
static void store_flux(const ty_diffusion_job* job, int axis, int32_t y, int32_t z) {
    const ty_box* box = &job->cells.box;
    const int32_t nx = box->size[0] + (axis == 0 ? 1 : 0), ny = box->size[1] + (axis == 1 ? 1 : 0);
    float* out = job->out->flux[axis] + ((ptrdiff_t)z * ny + y) * nx;
    const double unscale = 1 / (double)job->cells.scale;
    for (int32_t x = 0; x < nx; ++x) {
        const int32_t cell[3] = {x, y, z};
        out[x] = (float)(flux_below(job, axis, cell, ty_box_at(box, y, z) + x) * unscale);
    }
}

/* Power leaving through the sides of the box that a row touches, W. */
static double leakage(const ty_diffusion_job* job, int32_t y, int32_t z) {
    const ty_box* box = &job->cells.box;
    const double* cell = job->def->cell;
    double sum = 0;
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const int32_t last = box->size[axis] - 1, edge = (side & 1) != 0 ? last : 0;
        if ((axis == 1 && y != edge) || (axis == 2 && z != edge) || !ty_box_ends(box, side)) continue;
        const double area = cell[0] * cell[1] * cell[2] / cell[axis] / (double)job->cells.scale;
        for (int32_t x = axis == 0 ? edge : 0; x <= (axis == 0 ? edge : box->size[0] - 1); ++x) {
            const int32_t at[3] = {x, y, z};
            sum += flux_out(job, side, at, ty_box_at(box, y, z) + x) * area;
        }
    }
    return sum;
}

static void store_plane(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const ty_diffusion_job* job = user;
    const int32_t z = (int32_t)index, ny = job->cells.box.size[1], nz = job->cells.box.size[2];
    ty_plane_sums sums = {0};
    for (int32_t y = 0; y < ny; ++y) {
        store_cells(job, y, z, &sums);
        sums.c += leakage(job, y, z);
    }
    job->sums[z] = sums;
    for (int axis = 0; axis < 3; ++axis) {
        if (job->out->flux[axis] == NULL) continue;
        for (int32_t y = 0; y < ny + (axis == 1 ? 1 : 0); ++y) store_flux(job, axis, y, z);
        if (axis != 2 || z != nz - 1) continue;
        for (int32_t y = 0; y < ny; ++y) store_flux(job, axis, y, nz);
    }
}

void ty_solve_store(ty_diffusion_job* job) {
    const ty_box* box = &job->cells.box;
    ty_solve_planes(job, box, store_plane, job);
    const ty_plane_sums sums = ty_solve_sum(job, box);
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2];
    job->stats->emitted = sums.a * volume;
    job->stats->absorbed = sums.b * volume;
    job->stats->leaving = sums.c;
    if (job->def->faces != NULL) ty_solve_store_closed(job);
}

void ty_solve_store_dark(const ty_diffusion_job* job) {
    const ty_diffusion_out* out = job->out;
    const ty_diffusion_faces* faces = job->def->faces;
    memset(out->fluence, 0, sizeof(float) * (size_t)ty_box_cells(&job->cells.box));
    if (faces == NULL) return;
    const size_t bytes = sizeof(float) * (size_t)faces->count;
    if (out->side_flux != NULL) memset(out->side_flux, 0, bytes);
    if (out->side_irradiance != NULL) memset(out->side_irradiance, 0, bytes);
}
