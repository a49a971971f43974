/* Shapes: checks and decomposition. */
#include "scene/surfaces/shape.h"

#include "base/context.h"
#include "base/check.h"
#include "scene/surfaces/gloss.h"

#include <math.h>

void ty_init_shape_def(void* def, size_t bytes) {
    const ty_shape_def own = {.kind = TY_SHAPE_QUAD,
                              .transform = ty_affine_identity(),
                              .albedo = {0.5f, 0.5f, 0.5f},
                              .gloss = ty_default_gloss(),
                              .albedo_texture = ty_default_texture_use()};
    ty_init_def(def, bytes, &own, sizeof own);
}

int32_t ty_shape_quad_count(const ty_shape_def* shape) {
    return shape->kind == TY_SHAPE_QUAD ? 1 : shape->kind == TY_SHAPE_BOX ? 6 : 0;
}

static void map_direction(const ty_affine* map, const double in[3], double out[3]) {
    for (int r = 0; r < 3; ++r) out[r] = map->m[4 * r] * in[0] + map->m[4 * r + 1] * in[1] + map->m[4 * r + 2] * in[2];
}

/* True for maps with negative determinant. */
static bool mirrors(const ty_affine* map) {
    const double* m = map->m;
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
               m[2] * (m[4] * m[9] - m[5] * m[8]) <
           0;
}

void ty_shape_quad(const ty_shape_def* shape, int32_t i, double origin[3], double u[3], double v[3]) {
    double corner[3], a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) corner[axis] = shape->origin[axis];
    if (shape->kind == TY_SHAPE_QUAD) {
        for (int axis = 0; axis < 3; ++axis) {
            a[axis] = shape->u[axis];
            b[axis] = shape->v[axis];
        }
    } else {
        /* Face i: its outward normal is along axis i / 2; on upper faces first x second edge is cyclic. */
        const int32_t normal = i / 2, upper = i % 2;
        const int32_t first = (normal + (upper ? 1 : 2)) % 3, second = (normal + (upper ? 2 : 1)) % 3;
        a[first] = shape->u[first] - shape->origin[first];
        b[second] = shape->u[second] - shape->origin[second];
        if (upper) corner[normal] = shape->u[normal];
    }
    const bool swap = mirrors(&shape->transform) && shape->kind == TY_SHAPE_BOX;
    ty_affine_point(&shape->transform, corner, origin);
    map_direction(&shape->transform, swap ? b : a, u);
    map_direction(&shape->transform, swap ? a : b, v);
}

ty_vec ty_shape_normal(const double u[3], const double v[3]) {
    const double cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    return ty_vec_make((float)(cross[0] / length), (float)(cross[1] / length), (float)(cross[2] / length));
}

double ty_shape_sphere(const ty_shape_def* shape, double center[3]) {
    ty_affine_point(&shape->transform, shape->origin, center);
    const double x[3] = {1, 0, 0};
    double image[3];
    map_direction(&shape->transform, x, image);
    return shape->radius * sqrt(image[0] * image[0] + image[1] * image[1] + image[2] * image[2]);
}

static void widen(const double point[3], double lower[3], double upper[3]) {
    for (int a = 0; a < 3; ++a) {
        lower[a] = fmin(lower[a], point[a]);
        upper[a] = fmax(upper[a], point[a]);
    }
}

void ty_shape_extent(const ty_shape_def* shape, double lower[3], double upper[3]) {
    double origin[3], u[3], v[3], point[3];
    if (shape->kind == TY_SHAPE_SPHERE) {
        const double radius = ty_shape_sphere(shape, origin);
        for (int side = -1; side <= 1; side += 2) {
            for (int a = 0; a < 3; ++a) point[a] = origin[a] + side * radius;
            widen(point, lower, upper);
        }
    }
    for (int32_t q = 0; q < ty_shape_quad_count(shape); ++q) {
        ty_shape_quad(shape, q, origin, u, v);
        for (int corner = 0; corner < 4; ++corner) {
            for (int a = 0; a < 3; ++a) point[a] = origin[a] + (corner & 1 ? u[a] : 0) + (corner & 2 ? v[a] : 0);
            widen(point, lower, upper);
        }
    }
}

bool ty_shape_emits(const ty_shape_def* shape) {
    return shape->emission[0] > 0 || shape->emission[1] > 0 || shape->emission[2] > 0;
}

const ty_texture_use* ty_shape_texture(const ty_shape_def* shape, int32_t i) {
    return i < TY_GLOSS_TEXTURES ? &shape->gloss.textures[i] : &shape->albedo_texture;
}

bool ty_shape_is_textured(const ty_shape_def* shape) {
    for (int32_t i = 0; i <= TY_GLOSS_TEXTURES; ++i)
        if (ty_shape_texture(shape, i)->texture != NULL) return true;
    return false;
}

/* True for a rotation, translation and uniform scale. */
static bool is_similarity(const ty_affine* map) {
    double columns[3][3];
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) columns[c][r] = map->m[4 * r + c];
    double dots[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            dots[i][j] = columns[i][0] * columns[j][0] + columns[i][1] * columns[j][1] + columns[i][2] * columns[j][2];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (fabs(dots[i][j] - (i == j ? dots[0][0] : 0)) > 1e-6 * dots[0][0]) return false;
    return true;
}

ty_result ty_shape_check(ty_context* context, const ty_shape_def** given, ty_shape_def* own) {
    *own = ty_default_shape_def();
    ty_result result = ty_take_def(context, *given, "ty_default_shape_def", own, sizeof *own);
    const ty_shape_def* shape = *given = own;
    if (result == TY_OK) result = ty_check_point(context, "shape.origin", shape->origin);
    if (result == TY_OK) result = ty_check_affine(context, "shape.transform", &shape->transform);
    if (result == TY_OK) result = ty_check_rgb(context, "shape.albedo", shape->albedo, 0, 1);
    if (result == TY_OK) result = ty_check_rgb(context, "shape.emission", shape->emission, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_gloss_check(context, "shape.gloss", &shape->gloss);
    if (result == TY_OK) result = ty_texture_use_check(context, "shape.albedo_texture", &shape->albedo_texture);
    for (int i = 0; i <= TY_GLOSS_TEXTURES && result == TY_OK; ++i)
        if (ty_shape_texture(shape, i)->uv != 0)
            result = ty_fail(context, TY_ERROR_ARGUMENT, "shape: textures of shapes have the texture coordinates 0");
    if (result == TY_OK && shape->kind == TY_SHAPE_QUAD && shape->gloss.solid)
        result = ty_fail(context, TY_ERROR_ARGUMENT,
                         "shape.gloss.solid: a quad bounds no volume; take a box, a sphere or a closed mesh");
    if (result != TY_OK) return result;
    if (shape->kind == TY_SHAPE_SPHERE) {
        if (!(shape->radius > 0 && shape->radius <= 1e15))
            return ty_fail(context, TY_ERROR_ARGUMENT, "shape.radius: %g is outside (0, 1e15]", shape->radius);
        if (!is_similarity(&shape->transform))
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "shape.transform: a sphere takes rotation, translation and uniform scale only");
        return TY_OK;
    }
    if (shape->kind == TY_SHAPE_BOX) {
        result = ty_check_point(context, "shape.u", shape->u);
        if (result != TY_OK) return result;
        for (int a = 0; a < 3; ++a)
            if (!(shape->u[a] > shape->origin[a]))
                return ty_fail(context, TY_ERROR_ARGUMENT, "shape: a box's upper corner must be above its lower in %c",
                               "xyz"[a]);
        return TY_OK;
    }
    if (shape->kind != TY_SHAPE_QUAD)
        return ty_fail(context, TY_ERROR_ARGUMENT, "shape.kind: %d is not a ty_shape_kind", (int)shape->kind);
    return ty_check_edges(context, "shape", shape->u, shape->v);
}
