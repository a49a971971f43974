/* Lattices packed for lookups, with all terms of a cell side by side. */
#ifndef TY_METHOD_LPV_LATTICE_PACKED_LATTICE_H
#define TY_METHOD_LPV_LATTICE_PACKED_LATTICE_H

#include "method/lpv/lattice/lattice.h"
#include "method/lpv/lattice/packed_lattice.k.h"

/* The propagated light, or for an eye (NULL: none) what each cell scatters towards it of the uncollided light of lights
 * with extent. Errors: TY_ERROR_MEMORY. Ended with
 * ty_packed_lattices_destroy, failed or not. */
ty_result ty_packed_lattices_create(ty_context* context, ty_lattice* const* lattices, int32_t count, const ty_vec* eye,
                                    ty_packed_lattices* out);
void ty_packed_lattices_destroy(ty_context* context, ty_packed_lattices* packed);

#endif
