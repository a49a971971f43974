/* Meshes and directions under an affine map. */
#include "io/mesh_file.h"

#include <math.h>

/* The cofactors of the linear part, which turn normals; their sign is that of the determinant's. */
static double normal_map(const ty_affine* map, double cofactors[9]) {
    const double* m = map->m;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactors[3 * r + c] = m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1];
        }
    return m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
}

void ty_place_direction(const ty_affine* map, const double in[3], double out[3]) {
    double turned[3], length = 0;
    for (int r = 0; r < 3; ++r) {
        turned[r] = map->m[4 * r] * in[0] + map->m[4 * r + 1] * in[1] + map->m[4 * r + 2] * in[2];
        length += turned[r] * turned[r];
    }
    for (int r = 0; r < 3; ++r) out[r] = turned[r] / sqrt(length);
}

void ty_place_positions(const ty_model_mesh* mesh, const ty_affine* map, float* out) {
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double point[3];
        for (size_t a = 0; a < 3; ++a) point[a] = mesh->positions[3 * i + a];
        ty_affine_point(map, point, point);
        for (size_t a = 0; a < 3; ++a) out[3 * i + a] = (float)point[a];
    }
}

void ty_place_normals(const ty_model_mesh* mesh, const ty_affine* map, float* out) {
    double cofactors[9];
    const double sign = normal_map(map, cofactors) < 0 ? -1 : 1;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const float* in = mesh->normals + 3 * i;
        double turned[3], length = 0;
        for (int r = 0; r < 3; ++r) {
            const double* row = cofactors + 3 * r;
            turned[r] = sign * (row[0] * (double)in[0] + row[1] * (double)in[1] + row[2] * (double)in[2]);
            length += turned[r] * turned[r];
        }
        for (size_t r = 0; r < 3; ++r) out[3 * i + r] = length > 0 ? (float)(turned[r] / sqrt(length)) : 0;
    }
}

void ty_place_triangles(const ty_model_mesh* mesh, const ty_affine* map, uint32_t first, uint32_t* out) {
    double cofactors[9];
    const bool mirrored = normal_map(map, cofactors) < 0;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        const uint32_t* in = mesh->indices + 3 * i;
        out[3 * i] = first + in[0];
        out[3 * i + 1] = first + in[mirrored ? 2 : 1];
        out[3 * i + 2] = first + in[mirrored ? 1 : 2];
    }
}
