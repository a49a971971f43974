/* First-collision sources that are not centered in their cells. In diffusion a source Q at a displacement d has the
 * fluence of a source at the center with a first moment of sigma_tr Q d besides: with Q - div(d Q) in place of Q,
 *
 *     div J + sigma_a phi = Q - div(d Q),   grad phi / 3 + sigma_tr J = 0,
 *
 * and J' = J + d Q fulfils div J' + sigma_a phi = Q and grad phi / 3 + sigma_tr J' = sigma_tr d Q. Cells that are swept
 * get this moment; d Q is subtracted from their flux at the end. Diffusive cells know the positions of their sources.
 */
#include "base/context.h"
#include "solve/ordinates/job.h"

#include <math.h>

/* Harmonics of the first moments along x, y and z. */
static const size_t term_of[3] = {3, 1, 2};

/* sqrt(3) d q_00 of a cell along the three axes, bounded so that the displaced source is nowhere negative. Of the known
 * part the fraction that counts as unscattered is no source. */
static void find_displaced(const ty_ordinates_job* job, size_t cell, float reduced, float out[3]) {
    const ty_ordinates_def* def = job->def;
    const float unscattered = def->extinction[cell] - job->extinction[cell], scattering = def->scattering[cell];
    const double root = sqrt(3), part = scattering > 0 ? 1 - (double)(unscattered / scattering) : 0;
    const double known = part * (double)def->source_center[0][cell];
    double square = 0, moment[3];
    for (size_t a = 0; a < 3; ++a) {
        moment[a] = root * part * (double)def->source_center[1 + a][cell] * def->cell[a] / 2;
        square += moment[a] * moment[a];
    }
    const double excess = root * (double)reduced * sqrt(square);
    const double factor = excess > known ? known / excess : 1;
    for (size_t a = 0; a < 3; ++a) out[a] = (float)(factor * moment[a]);
}

ty_result ty_ordinates_displace(ty_ordinates_job* job, const float* reduced) {
    const int32_t* slots = job->diffusive.slots;
    if (!job->def->displaces_sources || job->def->source_center == NULL || job->source_lm == NULL || reduced == NULL)
        return TY_OK;
    job->displaced = ty_alloc_array(job->context, (size_t)job->cells, 3 * sizeof(float), true);
    if (job->displaced == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < (size_t)job->cells; ++i) {
        if (job->diffusive.count > 0 && slots[i] >= 0) continue;
        if (!(job->def->source_center[0][i] > 0)) continue;
        find_displaced(job, i, reduced[i], job->displaced + 3 * i);
        for (size_t a = 0; a < 3; ++a)
            job->source_lm[(size_t)job->terms * i + term_of[a]] += reduced[i] * job->displaced[3 * i + a];
    }
    return TY_OK;
}

void ty_ordinates_undo_displaced_flux(const ty_ordinates_job* job, float* const* moments) {
    if (job->displaced == NULL || job->def->output_order < 2) return;
    for (size_t i = 0; i < (size_t)job->cells; ++i)
        for (size_t a = 0; a < 3; ++a) moments[term_of[a]][i] -= job->displaced[3 * i + a];
}
