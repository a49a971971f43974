/* Iterative propagation of injected light through a lattice. */
#ifndef TY_METHOD_LPV_PROPAGATE_H
#define TY_METHOD_LPV_PROPAGATE_H

#include "method/lpv/lattice/lattice.h"
#include "scene/lights/light.k.h"

/* The energy balance of a propagation, W per channel. `entered` is the injected light and the inflow from the outer
 * cascade. */
typedef struct ty_lattice_power {
    double entered[3], absorbed[3], blocked[3], escaped[3], left[3];
    int32_t iterations;
    double prepare_seconds, propagate_seconds, gather_seconds;
} ty_lattice_power;

/* Propagates all injected light until def's criterion holds, and writes `light`. own_cell_sh[c]: the injected power
 * that counts as light in its own cell (mode published: reflected light only; mode links: NULL, about half of all).
 * outer: the next coarser cascade, already propagated, whose light enters through the faces; NULL: none. Light injected
 * within this lattice is in both; the outer lattice's share counts here only as far as it left and came back. progress:
 * NULL, or a callback of the iterations. Where two bands overshoot to negative fluence the light is set to zero.
 * Errors: TY_ERROR_MEMORY; TY_CANCELLED. */
ty_result ty_lattice_propagate(ty_lattice* lattice, const ty_lpv_def* def, float* const own_cell_sh[3][TY_SH_TERMS],
                               const ty_lattice* outer, ty_progress_fn progress, void* progress_user,
                               ty_lattice_power* power);

/* Two bands in a thin medium cannot hold the r^-2 falloff near a point source: the fluence would be constant around it.
 * This finds per cell the extinction that restores the falloff near the point and spot lights, less where other lights
 * are as bright; mode links. Errors: TY_ERROR_MEMORY. */
ty_result ty_lattice_find_extinction_floor(ty_lattice* lattice, const ty_light_view* lights, int32_t count);

/* Multiply-adds of one cell in one iteration, all channels, without surfaces nearby. */
int32_t ty_lattice_step_operations(int32_t bands);

#endif
