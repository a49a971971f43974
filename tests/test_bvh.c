/* Our own hierarchy against Embree, ray by ray: shapes, random triangles, alpha, closed meshes, other people's scenes.
 */
#include "checks.h"
#include "files.h"
#include "triangle_maker.h"

#include "scene/scene.h"
#include "scene/surfaces/bvh.h"
#include "scene/surfaces/closed_mesh.h"

#include <tyndall/io.h>

/* Differences are allowed for rays that pass an edge or a sphere's rim within rounding, or surfaces that coincide.
 * Measured: none, and distances within 4e-6 of the extent; grazing ones of the staircase, 4e-5. */
typedef struct comparison {
    int rays, hits, unlike;
    double worst; /* difference of distances over the scene's extent */
} comparison;

static ty_bvh_data* hierarchy_of(const ty_scene* scene) {
    const ty_committed_surfaces* surfaces = &scene->surfaces;
    const ty_accel_input input = {.shapes = surfaces->shapes,
                                  .shape_count = surfaces->shape_count,
                                  .meshes = scene->meshes,
                                  .mesh_count = scene->mesh_count,
                                  .surfaces = surfaces->surfaces};
    ty_bvh_data* data = NULL;
    assert_int_equal(ty_bvh_create(scene->context, &input, &data), TY_OK);
    return data;
}

/* Rays between random points of the box around all surfaces, and along the axes, which quads and boxes have. */
static void random_ray(const double low[3], const double high[3], uint64_t* random, ty_vec* origin, ty_vec* way) {
    double from[3], to[3];
    for (int a = 0; a < 3; ++a) {
        const double size = high[a] - low[a];
        from[a] = uniform_in(random, low[a] - 0.1 * size, high[a] + 0.1 * size);
        to[a] = uniform_in(random, low[a], high[a]);
    }
    *origin = ty_vec_make((float)from[0], (float)from[1], (float)from[2]);
    *way = ty_normalize(ty_sub(ty_vec_make((float)to[0], (float)to[1], (float)to[2]), *origin));
    const double choice = uniform(random);
    if (choice < 0.05) *way = ty_vec_make(0, choice < 0.025 ? 1.0f : -1.0f, 0);
}

static comparison compare(const ty_scene* scene, int rays) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    ty_bvh_data* data = hierarchy_of(scene);
    comparison out = {.rays = rays};
    uint64_t random = 9;
    double low[3], high[3], extent = 0;
    ty_scene_surface_extent(scene, low, high);
    for (int a = 0; a < 3; ++a) extent = fmax(extent, high[a] - low[a]);
    for (int i = 0; i < rays; ++i) {
        ty_vec origin, way;
        ty_hit expected, hit;
        ty_bvh_hit found;
        random_ray(low, high, &random, &origin, &way);
        const bool hits = ty_accel_intersect(view->mesh, origin, way, TY_FLOAT_MAX, &expected);
        const bool is_found = ty_bvh_trace(&data->bvh, origin, way, TY_FLOAT_MAX, 0, &found);
        out.hits += hits;
        if (is_found) ty_bvh_complete(&data->bvh, origin, way, &found, &hit);
        if (hits != is_found || (hits && (expected.surface != hit.surface ||
                                          fabs((double)expected.distance - (double)hit.distance) > 1e-4 * extent))) {
            ++out.unlike;
            continue;
        }
        if (!hits) continue;
        out.worst = fmax(out.worst, fabs((double)expected.distance - (double)hit.distance) / extent);
        ty_bvh_hit any;
        const float before = 0.999f * hit.distance, behind = 1.001f * hit.distance;
        assert_true(ty_bvh_trace(&data->bvh, origin, way, behind, 1, &any));
        if (ty_bvh_trace(&data->bvh, origin, way, before, 1, &any)) ++out.unlike;
    }
    ty_bvh_destroy(data);
    return out;
}

static void check(const char* name, comparison got, double unlike, double worst) {
    printf("%s: %d of %d rays hit, %d unlike, distances within %.1e\n", name, got.hits, got.rays, got.unlike,
           got.worst);
    assert_true(got.hits > got.rays / 4);
    assert_true(got.unlike <= unlike * got.rays);
    assert_true(got.worst <= worst);
}

static void shapes_are_hit_alike(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    uint64_t random = 3;
    for (int i = 0; i < 60; ++i) {
        ty_shape_def shape = ty_default_shape_def();
        shape.kind = (ty_shape_kind)(i % 3);
        shape.radius = uniform_in(&random, 0.05, 0.3);
        for (int a = 0; a < 3; ++a) {
            shape.origin[a] = uniform_in(&random, -1, 1);
            shape.u[a] = uniform_in(&random, 0.1, 0.5);
            shape.v[a] = uniform_in(&random, -0.5, -0.1);
            if (shape.kind == TY_SHAPE_BOX) shape.u[a] += shape.origin[a];
        }
        assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    }
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    check("shapes", compare(scene, 20000), 2e-4, 1e-5);
    ty_scene_destroy(scene);
}

static ty_mesh_def soup_def(made_mesh* mesh, int triangles, uint64_t* random, double size) {
    *mesh = made_nothing();
    for (int i = 0; i < triangles; ++i) {
        double corner[3][3];
        for (int a = 0; a < 3; ++a) corner[0][a] = uniform_in(random, -1, 1);
        for (int k = 1; k < 3; ++k)
            for (int a = 0; a < 3; ++a) corner[k][a] = corner[0][a] + uniform_in(random, -size, size);
        made_add(mesh, corner[0], corner[1], corner[2]);
    }
    return made_def(mesh);
}

static void triangles_are_hit_alike(void** state) {
    ty_context* context = *state;
    uint64_t random = 5;
    for (int round = 0; round < 2; ++round) {
        made_mesh mesh;
        ty_scene* scene = make_scene(context);
        ty_mesh_def def = soup_def(&mesh, 10000, &random, 0.1);
        def.material.albedo[0] = 0.5f;
        if (round == 1) {
            def.material.alpha_mode = TY_ALPHA_BLEND;
            def.material.alpha = 0.5f;
        }
        if (ty_scene_add_mesh(scene, &def) != TY_OK) fail_msg("%s", ty_take_error(context));
        assert_int_equal(ty_scene_commit(scene), TY_OK);
        check(round == 0 ? "triangles" : "half of them by alpha", compare(scene, 20000), 2e-4, 1e-5);
        ty_scene_destroy(scene);
        made_free(&mesh);
    }
}

static void few_primitives_have_a_hierarchy(void** state) {
    ty_context* context = *state;
    for (int count = 1; count < 8; ++count) {
        uint64_t random = (uint64_t)count;
        made_mesh mesh;
        ty_scene* scene = make_scene(context);
        ty_mesh_def def = soup_def(&mesh, count, &random, 3);
        assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
        assert_int_equal(ty_scene_commit(scene), TY_OK);
        const comparison got = compare(scene, 500);
        assert_int_equal(got.unlike, 0);
        ty_scene_destroy(scene);
        made_free(&mesh);
    }
}

/* Triangles in one place can be divided by their number alone. */
static void equal_triangles_have_a_hierarchy(void** state) {
    ty_context* context = *state;
    static const double a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0, 1, 0};
    made_mesh mesh = made_nothing();
    for (int i = 0; i < 3000; ++i) made_add(&mesh, a, b, c);
    ty_scene* scene = make_scene(context);
    ty_mesh_def def = made_def(&mesh);
    assert_int_equal(ty_scene_add_mesh(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_bvh_data* data = hierarchy_of(scene);
    ty_bvh_hit hit;
    assert_true(ty_bvh_trace(&data->bvh, ty_vec_make(0.2f, 0.2f, 1), ty_vec_make(0, 0, -1), TY_FLOAT_MAX, 0, &hit));
    assert_close(hit.distance, 1, 1e-6);
    ty_bvh_destroy(data);
    ty_scene_destroy(scene);
    made_free(&mesh);
}

static void closed_meshes_are_crossed_alike(void** state) {
    ty_context* context = *state;
    static const double zero[3] = {0, 0, 0}, lower[3] = {0.2, 0.1, -0.1}, upper[3] = {0.5, 0.6, 0.4};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 1, 40);
    made_add_box(&mesh, lower, upper);
    ty_closed_mesh* closed = NULL;
    if (made_shell(context, &mesh, &closed) != TY_OK) fail_msg("%s", ty_take_error(context));
    ty_bvh_data* data = NULL;
    assert_int_equal(ty_bvh_create_closed(context, closed->triangles, &data), TY_OK);
    uint64_t random = 2;
    int crossed = 0;
    for (int i = 0; i < 4000; ++i) {
        const ty_vec origin = ty_scale(random_unit(&random), (float)uniform_in(&random, 0, 2));
        const ty_vec way = ty_scale(random_unit(&random), (float)uniform_in(&random, 0.1, 3));
        ty_crossing expected[TY_CROSSINGS_MAX], found[TY_CROSSINGS_MAX];
        int32_t beyond_expected, beyond;
        const int32_t count = ty_accel_crossings(closed->mesh, origin, way, expected, &beyond_expected);
        assert_int_equal(ty_bvh_crossings(&data->bvh, origin, way, found, &beyond), count);
        assert_int_equal(beyond, beyond_expected);
        for (int32_t k = 0; k < count; ++k) assert_true(found[k].t == expected[k].t);
        crossed += count;
    }
    assert_true(crossed > 2000);
    ty_bvh_destroy(data);
    ty_closed_mesh_release(closed);
    made_free(&mesh);
}

static void compare_file(ty_context* context, const char* name) {
    char path[1024];
    ty_scene* scene = make_scene(context);
    const ty_mesh_file_def def = ty_default_mesh_file_def();
    if (ty_scene_add_mesh_file(scene, data_path(name, path), &def) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    check(name, compare(scene, 20000), 2e-4, 1e-4);
    ty_scene_destroy(scene);
}

static void sponza_is_hit_alike(void** state) {
    compare_file(*state, "scenes/sponza_atrium.glb");
}

static void the_staircase_is_hit_alike(void** state) {
    compare_file(*state, "scenes/wooden_staircase.glb");
}

/* Every allocation of a hierarchy may fail. */
static ty_result make_hierarchy(ty_context* context, void* user) {
    static const ty_shape_def* shapes;
    shapes = user;
    const ty_accel_input input = {.shapes = shapes, .shape_count = 2};
    ty_bvh_data* data = NULL;
    const ty_result result = ty_bvh_create(context, &input, &data);
    if (result == TY_OK) ty_bvh_destroy(data);
    return result;
}

static void memory_may_run_out(void** state) {
    (void)state;
    strict_memory memory = {.limit = 1 << 24, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_shape_def shapes[2] = {ty_default_shape_def(), ty_default_shape_def()};
    shapes[0].kind = TY_SHAPE_SPHERE;
    shapes[0].radius = 1;
    shapes[1].u[0] = shapes[1].v[1] = 1;
    assert_true(check_short_memory(context, &memory, make_hierarchy, shapes) >= 8);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes_are_hit_alike),
        cmocka_unit_test(triangles_are_hit_alike),
        cmocka_unit_test(few_primitives_have_a_hierarchy),
        cmocka_unit_test(equal_triangles_have_a_hierarchy),
        cmocka_unit_test(closed_meshes_are_crossed_alike),
        cmocka_unit_test(sponza_is_hit_alike),
        cmocka_unit_test(the_staircase_is_hit_alike),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
