/* Linear diffusion on a box of cells for a sequence of sources: the low-order solve of diffusion synthetic
 * acceleration. */
#ifndef TY_SOLVE_ORDINATES_DSA_H
#define TY_SOLVE_ORDINATES_DSA_H

#include "solve/diffusion/box.h"
#include "solve/ordinates/ordinates.h"

typedef struct ty_dsa ty_dsa;

/* Uses size, cell, extinction, absorption, min_extinction and periodic of the def, with Marshak boundaries; its planes
 * are not needed afterwards. walls must outlive the result; with a nonzero count, a side reflects its incident partial
 * current times its albedo (Marshak) and transmits nothing. domain: as of ty_ordinates_def; NULL: none. Errors:
 * TY_ERROR_MEMORY. */
ty_result ty_dsa_create(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                        ty_domain* domain, ty_dsa** out);
void ty_dsa_destroy(ty_dsa* dsa);
size_t ty_dsa_bytes(const ty_dsa* dsa);
/* The bytes that a result would have, without making it. */
size_t ty_dsa_plan(ty_context* context, const ty_diffusion_def* def, const ty_ordinates_faces* walls,
                   ty_domain* domain);

/* Layout of the arrays; D, with ghosts -D of the cell beside them; the source, to be written before each solve, which
 * overwrites it. */
const ty_box* ty_dsa_box(const ty_dsa* dsa);
const float* ty_dsa_diffusivity(const ty_dsa* dsa);
float* ty_dsa_source(ty_dsa* dsa);

/* Outflow of a cell into a boundary face per area: slope times the cell's fluence plus offset. The offset is written
 * before each solve, and the source already contains it. NULL without boundary faces. */
const float* ty_dsa_face_slope(const ty_dsa* dsa);
float* ty_dsa_face_offset(ty_dsa* dsa);
/* Index of a side's cell in the DSA arrays, and the step across the side's face. */
ptrdiff_t ty_dsa_face_cell(const ty_dsa* dsa, int32_t side, int64_t row, ptrdiff_t* step);

/* Solves for the fluence of the source, whose sum of squares is `squares`, until the rms residual is reduced by about
 * `reduction`, or for at most `cycles` multigrid cycles. */
void ty_dsa_solve(ty_dsa* dsa, double squares, double reduction, int32_t cycles);
/* Fluence of the last solve, with ghosts that make differences across the box's faces exact; and its means over each
 * cell and its neighbours along each axis, with weights 1/4, 1/2, 1/4 (generalised where D changes: face values
 * interpolated by D). */
const float* ty_dsa_fluence(const ty_dsa* dsa);
const float* ty_dsa_smoothed_fluence(const ty_dsa* dsa);
/* Power of the last solution through the box's faces, W; of a part, through those of the whole. */
double ty_dsa_leakage(const ty_dsa* dsa);
/* Multigrid cycles so far. */
int32_t ty_dsa_cycles(const ty_dsa* dsa);

#endif
