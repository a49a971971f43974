/* State of the gradient of a loss on the fluence of one solution by discrete ordinates. */
#ifndef TY_METHOD_DOM_GRADIENT_GRADIENT_H
#define TY_METHOD_DOM_GRADIENT_GRADIENT_H

#include "method/dom/job.h"
#include "method/gradient/gradient.h"

/* Moments of the phase function by the mean cosine: sigma* = sigma_t - forward sigma_s, s_l = scattered[l] sigma_s. */
typedef struct ty_dom_phase_slope {
    double scattered[TY_DOM_BANDS_MAX], forward;
    double scattered_by_g[TY_DOM_BANDS_MAX], forward_by_g;
} ty_dom_phase_slope;

/* The adjoint of a channel: dL/dq_lm and the derivatives by coefficients of the light whose moments it was made from.
 * Channels whose light and weights are multiples of another one's take theirs, times factors. */
typedef struct ty_dom_channel_adjoint {
    int32_t of;                         /* the channel that has the arrays; itself, or a lower one */
    float factor;                       /* of its weights over those of that channel */
    float* source;                      /* bands^2 planes of coarse cells */
    float* extinction;                  /* by sigma* */
    float* scattered[TY_DOM_BANDS_MAX]; /* by s_l */
} ty_dom_channel_adjoint;

typedef struct ty_dom_gradient_job {
    ty_dom_job dom; /* media, lights and sources as in the solve */
    const ty_dom* light;
    ty_gradient* gradient;
    ty_gradient_stats* stats;
    float *weight[3], *source_weight[3]; /* dL/dfluence of fine and coarse cells, per channel */
    ty_dom_channel_adjoint channels[3];
    ty_dom_phase_slope fit; /* of a fitted phase function */
    float g[3];             /* mean cosine of cells where nothing scatters, per plane: that of the first that does */
    bool uniform[3];        /* all that scatters on a plane has that g */
    ty_medium_gradient coarse;
} ty_dom_gradient_job;

/* Sets job->fit where the phase function is fitted. */
void ty_dom_gradient_find_fit(ty_dom_gradient_job* job);
/* The moments of a cell on a plane of the medium, and its mean cosine g. */
void ty_dom_phase_slope_at(const ty_dom_gradient_job* job, double g, ty_dom_phase_slope* out);
/* The mean cosine of a cell. */
static inline double ty_dom_gradient_g(const ty_dom_gradient_job* job, const ty_grid_medium* medium, int32_t plane,
                                       size_t cell) {
    return (double)(medium->scattering[plane][cell] > 0 ? medium->g[plane][cell] : job->g[plane]);
}

/* Adds the derivative by sigma* of a cell to those by its media. */
static inline void ty_dom_gradient_add_extinction(ty_medium_gradient* media, int32_t plane, size_t cell,
                                                  const ty_dom_phase_slope* slope, double g, double by_extinction) {
    media->extinction[plane][cell] += (float)by_extinction;
    media->scattering[plane][cell] += (float)((g * slope->forward_by_g - slope->forward) * by_extinction);
    media->scattering_g[plane][cell] -= (float)(slope->forward_by_g * by_extinction);
}

/* The adjoint of ordinates: job->channels, and the derivatives by the media of coarse cells. Errors: those of
 * ty_ordinates_adjoint. */
ty_result ty_dom_gradient_solve(ty_dom_gradient_job* job);
void ty_dom_gradient_free_channels(ty_dom_gradient_job* job);
/* The adjoint of first-collision sources and of uncollided light. Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_dom_gradient_return_sources(ty_dom_gradient_job* job);

#endif
