#include "scene/surfaces/traced_shapes.h"

#include "scene/surfaces/shape.h"

/* Rounding displaces a point from a quad by the rounding errors of the coordinates projected on the normal: none for a
 * normal along an axis. */
static float quad_margin(ty_vec normal, const float* corners) {
    ty_vec largest = ty_vec_make(0, 0, 0);
    for (int corner = 0; corner < 4; ++corner)
        largest = ty_vec_make(ty_maxf(largest.x, fabsf(corners[3 * corner])),
                              ty_maxf(largest.y, fabsf(corners[3 * corner + 1])),
                              ty_maxf(largest.z, fabsf(corners[3 * corner + 2])));
    const ty_vec magnitude = ty_vec_make(fabsf(normal.x), fabsf(normal.y), fabsf(normal.z));
    return ty_maxf(TY_RELATIVE_MARGIN * ty_dot(magnitude, largest), TY_MIN_MARGIN);
}

static float sphere_margin(ty_vec center, float radius) {
    const float largest = ty_maxf(fabsf(center.x), ty_maxf(fabsf(center.y), fabsf(center.z)));
    return ty_maxf(TY_RELATIVE_MARGIN * (largest + radius), TY_MIN_MARGIN);
}

size_t ty_traced_quad_count(const ty_shape_def* shapes, size_t count) {
    size_t quads = 0;
    for (size_t i = 0; i < count; ++i) quads += (size_t)ty_shape_quad_count(&shapes[i]);
    return quads;
}

size_t ty_traced_sphere_count(const ty_shape_def* shapes, size_t count) {
    size_t spheres = 0;
    for (size_t i = 0; i < count; ++i) spheres += shapes[i].kind == TY_SHAPE_SPHERE;
    return spheres;
}

void ty_traced_quads(const ty_shape_def* shapes, size_t count, ty_quad_face* faces, float* corners) {
    size_t quad = 0;
    for (size_t i = 0; i < count; ++i)
        for (int32_t q = 0; q < ty_shape_quad_count(&shapes[i]); ++q, ++quad) {
            double origin[3], u[3], v[3];
            ty_shape_quad(&shapes[i], q, origin, u, v);
            for (int corner = 0; corner < 4; ++corner)
                for (int a = 0; a < 3; ++a)
                    corners[12 * quad + 3 * (size_t)corner + (size_t)a] =
                        (float)(origin[a] + (corner == 1 || corner == 2 ? u[a] : 0) + (corner >= 2 ? v[a] : 0));
            faces[quad] = (ty_quad_face){.shape = (int32_t)i,
                                         .primitive_id = q,
                                         .corner = ty_vec_load(corners + 12 * quad),
                                         .normal = ty_shape_normal(u, v)};
            faces[quad].margin = quad_margin(faces[quad].normal, corners + 12 * quad);
        }
}

void ty_traced_spheres(const ty_shape_def* shapes, size_t count, ty_sphere_face* faces, float* points) {
    size_t sphere = 0;
    for (size_t i = 0; i < count; ++i) {
        if (shapes[i].kind != TY_SHAPE_SPHERE) continue;
        double center[3];
        float* point = points + 4 * sphere;
        point[3] = (float)ty_shape_sphere(&shapes[i], center);
        for (int a = 0; a < 3; ++a) point[a] = (float)center[a];
        faces[sphere++] = (ty_sphere_face){.shape = (int32_t)i,
                                           .center = ty_vec_load(point),
                                           .radius = point[3],
                                           .margin = sphere_margin(ty_vec_load(point), point[3])};
    }
}
