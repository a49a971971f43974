/* Meshes with second texture coordinates, and light made up for their texels. */
#ifndef TY_TESTS_ATLAS_MAKER_H
#define TY_TESTS_ATLAS_MAKER_H

#include "checks.h"

#include <tyndall/bake.h>

#include <math.h>
#include <string.h>

enum { ATLAS_VERTICES_MAX = 1 << 18 };

typedef struct mapped_mesh {
    int64_t vertices, triangles;
    float *positions, *normals, *uv;
    uint32_t* indices;
} mapped_mesh;

static inline mapped_mesh mapped_nothing(void) {
    return (mapped_mesh){.positions = calloc(3 * ATLAS_VERTICES_MAX, sizeof(float)),
                         .normals = calloc(3 * ATLAS_VERTICES_MAX, sizeof(float)),
                         .uv = calloc(2 * ATLAS_VERTICES_MAX, sizeof(float)),
                         .indices = calloc(3 * ATLAS_VERTICES_MAX, sizeof(uint32_t))};
}

static inline void mapped_free(mapped_mesh* mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uv);
    free(mesh->indices);
}

static inline uint32_t mapped_vertex(mapped_mesh* mesh, double x, double y, double z, double u, double v) {
    const int64_t i = mesh->vertices++;
    assert_true(i < ATLAS_VERTICES_MAX);
    const double at[3] = {x, y, z};
    for (int a = 0; a < 3; ++a) mesh->positions[3 * i + a] = (float)at[a];
    mesh->uv[2 * i] = (float)u;
    mesh->uv[2 * i + 1] = (float)v;
    return (uint32_t)i;
}

static inline void mapped_triangle(mapped_mesh* mesh, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t* corner = mesh->indices + 3 * mesh->triangles++;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

/* A rectangle in x and y at height z, facing +z, with the map's rectangle from (u0, v0) to (u1, v1). */
static inline void mapped_quad(mapped_mesh* mesh, const double x[2], const double y[2], double z, const double u[2],
                               const double v[2]) {
    const uint32_t a = mapped_vertex(mesh, x[0], y[0], z, u[0], v[0]);
    const uint32_t b = mapped_vertex(mesh, x[1], y[0], z, u[1], v[0]);
    const uint32_t c = mapped_vertex(mesh, x[1], y[1], z, u[1], v[1]);
    const uint32_t d = mapped_vertex(mesh, x[0], y[1], z, u[0], v[1]);
    mapped_triangle(mesh, a, b, c);
    mapped_triangle(mesh, a, c, d);
}

/* A scene of the mesh alone. */
static inline ty_scene* mapped_scene(ty_context* context, const mapped_mesh* mesh, bool smooth, bool mapped) {
    ty_mesh_def def = ty_default_mesh_def();
    def.vertex_count = mesh->vertices;
    def.triangle_count = mesh->triangles;
    def.positions = mesh->positions;
    def.normals = smooth ? mesh->normals : NULL;
    def.uv[1] = mapped ? mesh->uv : NULL;
    def.indices = mesh->indices;
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static inline ty_atlas_def sized(int32_t side) {
    ty_atlas_def def = ty_default_atlas_def();
    def.width = def.height = side;
    return def;
}

static inline ty_atlas* mapped_atlas(const ty_scene* scene, const ty_atlas_def* def) {
    ty_atlas* atlas = NULL;
    const ty_result result = ty_atlas_create(scene, 0, "wall", def, &atlas);
    if (result != TY_OK) fail_msg("%s", ty_take_error(ty_scene_context(scene)));
    return atlas;
}

typedef void (*light_fn)(const ty_bake_receiver* receiver, int64_t index, ty_bake_light* out);

/* Light from a function of receivers; to be freed. */
static inline ty_bake_light* made_up(const ty_atlas* atlas, light_fn light) {
    int64_t count;
    const ty_bake_receiver* receivers = ty_atlas_receivers(atlas, &count);
    ty_bake_light* out = calloc((size_t)count + 1, sizeof *out);
    for (int64_t i = 0; i < count; ++i) {
        out[i].samples = 16;
        light(&receivers[i], i, &out[i]);
    }
    return out;
}

static inline ty_image* image_of(const ty_atlas* atlas, light_fn light) {
    ty_bake_light* lit = made_up(atlas, light);
    ty_image* image = NULL;
    assert_int_equal(ty_atlas_create_image(atlas, lit, &image), TY_OK);
    free(lit);
    return image;
}

static inline const float* plane_of(const ty_image* image, const char* name) {
    const int32_t channel = ty_image_find_channel(image, name);
    if (channel < 0) fail_msg("there is no channel %s", name);
    return ty_image_plane_const(image, channel);
}

/* A bilinear lookup at (u, v), as engines do it. */
static inline double looked_up(const ty_image* image, const char* name, double u, double v) {
    const int32_t width = ty_image_width(image), height = ty_image_height(image);
    const float* plane = plane_of(image, name);
    const double x = u * width - 0.5, y = v * height - 0.5;
    double sum = 0;
    for (int tap = 0; tap < 4; ++tap) {
        const int32_t column = (int32_t)floor(x) + tap % 2, row = (int32_t)floor(y) + tap / 2;
        const double wx = 1 - fabs(x - column), wy = 1 - fabs(y - row);
        const int32_t cx = column < 0 ? 0 : column >= width ? width - 1 : column;
        const int32_t cy = row < 0 ? 0 : row >= height ? height - 1 : row;
        sum += wx * wy * (double)plane[(size_t)cy * (size_t)width + (size_t)cx];
    }
    return sum;
}

#endif
