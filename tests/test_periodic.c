/* Periodic boundaries: what they refuse, rays through the cell, grids across its faces, and scenes that repeat. */
#include "fog.h"

#include "scene/scene.h"

#include <stdio.h>

static void set_axes(ty_scene* scene, bool x, bool y, bool z) {
    ty_periodic_def def = ty_default_periodic_def();
    def.axes[0] = x;
    def.axes[1] = y;
    def.axes[2] = z;
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_OK);
}

/* A box of 2 x 1 x 3 m under a sun, repeated along x and z. */
static ty_scene* boxed_scene(ty_context* context) {
    const double lower[3] = {-1, 0, -1}, upper[3] = {1, 1, 2};
    ty_scene* scene = make_scene(context);
    const ty_medium_def fog = box_medium(lower, upper, 2, 0.5f);
    const ty_light_def sun = ty_default_light_def();
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    set_axes(scene, true, false, true);
    return scene;
}

static void wrong_boundaries_are_refused(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_periodic_def def = ty_default_periodic_def();
    def.axes[0] = def.axes[1] = def.axes[2] = true;
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_ERROR_ARGUMENT);
    assert_error(*state, "all three axes");
    def.axes[1] = false;
    def.upper[0] = NAN;
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_ERROR_ARGUMENT);
    assert_error(*state, "periodic.cell[1]");
    def.upper[0] = 0;
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_ERROR_ARGUMENT);
    assert_error(*state, "along x must be given");
    ty_scene_destroy(scene);
}

static void what_cannot_repeat_is_refused(void** state) {
    for (int kind = 0; kind < 4; ++kind) {
        ty_scene* scene = boxed_scene(*state);
        ty_light_def lamp = ty_default_light_def();
        lamp.kind = kind == 0 ? TY_LIGHT_POINT : TY_LIGHT_AREA;
        lamp.u[0] = lamp.v[2] = 1;
        ty_shape_def ball = ty_default_shape_def();
        ball.kind = TY_SHAPE_SPHERE;
        ball.radius = 0.1;
        if (kind == 2) set3f(ball.emission, 1, 1, 1);
        if (kind == 3) {
            ball.gloss.specular = ball.gloss.transmission = 1;
            ball.gloss.solid = true;
        }
        assert_int_equal(kind < 2 ? ty_scene_add_light(scene, &lamp) : ty_scene_add_shape(scene, &ball), TY_OK);
        if (ty_scene_commit(scene) != TY_ERROR_ARGUMENT) fail_msg("kind %d is accepted", kind);
        assert_error(*state, kind == 3 ? "no dielectrics" : "do not repeat");
        ty_scene_destroy(scene);
    }
}

static void other_methods_refuse_them(void** state) {
    ty_scene* scene = boxed_scene(*state);
    ty_image* image = NULL;
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_fld_def fld = ty_default_fld_def();
    assert_int_equal(ty_fld_render(scene, &fld, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fld takes no periodic scenes; the method path does");
    ty_lpv_def lpv = ty_default_lpv_def();
    assert_int_equal(ty_lpv_render(scene, &lpv, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "lpv takes no periodic scenes");
    ty_path_def path = small_def(1);
    path.guide = TY_PATH_GUIDE_DOM;
    assert_int_equal(ty_path_render(scene, &path, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "have no guide");
    ty_choice choice;
    const ty_choose_def choose = ty_default_choose_def();
    assert_int_equal(ty_choose_method(scene, &choose, &choice), TY_OK);
    assert_string_equal(choice.method, "path");
    ty_scene_destroy(scene);
}

static void the_cell_is_that_of_the_media(void** state) {
    ty_scene* scene = boxed_scene(*state);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_periodic_def found = ty_scene_periodic(scene);
    assert_true(found.axes[0] && !found.axes[1] && found.axes[2]);
    assert_close(found.lower[0], -1, 1e-6);
    assert_close(found.upper[0], 1, 1e-6);
    assert_close(found.lower[2], -1, 1e-6);
    assert_close(found.upper[2], 2, 1e-6);
    ty_scene_destroy(scene);
}

/* Pieces of a ray join to the whole of it, each in the cell. */
static void rays_go_on_at_the_opposite_face(void** state) {
    const ty_periodic_view cell = {5, {-1, 0, -1}, {1, 1, 2}};
    uint64_t random = 1;
    (void)state;
    for (int n = 0; n < 1000; ++n) {
        const ty_vec origin = ty_vec_make((float)uniform_in(&random, -9, 9), (float)uniform_in(&random, -1, 2),
                                          (float)uniform_in(&random, -9, 9));
        const ty_vec direction = random_unit(&random);
        ty_periodic_walk walk;
        const bool meets = ty_periodic_walk_begin(&walk, &cell, origin, direction);
        const bool inside = origin.y > 0 && origin.y < 1;
        assert_int_equal(meets, inside || (origin.y <= 0 ? direction.y > 0 : direction.y < 0));
        if (!meets) continue;
        double end = walk.passed;
        do {
            assert_true(walk.origin.x >= -1 && walk.origin.x <= 1 && walk.origin.z >= -1 && walk.origin.z <= 2);
            assert_true(walk.origin.y > -1e-3f && walk.origin.y < 1.001f);
            assert_close(walk.passed, end, 1e-4 * (1 + end));
            const ty_vec at = ty_periodic_point(&cell, ty_mad(origin, direction, walk.passed + 0.5f * walk.far));
            const ty_vec middle = ty_mad(walk.origin, direction, 0.5f * walk.far);
            const double tolerance = 1e-5 * (10 + (double)walk.passed);
            if (walk.far > 1e-3f && walk.passed < 100) assert_vec_close(middle, at, tolerance);
            end = walk.passed + walk.far;
        } while (ty_periodic_walk_next(&walk, &cell));
        assert_close(origin.y + direction.y * end, direction.y > 0 ? 1 : 0, 1e-4 * (1 + end));
    }
}

static float density_at(const ty_scene* scene, double x, double y, double z) {
    const ty_medium_view* medium = &ty_scene_get_view(scene)->media[0];
    return ty_grid_value(&medium->grid, ty_map_point(medium->to_index, ty_vec_make((float)x, (float)y, (float)z)));
}

/* A grid that spans the cell is interpolated across its faces; the extremes of its bricks account for that. */
static void grids_have_no_seam(void** state) {
    enum { N = 20 };
    static float values[N * N * N];
    uint64_t random = 2;
    for (int i = 0; i < N * N * N; ++i) values[i] = (float)uniform_in(&random, 0, 1);
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = N;
    def.values = values;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(*state, &def, &grid), TY_OK);
    const double lower[3] = {0, 0, 0}, upper[3] = {N, N, N};
    ty_medium_def fog = box_medium(lower, upper, 1, 0);
    fog.density_grid = grid;
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    set_axes(scene, true, false, true);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_medium_view* medium = &ty_scene_get_view(scene)->media[0];
    assert_int_equal(medium->grid.wraps, 5);
    for (int n = 0; n < 200; ++n) {
        const double y = uniform_in(&random, 0, N), z = uniform_in(&random, 0, N);
        assert_close(density_at(scene, 0, y, z), density_at(scene, N, y, z), 1e-5);
        assert_close(density_at(scene, y, z, 0), density_at(scene, y, z, N), 1e-5);
    }
    /* Halfway between the outermost voxels of two opposite faces. */
    assert_close(density_at(scene, 0, 4.5, 6.5), (values[N * (4 + N * 6)] + values[N - 1 + N * (4 + N * 6)]) / 2, 1e-5);
    for (int n = 0; n < 20000; ++n) {
        const ty_vec p =
            ty_vec_make((float)uniform_in(&random, -0.5, N - 0.5), (float)uniform_in(&random, -0.5, N - 0.5),
                        (float)uniform_in(&random, -0.5, N - 0.5));
        const int brick[3] = {(int)((p.x + 1) / TY_BRICK), (int)((p.y + 1) / TY_BRICK), (int)((p.z + 1) / TY_BRICK)};
        const float* extremes =
            medium->extremes + 2 * (brick[0] + medium->grid.bricks[0] * (brick[1] + medium->grid.bricks[1] * brick[2]));
        const float value = ty_grid_value(&medium->grid, p);
        assert_true(value >= extremes[0] - 1e-6f && value <= extremes[1] + 1e-6f);
    }
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* A part of a row of scattering boxes, or all of it. */
static ty_scene* row_of_boxes(ty_context* context, int tiles, bool repeats) {
    ty_scene* scene = make_scene(context);
    ty_light_def sun = ty_default_light_def(), sky = sky_light(0.2f, 0.3f, 0.4f);
    set3(sun.direction, 0.7, -1, 0.2);
    for (int i = -tiles; i <= tiles; ++i) {
        const double lower[3] = {3 * i, 0, -1}, upper[3] = {3 * i + 1, 1, 1};
        ty_medium_def box = box_medium(lower, upper, 2, 0.2f);
        ty_shape_def ball = ty_default_shape_def();
        box.g[0] = box.g[1] = box.g[2] = 0.5f;
        ball.kind = TY_SHAPE_SPHERE;
        ball.radius = 0.4;
        set3(ball.origin, 3 * i + 1.9, 0.4, 0);
        assert_int_equal(ty_scene_add_medium(scene, &box), TY_OK);
        assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    }
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    ty_periodic_def def = ty_default_periodic_def();
    def.axes[0] = repeats;
    def.lower[0] = -0.5;
    def.upper[0] = 2.5;
    assert_int_equal(ty_scene_set_periodic(scene, &def), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Radiance along rays in a periodic scene is that in many copies side by side. */
static void a_cell_is_as_its_copies(void** state) {
    enum { RAYS = 24 };
    ty_scene *tiled = row_of_boxes(*state, 12, false), *cell = row_of_boxes(*state, 0, true);
    double rays[6 * RAYS], radiance[2][3 * RAYS], variance[2][3 * RAYS], square = 0;
    uint64_t random = 3;
    ty_path_def def = ty_default_path_def();
    def.spp = 4096;
    for (int i = 0; i < RAYS; ++i) {
        const double at[3] = {uniform_in(&random, -0.5, 2.5), 0.5, uniform_in(&random, -0.9, 0.9)};
        const ty_vec d = random_unit(&random);
        const double direction[3] = {d.x, fabs((double)d.y) + 0.3, d.z};
        for (int a = 0; a < 3; ++a) {
            rays[6 * i + a] = at[a] + 4 * direction[a];
            rays[6 * i + 3 + a] = direction[a];
        }
    }
    for (int k = 0; k < 2; ++k)
        assert_int_equal(ty_path_radiance(k == 0 ? tiled : cell, &def, rays, RAYS, radiance[k], variance[k]), TY_OK);
    double sums[2] = {0, 0}, errors = 0;
    for (int i = 0; i < 3 * RAYS; ++i) {
        const double off = radiance[1][i] - radiance[0][i], noise = variance[0][i] + variance[1][i] + 1e-12;
        square += off * off / noise;
        sums[0] += radiance[0][i];
        sums[1] += radiance[1][i];
        errors += noise;
    }
    printf("%d rays: mean z^2 %.2f, means %.5f and %.5f +- %.5f\n", RAYS, square / (3 * RAYS), sums[0] / (3 * RAYS),
           sums[1] / (3 * RAYS), sqrt(errors) / (3 * RAYS));
    assert_true(square / (3 * RAYS) < 2.2); /* 24 rays of three channels that are nearly alike: 1 +- 0.29 */
    assert_true(fabs(sums[1] - sums[0]) < 4 * sqrt(3 * errors));
    ty_scene_destroy(tiled);
    ty_scene_destroy(cell);
}

/* Media that absorb nothing, of a grid and homogeneous, and a white ball cannot be seen before an even sky; media that
 * are as bright as it and scatter nothing cannot, either. */
static void an_even_sky_hides_everything(void** state) {
    enum { RAYS = 16 };
    const double lower[3] = {-1, 0, -1}, upper[3] = {1, 1, 2}, low[3] = {-0.5, 0.2, 0}, high[3] = {0.7, 2, 1};
    for (int emitting = 0; emitting < 2; ++emitting) {
        ty_scene* scene = make_scene(*state);
        const float values[8] = {0.1f, 2, 1, 0, 3, 0.5f, 0, 1};
        ty_grid_def def = ty_default_grid_def();
        def.size[0] = def.size[1] = def.size[2] = 2;
        def.values = values;
        ty_grid* grid = NULL;
        assert_int_equal(ty_grid_create(*state, &def, &grid), TY_OK);
        ty_medium_def cloud = box_medium(lower, upper, emitting ? 0 : 3, emitting ? 2 : 0);
        ty_medium_def block = box_medium(low, high, emitting ? 0 : 2, emitting ? 1 : 0);
        const ty_light_def sky = sky_light(1, 1, 1);
        cloud.density_grid = grid;
        cloud.g[0] = cloud.g[1] = cloud.g[2] = 0.8f;
        for (int c = 0; c < 3 && emitting; ++c) cloud.emission[c] = block.emission[c] = 1;
        ty_shape_def ball = ty_default_shape_def();
        ball.kind = TY_SHAPE_SPHERE;
        ball.radius = 0.3;
        set3f(ball.albedo, 1, 1, 1);
        assert_int_equal(ty_scene_add_medium(scene, &cloud), TY_OK);
        assert_int_equal(ty_scene_add_medium(scene, &block), TY_OK);
        assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
        assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
        set_axes(scene, true, false, true);
        assert_int_equal(ty_scene_commit(scene), TY_OK);
        double rays[6 * RAYS], radiance[3 * RAYS], variance[3 * RAYS], sum = 0, noise = 0;
        uint64_t random = 7;
        for (int i = 0; i < RAYS; ++i) {
            const ty_vec d = random_unit(&random);
            const double ray[6] = {
                uniform_in(&random, -5, 5), uniform_in(&random, -0.5, 3), uniform_in(&random, -5, 5), d.x, d.y, d.z};
            memcpy(rays + 6 * i, ray, sizeof ray);
        }
        ty_path_def path = ty_default_path_def();
        path.spp = 1024;
        assert_int_equal(ty_path_radiance(scene, &path, rays, RAYS, radiance, variance), TY_OK);
        for (int i = 0; i < 3 * RAYS; ++i) {
            sum += radiance[i] / (3 * RAYS);
            noise += variance[i] / (3 * RAYS);
        }
        const double error = sqrt(noise / RAYS); /* channels are alike */
        printf("even sky, %s: %.5f +- %.5f\n", emitting ? "emitting" : "scattering", sum, error);
        assert_close(sum, 1, 4 * error + 1e-4);
        assert_true(error < 0.01);
        ty_scene_destroy(scene);
        ty_grid_release(grid);
    }
}

/* First-hit channels, and the light without scattering, pass the faces, too. */
static void channels_pass_the_faces(void** state) {
    ty_scene *tiled = row_of_boxes(*state, 12, false), *cell = row_of_boxes(*state, 0, true);
    ty_image* images[2] = {NULL, NULL};
    ty_path_def def = ty_default_path_def();
    def.spp = 16;
    def.width = 24;
    def.height = 16;
    def.aovs = TY_AOV_DEPTH | TY_AOV_TRANSMITTANCE | TY_AOV_NORMAL | TY_AOV_SURFACE_ALBEDO;
    def.unscattered = true;
    for (int k = 0; k < 2; ++k) {
        ty_scene* scene = k == 0 ? tiled : cell;
        ty_camera_def camera = ty_default_camera_def();
        set3(camera.position, 7, 3, 5);
        set3(camera.target, 4, 0.5, 0);
        assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
        assert_int_equal(ty_path_render(scene, &def, &images[k], NULL), TY_OK);
    }
    for (int c = 0; c < ty_image_channel_count(images[0]); ++c) {
        double sums[2] = {0, 0};
        for (int k = 0; k < 2; ++k)
            for (int i = 0; i < 24 * 16; ++i) {
                const double value = (double)ty_image_plane_const(images[k], c)[i];
                if (isfinite(value)) sums[k] += fabs(value);
            }
        assert_close(sums[1], sums[0], 0.02 * sums[0] + 1e-6);
    }
    for (int k = 0; k < 2; ++k) ty_image_destroy(images[k]);
    ty_scene_destroy(tiled);
    ty_scene_destroy(cell);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_boundaries_are_refused),    cmocka_unit_test(what_cannot_repeat_is_refused),
        cmocka_unit_test(other_methods_refuse_them),       cmocka_unit_test(the_cell_is_that_of_the_media),
        cmocka_unit_test(rays_go_on_at_the_opposite_face), cmocka_unit_test(grids_have_no_seam),
        cmocka_unit_test(a_cell_is_as_its_copies),         cmocka_unit_test(channels_pass_the_faces),
        cmocka_unit_test(an_even_sky_hides_everything),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
