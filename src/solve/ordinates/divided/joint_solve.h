/* Solves by discrete ordinates that rank 0 of a command divides among all its ranks (comm/joint.h). Rank 0 sends the
 * others the arrays of their parts, all solve, and rank 0 gathers the results. */
#ifndef TY_SOLVE_ORDINATES_DIVIDED_JOINT_SOLVE_H
#define TY_SOLVE_ORDINATES_DIVIDED_JOINT_SOLVE_H

#include "comm/joint.h"
#include "solve/ordinates/ordinates.h"

/* Cuts a box among ranks. False: it has too few cells for so many. */
bool ty_ordinates_cut(ty_comm* comm, const int32_t size[3], ty_domain* out);
/* NULL where the context's other ranks take part in a solve of the whole; or the reason why not, in words that follow
 * "because" (an empty text: there are no others). */
const char* ty_ordinates_why_undivided(const ty_context* context, const ty_ordinates_def* def);
/* On rank 0, as ty_ordinates_solve without a history: with all ranks where they take part. def->memory is for a solve
 * by this rank alone. */
ty_result ty_ordinates_solve_jointly(ty_context* context, const ty_ordinates_def* def, float* const* moments,
                                     ty_ordinates_stats* stats);
/* On the others: takes part in one, described by the bytes of rank 0. */
void ty_ordinates_join(ty_context* context, ty_comm* comm, const uint8_t* bytes, size_t size);

#endif
