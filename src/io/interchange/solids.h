/* Shapes of other formats as triangles, in their own space: fronts outwards, normals and texture coordinates at every
 * vertex. */
#ifndef TY_IO_INTERCHANGE_SOLIDS_H
#define TY_IO_INTERCHANGE_SOLIDS_H

#include "io/meshes/model.h"

/* A surface of revolution about z: a radius and a height at each of `rows` places, from v = 0 to 1, with the outer side
 * to the right of the direction along them; it turns from +x by phi_max, radians. */
typedef struct ty_revolution {
    const double (*profile)[4]; /* radius, z, and their normal */
    int rows;
    double phi_max;
} ty_revolution;

/* Each makes a mesh whose arrays ty_model_free_mesh frees. */
ty_result ty_make_revolution(ty_context* context, const ty_revolution* shape, int columns, ty_model_mesh* out);
/* A sphere about 0, between two heights. */
ty_result ty_make_sphere(ty_context* context, double radius, double z_min, double z_max, double phi_max,
                         ty_model_mesh* out);
/* A disk at a height, with a hole; its front looks along +z. */
ty_result ty_make_disk(ty_context* context, double radius, double inner, double height, double phi_max,
                       ty_model_mesh* out);
/* The side of a cylinder between two heights. */
ty_result ty_make_cylinder(ty_context* context, double radius, double z_min, double z_max, double phi_max,
                           ty_model_mesh* out);
/* A square from (-1, -1, 0) to (1, 1, 0) with its front along +z, and a cube of such faces from -1 to 1. */
ty_result ty_make_square(ty_context* context, ty_model_mesh* out);
ty_result ty_make_cube(ty_context* context, ty_model_mesh* out);

/* Maps a mesh: normals by the inverse transpose. Its front stays on the side of its normals: triangles turn round where
 * the map mirrors, unless `reversed` asks for the other side. */
void ty_map_mesh(const ty_affine* map, bool reversed, ty_model_mesh* mesh);

/* Determinant of the linear part. */
double ty_affine_determinant(const ty_affine* map);
/* The linear map of a direction; its length is kept as it comes out. */
void ty_affine_direction(const ty_affine* map, const double direction[3], double out[3]);
/* Tells whether a map keeps shapes, and its scale: all axes stay at right angles, and scale alike within 1e-5. */
bool ty_affine_is_similarity(const ty_affine* map, double* scale);

#endif
