/* Meshes and directions under an affine map, which need not be invertible. */
#ifndef TY_IO_MESH_FILE_H
#define TY_IO_MESH_FILE_H

#include "io/model.h"

/* A unit direction; the map must not take it to zero. */
void ty_place_direction(const ty_affine* map, const double in[3], double out[3]);
void ty_place_positions(const ty_model_mesh* mesh, const ty_affine* map, float* out);
/* Unit normals of the mapped surface, on the side that they were on; zero stays zero. */
void ty_place_normals(const ty_model_mesh* mesh, const ty_affine* map, float* out);
/* Indices raised by first. A mirrored mesh has the corners in the other order, so that fronts stay fronts. */
void ty_place_triangles(const ty_model_mesh* mesh, const ty_affine* map, uint32_t first, uint32_t* out);

#endif
