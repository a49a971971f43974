/* Triangle meshes for tests: boxes and finely tessellated spheres. Each triangle has vertices of its own; those that
 * meet have the same coordinates to the bit. */
#ifndef TY_TESTS_TRIANGLE_MAKER_H
#define TY_TESTS_TRIANGLE_MAKER_H

#include <tyndall/tyndall.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MADE_TRIANGLES_MAX = 1 << 15 };

typedef struct made_mesh {
    int64_t triangles;
    float *positions, *normals, *uv; /* per vertex: 3, 3, 2 */
    uint32_t* indices;
} made_mesh;

static inline made_mesh made_nothing(void) {
    made_mesh mesh = {.positions = calloc(9 * MADE_TRIANGLES_MAX, sizeof(float)),
                      .normals = calloc(9 * MADE_TRIANGLES_MAX, sizeof(float)),
                      .uv = calloc(6 * MADE_TRIANGLES_MAX, sizeof(float)),
                      .indices = calloc(3 * MADE_TRIANGLES_MAX, sizeof(uint32_t))};
    for (uint32_t i = 0; i < 3 * MADE_TRIANGLES_MAX; ++i) mesh.indices[i] = i;
    return mesh;
}

static inline void made_free(made_mesh* mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uv);
    free(mesh->indices);
}

static inline float* made_corner(const made_mesh* mesh, int64_t triangle, int corner) {
    return mesh->positions + 9 * triangle + 3 * corner;
}

/* Counter-clockwise seen from the front. */
static inline void made_add(made_mesh* mesh, const double a[3], const double b[3], const double c[3]) {
    const double* corners[3] = {a, b, c};
    for (int corner = 0; corner < 3; ++corner)
        for (int axis = 0; axis < 3; ++axis)
            made_corner(mesh, mesh->triangles, corner)[axis] = (float)corners[corner][axis];
    ++mesh->triangles;
}

/* Two triangles with texture coordinates from (0, 0) at the corner to (1, 1) at corner + u + v. */
static inline void made_add_quad(made_mesh* mesh, const double corner[3], const double u[3], const double v[3]) {
    static const float uv[12] = {0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};
    double b[3], c[3], d[3];
    for (int a = 0; a < 3; ++a) {
        b[a] = corner[a] + u[a];
        c[a] = corner[a] + u[a] + v[a];
        d[a] = corner[a] + v[a];
    }
    memcpy(mesh->uv + 6 * mesh->triangles, uv, sizeof uv);
    made_add(mesh, corner, b, c);
    made_add(mesh, corner, c, d);
}

static inline void made_add_box(made_mesh* mesh, const double low[3], const double high[3]) {
    for (int axis = 0; axis < 3; ++axis)
        for (int upper = 0; upper < 2; ++upper) {
            double corner[3] = {low[0], low[1], low[2]}, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
            const int first = (axis + 1) % 3, second = (axis + 2) % 3;
            if (upper) corner[axis] = high[axis];
            u[first] = high[first] - low[first];
            v[second] = high[second] - low[second];
            made_add_quad(mesh, corner, upper ? u : v, upper ? v : u);
        }
}

/* A point of an octahedron with 4 n^2 + 2 such points, moved out to the sphere. */
static inline void made_on_sphere(const int at[3], const double center[3], double radius, double out[3]) {
    const double length = sqrt((double)(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]));
    for (int a = 0; a < 3; ++a) out[a] = center[a] + radius * at[a] / length;
}

static inline void made_add_sphere_triangle(made_mesh* mesh, const int place[3][2], const int sign[3], int n,
                                            const double center[3], double radius) {
    const double zero[3] = {0, 0, 0};
    double corner[3][3], normal[3];
    for (int k = 0; k < 3; ++k) {
        const int p = sign[0] * sign[1] * sign[2] > 0 ? k : 2 - k;
        const int at[3] = {sign[0] * place[p][0], sign[1] * place[p][1], sign[2] * (n - place[p][0] - place[p][1])};
        made_on_sphere(at, center, radius, corner[k]);
        made_on_sphere(at, zero, 1, normal);
        for (int a = 0; a < 3; ++a) mesh->normals[9 * mesh->triangles + 3 * k + a] = (float)normal[a];
    }
    made_add(mesh, corner[0], corner[1], corner[2]);
}

/* 8 n^2 triangles, with the sphere's normals. */
static inline void made_add_sphere(made_mesh* mesh, const double center[3], double radius, int n) {
    for (int octant = 0; octant < 8; ++octant) {
        const int sign[3] = {octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1};
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j) {
                const int up[3][2] = {{i, j}, {i + 1, j}, {i, j + 1}};
                const int down[3][2] = {{i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
                made_add_sphere_triangle(mesh, up, sign, n, center, radius);
                if (i + j < n - 1) made_add_sphere_triangle(mesh, down, sign, n, center, radius);
            }
    }
}

/* Turns triangles inside out from number `first` on. */
static inline void made_turn(made_mesh* mesh, int64_t first) {
    for (int64_t i = first; i < mesh->triangles; ++i) {
        float corner[3];
        memcpy(corner, made_corner(mesh, i, 1), sizeof corner);
        memcpy(made_corner(mesh, i, 1), made_corner(mesh, i, 2), sizeof corner);
        memcpy(made_corner(mesh, i, 2), corner, sizeof corner);
    }
}

static inline double made_volume(const made_mesh* mesh) {
    double sum = 0;
    for (int64_t i = 0; i < mesh->triangles; ++i) {
        const float *a = made_corner(mesh, i, 0), *b = made_corner(mesh, i, 1), *c = made_corner(mesh, i, 2);
        for (int x = 0; x < 3; ++x) {
            const int y = (x + 1) % 3, z = (x + 2) % 3;
            sum += (double)a[x] * ((double)b[y] * (double)c[z] - (double)b[z] * (double)c[y]) / 6;
        }
    }
    return sum;
}

/* Flat triangles with texture coordinates; the caller may set normals and material. */
static inline ty_mesh_def made_def(const made_mesh* mesh) {
    ty_mesh_def def = ty_default_mesh_def();
    def.vertex_count = 3 * mesh->triangles;
    def.triangle_count = mesh->triangles;
    def.positions = mesh->positions;
    def.uv[0] = mesh->uv;
    def.indices = mesh->indices;
    return def;
}

static inline ty_result made_shell(ty_context* context, const made_mesh* mesh, ty_closed_mesh** out) {
    return ty_closed_mesh_create(context, mesh->positions, 3 * mesh->triangles, mesh->indices, mesh->triangles, out);
}

#endif
