#include "solve/diffusion/result.h"

#include "solve/diffusion/cells.k.h"

static double phi_at(const ty_diffusion_job* job, ptrdiff_t at) {
    return job->def->solver == TY_DIFFUSION_SOR_FLOAT ? (double)((const float*)job->phi)[at]
                                                      : ((const double*)job->phi)[at];
}

/* Net flux out of the box through the boundary face of a cell, W m^-2 in the solvers' units. */
static double flux_out(const ty_diffusion_job* job, int side, const int32_t cell[3], ptrdiff_t at) {
    const ty_side* s = &job->cells.sides[side];
    const int axis = side / 2;
    const ptrdiff_t face = s->step * cell[axis == 2 ? 1 : 2] + cell[axis == 0 ? 1 : 0];
    const double w = (double)ty_cell_boundary(s->a, s->b, job->diffusivity[at]);
    return w * job->def->cell[axis] * (phi_at(job, at) - (double)s->value[face]);
}

/* Net flux through the lower face of a cell along an axis; for the index after the last cell, through the last face. */
static double flux_below(const ty_diffusion_job* job, int axis, const int32_t cell[3], ptrdiff_t at) {
    const ty_box* box = &job->cells.box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    const ptrdiff_t below = at - steps[axis];
    if (cell[axis] == 0) return -flux_out(job, 2 * axis, cell, at);
    if (cell[axis] == box->size[axis]) return flux_out(job, 2 * axis + 1, cell, below);
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
        if ((axis == 1 && y != edge) || (axis == 2 && z != edge)) continue;
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
    const ty_plane_sums sums = ty_solve_sum(job, box->size[2]);
    const double volume = job->def->cell[0] * job->def->cell[1] * job->def->cell[2];
    job->stats->emitted = sums.a * volume;
    job->stats->absorbed = sums.b * volume;
    job->stats->leaving = sums.c;
}
