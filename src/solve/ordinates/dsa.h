/* Linear diffusion on a box of cells, for one source after another: what discrete ordinates are corrected with. */
#ifndef TY_SOLVE_ORDINATES_DSA_H
#define TY_SOLVE_ORDINATES_DSA_H

#include "solve/diffusion/box.h"
#include "solve/ordinates/ordinates.h"

typedef struct ty_dsa ty_dsa;

/* Of the def, size, cells, extinction, absorption and least_extinction count (light leaves through Marshak boundaries);
 * its planes are not needed any more after this. walls outlive it; where count is not 0, what arrives on a side is sent
 * back times its albedo (Marshak's partial currents), and nothing passes. Errors: TY_ERROR_MEMORY. */
ty_result ty_dsa_create(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                        ty_dsa** out);
void ty_dsa_destroy(ty_dsa* correction);
size_t ty_dsa_bytes(const ty_dsa* correction);

/* How the arrays lie; D, whose ghosts are -D of the cell beside them; the source, to be written before each solve,
 * which changes it. */
const ty_box* ty_dsa_box(const ty_dsa* correction);
const float* ty_dsa_diffusivity(const ty_dsa* correction);
float* ty_dsa_source(ty_dsa* correction);

/* What flows out of a cell into a side of a wall, per area: slope times the cell's fluence, and rest, to be written
 * before each solve, of which the source has its part already. NULL where there are no walls. */
const float* ty_dsa_face_slope(const ty_dsa* correction);
float* ty_dsa_face_offset(ty_dsa* correction);
/* A side's cell in the correction's arrays, and the step across the side's face. */
ptrdiff_t ty_dsa_face_cell(const ty_dsa* correction, int32_t side, int64_t row, ptrdiff_t* step);

/* Solves for the fluence of the source, whose sum of squares is `squares`, until about the share `reduction` of the
 * residual's rms is left or for so many cycles of multigrid. */
void ty_dsa_solve(ty_dsa* correction, double squares, double reduction, int32_t cycles);
/* What the last solve found, with ghosts such that differences hold at the box's faces; and its means over cells and
 * their neighbours along each axis, with weights 1/4, 1/2, 1/4: where D changes, of what D's means make of the face. */
const float* ty_dsa_fluence(const ty_dsa* correction);
const float* ty_dsa_smoothed_fluence(const ty_dsa* correction);
/* Of it, what leaves through the box's faces, W. */
double ty_dsa_leakage(const ty_dsa* correction);
/* Cycles so far. */
int32_t ty_dsa_cycles(const ty_dsa* correction);

#endif
