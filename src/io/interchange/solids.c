#include "io/interchange/solids.h"

#include "base/constants.h"
#include "base/context.h"

#include <math.h>
#include <string.h>

enum { ROWS = 65, COLUMNS = 128 };

ty_result ty_make_revolution(ty_context* context, const ty_revolution* shape, int columns, ty_model_mesh* out) {
    const int across = columns + 1;
    *out = (ty_model_mesh){.vertex_count = (size_t)shape->rows * (size_t)across,
                           .triangle_count = 2 * (size_t)(shape->rows - 1) * (size_t)columns,
                           .material = -1,
                           .primitive = -1};
    const ty_result result = ty_model_alloc_mesh(context, out, true, true, false, false);
    if (result != TY_OK) return result;
    for (int j = 0; j < shape->rows; ++j)
        for (int i = 0; i < across; ++i) {
            const size_t at = (size_t)j * (size_t)across + (size_t)i;
            const double* profile = shape->profile[j];
            const double u = (double)i / columns, phi = u * shape->phi_max;
            const double c = cos(phi), s = sin(phi);
            const double numbers[6] = {profile[0] * c, profile[0] * s, profile[1],
                                       profile[2] * c, profile[2] * s, profile[3]};
            for (int k = 0; k < 3; ++k) {
                out->positions[3 * at + (size_t)k] = (float)numbers[k];
                out->normals[3 * at + (size_t)k] = (float)numbers[3 + k];
            }
            out->uv[0][2 * at] = (float)u;
            out->uv[0][2 * at + 1] = (float)((double)j / (shape->rows - 1));
        }
    uint32_t* index = out->indices;
    for (int j = 0; j + 1 < shape->rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const uint32_t a = (uint32_t)(j * across + i), b = a + 1, c = a + (uint32_t)across, d = c + 1;
            const uint32_t corners[6] = {a, b, d, a, d, c};
            memcpy(index, corners, sizeof corners);
            index += 6;
        }
    return TY_OK;
}

ty_result ty_make_sphere(ty_context* context, double radius, double z_min, double z_max, double phi_max,
                         ty_model_mesh* out) {
    double profile[ROWS][4];
    const double first = acos(fmin(fmax(z_min / radius, -1), 1)), last = acos(fmin(fmax(z_max / radius, -1), 1));
    for (int j = 0; j < ROWS; ++j) {
        const double theta = first + (last - first) * j / (ROWS - 1);
        profile[j][2] = sin(theta);
        profile[j][3] = cos(theta);
        profile[j][0] = radius * profile[j][2];
        profile[j][1] = radius * profile[j][3];
    }
    return ty_make_revolution(context, &(ty_revolution){(const double(*)[4])profile, ROWS, phi_max}, COLUMNS, out);
}

ty_result ty_make_disk(ty_context* context, double radius, double inner, double height, double phi_max,
                       ty_model_mesh* out) {
    const double profile[2][4] = {{radius, height, 0, 1}, {inner, height, 0, 1}};
    return ty_make_revolution(context, &(ty_revolution){profile, 2, phi_max}, COLUMNS, out);
}

ty_result ty_make_cylinder(ty_context* context, double radius, double z_min, double z_max, double phi_max,
                           ty_model_mesh* out) {
    const double profile[2][4] = {{radius, z_min, 1, 0}, {radius, z_max, 1, 0}};
    return ty_make_revolution(context, &(ty_revolution){profile, 2, phi_max}, COLUMNS, out);
}

/* Fills in a face with its front on the side of u x v, whose corners are center +- u +- v. */
static void fill_face(ty_model_mesh* mesh, size_t face, const double center[3], const double u[3], const double v[3]) {
    static const uint32_t corners[6] = {0, 1, 3, 0, 3, 2};
    for (size_t k = 0; k < 4; ++k) {
        const size_t at = 4 * face + k;
        for (int a = 0; a < 3; ++a) {
            mesh->positions[3 * at + (size_t)a] =
                (float)(center[a] + (k % 2 == 0 ? -u[a] : u[a]) + (k < 2 ? -v[a] : v[a]));
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            mesh->normals[3 * at + (size_t)a] = (float)(u[b] * v[c] - u[c] * v[b]);
        }
        mesh->uv[0][2 * at] = (float)(k % 2);
        mesh->uv[0][2 * at + 1] = (float)(k / 2);
    }
    for (size_t k = 0; k < 6; ++k) mesh->indices[6 * face + k] = (uint32_t)(4 * face) + corners[k];
}

static ty_result alloc_faces(ty_context* context, size_t faces, ty_model_mesh* out) {
    *out = (ty_model_mesh){.vertex_count = 4 * faces, .triangle_count = 2 * faces, .material = -1, .primitive = -1};
    return ty_model_alloc_mesh(context, out, true, true, false, false);
}

ty_result ty_make_square(ty_context* context, ty_model_mesh* out) {
    const ty_result result = alloc_faces(context, 1, out);
    if (result == TY_OK)
        fill_face(out, 0, (const double[3]){0, 0, 0}, (const double[3]){1, 0, 0}, (const double[3]){0, 1, 0});
    return result;
}

ty_result ty_make_cube(ty_context* context, ty_model_mesh* out) {
    const ty_result result = alloc_faces(context, 6, out);
    for (int face = 0; face < 6 && result == TY_OK; ++face) {
        const int axis = face / 2, sign = face % 2 == 0 ? -1 : 1;
        double center[3] = {0, 0, 0}, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
        center[axis] = sign;
        u[(axis + 1) % 3] = sign;
        v[(axis + 2) % 3] = 1;
        fill_face(out, (size_t)face, center, u, v);
    }
    return result;
}

/* ---- maps ---- */

double ty_affine_determinant(const ty_affine* map) {
    const double* m = map->m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

void ty_affine_direction(const ty_affine* map, const double direction[3], double out[3]) {
    const double in[3] = {direction[0], direction[1], direction[2]};
    for (int r = 0; r < 3; ++r) out[r] = map->m[4 * r] * in[0] + map->m[4 * r + 1] * in[1] + map->m[4 * r + 2] * in[2];
}

bool ty_affine_is_similarity(const ty_affine* map, double* scale) {
    double products[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            products[i][j] = 0;
            for (int r = 0; r < 3; ++r) products[i][j] += map->m[4 * r + i] * map->m[4 * r + j];
        }
    const double square = products[0][0];
    if (!(square > 0)) return false;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (fabs(products[i][j] - (i == j ? square : 0)) > 1e-5 * square) return false;
    *scale = sqrt(square);
    return true;
}

/* Cofactors of the linear part: the inverse transpose times the determinant. */
static void cofactors(const ty_affine* map, double out[9]) {
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[3 * r + c] = map->m[4 * r1 + c1] * map->m[4 * r2 + c2] - map->m[4 * r1 + c2] * map->m[4 * r2 + c1];
        }
}

static void turn_triangles(ty_model_mesh* mesh) {
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t swapped = mesh->indices[3 * t + 1];
        mesh->indices[3 * t + 1] = mesh->indices[3 * t + 2];
        mesh->indices[3 * t + 2] = swapped;
    }
}

void ty_map_mesh(const ty_affine* map, bool reversed, ty_model_mesh* mesh) {
    double normal_map[9];
    cofactors(map, normal_map);
    const bool mirrored = ty_affine_determinant(map) < 0;
    const double sign = (mirrored ? -1 : 1) * (reversed ? -1 : 1);
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        float* p = mesh->positions + 3 * i;
        double point[3];
        ty_affine_point(map, (const double[3]){(double)p[0], (double)p[1], (double)p[2]}, point);
        for (int a = 0; a < 3; ++a) p[a] = (float)point[a];
        if (mesh->normals == NULL) continue;
        float* n = mesh->normals + 3 * i;
        double normal[3], length = 0;
        for (int a = 0; a < 3; ++a) {
            normal[a] = sign * (normal_map[3 * a] * (double)n[0] + normal_map[3 * a + 1] * (double)n[1] +
                                normal_map[3 * a + 2] * (double)n[2]);
            length += normal[a] * normal[a];
        }
        for (int a = 0; a < 3; ++a) n[a] = length > 0 ? (float)(normal[a] / sqrt(length)) : 0;
    }
    if (mirrored != reversed) turn_triangles(mesh);
}
