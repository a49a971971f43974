/* Rays several pixels apart against a ray per pixel: how far the images differ, and that surfaces, skies, images behind
 * and odd sizes come out right. */
#include "fog.h"
#include "march_maker.h"

static const double low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};

/* Smoke of 16^3 voxels around a ball before a wall and a sky, with a field; seen so that a voxel is about six pixels
 * wide. */
typedef struct smoke {
    ty_scene* scene;
    even_field even;
    ty_march_def def;
} smoke;

enum { WIDE = 121, HIGH = 90 };

/* Within the smoke's box the wall ends with it; outside, light is gathered for it, which is noisy. */
static void add_wall(ty_scene* scene, double z) {
    const double far = z > low[2] ? 1 : 9;
    ty_shape_def wall = quad_shape((const double[3][3]){{-0.3, -far, z}, {far + 0.3, 0, 0}, {0, 2 * far, 0}});
    set3f(wall.albedo, 0.5f, 0.6f, 0.7f);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &wall));
}

/* wall: its z; NAN: there is neither wall nor ball. */
static void begin_smoke(ty_context* context, double wall, smoke* s) {
    s->scene = make_scene(context);
    ty_medium_def medium = box_medium(low, high, 3, 0.5f);
    set3f(medium.sigma_s, 2, 3, 4);
    medium.density_grid = lumpy_grid(context);
    check_result(context, ty_scene_add_medium(s->scene, &medium));
    ty_grid_release(medium.density_grid);
    ty_light_def sky = sky_light(0.2f, 0.3f, 0.5f);
    check_result(context, ty_scene_add_light(s->scene, &sky));
    if (!isnan(wall)) {
        ty_shape_def ball = ty_default_shape_def();
        ball.kind = TY_SHAPE_SPHERE;
        ball.radius = 0.3;
        set3(ball.origin, -0.4, 0.1, 0.4);
        add_wall(s->scene, wall);
        check_result(context, ty_scene_add_shape(s->scene, &ball));
    }
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0.3, 0.2, 4);
    camera.fov_y = 30;
    check_result(context, ty_scene_set_camera(s->scene, &camera));
    check_result(context, ty_scene_commit(s->scene));
    even_begin(&s->even, low, high, 1);
    s->def = march_def(WIDE, HIGH);
    s->def.field = &s->even.field;
}

static ty_image* march_spaced(smoke* s, int32_t spacing, ty_march_stats* stats) {
    s->def.field = &s->even.field;
    s->def.ray_spacing = spacing;
    return march_image(s->scene, &s->def, stats);
}

/* Difference from a ray per pixel over blocks of pixels, and the fraction of its steps. */
static ty_difference compare_spaced(smoke* s, int32_t spacing, int32_t block, double* work) {
    ty_context* context = ty_scene_context(s->scene);
    ty_difference difference;
    ty_march_stats stats[2];
    ty_image *full = march_spaced(s, 1, &stats[0]), *spaced = march_spaced(s, spacing, &stats[1]);
    check_result(context, ty_image_compare(context, spaced, full, block, &difference));
    *work = (double)stats[1].steps / (double)stats[0].steps;
    ty_image_destroy(full);
    ty_image_destroy(spaced);
    return difference;
}

/* ---- errors ---- */

static void smoke_before_a_sky(void** state) {
    static const int32_t spacing[] = {2, 4, 8};
    static const double rmse[] = {0.006, 0.015, 0.03}, of_blocks[] = {0.0015, 0.006, 0.02}, works[] = {0.3, 0.25, 0.4};
    smoke s;
    begin_smoke(*state, NAN, &s);
    for (int i = 0; i < 3; ++i) {
        double work;
        const ty_difference all = compare_spaced(&s, spacing[i], 1, &work);
        const ty_difference blocks = compare_spaced(&s, spacing[i], 8, &work);
        assert_true(all.relative_rmse[3] < rmse[i] && blocks.relative_rmse[3] < of_blocks[i]);
        assert_close(all.mean_ratio[3], 1, 1e-3 * spacing[i]);
        assert_true(work < works[i]);
        assert_true(all.not_finite == 0 && all.differing > 0);
    }
    ty_scene_destroy(s.scene);
}

static void smoke_before_surfaces(void** state) {
    static const double walls[] = {-0.5, -2};
    for (int i = 0; i < 2; ++i) {
        smoke s;
        double work;
        begin_smoke(*state, walls[i], &s);
        for (int32_t spacing = 2; spacing <= 4; spacing += 2) {
            const ty_difference all = compare_spaced(&s, spacing, 1, &work);
            assert_true(all.relative_rmse[3] < (i == 0 ? 0.01 : 0.08) * spacing / 2);
            assert_close(all.mean_ratio[3], 1, 1e-3 * spacing);
        }
        ty_scene_destroy(s.scene);
    }
}

/* Even fog around a ball before a wall, of which every pixel's radiance is smooth but for the edges: no pixel may take
 * fog from a ray that ends elsewhere. */
static void edges_stay_sharp(void** state) {
    const double lower[3] = {-4, -4, -4}, upper[3] = {4, 4, 4};
    ty_scene* scene = foggy_scene(*state);
    ty_camera_def camera = ty_scene_camera(scene);
    even_field even;
    ty_image* images[2];
    even_begin(&even, lower, upper, 1);
    camera.fov_y = 40;
    set3(camera.position, 0, 0.3, 2.5);
    check_result(*state, ty_scene_set_camera(scene, &camera));
    ty_march_def def = march_def(WIDE, HIGH);
    def.field = &even.field;
    def.aovs = TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
    for (int i = 0; i < 2; ++i) {
        def.ray_spacing = i == 0 ? 1 : 4;
        images[i] = march_image(scene, &def, NULL);
    }
    const int32_t depth = ty_image_find_channel(images[0], "depth.Z");
    for (int32_t p = 0; p < WIDE * HIGH; ++p) {
        for (int32_t c = 0; c < 6; ++c)
            assert_close(ty_image_plane_const(images[1], c)[p], ty_image_plane_const(images[0], c)[p], 0.02);
        assert_close(ty_image_plane_const(images[1], depth)[p], ty_image_plane_const(images[0], depth)[p], 1e-4);
    }
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    ty_scene_destroy(scene);
}

/* Images behind media are taken pixel by pixel, however far the rays lie apart. */
static void images_behind_stay_sharp(void** state) {
    smoke s;
    ty_image *behind = NULL, *with[2], *without[2];
    uint64_t seed = 3;
    begin_smoke(*state, -0.5, &s);
    check_result(*state, ty_image_create_rgb(*state, WIDE, HIGH, &behind));
    for (int c = 0; c < 3; ++c)
        for (int p = 0; p < WIDE * HIGH; ++p) ty_image_plane(behind, c)[p] = (float)uniform(&seed);
    for (int i = 0; i < 2; ++i) {
        s.def.unscattered = NULL;
        without[i] = march_spaced(&s, i == 0 ? 1 : 4, NULL);
        s.def.unscattered = behind;
        with[i] = march_spaced(&s, i == 0 ? 1 : 4, NULL);
    }
    /* On the wall, where no sky gives way to the image. */
    for (int c = 0; c < 3; ++c)
        for (int y = HIGH / 3; y < 2 * HIGH / 3; ++y)
            for (int x = WIDE / 2; x < 5 * WIDE / 8; ++x) {
                const int p = y * WIDE + x;
                assert_close(ty_image_plane_const(with[1], c)[p] - ty_image_plane_const(without[1], c)[p],
                             ty_image_plane_const(behind, c)[p], 1e-5);
            }
    ty_difference difference;
    check_result(*state, ty_image_compare(*state, with[1], with[0], 1, &difference));
    assert_true(difference.relative_rmse[3] < 0.01);
    for (int i = 0; i < 2; ++i) {
        ty_image_destroy(with[i]);
        ty_image_destroy(without[i]);
    }
    ty_image_destroy(behind);
    ty_scene_destroy(s.scene);
}

/* ---- sizes, samples, threads ---- */

static void any_size(void** state) {
    static const int32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 5}, {3, 2}, {8, 9}, {17, 16}, {33, 7}};
    smoke s;
    begin_smoke(*state, NAN, &s);
    s.def.aovs = TY_MARCH_AOVS;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        for (int32_t spacing = 2; spacing <= 8; spacing += 3) {
            s.def.width = sizes[i][0];
            s.def.height = sizes[i][1];
            ty_image *full = march_spaced(&s, 1, NULL), *spaced = march_spaced(&s, spacing, NULL);
            const int32_t pixels = sizes[i][0] * sizes[i][1];
            /* The corners have rays in both images, and even the smallest images are no coarser than their pixels. */
            const int32_t corners[4] = {0, sizes[i][0] - 1, pixels - sizes[i][0], pixels - 1};
            for (int c = 0; c < ty_image_channel_count(full); ++c)
                for (int k = 0; k < 4; ++k)
                    assert_close(ty_image_plane_const(spaced, c)[corners[k]], ty_image_plane_const(full, c)[corners[k]],
                                 0.01);
            ty_image_destroy(full);
            ty_image_destroy(spaced);
        }
    ty_scene_destroy(s.scene);
}

static void several_rays_per_pixel(void** state) {
    smoke s;
    double work;
    begin_smoke(*state, -0.5, &s);
    s.def.spp = 3;
    s.def.width = 61;
    s.def.height = 45;
    const ty_difference difference = compare_spaced(&s, 2, 1, &work);
    assert_true(difference.relative_rmse[3] < 0.015 && work < 0.6);
    assert_close(difference.mean_ratio[3], 1, 2e-3);
    ty_scene_destroy(s.scene);
}

static void threads_change_nothing(void** state) {
    (void)state;
    ty_image* images[2];
    ty_context* contexts[2];
    for (int i = 0; i < 2; ++i) {
        smoke s;
        contexts[i] = make_context(i == 0 ? 1 : 4);
        begin_smoke(contexts[i], -2, &s);
        s.def.spp = 2;
        s.def.seed = 5;
        s.def.aovs = TY_MARCH_AOVS;
        images[i] = march_spaced(&s, 3, NULL);
        ty_scene_destroy(s.scene);
    }
    assert_true(same_images(images[0], images[1]));
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    for (int i = 0; i < 2; ++i) ty_context_destroy(contexts[i]);
}

static bool look_on(void* user, const ty_progress* progress) {
    double* last = user;
    assert_true(progress->fraction >= *last && progress->fraction <= 1);
    *last = progress->fraction;
    return true;
}

static bool stop(void* user, const ty_progress* progress) {
    (void)user;
    (void)progress;
    return false;
}

static void reported_cancelled_and_refused(void** state) {
    smoke s;
    double last = 0;
    begin_smoke(*state, NAN, &s);
    s.def.field = &s.even.field;
    s.def.ray_spacing = 2;
    s.def.spp = 2;
    s.def.progress = look_on;
    s.def.progress_user = &last;
    ty_image* image = march_image(s.scene, &s.def, NULL);
    assert_true(last == 1);
    ty_image_destroy(image);
    s.def.progress = stop;
    s.def.width = s.def.height = 3000;
    assert_int_equal(ty_march(s.scene, &s.def, &image, NULL), TY_CANCELLED);
    assert_null(image);
    for (int32_t spacing = 0; spacing <= 9; spacing += 9) {
        s.def.ray_spacing = spacing;
        assert_int_equal(ty_march(s.scene, &s.def, &image, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, "march.ray_spacing");
    }
    ty_scene_destroy(s.scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smoke_before_a_sky),
        cmocka_unit_test(smoke_before_surfaces),
        cmocka_unit_test(edges_stay_sharp),
        cmocka_unit_test(images_behind_stay_sharp),
        cmocka_unit_test(any_size),
        cmocka_unit_test(several_rays_per_pixel),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(reported_cancelled_and_refused),
    };
    return cmocka_run_group_tests_name("march spaced", tests, start_context, stop_context);
}
