/* A grid divided among ranks (comm/domain.h): each has a box of the finest levels, with a layer of its neighbours'
 * cells, and all have the coarser ones whole. Rows along x are not cut, so that loops over them are those of one rank;
 * what a cell gets does not depend on the cuts. Without a domain calls do nothing, but that exchanges fill in the
 * images of a grid that repeats (solve/diffusion/images.h). */
#ifndef TY_SOLVE_DIFFUSION_DIVIDED_DIVIDED_H
#define TY_SOLVE_DIFFUSION_DIVIDED_DIVIDED_H

#include "solve/diffusion/job.h"

/* Boxes of level 0, and number of levels that are divided, of a job whose def is set. */
void ty_divided_begin(ty_diffusion_job* job);
/* Box of a grid of `whole` cells, coarser than the finest by `ratio`. divided: this rank's part. */
ty_box ty_divided_box(const ty_diffusion_job* job, const int32_t whole[3], const int32_t ratio[3], bool divided);
/* Memory of sums; and of gathered cells, once the levels are known. */
void ty_divided_lay_out_sums(ty_diffusion_job* job, ty_arena* arena);
void ty_divided_lay_out(ty_diffusion_job* job, ty_arena* arena);

/* The level or stage below level i as the kernels of level i see it: this rank's part of it. */
const ty_level* ty_divided_coarse_level(const ty_diffusion_job* job, int32_t i);
const ty_fas_level* ty_divided_coarse_stage(const ty_diffusion_job* job, int32_t i);
/* True if every rank has level i + 1 whole, and only a part of level i. */
bool ty_divided_gathers(const ty_diffusion_job* job, int32_t i);

/* Fills the layers beyond the cuts of a box, of arrays that point to cell (0, 0, 0); of a grid that repeats, with the
 * cells at its opposite faces. */
void ty_divided_exchange(const ty_diffusion_job* job, const ty_box* box, float* const* arrays, int32_t count);
/* The same of the fluence, of the solver's type, and of D, unless it is NULL. */
void ty_divided_exchange_fluence(const ty_diffusion_job* job, const ty_box* box, void* phi, float* diffusivity);
/* Brings the parts of the first whole level together, with or without ghosts: at most TY_GATHERED_MAX arrays. */
enum { TY_GATHERED_MAX = 4 };
void ty_divided_gather(const ty_diffusion_job* job, float* const* arrays, int32_t count, bool with_ghosts);
void ty_divided_gather_side(const ty_diffusion_job* job, int side);

/* Sum over the planes of a box, of all ranks; the same on each of them. */
ty_plane_sums ty_divided_sum(const ty_diffusion_job* job, const ty_box* box);
/* Adds up a number over all ranks. */
void ty_divided_add(const ty_diffusion_job* job, double* value);
/* True if any rank says so. */
bool ty_divided_any(const ty_diffusion_job* job, bool own);

#endif
