/* Irradiance by the propagated light at single surface points. */
#ifndef TY_METHOD_LPV_IRRADIANCE_H
#define TY_METHOD_LPV_IRRADIANCE_H

#include "base/vector.k.h"
#include "method/lpv/lattice/lattice.h"

/* The cascades of a solve, from the finest to the coarsest. */
typedef struct ty_lpv_light_view {
    ty_lattice* const* lattices;
    int32_t count;
} ty_lpv_light_view;

/* Irradiance, W m^-2, on the side of the surface that the unit normal points to. */
void ty_lpv_irradiance_at(const ty_lpv_light_view* light, ty_vec point, ty_vec normal, float irradiance[3]);

#endif
