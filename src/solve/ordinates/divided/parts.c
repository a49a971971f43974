/* A part of a box that is cut among ranks: sums over all ranks, and the flux beyond the cuts. */
#include "base/context.h"
#include "solve/ordinates/job.h"

#include <math.h>
#include <string.h>

/* Tags of messages, by the side from which they are sent. */
enum { TAG_OF_FLUX = 96 };

static size_t side_cells(const ty_ordinates_def* def, int side) {
    return (size_t)def->size[side < 2 ? 1 : 0] * (size_t)def->size[2];
}

ty_result ty_ordinates_parts_create(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    for (int side = 0; side < 4; ++side)
        if (!ty_ordinates_ends(def, side)) job->flux_floats += 2 * side_cells(def, side);
    if (job->flux_floats == 0) return TY_OK;
    float* at = job->flux_messages = ty_alloc_array(job->context, job->flux_floats, sizeof(float), true);
    if (at == NULL) return TY_ERROR_MEMORY;
    job->stats->bytes += (double)job->flux_floats * sizeof(float);
    for (int side = 0; side < 4; ++side) {
        if (ty_ordinates_ends(def, side)) continue;
        job->flux_beyond[side] = at;
        at += 2 * side_cells(def, side);
    }
    return TY_OK;
}

void ty_ordinates_parts_destroy(ty_ordinates_job* job) {
    ty_free_array(job->context, job->flux_messages, job->flux_floats, sizeof(float));
}

void ty_ordinates_sum_ranks(const ty_ordinates_job* job, double* values, int32_t count) {
    if (job->def->domain != NULL) ty_comm_sum(job->def->domain->comm, values, count);
}

ty_result ty_ordinates_check_ranks(const ty_ordinates_job* job) {
    const ty_domain* domain = job->def->domain;
    if (domain == NULL || ty_comm_lost(domain->comm) < 0) return TY_OK;
    return ty_fail(job->context, TY_ERROR_INTERNAL, "ordinates: rank %d does not answer",
                   (int)ty_comm_lost(domain->comm));
}

/* Copies the flux across a side of the cells there. */
static void copy_flux(const ty_ordinates_job* job, int side, float* to) {
    const ty_ordinates_def* def = job->def;
    const ptrdiff_t nx = def->size[0], ny = def->size[1], low_row = nx * job->low_order_terms;
    const float* flux = job->changes[job->latest] + (side < 2 ? 3 : 1) * nx;
    for (ptrdiff_t z = 0; z < def->size[2]; ++z) {
        const float* plane = flux + z * ny * low_row;
        for (ptrdiff_t y = 0; side < 2 && y < ny; ++y) *to++ = plane[y * low_row + (side == 1 ? nx - 1 : 0)];
        if (side < 2) continue;
        memcpy(to, plane + (side == 3 ? ny - 1 : 0) * low_row, sizeof(float) * (size_t)nx);
        to += nx;
    }
}

void ty_ordinates_exchange_flux(ty_ordinates_job* job) {
    const ty_ordinates_def* def = job->def;
    ty_comm_transfer transfers[8];
    int32_t count = 0;
    if (job->flux_floats == 0 || job->low_order_terms == 1) return;
    for (int side = 0; side < 4; ++side) {
        float* in = job->flux_beyond[side];
        if (in == NULL) continue;
        const size_t cells = side_cells(def, side);
        const ty_comm_transfer t = {.rank = ty_domain_neighbour(def->domain, side), .size = cells * sizeof(float)};
        copy_flux(job, side, in + cells);
        transfers[count] = transfers[count + 1] = t;
        transfers[count].receives = true;
        transfers[count].tag = TAG_OF_FLUX + (side ^ 1);
        transfers[count++].bytes = in;
        transfers[count].tag = TAG_OF_FLUX + side;
        transfers[count++].bytes = in + cells;
    }
    if (ty_comm_post(def->domain->comm, transfers, count)) ty_comm_finish(def->domain->comm, transfers, count);
}

/* ---- what is not divided ---- */

/* Cells that may be diffusive, without the conditions on transport mean free paths. */
static bool may_be_diffusive(const ty_ordinates_def* def) {
    const int64_t cells = (int64_t)def->size[0] * def->size[1] * def->size[2];
    const double longest = fmax(fmax(def->cell[0], def->cell[1]), def->cell[2]);
    for (int64_t i = 0; i < cells; ++i) {
        const double g = (double)def->g[i];
        const double forward = def->scattered != NULL ? 1 - (double)def->scattered[0] : pow(g, def->bands);
        if ((double)def->extinction[i] - forward * (double)def->scattering[i] > def->diffusive_paths / longest)
            return true;
    }
    return false;
}

const char* ty_ordinates_undivided(const ty_ordinates_def* whole) {
    if (whole->periodic != 0) return "scenes that repeat are not divided";
    if (whole->walls.count > 0 && whole->walls.ior != NULL) return "media in dielectrics are not divided";
    if (whole->accelerated && may_be_diffusive(whole))
        return "cells are so thick that light diffuses in them; a finer resolution makes them thinner";
    return NULL;
}
