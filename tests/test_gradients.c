/* Gradients of fld by adjoint solves against central differences of the solves themselves. */
#include "gradient_maker.h"

static void gray_media_and_lights(void** state) {
    parameters p = gray();
    check_all(*state, &p, true);
}

static void coloured_media_and_lights(void** state) {
    parameters p = colored();
    p.lamps = 1;
    p.def.resolution = 12;
    check_all(*state, &p, false);
}

static void every_limiter(void** state) {
    for (int limiter = TY_FLD_LIMITER_NONE; limiter < TY_FLD_LIMITER_LEVERMORE_POMRANING; ++limiter) {
        parameters p = gray();
        p.def.limiter = (ty_fld_limiter)limiter;
        check_all(*state, &p, true);
    }
}

static void voxels_of_density(void** state) {
    parameters p = gray();
    p.def.resolution = TY_AUTO;
    check_voxels(*state, p);
}

/* Different weights of channels of gray media, so that channels share extinction, but no adjoint. */
static void points_and_spots(void** state) {
    parameters p = gray();
    p.lamps = 1;
    p.def.resolution = 12;
    check_all(*state, &p, false);
}

static void voxels_around_points(void** state) {
    parameters p = gray();
    p.def.resolution = TY_AUTO;
    p.lamps = 1;
    check_voxels(*state, p);
}

/* ---- threads and progress ---- */

static void threads_do_not_matter(void** state) {
    (void)state;
    parameters p = colored();
    p.def.resolution = 96; /* so that slabs and boxes are divided among threads */
    p.def.environment_beams = 3;
    p.def.tolerance = 1e-4;
    p.lamps = 1;
    check_threads(&p);
}

static bool stop(void* user, const ty_progress* progress) {
    ++*(int*)user;
    return strcmp(progress->stage, "adjoint") != 0;
}

static void a_gradient_is_cancelled(void** state) {
    double weights[3 * CELLS];
    int calls = 0;
    parameters p = gray();
    ty_gradient* gradient = NULL;
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_fld* light = solve(scene, &p).fld;
    ty_fld_def def = p.def;
    def.progress = stop;
    def.progress_user = &calls;
    assert_int_equal(ty_fld_gradient(light, scene, &def, from, to, cells_size, weights, &gradient, NULL), TY_CANCELLED);
    assert_null(gradient);
    assert_true(calls > 0);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* ---- refusals ---- */

static void refuse(const ty_scene* scene, const ty_fld* light, const ty_fld_def* def, const char* words) {
    double weights[3 * CELLS] = {0};
    ty_gradient* gradient = NULL;
    assert_int_equal(ty_fld_gradient(light, scene, def, from, to, cells_size, weights, &gradient, NULL),
                     TY_ERROR_ARGUMENT);
    assert_null(gradient);
    assert_error(ty_scene_context(scene), words);
}

static void what_has_no_gradient_is_refused(void** state) {
    parameters p = gray();
    p.def.resolution = 8;
    ty_scene* scene = make(*state, &p);
    ty_fld* light = solve(scene, &p).fld;
    ty_scene* surfaces = foggy_scene(*state);
    ty_fld* between = solve(surfaces, &p).fld;
    refuse(surfaces, between, &p.def, "scenes with surfaces");
    ty_fld_destroy(between);
    ty_scene_destroy(surfaces);

    ty_fld_def other = p.def;
    other.resolution = 12;
    refuse(scene, light, &other, "other options");
    other = p.def;
    other.ratio = 4;
    refuse(scene, light, &other, "above 3");
    for (int c = 0; c < 3; ++c) p.sigma_s[c] = 20;
    ty_scene* moved = make(*state, &p);
    refuse(moved, light, &p.def, "no solution");
    ty_scene_destroy(moved);

    /* A medium without voxels has no derivatives by them. */
    double weights[3 * CELLS] = {1}, voxels[1], sigma_s[3], sigma_a[3], g[3];
    ty_gradient_stats stats = ty_default_gradient_stats();
    for (int c = 0; c < 3; ++c) p.sigma_s[c] = 3;
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    assert_int_equal(ty_gradient_density(gradient, scene, 0, voxels), TY_ERROR_ARGUMENT);
    assert_error(*state, "no voxels");
    assert_int_equal(ty_gradient_medium(gradient, scene, 1, sigma_s, sigma_a, g), TY_ERROR_ARGUMENT);
    assert_error(*state, "media[1]");
    assert_int_equal(ty_gradient_cells(gradient, TY_GRADIENT_G, 1, voxels), TY_ERROR_ARGUMENT);
    assert_error(*state, "plane 1");
    assert_int_equal(ty_gradient_light(gradient, 2, g), TY_ERROR_ARGUMENT);
    assert_error(*state, "lights[2]");
    ty_gradient_destroy(gradient);
    ty_fld_destroy(light);
    ty_scene_destroy(scene);
}

/* The sum over cells of the derivatives by albedo and g is that by the medium's; so is that by extinction at a constant
 * albedo. */
static void cells_add_up_to_media(void** state) {
    double weights[3 * CELLS], sigma_s[3], sigma_a[3], g[3], values[16 * 16 * 16], sums[3] = {0};
    ty_gradient_stats stats = ty_default_gradient_stats();
    parameters p = gray();
    make_weights(weights, true);
    ty_scene* scene = make(*state, &p);
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    double lower[3], upper[3];
    int32_t size[3];
    ty_gradient_box(gradient, lower, upper, size);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(ty_gradient_cells(gradient, (ty_gradient_coefficient)i, 0, values), TY_OK);
        for (int n = 0; n < size[0] * size[1] * size[2]; ++n) sums[i] += values[n];
    }
    assert_int_equal(ty_gradient_medium(gradient, scene, 0, sigma_s, sigma_a, g), TY_OK);
    const double sigma_t = p.sigma_s[0] + p.sigma_a[0], albedo = p.sigma_s[0] / sigma_t;
    assert_close(sums[0], albedo * sigma_s[0] + (1 - albedo) * sigma_a[0], 1e-5 * fabs(sigma_a[0]));
    assert_close(sums[1], sigma_t * (sigma_s[0] - sigma_a[0]), 1e-5 * fabs(sigma_t * sigma_a[0]));
    assert_close(sums[2], g[0], 1e-4 * fabs(g[0]));
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gray_media_and_lights),
        cmocka_unit_test(coloured_media_and_lights),
        cmocka_unit_test(every_limiter),
        cmocka_unit_test(voxels_of_density),
        cmocka_unit_test(points_and_spots),

        cmocka_unit_test(voxels_around_points),
        cmocka_unit_test(cells_add_up_to_media),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(a_gradient_is_cancelled),
        cmocka_unit_test(what_has_no_gradient_is_refused),
    };
    return cmocka_run_group_tests_name("gradients", tests, start_context, stop_context);
}
