/* Texture coordinates of shapes, in a frame x, up, x cross up of the space before their transform: as a sphere, a box
 * and a quad of glTF have them, whose v begins at the top of a texture. */
#include "scene/surfaces/shape.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    const double result[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    memcpy(out, result, sizeof result);
}

static void map_direction(const ty_affine* map, const double in[3], double out[3]) {
    for (int r = 0; r < 3; ++r) out[r] = dot(map->m + 4 * (size_t)r, in);
}

static void store(const double in[3], double scale, float out[4]) {
    for (int a = 0; a < 3; ++a) out[a] = (float)(in[a] * scale);
}

/* Sign of the determinant of a map. */
static double handedness(const ty_affine* map) {
    double normal[3];
    const double x[3] = {map->m[0], map->m[4], map->m[8]}, y[3] = {map->m[1], map->m[5], map->m[9]};
    const double z[3] = {map->m[2], map->m[6], map->m[10]};
    cross(x, y, normal);
    return dot(normal, z) < 0 ? -1 : 1;
}

/* A parallelogram with u along its edge `right` and v against its edge `up`, by the basis dual to both edges. */
static void set_parallelogram(const double origin[3], const double right[3], const double up[3], double sign,
                              ty_shape_face* face) {
    const double rr = dot(right, right), ru = dot(right, up), uu = dot(up, up), determinant = rr * uu - ru * ru;
    double along_right[3], along_up[3];
    for (int a = 0; a < 3; ++a) {
        along_right[a] = (right[a] * uu - up[a] * ru) / determinant;
        along_up[a] = (up[a] * rr - right[a] * ru) / determinant;
    }
    store(along_right, 1, face->u);
    store(along_up, -1, face->v);
    face->u[3] = (float)-dot(along_right, origin);
    face->v[3] = (float)(1 + dot(along_up, origin));
    store(right, 1 / sqrt(rr), face->tangent);
    face->tangent[3] = (float)sign;
}

/* Face i of a box, as in ty_shape_quad. */
static void set_box_face(const ty_shape_def* shape, const double vertical[3], int32_t i, ty_shape_face* face) {
    const double x[3] = {1, 0, 0};
    double normal[3] = {0, 0, 0}, right[3], up[3], corner[3];
    normal[i / 2] = i % 2 != 0 ? 1 : -1;
    const bool side = dot(normal, vertical) == 0;
    memcpy(up, vertical, sizeof up);
    cross(vertical, normal, right);
    if (!side) {
        memcpy(right, x, sizeof right);
        cross(normal, x, up);
    }
    for (int a = 0; a < 3; ++a) {
        const double sum = normal[a] - right[a] - up[a], extent = shape->u[a] - shape->origin[a];
        corner[a] = sum > 0 ? shape->u[a] : shape->origin[a];
        right[a] *= extent;
        up[a] *= extent;
    }
    ty_affine_point(&shape->transform, corner, corner);
    map_direction(&shape->transform, right, right);
    map_direction(&shape->transform, up, up);
    set_parallelogram(corner, right, up, handedness(&shape->transform), face);
}

static void set_sphere(const ty_shape_def* shape, const double vertical[3], ty_shape_face* face) {
    const double x[3] = {1, 0, 0};
    double axes[3][3];
    memcpy(axes[0], x, sizeof x);
    memcpy(axes[1], vertical, sizeof axes[1]);
    cross(x, vertical, axes[2]);
    for (int i = 0; i < 3; ++i) {
        double image[3];
        map_direction(&shape->transform, axes[i], image);
        store(image, 1 / sqrt(dot(image, image)), i == 0 ? face->u : i == 1 ? face->v : face->tangent);
    }
    face->u[3] = face->v[3] = 0;
    face->tangent[3] = (float)handedness(&shape->transform);
}

void ty_shape_get_faces(const ty_shape_def* shape, ty_axis up, ty_shape_face faces[TY_SHAPE_FACES]) {
    const double vertical[3] = {0, up == TY_AXIS_Y ? 1 : 0, up == TY_AXIS_Z ? 1 : 0};
    double origin[3], u[3], v[3];
    if (shape->kind == TY_SHAPE_SPHERE) {
        set_sphere(shape, vertical, faces);
    } else if (shape->kind == TY_SHAPE_QUAD) {
        ty_shape_quad(shape, 0, origin, u, v);
        set_parallelogram(origin, u, v, 1, faces);
    }
    for (int32_t i = 0; shape->kind == TY_SHAPE_BOX && i < TY_SHAPE_FACES; ++i)
        set_box_face(shape, vertical, i, &faces[i]);
}
