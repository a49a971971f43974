/* What a solve hands out. */
#ifndef TY_SOLVE_RESULT_H
#define TY_SOLVE_RESULT_H

#include "solve/job.h"

/* Fluence, flux, D and the energy's whereabouts, from phi and D. */
void ty_solve_store(ty_diffusion_job* job);

#endif
