/* What a solve hands out. */
#ifndef TY_SOLVE_DIFFUSION_RESULT_H
#define TY_SOLVE_DIFFUSION_RESULT_H

#include "solve/diffusion/job.h"

/* Fluence, flux, D and the energy's whereabouts, from phi and D. */
void ty_solve_store(ty_diffusion_job* job);

#endif
