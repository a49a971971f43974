/* Linear diffusion on a box of cells, for one source after another: what discrete ordinates are corrected with. */
#ifndef TY_SOLVE_CORRECTION_H
#define TY_SOLVE_CORRECTION_H

#include "solve/box.h"
#include "solve/ordinates.h"

typedef struct ty_correction ty_correction;

/* Of the def, size, cells, extinction, absorption and least_extinction count (light leaves through Marshak boundaries);
 * its planes are not needed any more after this. walls outlive it; where count is not 0, what arrives on a side is sent
 * back times its albedo (Marshak's partial currents), and nothing passes. Errors: TY_ERROR_MEMORY. */
ty_result ty_correction_create(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_walls* walls,
                               ty_correction** out);
void ty_correction_destroy(ty_correction* correction);
size_t ty_correction_bytes(const ty_correction* correction);

/* How the arrays lie; D, whose ghosts are -D of the cell beside them; the source, to be written before each solve,
 * which changes it. */
const ty_box* ty_correction_box(const ty_correction* correction);
const float* ty_correction_diffusivity(const ty_correction* correction);
float* ty_correction_source(ty_correction* correction);

/* What flows out of a cell into a side of a wall, per area: slope times the cell's fluence, and rest, to be written
 * before each solve, of which the source has its part already. NULL where there are no walls. */
const float* ty_correction_slope(const ty_correction* correction);
float* ty_correction_rest(ty_correction* correction);
/* A side's cell in the correction's arrays, and the step across the side's face. */
ptrdiff_t ty_correction_side(const ty_correction* correction, int32_t side, int64_t row, ptrdiff_t* step);

/* Solves for the fluence of the source, whose sum of squares is `squares`, until about the share `reduction` of the
 * residual's rms is left or for so many cycles of multigrid. */
void ty_correction_solve(ty_correction* correction, double squares, double reduction, int32_t cycles);
/* What the last solve found, with ghosts such that differences hold at the box's faces; and its means over cells and
 * their neighbours along each axis, with weights 1/4, 1/2, 1/4: where D changes, of what D's means make of the face. */
const float* ty_correction_fluence(const ty_correction* correction);
const float* ty_correction_smooth(const ty_correction* correction);
/* Of it, what leaves through the box's faces, W. */
double ty_correction_leaving(const ty_correction* correction);
/* Cycles so far. */
int32_t ty_correction_cycles(const ty_correction* correction);

#endif
