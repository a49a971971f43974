/* Lattices' light brought together for lookups. */
#ifndef TY_METHOD_LPV_LOOK_H
#define TY_METHOD_LPV_LOOK_H

#include "method/lpv/lattice.h"
#include "method/lpv/look.k.h"

/* Errors: TY_ERROR_MEMORY. Ended with ty_look_end, failed or not. */
ty_result ty_look_begin(ty_context* context, ty_lattice* const* lattices, int32_t count, ty_lattice_look* out);
void ty_look_end(ty_context* context, ty_lattice_look* look);

#endif
