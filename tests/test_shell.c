/* Shells: how long rays are inside, holes, coverage of cells. */
#include "checks.h"
#include "triangle_maker.h"

#include "scene/scene.h"
#include "scene/surfaces/closed_mesh.h"
#include "scene/media/spans.k.h"

static const double zero[3] = {0, 0, 0};

/* A committed scene of one medium, with what is to be measured in it. */
static ty_scene* medium_scene(ty_context* context, const ty_medium_def* def) {
    ty_scene* scene = make_scene(context);
    if (ty_scene_add_medium(scene, def) != TY_OK) fail_msg("%s", ty_take_error(context));
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static ty_scene* shell_scene(ty_context* context, const made_mesh* mesh) {
    ty_medium_def def = ty_default_medium_def();
    def.bounds = TY_BOUNDS_SHELL;
    def.sigma_a[0] = 1;
    if (made_shell(context, mesh, &def.shell) != TY_OK) fail_msg("%s", ty_take_error(context));
    ty_scene* scene = medium_scene(context, &def);
    ty_closed_mesh_release(def.shell);
    return scene;
}

static double inside_length(const ty_scene* scene, ty_vec origin, ty_vec direction, double far) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    ty_spans spans;
    ty_spans_find(view->media, view->medium_count, origin, direction, (float)far, &spans);
    double sum = 0;
    for (int32_t i = 0; i < spans.count; ++i) {
        assert_true(spans.enter[i] >= 0 && (double)spans.leave[i] <= far);
        sum += (double)spans.leave[i] - (double)spans.enter[i];
    }
    return sum;
}

typedef struct stretch {
    double enter, leave;
} stretch;

/* Where a ray is inside a convex part of a mesh, by the planes of its triangles. */
static stretch convex_stretch(const made_mesh* mesh, int64_t first, int64_t end, ty_vec origin, ty_vec way,
                              double far) {
    const double o[3] = {(double)origin.x, (double)origin.y, (double)origin.z};
    const double d[3] = {(double)way.x, (double)way.y, (double)way.z};
    stretch inside = {0, far};
    for (int64_t i = first; i < end; ++i) {
        const float *a = made_corner(mesh, i, 0), *b = made_corner(mesh, i, 1), *c = made_corner(mesh, i, 2);
        double height = 0, along = 0;
        for (int x = 0; x < 3; ++x) {
            const int y = (x + 1) % 3, z = (x + 2) % 3;
            const double normal = ((double)b[y] - (double)a[y]) * ((double)c[z] - (double)a[z]) -
                                  ((double)b[z] - (double)a[z]) * ((double)c[y] - (double)a[y]);
            height += normal * (o[x] - (double)a[x]);
            along += normal * d[x];
        }
        if (along > 0) inside.leave = fmin(inside.leave, -height / along);
        if (along < 0) inside.enter = fmax(inside.enter, -height / along);
        if (along == 0 && height > 0) inside.leave = 0;
    }
    if (inside.leave < inside.enter) inside.leave = inside.enter;
    return inside;
}

static double length_of(stretch s) {
    return s.leave - s.enter;
}

static double common_length(stretch a, stretch b) {
    return fmax(0, fmin(a.leave, b.leave) - fmax(a.enter, b.enter));
}

/* ---- rays ---- */

/* Random rays from outside and inside, some of them cut short. */
static void random_ray(uint64_t* random, ty_vec* origin, ty_vec* way, double* far) {
    *origin = ty_scale(random_unit(random), (float)uniform_in(random, 0, 4));
    const ty_vec target = ty_scale(random_unit(random), (float)uniform_in(random, 0, 1.2));
    *way = ty_normalize(ty_sub(target, *origin));
    *far = uniform(random) < 0.3 ? (double)(float)uniform_in(random, 0.1, 4) : 100;
}

/* Random rays through vertices, middles of edges, and places on them. */
static void edge_ray(const made_mesh* mesh, uint64_t* random, ty_vec* origin, ty_vec* way, double* far) {
    const int64_t triangle = (int64_t)(uniform(random) * (double)mesh->triangles);
    const int corner = (int)(3 * uniform(random)), kind = (int)(3 * uniform(random));
    const ty_vec a = ty_vec_load(made_corner(mesh, triangle, corner));
    const ty_vec b = ty_vec_load(made_corner(mesh, triangle, (corner + 1) % 3));
    const float along = kind == 0 ? 0 : kind == 1 ? 0.5f : (float)uniform(random);
    random_ray(random, origin, way, far);
    *far = 100;
    if (uniform(random) < 0.5) { /* exactly there */
        const int axis = (int)(3 * uniform(random));
        *way = ty_vec_make(axis == 0, axis == 1, axis == 2);
        *origin = ty_mad(ty_mad(a, ty_sub(b, a), along), *way, -4);
    } else {
        *way = ty_normalize(ty_sub(ty_mad(a, ty_sub(b, a), along), *origin));
    }
}

static void check_convex(ty_context* context, const made_mesh* mesh) {
    ty_scene* scene = shell_scene(context, mesh);
    uint64_t random = 5;
    for (int i = 0; i < 6000; ++i) {
        ty_vec origin, way;
        double far;
        if (i % 2 == 0)
            random_ray(&random, &origin, &way, &far);
        else
            edge_ray(mesh, &random, &origin, &way, &far);
        const double expected = length_of(convex_stretch(mesh, 0, mesh->triangles, origin, way, far));
        const double found = inside_length(scene, origin, way, far);
        if (fabs(found - expected) < 3e-5) continue;
        /* Along a face, either side is right. */
        const ty_vec aside = ty_mad(origin, random_unit(&random), 1e-5f);
        const double other = length_of(convex_stretch(mesh, 0, mesh->triangles, aside, way, far));
        if (fabs(found) < 3e-5 || fabs(found - other) < 1e-3) {
            assert_true(i % 2 == 1 && (fabs(way.x) == 1 || fabs(way.y) == 1 || fabs(way.z) == 1));
            continue;
        }
        fail_msg("ray %d from (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g): %g inside, not %g", i, (double)origin.x,
                 (double)origin.y, (double)origin.z, (double)way.x, (double)way.y, (double)way.z, found, expected);
    }
    ty_scene_destroy(scene);
}

static void rays_cross_cubes(void** state) {
    static const double low[3] = {-1, -0.5, -0.75}, high[3] = {0.5, 1, 0.25};
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    check_convex(*state, &mesh);
    made_free(&mesh);
}

static void rays_cross_spheres(void** state) {
    for (int n = 1; n <= 8; n += 7) {
        made_mesh mesh = made_nothing();
        made_add_sphere(&mesh, zero, 1, n);
        check_convex(*state, &mesh);
        made_free(&mesh);
    }
}

/* Two bodies: the second hollows the first out, or both together. */
static void check_two(ty_context* context, const made_mesh* mesh, int64_t second, bool hollow) {
    ty_scene* scene = shell_scene(context, mesh);
    uint64_t random = 6;
    for (int i = 0; i < 4000; ++i) {
        ty_vec origin, way;
        double far;
        random_ray(&random, &origin, &way, &far);
        const stretch a = convex_stretch(mesh, 0, second, origin, way, far);
        made_mesh turned = *mesh;
        if (hollow) made_turn(&turned, second);
        const stretch b = convex_stretch(&turned, second, mesh->triangles, origin, way, far);
        if (hollow) made_turn(&turned, second);
        const double common = common_length(a, b);
        const double expected = hollow ? length_of(a) - common : length_of(a) + length_of(b) - common;
        const double found = inside_length(scene, origin, way, far);
        if (fabs(found - expected) > 5e-5)
            fail_msg("ray %d from (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g): %g inside, not %g", i, (double)origin.x,
                     (double)origin.y, (double)origin.z, (double)way.x, (double)way.y, (double)way.z, found, expected);
    }
    ty_scene_destroy(scene);
}

static void shells_may_be_hollow(void** state) {
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 1, 4);
    const int64_t second = mesh.triangles;
    made_add_sphere(&mesh, zero, 0.6, 3);
    made_turn(&mesh, second);
    check_two(*state, &mesh, second, true);
    made_free(&mesh);
}

static void shells_may_overlap(void** state) {
    static const double aside[3] = {0.5, 0.3, -0.2};
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 0.8, 4);
    const int64_t second = mesh.triangles;
    made_add_sphere(&mesh, aside, 0.7, 3);
    check_two(*state, &mesh, second, false);
    made_free(&mesh);
}

/* Crossings at one distance are several: two boxes on one floor, one within the other at three faces, and the same box
 * twice. */
static void shells_may_touch(void** state) {
    static const double low[3][3] = {{0.1, -0.8, -0.4}, {-0.9, -0.8, -0.7}, {-0.9, -0.8, -0.7}};
    static const double high[3][3] = {{1.2, 0.7, 0.9}, {0.2, 0.1, 0.3}, {0.4, 0.5, 0.6}};
    static const double base_low[3] = {-0.9, -0.8, -0.7}, base_high[3] = {0.4, 0.5, 0.6};
    for (int i = 0; i < 3; ++i) {
        made_mesh mesh = made_nothing();
        made_add_box(&mesh, base_low, base_high);
        const int64_t second = mesh.triangles;
        made_add_box(&mesh, low[i], high[i]);
        check_two(*state, &mesh, second, false);
        made_free(&mesh);
    }
}

/* Forty plates in a row: what is nearest counts, also from within the first. */
static void many_crossings_keep_the_nearest(void** state) {
    made_mesh mesh = made_nothing();
    for (int i = 0; i < 40; ++i) {
        const double low[3] = {i, -1, -1}, high[3] = {i + 0.5, 1, 1};
        made_add_box(&mesh, low, high);
    }
    ty_scene* scene = shell_scene(*state, &mesh);
    static const double from[3] = {-1, 0.25, 0.75};
    for (int i = 0; i < 3; ++i) {
        const ty_vec origin = ty_vec_make((float)from[i], 0.3f, 0.2f), way = ty_vec_make(1, 0, 0);
        const double expected = i == 1 ? 0.25 + 31 * 0.5 : 32 * 0.5;
        assert_close(inside_length(scene, origin, way, 100), expected, 1e-4);
        assert_close(inside_length(scene, origin, way, 10 - from[i]), 5 - fmax(0, fmin(0.5, from[i])), 1e-4);
    }
    ty_scene_destroy(scene);
    made_free(&mesh);
}

/* A turned, mirrored, stretched shell is inside out nowhere. */
static void shells_follow_their_transform(void** state) {
    static const double low[3] = {-1, -0.5, -0.75}, high[3] = {0.5, 1, 0.25};
    static const double move[3] = {0.3, -0.2, 0.1}, turn[3] = {30, -50, 110}, scale[3] = {0.7, -0.9, 1.3};
    ty_medium_def def = ty_default_medium_def(), box = box_medium(low, high, 0, 1);
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    def.bounds = TY_BOUNDS_SHELL;
    def.transform = box.transform = ty_affine_compose(move, turn, scale);
    assert_int_equal(made_shell(*state, &mesh, &def.shell), TY_OK);
    ty_scene *scene = medium_scene(*state, &def), *boxed = medium_scene(*state, &box);
    uint64_t random = 9;
    for (int i = 0; i < 2000; ++i) {
        ty_vec origin, way;
        double far;
        random_ray(&random, &origin, &way, &far);
        assert_close(inside_length(scene, origin, way, far), inside_length(boxed, origin, way, far), 3e-5);
    }
    const ty_scene_info info = ty_scene_get_info(scene), boxed_info = ty_scene_get_info(boxed);
    for (int a = 0; a < 3; ++a) {
        assert_close(info.lower[a], boxed_info.lower[a], 1e-6);
        assert_close(info.upper[a], boxed_info.upper[a], 1e-6);
    }
    ty_scene_destroy(scene);
    ty_scene_destroy(boxed);
    ty_closed_mesh_release(def.shell);
    made_free(&mesh);
}

/* ---- creation ---- */

typedef struct heard {
    int count;
    char text[256];
} heard;

static void hear(void* user, ty_log_level level, const char* text) {
    heard* log = user;
    assert_int_equal(level, TY_LOG_WARNING);
    ++log->count;
    strncpy(log->text, text, sizeof log->text - 1);
}

static void open_edges_are_counted(void** state) {
    (void)state;
    static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    heard log = {0};
    ty_context_def context_def = ty_default_context_def();
    context_def.log = hear;
    context_def.log_user = &log;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&context_def, &context), TY_OK);
    made_mesh mesh = made_nothing();
    ty_closed_mesh* shell = NULL;
    made_add_box(&mesh, low, high);
    assert_int_equal(made_shell(context, &mesh, &shell), TY_OK);
    assert_int_equal(log.count, 0);
    ty_closed_mesh_release(shell);
    --mesh.triangles; /* a hole */
    assert_int_equal(made_shell(context, &mesh, &shell), TY_OK);
    assert_int_equal(log.count, 1);
    assert_non_null(strstr(log.text, " 3 of its edges"));
    assert_string_equal(ty_take_error(context), "");
    ty_closed_mesh_release(shell);
    ++mesh.triangles;
    made_turn(&mesh, mesh.triangles - 1); /* one the wrong way round */
    assert_int_equal(made_shell(context, &mesh, &shell), TY_OK);
    assert_int_equal(log.count, 2);
    assert_non_null(strstr(log.text, " 3 of its edges"));
    ty_closed_mesh_release(shell);
    made_free(&mesh);
    ty_context_destroy(context);
}

static void wrong_shells_are_refused(void** state) {
    static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    ty_closed_mesh* shell = NULL;
    assert_int_equal(ty_closed_mesh_create(*state, mesh.positions, 36, mesh.indices, 0, &shell), TY_ERROR_ARGUMENT);
    assert_error(*state, "shell: 36 vertices and 0 triangles");
    assert_int_equal(ty_closed_mesh_create(*state, NULL, 36, mesh.indices, 12, &shell), TY_ERROR_ARGUMENT);
    assert_error(*state, "shell: positions or indices are NULL");
    assert_int_equal(ty_closed_mesh_create(*state, mesh.positions, 35, mesh.indices, 12, &shell), TY_ERROR_ARGUMENT);
    assert_error(*state, "shell: indices[35] is 35, and there are 35 vertices");
    mesh.positions[7] = NAN;
    assert_int_equal(made_shell(*state, &mesh, &shell), TY_ERROR_ARGUMENT);
    assert_error(*state, "shell: the position of vertex 2");
    assert_null(shell);
    assert_null(ty_closed_mesh_retain(NULL));
    ty_closed_mesh_release(NULL);
    made_free(&mesh);
}

/* ---- coverage ---- */

/* Sum of coverage times the cells' volume, over a box that holds the medium. */
static double covered(ty_context* context, const ty_medium_def* def, int32_t samples, ty_grid** out) {
    static const double lower[3] = {-1.3, -1.2, -1.1}, upper[3] = {1.4, 1.3, 1.2};
    static const int32_t size[3] = {9, 11, 7};
    ty_scene* scene = medium_scene(context, def);
    assert_int_equal(ty_medium_create_coverage(scene, 0, lower, upper, size, samples, out), TY_OK);
    double sum = 0;
    for (int k = 0; k < 7; ++k)
        for (int j = 0; j < 11; ++j)
            for (int i = 0; i < 9; ++i) {
                const double value = (double)ty_grid_voxel(*out, i, j, k);
                assert_true(value >= 0 && value <= 1);
                sum += value;
            }
    assert_false(ty_grid_get_info(*out).placed);
    ty_scene_destroy(scene);
    return sum * 2.7 / 9 * 2.5 / 11 * 2.3 / 7;
}

static void boxes_cover_cells(void** state) {
    static const double low[3] = {-0.85, -1.2, -0.4}, high[3] = {0.95, 0.3, 0.8};
    const ty_medium_def def = box_medium(low, high, 1, 0);
    ty_grid* grid = NULL;
    assert_close(covered(*state, &def, 64, &grid), 1.8 * 1.5 * 1.2, 0.01);
    /* Cell 1 along x is [-1, -0.7], 7 is [0.8, 1.1]; j 3 and k 3 are inside. */
    assert_close(ty_grid_voxel(grid, 0, 3, 3), 0, 0);
    assert_close(ty_grid_voxel(grid, 1, 3, 3), 0.5, 1e-5);
    assert_close(ty_grid_voxel(grid, 4, 3, 3), 1, 1e-5);
    assert_close(ty_grid_voxel(grid, 7, 3, 3), 0.5, 1e-5);
    assert_close(ty_grid_voxel(grid, 8, 3, 3), 0, 0);
    ty_grid_release(grid);
}

static void spheres_and_shells_cover_cells(void** state) {
    static const double center[3] = {0.1, 0.05, -0.02};
    ty_medium_def def = ty_default_medium_def();
    def.bounds = TY_BOUNDS_SPHERE;
    memcpy(def.sphere_center, center, sizeof center);
    def.sphere_radius = 0.9;
    ty_grid *grid = NULL, *meshed = NULL;
    assert_close(covered(*state, &def, 16, &grid), 4.1887902 * 0.729, 0.005);
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, center, 0.9, 24);
    def.bounds = TY_BOUNDS_SHELL;
    assert_int_equal(made_shell(*state, &mesh, &def.shell), TY_OK);
    assert_close(covered(*state, &def, 16, &meshed), made_volume(&mesh), 0.005);
    for (int i = 0; i < 9 * 11 * 7; ++i)
        assert_close(ty_grid_voxel(meshed, i % 9, i / 9 % 11, i / 99), ty_grid_voxel(grid, i % 9, i / 9 % 11, i / 99),
                     0.02);
    ty_grid_release(grid);
    ty_grid_release(meshed);
    ty_closed_mesh_release(def.shell);
    made_free(&mesh);
}

static void wrong_coverages_are_refused(void** state) {
    static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    static const int32_t size[3] = {2, 2, 2}, none[3] = {2, 0, 2};
    const ty_medium_def def = box_medium(low, high, 1, 0);
    ty_scene* scene = medium_scene(*state, &def);
    ty_grid* grid = NULL;
    assert_int_equal(ty_medium_create_coverage(scene, 1, low, high, size, 4, &grid), TY_ERROR_ARGUMENT);
    assert_error(*state, "there is no medium 1");
    assert_int_equal(ty_medium_create_coverage(scene, -1, low, high, size, 4, &grid), TY_ERROR_ARGUMENT);
    assert_error(*state, "there is no medium -1");
    assert_int_equal(ty_medium_create_coverage(scene, 0, low, low, size, 4, &grid), TY_ERROR_ARGUMENT);
    assert_error(*state, "coverage: 2 cells from 0 to 0 along x");
    assert_int_equal(ty_medium_create_coverage(scene, 0, low, high, none, 4, &grid), TY_ERROR_ARGUMENT);
    assert_error(*state, "coverage: 0 cells from 0 to 1 along y");
    for (int32_t samples = 0; samples <= 65; samples += 65) {
        assert_int_equal(ty_medium_create_coverage(scene, 0, low, high, size, samples, &grid), TY_ERROR_ARGUMENT);
        assert_error(*state, "coverage: samples");
    }
    assert_int_equal(ty_scene_add_medium(scene, &def), TY_OK);
    assert_int_equal(ty_medium_create_coverage(scene, 0, low, high, size, 4, &grid), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    assert_null(grid);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_cross_cubes),
        cmocka_unit_test(rays_cross_spheres),
        cmocka_unit_test(shells_may_be_hollow),
        cmocka_unit_test(shells_may_overlap),
        cmocka_unit_test(shells_may_touch),
        cmocka_unit_test(many_crossings_keep_the_nearest),
        cmocka_unit_test(shells_follow_their_transform),
        cmocka_unit_test(open_edges_are_counted),
        cmocka_unit_test(wrong_shells_are_refused),
        cmocka_unit_test(boxes_cover_cells),
        cmocka_unit_test(spheres_and_shells_cover_cells),
        cmocka_unit_test(wrong_coverages_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
