/* Diffusion between surfaces, which close faces of cells. */
#ifndef TY_SOLVE_DIFFUSION_CLOSED_FACES_H
#define TY_SOLVE_DIFFUSION_CLOSED_FACES_H

#include "solve/diffusion/job.h"

/* The solver for a def with faces; sets phi and the statistics. */
ty_result ty_solve_closed(ty_diffusion_job* job);
/* Flux to the sides, their irradiance and their part in the balance of power. */
void ty_solve_store_closed(ty_diffusion_job* job);
/* Light that a side sends into its cell, per volume, W m^-3. */
double ty_diffusion_faces_source(const ty_diffusion_faces* faces, const double cell[3], int32_t side);

#endif
