/* A solve for the fluence that all ranks make together: rank 0 has the whole grid, and hands every rank its box. */
#ifndef TY_SOLVE_DIFFUSION_DIVIDED_JOINT_H
#define TY_SOLVE_DIFFUSION_DIVIDED_JOINT_H

#include "comm/joint.h"
#include "solve/diffusion/diffusion.h"

/* Smaller grids are solved by rank 0: messages would take longer than their cells. */
enum { TY_DIFFUSION_JOINT_CELLS = 24 * 24 * 24 };

/* True if ranks of the context's command would solve a def together. Otherwise *why, if it is not NULL, tells why not;
 * NULL where there are no other ranks. */
bool ty_diffusion_is_joint(const ty_context* context, const ty_diffusion_def* def, const char** why);
/* ty_diffusion_solve on rank 0, by all ranks if ty_diffusion_is_joint and none of them is lost. def->memory is then not
 * used. */
ty_result ty_diffusion_solve_jointly(ty_context* context, const ty_diffusion_def* def, const ty_diffusion_out* out,
                                     ty_diffusion_stats* stats);
/* The part of another rank in TY_JOINT_DIFFUSION. */
void ty_diffusion_take_part(ty_comm* comm, ty_context* context, const uint8_t* bytes, size_t size);

#endif
