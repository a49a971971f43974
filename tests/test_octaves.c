/* Multiple scattering octaves: calls, and the sums of single scattering that they are, in closed form. */
#include "effort.h"
#include "volume_calls.h"

static ty_octaves_def small_octaves(void) {
    ty_octaves_def def = ty_default_octaves_def();
    def.resolution = 12;
    def.width = WIDTH;
    def.height = HEIGHT;
    def.environment_beams = 4;
    return def;
}

/* ---- calls ---- */

VOLUME_CALLS(octaves)

static void make_def(volume_def* def, int variant) {
    def->octaves = small_octaves();
    def->octaves.view_extinction = (ty_octaves_view_extinction)(variant % 2);
    if (variant < 2) return;
    def->octaves.froxels = 6;
    def->octaves.froxel_slices = 5;
}

static const volume_calls calls = {VOLUME_CALLS_OF(octaves), .variants = 4, .resolution = 40, .told = 0.5,
                                   .make_scene = foggy_scene};

static const bad_field bad_fields[] = {VOLUME_BAD_FIELDS(octaves),
                                       VOLUME_BAD_FIELD(octaves, count, FIELD_INT, 9, "octaves.count"),
                                       VOLUME_BAD_FIELD(octaves, froxels, FIELD_INT, 3, "octaves.froxels"),
                                       VOLUME_BAD_FIELD(octaves, froxels, FIELD_INT, 1025, "octaves.froxels"),
                                       VOLUME_BAD_FIELD(octaves, froxel_slices, FIELD_INT, 0, "octaves.froxel_slices")};
static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

static void scattering_may_not_exceed_scaled_extinction(void** state) {
    ty_scene* scene = foggy_scene(*state);
    volume_def def;
    make_def(&def, TY_OCTAVES_VIEW_SCALED);
    void* light = solve_volume(&calls, scene, &def);
    def.octaves.scattering = 0.6;
    refuse_def(&calls, scene, light, &def, "octaves.scattering: 0.6 exceeds octaves.extinction (0.5)");
    call_destroy(light);
    ty_scene_destroy(scene);
}

/* The sun has a field of one plane per channel in each octave; the sky, seen from everywhere, one of fluence and flux.
 */
static void statistics_tell_what_was_done(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_octaves_def def = small_octaves();
    ty_octaves_stats stats = ty_default_octaves_stats();
    ty_image* image = NULL;
    def.count = 3;
    check_result(*state, ty_octaves_render(scene, &def, &image, &stats));
    for (int a = 0; a < 3; ++a) assert_int_equal(stats.size[a], 12);
    assert_int_equal(stats.planes, 3);
    assert_int_equal(stats.lights, 2);
    assert_true(stats.memory_bytes == 3.0 * 12 * 12 * 12 * (3 + 12) * sizeof(float));
    const double parts = stats.medium_seconds + stats.direct_seconds + stats.march_seconds;
    assert_true(stats.isa != NULL && stats.march_seconds > 0);
    assert_close(stats.seconds, parts, 0.5 * parts);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* ---- sums of single scattering ---- */

/* The block of colored fog under a sun that shines straight down, seen along z through its whole width. */
static ty_scene* block_scene(ty_context* context) {
    ty_scene* scene = make_scene(context);
    const ty_medium_def block = colored_block();
    ty_light_def sun = sun_light(1, 2, 3);
    ty_camera_def camera = ty_default_camera_def();
    set3(sun.direction, 0, -1, 0);
    set3(camera.position, 0, 0, 1000);
    set3(camera.target, 0, 0, 0);
    camera.fov_y = 0.001;
    add_medium(scene, &block);
    add_light(scene, &sun);
    check_result(context, ty_scene_set_camera(scene, &camera));
    commit(scene);
    return scene;
}

static double henyey_greenstein(double mu, double g) {
    return (1 - g * g) / (12.566370614359172 * pow(1 + g * g - 2 * g * mu, 1.5));
}

/* The radiance of octave i at the block's centre: a^i sigma_s p(c^i g) E exp(-b^i sigma_t 0.75 m) times the integral of
 * exp(-s z) over 1 m, s the extinction of the view; light turns by a right angle. */
static double block_radiance(const ty_octaves_def* def, int i, int c) {
    const ty_medium_def block = colored_block();
    const double sigma_s = (double)block.sigma_s[c], sigma_t = sigma_s + (double)block.sigma_a[c];
    const double b = pow(def->extinction, i), irradiance = c + 1;
    const double s = def->view_extinction == TY_OCTAVES_VIEW_SCALED ? b * sigma_t : sigma_t;
    const double phase = henyey_greenstein(0, pow(def->anisotropy, i) * (double)block.g[c]);
    return pow(def->scattering, i) * sigma_s * phase * irradiance * exp(-b * sigma_t * 0.75) * (1 - exp(-s)) / s;
}

static void check_block(ty_context* context, const ty_octaves* light, const ty_scene* scene,
                        const ty_octaves_def* def) {
    ty_image* image = NULL;
    check_result(context, ty_octaves_view(light, scene, def, &image, NULL));
    const int32_t single = ty_image_find_channel(image, "single.R");
    const int32_t multiple = ty_image_find_channel(image, "multiple.R");
    for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int i = 1; i < def->count; ++i) sum += block_radiance(def, i, c);
        assert_close((double)ty_image_plane_const(image, single + c)[0], block_radiance(def, 0, c),
                     0.01 * block_radiance(def, 0, c));
        assert_close((double)ty_image_plane_const(image, multiple + c)[0], sum, 0.01 * sum);
    }
    ty_image_destroy(image);
}

/* Froxels have one slice here: light is uniform along the view, and the analytic step is then exact in any thickness.
 */
static void octaves_are_single_scattering_in_scaled_media(void** state) {
    skip_under_sanitizers();
    static const double scales[][3] = {{0.5, 0.5, 0.5}, {0.3, 0.7, 0.9}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {1, 1, 1}};
    ty_scene* scene = block_scene(*state);
    ty_octaves_def def = ty_default_octaves_def();
    def.width = def.height = 1;
    def.resolution = 128;
    def.froxel_slices = 1;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    for (int view = 0; view < 2; ++view)
        for (int32_t count = 1; count <= TY_OCTAVES_COUNT_MAX; count += count == 1 ? 2 : 5)
            for (size_t i = 0; i < sizeof scales / sizeof *scales; i += in_full() ? 1 : 2) {
                def.view_extinction = (ty_octaves_view_extinction)view;
                def.count = count;
                def.scattering = scales[i][0];
                def.extinction = scales[i][1];
                def.anisotropy = scales[i][2];
                ty_octaves* light = NULL;
                check_result(*state, ty_octaves_solve(scene, &def, &light, NULL));
                for (def.froxels = 0; def.froxels <= 4; def.froxels += 4) check_block(*state, light, scene, &def);
                ty_octaves_destroy(light);
            }
    ty_scene_destroy(scene);
}

/* A medium that does not absorb, under a sky of radiance 1: no octave sends more than a^i (1 - T) times the largest
 * value of 4 pi p, here 1; in a thin medium octave i sends a^i times as much as octave 0, which is the energy gained.
 */
static void energy_in_a_white_furnace(void** state) {
    static const float sigma_s[] = {1e-3f, 1, 30};
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    for (size_t i = 0; i < sizeof sigma_s / sizeof *sigma_s; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_medium_def fog = box_medium(lower, upper, sigma_s[i], 0);
        ty_light_def sky = sky_light(1, 1, 1);
        add_medium(scene, &fog);
        add_light(scene, &sky);
        commit(scene);
        ty_octaves_def def = small_octaves();
        ty_image* image = NULL;
        def.count = 4;
        def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE;
        check_result(*state, ty_octaves_render(scene, &def, &image, NULL));
        const double single = total(image, ty_image_find_channel(image, "single.R"));
        const double multiple = total(image, ty_image_find_channel(image, "multiple.R"));
        const double opaque = PIXELS - total(image, ty_image_find_channel(image, "transmittance.R"));
        const double gain = 0.5 + 0.25 + 0.125;
        assert_true(single > 0 && single <= 1.001 * opaque && multiple <= 1.001 * gain * opaque);
        if (i == 0) assert_close(multiple, gain * single, 0.005 * single);
        ty_image_destroy(image);
        ty_scene_destroy(scene);
    }
}

/* Octave 0 is what it is without others, to the bit where they do not scale the view. */
static void single_scattering_does_not_depend_on_octaves(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_octaves_def def = small_octaves();
    ty_image *one = NULL, *all = NULL;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    def.count = 1;
    check_result(*state, ty_octaves_render(scene, &def, &one, NULL));
    def.count = 5;
    check_result(*state, ty_octaves_render(scene, &def, &all, NULL));
    for (int c = 0; c < 3; ++c) {
        const int32_t single = ty_image_find_channel(one, "single.R") + c;
        const int32_t multiple = ty_image_find_channel(one, "multiple.R") + c;
        assert_memory_equal(ty_image_plane_const(one, single), ty_image_plane_const(all, single),
                            PIXELS * sizeof(float));
        assert_true(total(one, multiple) == 0 && total(all, multiple) > 0);
    }
    ty_image_destroy(one);
    ty_image_destroy(all);
    ty_scene_destroy(scene);
}

/* R, G, B are the layers and the surfaces of def.unscattered. */
static void channels_add_up(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_octaves_def def = small_octaves();
    ty_image *image = NULL, *surfaces = NULL;
    def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    check_result(*state, ty_image_create_rgb(*state, WIDTH, HEIGHT, &surfaces));
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < PIXELS; ++i) ty_image_plane(surfaces, c)[i] = (float)(c + i) / PIXELS;
    def.unscattered = surfaces;
    check_result(*state, ty_octaves_render(scene, &def, &image, NULL));
    const int32_t single = ty_image_find_channel(image, "single.R");
    const int32_t multiple = ty_image_find_channel(image, "multiple.R");
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < PIXELS; ++i) {
            const double sum = (double)ty_image_plane_const(image, single + c)[i] +
                               (double)ty_image_plane_const(image, multiple + c)[i] +
                               (double)ty_image_plane_const(surfaces, c)[i];
            assert_close((double)ty_image_plane_const(image, c)[i], sum, 1e-5 * sum);
        }
    ty_image_destroy(image);
    ty_image_destroy(surfaces);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        VOLUME_TESTS,
        cmocka_unit_test(scattering_may_not_exceed_scaled_extinction),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(cameras_move_without_solving_again),
        cmocka_unit_test(octaves_are_single_scattering_in_scaled_media),
        cmocka_unit_test(energy_in_a_white_furnace),
        cmocka_unit_test(single_scattering_does_not_depend_on_octaves),
        cmocka_unit_test(channels_add_up),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
