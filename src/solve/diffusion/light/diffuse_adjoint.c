#include "solve/diffusion/light/diffuse_adjoint.h"

#include "base/constants.h"
#include "base/context.h"
#include "base/kernel.h"
#include "solve/diffusion/light/thickness.h"

#include <math.h>
#include <string.h>

/* Arrays of one number per cell for the solve of one channel. */
typedef struct channel_arrays {
    float *extinction, *absorption, *fluence, *by_extinction, *by_absorption;
} channel_arrays;

static ty_result allocate(const ty_grid_medium* medium, channel_arrays* out) {
    float** const arrays[] = {&out->extinction, &out->absorption, &out->fluence, &out->by_extinction,
                              &out->by_absorption};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) {
        *arrays[i] = ty_alloc_array(medium->context, medium->cells, sizeof(float), false);
        if (*arrays[i] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

static void free_arrays(const ty_grid_medium* medium, const channel_arrays* arrays) {
    float* const all[] = {arrays->extinction, arrays->absorption, arrays->fluence, arrays->by_extinction,
                          arrays->by_absorption};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        ty_free_array(medium->context, all[i], medium->cells, sizeof(float));
}

/* sigma_t - g sigma_s before its thickness is limited. */
static float unlimited_extinction(const ty_diffuse_loss* loss, int32_t plane, size_t cell) {
    const ty_grid_medium* medium = loss->medium;
    const float forward = loss->reduced ? medium->scattering[plane][cell] * medium->g[plane][cell] : 0.0f;
    return ty_maxf(0, medium->extinction[plane][cell] - forward);
}

static void set_coefficients(const ty_diffuse_loss* loss, int32_t channel, int32_t plane, const channel_arrays* out) {
    const ty_grid_medium* medium = loss->medium;
    const ty_max_extinction max = ty_max_extinction_of(medium, NULL);
    for (size_t i = 0; i < medium->cells; ++i) {
        const float max_extinction = ty_max_extinction_at(&max, i), extinction = unlimited_extinction(loss, plane, i);
        const float scale = extinction > max_extinction ? max_extinction / extinction : 1.0f;
        out->extinction[i] = extinction * scale;
        out->absorption[i] = ty_maxf(0, medium->extinction[plane][i] - medium->scattering[plane][i]) * scale;
        out->fluence[i] = (float)(4 * TY_PI_F64 * (double)loss->light->terms[channel][0][i]);
    }
}

/* The derivatives by the medium, from those by the solver's coefficients, times factor. Where the thickness is limited
 * to e, extinction is constant and absorption is sigma_a e / extinction. */
static void add_media(const ty_diffuse_loss* loss, int32_t plane, float factor, const channel_arrays* from,
                      ty_medium_gradient* media) {
    const ty_grid_medium* medium = loss->medium;
    const ty_max_extinction max = ty_max_extinction_of(medium, NULL);
    for (size_t i = 0; i < medium->cells; ++i) {
        const float max_extinction = ty_max_extinction_at(&max, i), extinction = unlimited_extinction(loss, plane, i);
        float by_extinction = from->by_extinction[i], by_absorption = from->by_absorption[i];
        if (extinction > max_extinction) {
            by_extinction = -by_absorption * from->absorption[i] / extinction;
            by_absorption *= max_extinction / extinction;
        }
        media->extinction[plane][i] += factor * (by_extinction + by_absorption);
        media->scattering[plane][i] -= factor * by_absorption;
        if (loss->reduced) media->scattering_g[plane][i] -= factor * by_extinction;
    }
}

/* True if a channel's light and weights are multiples of another's; factor: of the weights. */
static bool is_multiple(const ty_diffuse_loss* loss, int32_t channel, int32_t of, float* factor) {
    return loss->light->shared && loss->medium->planes == 1 &&
           ty_is_multiple(loss->weight[channel], loss->weight[of], loss->medium->cells, factor);
}

static void note_solve(const ty_diffusion_adjoint_stats* solved, ty_diffusion_adjoint_stats* stats) {
    stats->converged = stats->converged && solved->converged;
    stats->iterations += solved->iterations;
    stats->cycles += solved->cycles;
    stats->residual = fmax(stats->residual, solved->residual);
    stats->imbalance = fmax(stats->imbalance, solved->imbalance);
}

static ty_result solve_channel(const ty_diffuse_loss* loss, int32_t channel, const channel_arrays* arrays,
                               float* by_source, double* by_streaming, ty_diffusion_adjoint_stats* stats) {
    const ty_grid_medium* medium = loss->medium;
    ty_diffusion_def def = *loss->solver;
    ty_diffusion_adjoint_stats solved;
    memcpy(def.size, medium->box.size, sizeof def.size);
    memcpy(def.cell, medium->cell, sizeof def.cell);
    set_coefficients(loss, channel, medium->planes == 3 ? channel : 0, arrays);
    def.extinction = arrays->extinction;
    def.absorption = arrays->absorption;
    def.source = loss->source[channel];
    def.progress = ty_part_report;
    def.progress_user = loss->progress;
    const ty_diffusion_adjoint_out out = {.source = by_source,
                                          .extinction = arrays->by_extinction,
                                          .absorption = arrays->by_absorption,
                                          .streaming = by_streaming};
    const ty_result result = ty_diffusion_adjoint(medium->context, &def, arrays->fluence, loss->weight[channel],
                                                  loss->tolerance, &out, &solved);
    if (result == TY_OK) note_solve(&solved, stats);
    return result;
}

ty_result ty_diffuse_adjoint(const ty_diffuse_loss* loss, ty_medium_gradient* media, float* const by_source[3],
                             ty_diffusion_adjoint_stats* stats) {
    const ty_grid_medium* medium = loss->medium;
    channel_arrays arrays = {.absorption = NULL};
    ty_result result = allocate(medium, &arrays);
    *stats = (ty_diffusion_adjoint_stats){.converged = true};
    int32_t solved = -1; /* the channel whose derivatives by coefficients the arrays hold */
    double by_streaming = 0;
    *loss->by_streaming = 0;
    for (int32_t c = 0; c < 3 && result == TY_OK; ++c) {
        float factor = 1;
        if (solved >= 0 && is_multiple(loss, c, solved, &factor)) {
            for (size_t i = 0; i < medium->cells; ++i) by_source[c][i] = factor * by_source[solved][i];
            const float fluence = loss->light->color[c] / loss->light->color[solved];
            add_media(loss, 0, factor * fluence, &arrays, media);
            *loss->by_streaming += (double)(factor * fluence) * by_streaming;
            continue;
        }
        result = solve_channel(loss, c, &arrays, by_source[c], &by_streaming, stats);
        if (result != TY_OK) break;
        *loss->by_streaming += by_streaming;
        add_media(loss, medium->planes == 3 ? c : 0, 1, &arrays, media);
        solved = c;
    }
    free_arrays(medium, &arrays);
    return result;
}
