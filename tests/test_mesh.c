/* Surfaces: hits against closed forms, sides, and rays that leave a surface. */
#include "checks.h"

#include "scene/surfaces/accel.h"
#include "scene/surfaces/shape.h"

static ty_accel* make_mesh(ty_context* context, const ty_shape_def* shapes, size_t count) {
    ty_accel* mesh = NULL;
    const ty_accel_input parts = {.shapes = shapes, .shape_count = count};
    assert_int_equal(ty_accel_create(context, &parts, &mesh), TY_OK);
    assert_non_null(mesh);
    return mesh;
}

static ty_shape_def quad(const double origin[3], const double u[3], const double v[3]) {
    ty_shape_def shape = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        shape.origin[a] = origin[a];
        shape.u[a] = u[a];
        shape.v[a] = v[a];
    }
    return shape;
}

static ty_shape_def box(double x0, double y0, double z0, double x1, double y1, double z1) {
    ty_shape_def shape = ty_default_shape_def();
    shape.kind = TY_SHAPE_BOX;
    set3(shape.origin, x0, y0, z0);
    set3(shape.u, x1, y1, z1);
    return shape;
}

static ty_shape_def sphere(double x, double y, double z, double radius) {
    ty_shape_def shape = ty_default_shape_def();
    shape.kind = TY_SHAPE_SPHERE;
    set3(shape.origin, x, y, z);
    shape.radius = radius;
    return shape;
}

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where a closed form says that a ray meets a shape; distance is negative where it does not, and sure is false where
 * rounding may decide. */
typedef struct expected_hit {
    double distance;
    double normal[3]; /* not normalized */
    bool sure;
} expected_hit;

/* The face of [low, high]^3 that a ray meets first, in the shape's own space. */
static expected_hit meet_box(const ty_shape_def* shape, const double o[3], const double d[3]) {
    expected_hit best = {.distance = -1, .sure = true};
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, first = (axis + 1) % 3, second = (axis + 2) % 3;
        const double t = ((face % 2 ? shape->u[axis] : shape->origin[axis]) - o[axis]) / d[axis];
        double slack = INFINITY;
        for (int i = 0; i < 2; ++i) {
            const int a = i == 0 ? first : second;
            const double at = o[a] + t * d[a];
            slack = fmin(slack, fmin(at - shape->origin[a], shape->u[a] - at));
        }
        if (fabs(slack) < 1e-4 || fabs(t) < 1e-4) best.sure = false;
        if (slack < 0 || t < 0 || (best.distance >= 0 && t > best.distance)) continue;
        best.distance = t;
        set3(best.normal, 0, 0, 0);
        best.normal[axis] = face % 2 ? 1 : -1;
    }
    return best;
}

static expected_hit meet_quad(const ty_shape_def* shape, const double o[3], const double d[3]) {
    expected_hit hit = {.distance = -1, .sure = true};
    const double *u = shape->u, *v = shape->v;
    double offset[3];
    for (int a = 0; a < 3; ++a) hit.normal[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
    for (int a = 0; a < 3; ++a) offset[a] = shape->origin[a] - o[a];
    const double t = dot3(offset, hit.normal) / dot3(d, hit.normal);
    for (int a = 0; a < 3; ++a) offset[a] = t * d[a] - offset[a];
    const double uu = dot3(u, u), uv = dot3(u, v), vv = dot3(v, v), pu = dot3(offset, u), pv = dot3(offset, v);
    const double a = (pu * vv - pv * uv) / (uu * vv - uv * uv), b = (pv * uu - pu * uv) / (uu * vv - uv * uv);
    const double slack = fmin(fmin(a, 1 - a), fmin(b, 1 - b));
    hit.sure = fabs(slack) > 1e-4 && fabs(t) > 1e-4;
    if (slack > 0 && t > 0) hit.distance = t;
    return hit;
}

static expected_hit meet_sphere(const ty_shape_def* shape, const double o[3], const double d[3]) {
    expected_hit hit = {.distance = -1, .sure = true};
    double off[3];
    for (int a = 0; a < 3; ++a) off[a] = o[a] - shape->origin[a];
    const double dd = dot3(d, d), b = dot3(off, d) / dd, c = dot3(off, off) - shape->radius * shape->radius;
    const double square = b * b - c / dd;
    if (fabs(square) < 1e-3 || fabs(c) < 1e-3) hit.sure = false;
    if (square < 0) return hit;
    const double near = -b - sqrt(square), far = -b + sqrt(square);
    hit.distance = near > 0 ? near : far > 0 ? far : -1;
    for (int a = 0; a < 3; ++a) hit.normal[a] = off[a] + hit.distance * d[a];
    return hit;
}

/* In the world: the ray is taken to the shape's space, the normal back as a covector (or, for a quad, as u x v). */
static expected_hit meet(const ty_shape_def* shape, ty_vec origin, ty_vec direction) {
    ty_affine inverse;
    assert_true(ty_affine_invert(&shape->transform, &inverse));
    const double world[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double way[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    double o[3], d[3];
    ty_affine_point(&inverse, world, o);
    for (int r = 0; r < 3; ++r)
        d[r] = inverse.m[4 * r] * way[0] + inverse.m[4 * r + 1] * way[1] + inverse.m[4 * r + 2] * way[2];
    expected_hit hit = shape->kind == TY_SHAPE_QUAD  ? meet_quad(shape, o, d)
                       : shape->kind == TY_SHAPE_BOX ? meet_box(shape, o, d)
                                                     : meet_sphere(shape, o, d);
    const double local[3] = {hit.normal[0], hit.normal[1], hit.normal[2]};
    for (int c = 0; c < 3; ++c)
        hit.normal[c] = inverse.m[c] * local[0] + inverse.m[4 + c] * local[1] + inverse.m[8 + c] * local[2];
    const double* m = inverse.m;
    const double determinant =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    if (shape->kind == TY_SHAPE_QUAD && determinant < 0)
        for (int c = 0; c < 3; ++c) hit.normal[c] *= -1;
    return hit;
}

static void check_ray(const ty_accel* mesh, const ty_shape_def* shape, ty_vec origin, ty_vec direction) {
    const expected_hit expected = meet(shape, origin, direction);
    ty_hit hit;
    if (!expected.sure) return;
    const bool met = ty_accel_intersect(mesh, origin, direction, TY_FLOAT_MAX, &hit);
    assert_int_equal(met, expected.distance > 0);
    assert_int_equal(ty_accel_occluded(mesh, origin, direction, TY_FLOAT_MAX), met);
    if (!met) return;
    assert_close(hit.distance, expected.distance, 1e-4);
    assert_vec_close(hit.position, ty_mad(origin, direction, hit.distance), 1e-5);
    const double length = sqrt(dot3(expected.normal, expected.normal));
    assert_vec_close(hit.normal,
                     ty_vec_make((float)(expected.normal[0] / length), (float)(expected.normal[1] / length),
                                 (float)(expected.normal[2] / length)),
                     2e-4);
    assert_int_equal(hit.surface, 0);
    assert_int_equal(ty_accel_intersect(mesh, origin, direction, hit.distance * 1.001f, &hit), 1);
    assert_int_equal(ty_accel_intersect(mesh, origin, direction, hit.distance * 0.999f, &hit), 0);
    assert_int_equal(ty_accel_occluded(mesh, origin, direction, hit.distance * 1.001f), 1);
    assert_int_equal(ty_accel_occluded(mesh, origin, direction, hit.distance * 0.999f), 0);
}

static void check_shape(ty_context* context, const ty_shape_def* shape) {
    ty_accel* mesh = make_mesh(context, shape, 1);
    uint64_t random = 21;
    for (int i = 0; i < 3000; ++i) {
        const ty_vec origin = ty_scale(random_unit(&random), (float)uniform_in(&random, 0, 6));
        const ty_vec target = ty_scale(random_unit(&random), (float)uniform_in(&random, 0, 1.5));
        check_ray(mesh, shape, origin, ty_normalize(ty_sub(target, origin)));
    }
    ty_accel_destroy(mesh);
}

/* Identity, a rotation with uneven scale, and its mirror image; even scale for spheres. */
static void check_transforms(ty_context* context, ty_shape_def shape) {
    const double move[3] = {0.3, -0.2, 0.1}, turn[3] = {30, -50, 110};
    double scale[3] = {0.7, 0.9, 1.3};
    check_shape(context, &shape);
    if (shape.kind == TY_SHAPE_SPHERE) scale[0] = scale[1] = scale[2] = 1.2;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        shape.transform = ty_affine_compose(move, turn, scale);
        check_shape(context, &shape);
        scale[1] = -scale[1];
    }
}

static void rays_meet_quads(void** state) {
    const double origin[3] = {-1, -0.5, 0.25}, u[3] = {2, 0.25, 0.5}, v[3] = {-0.5, 1.5, 0.75};
    check_transforms(*state, quad(origin, u, v));
}

static void rays_meet_boxes(void** state) {
    check_transforms(*state, box(-1, -0.75, -0.5, 0.5, 1, 1.25));
}

static void rays_meet_spheres(void** state) {
    check_transforms(*state, sphere(0.25, -0.5, 0.125, 1));
}

static void quads_face_the_u_cross_v_side(void** state) {
    const double origin[3] = {0, 0, 0}, u[3] = {0, 0, 2}, v[3] = {3, 0, 0};
    const ty_shape_def up = quad(origin, u, v);
    ty_accel* mesh = make_mesh(*state, &up, 1);
    ty_hit hit;
    assert_true(ty_accel_intersect(mesh, ty_vec_make(1, 4, 1), ty_vec_make(0, -1, 0), TY_FLOAT_MAX, &hit));
    assert_vec_close(hit.normal, ty_vec_make(0, 1, 0), 0);
    assert_close(hit.distance, 4, 1e-6);
    assert_true(ty_accel_intersect(mesh, ty_vec_make(1, -4, 1), ty_vec_make(0, 1, 0), TY_FLOAT_MAX, &hit));
    assert_vec_close(hit.normal, ty_vec_make(0, 1, 0), 0);
    ty_accel_destroy(mesh);
}

/* Shapes of all kinds in one mesh: hits name the shape as added, and the quad of a box. */
static void hits_name_shape_and_part(void** state) {
    const double origin[3] = {-1, 5, -1}, u[3] = {0, 0, 2}, v[3] = {2, 0, 0};
    const ty_shape_def shapes[] = {sphere(-5, 0, 0, 1), box(4, -1, -1, 6, 1, 1), quad(origin, u, v),
                                   sphere(0, -5, 0, 2)};
    ty_accel* mesh = make_mesh(*state, shapes, 4);
    static const float ways[][3] = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    static const double distances[] = {4, 4, 5, 3};
    const ty_vec zero = ty_vec_make(0, 0, 0);
    ty_hit hit;
    for (int i = 0; i < 4; ++i) {
        assert_true(ty_accel_intersect(mesh, zero, ty_vec_load(ways[i]), TY_FLOAT_MAX, &hit));
        assert_int_equal(hit.surface, i);
        assert_int_equal(hit.primitive_id, 0);
        assert_close(hit.distance, distances[i], 1e-5);
    }
    assert_false(ty_accel_intersect(mesh, zero, ty_vec_make(0, 0, 1), TY_FLOAT_MAX, &hit));
    for (int part = 0; part < 6; ++part) {
        ty_vec way = ty_vec_make(part / 2 == 0, part / 2 == 1, part / 2 == 2);
        if (part % 2 == 0) way = ty_scale(way, -1);
        assert_true(ty_accel_intersect(mesh, ty_vec_make(5, 0.25f, 0.25f), way, TY_FLOAT_MAX, &hit));
        assert_int_equal(hit.surface, 1);
        assert_int_equal(hit.primitive_id, part);
        assert_vec_close(hit.normal, way, 0);
    }
    assert_true(ty_accel_bytes(mesh) > 4 * sizeof(ty_vec));
    ty_accel_destroy(mesh);
    assert_int_equal(ty_accel_bytes(NULL), 0);
}

static void no_shapes_are_no_mesh(void** state) {
    ty_accel* mesh = NULL;
    const ty_accel_input parts = {.shapes = NULL};
    assert_int_equal(ty_accel_create(*state, &parts, &mesh), TY_OK);
    assert_null(mesh);
    ty_accel_destroy(mesh);
}

/* ---- leaving surfaces ---- */

/* Sends rays on from a hit to both sides: the surface that was hit must not be hit again (a sphere from within: not
 * before the ray has crossed it). */
static void check_leaving(const ty_accel* mesh, const ty_hit* hit, double radius, uint64_t* random) {
    for (int i = 0; i < 16; ++i) {
        const ty_vec way = random_unit(random);
        const float facing = ty_dot(way, hit->normal);
        if (fabsf(facing) < 0.01f) continue;
        ty_hit again;
        if (!ty_accel_intersect(mesh, ty_hit_leave(hit, way), way, TY_FLOAT_MAX, &again)) continue;
        if (again.surface != hit->surface || again.primitive_id != hit->primitive_id) continue;
        const double chord = radius > 0 && facing < 0 ? -2 * radius * (double)facing : 0;
        if (chord == 0 || again.distance < 0.5 * chord)
            fail_msg("from (%g, %g, %g): hit again after %g", (double)hit->position.x, (double)hit->position.y,
                     (double)hit->position.z, (double)again.distance);
    }
}

/* Rays from `away` towards points within `spread` of center. */
static void check_leaving_shape(ty_context* context, ty_shape_def shape, ty_vec center, double spread, double away) {
    ty_accel* mesh = make_mesh(context, &shape, 1);
    uint64_t random = 31;
    int hits = 0;
    double middle[3];
    const double radius = shape.kind == TY_SHAPE_SPHERE ? ty_shape_sphere(&shape, middle) : 0;
    for (int i = 0; i < 1000; ++i) {
        const ty_vec target = ty_mad(center, random_unit(&random), (float)(spread * uniform(&random)));
        const ty_vec origin = ty_mad(center, random_unit(&random), (float)away);
        ty_hit hit;
        if (!ty_accel_intersect(mesh, origin, ty_normalize(ty_sub(target, origin)), TY_FLOAT_MAX, &hit)) continue;
        ++hits;
        check_leaving(mesh, &hit, radius, &random);
    }
    assert_true(hits > 100);
    ty_accel_destroy(mesh);
}

static ty_shape_def turned_quad(double x, double y, double z, double size) {
    const double origin[3] = {-size / 2, -size / 2, 0}, u[3] = {size, 0, 0}, v[3] = {0, size, 0};
    const double move[3] = {x, y, z}, turn[3] = {25, 40, -60}, one[3] = {1, 1, 1};
    ty_shape_def shape = quad(origin, u, v);
    shape.transform = ty_affine_compose(move, turn, one);
    return shape;
}

static void leaving_surfaces_near_the_origin(void** state) {
    const ty_vec zero = ty_vec_make(0, 0, 0);
    check_leaving_shape(*state, turned_quad(0, 0, 0, 2), zero, 1, 5);
    check_leaving_shape(*state, box(-1, -1, -1, 1, 1, 1), zero, 1, 5);
    check_leaving_shape(*state, sphere(0, 0, 0, 1), zero, 1, 5);
}

static void leaving_small_surfaces(void** state) {
    const ty_vec zero = ty_vec_make(0, 0, 0);
    check_leaving_shape(*state, turned_quad(0, 0, 0, 1e-3), zero, 5e-4, 1);
    check_leaving_shape(*state, box(-1e-3, -1e-3, -1e-3, 1e-3, 1e-3, 1e-3), zero, 1e-3, 1);
    check_leaving_shape(*state, sphere(0, 0, 0, 1e-3), zero, 1e-3, 1);
}

static void leaving_surfaces_far_from_the_origin(void** state) {
    const ty_vec there = ty_vec_make(1e4f, -7e3f, 5e3f);
    check_leaving_shape(*state, turned_quad(1e4, -7e3, 5e3, 4), there, 2, 20);
    check_leaving_shape(*state, box(9998, -7002, 4998, 10002, -6998, 5002), there, 2, 20);
    check_leaving_shape(*state, sphere(1e4, -7e3, 5e3, 2), there, 2, 20);
}

/* The ray's length is what rounds the hit point. */
static void leaving_surfaces_seen_from_afar(void** state) {
    const ty_vec zero = ty_vec_make(0, 0, 0);
    check_leaving_shape(*state, turned_quad(0, 0, 0, 2), zero, 1, 1e4);
    check_leaving_shape(*state, box(-1, -1, -1, 1, 1, 1), zero, 1, 1e4);
    check_leaving_shape(*state, sphere(0, 0, 0, 1), zero, 1, 1e4);
}

/* The surface's size is what rounds the hit point. */
static void leaving_wide_surfaces(void** state) {
    const ty_vec zero = ty_vec_make(0, 0, 0);
    check_leaving_shape(*state, turned_quad(0, 0, 0, 2e4), zero, 1, 5);
    check_leaving_shape(*state, sphere(0, -1e4, 0, 1e4), zero, 1, 5);
}

/* The same ground as one level quad: nothing rounds, so nothing needs to stand off. */
static void leaving_level_ground_stays_close(void** state) {
    const double origin[3] = {-1e4, 0, -1e4}, u[3] = {0, 0, 2e4}, v[3] = {2e4, 0, 0};
    const ty_shape_def ground = quad(origin, u, v);
    check_leaving_shape(*state, ground, ty_vec_make(0, 0, 0), 1, 5);
    ty_accel* mesh = make_mesh(*state, &ground, 1);
    ty_hit hit;
    assert_true(ty_accel_intersect(mesh, ty_vec_make(1, 2, 3), ty_vec_make(0.6f, -0.8f, 0), TY_FLOAT_MAX, &hit));
    const ty_vec start = ty_hit_leave(&hit, ty_vec_make(0, 1, 0));
    assert_true(start.y > 0 && start.y < 1e-4f);
    ty_accel_destroy(mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_meet_quads),
        cmocka_unit_test(rays_meet_boxes),
        cmocka_unit_test(rays_meet_spheres),
        cmocka_unit_test(quads_face_the_u_cross_v_side),
        cmocka_unit_test(hits_name_shape_and_part),
        cmocka_unit_test(no_shapes_are_no_mesh),
        cmocka_unit_test(leaving_surfaces_near_the_origin),
        cmocka_unit_test(leaving_small_surfaces),
        cmocka_unit_test(leaving_surfaces_far_from_the_origin),
        cmocka_unit_test(leaving_surfaces_seen_from_afar),
        cmocka_unit_test(leaving_wide_surfaces),
        cmocka_unit_test(leaving_level_ground_stays_close),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
