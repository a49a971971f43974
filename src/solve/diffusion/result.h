/* Output of a diffusion solve. */
#ifndef TY_SOLVE_DIFFUSION_RESULT_H
#define TY_SOLVE_DIFFUSION_RESULT_H

#include "solve/diffusion/job.h"

/* Stores fluence, flux, D and the energy balance from phi and D. */
void ty_solve_store(ty_diffusion_job* job);
/* The results without any light. */
void ty_solve_store_dark(const ty_diffusion_job* job);

#endif
