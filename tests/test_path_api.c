/* The path tracer's calls: arguments, bounds on work, cancelling, what is reported; not whether the light is right. */
#include "fog.h"

#include "base/context.h"

#include <stddef.h>

static void assert_valid(const ty_image* image) {
    for (int c = 0; c < 6; ++c)
        for (int i = 0; i < ty_image_width(image) * ty_image_height(image); ++i) {
            const float value = ty_image_plane_const(image, c)[i];
            assert_true(isfinite(value) && value >= 0);
        }
}

#define PATH(field, type, value, words)                                                                                \
    { offsetof(ty_path_def, field), type, value, words }

static void wrong_defs_are_refused(void** state) {
    static const bad_field bad[] = {
        PATH(cookie, FIELD_INT, 0, "ty_default_path_def"),
        PATH(width, FIELD_INT, 0, "path: 0 x 11"),
        PATH(height, FIELD_INT, 0, "path: 19 x 0"),
        PATH(crop[2], FIELD_INT, 5, "path.crop: 5 x 0 pixels"),
        PATH(resume_size, FIELD_INT, 8, "path.resume is NULL"),
        PATH(width, FIELD_INT, -5, "path: -5 x 11"),
        PATH(height, FIELD_INT, 65537, "path: 19 x 65537"),
    };
    ty_scene* scene = dark_scene(*state);
    ty_image* image = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ty_path_def def = small_def(1);
        set_field(&def, &bad[i]);
        assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
        assert_null(image);
        assert_error(*state, bad[i].words);
    }
    assert_int_equal(ty_path_render(scene, NULL, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "ty_default_path_def");
    ty_scene_destroy(scene);
}

static void scenes_must_be_committed(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_path_def def = small_def(1);
    ty_image* image = NULL;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    assert_null(image);
    ty_scene_destroy(scene);
}

static void images_have_the_asked_size_and_channels(void** state) {
    static const char* const names[] = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    ty_scene* scene = dark_scene(*state);
    ty_camera_def camera = ty_scene_camera(scene);
    camera.resolution[0] = 7;
    camera.resolution[1] = 3;
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    ty_path_def def = small_def(1);
    for (int own = 0; own < 2; ++own) {
        ty_image* image = render(scene, &def, NULL);
        assert_int_equal(ty_image_width(image), own ? 7 : WIDTH);
        assert_int_equal(ty_image_height(image), own ? 3 : HEIGHT);
        assert_int_equal(ty_image_channel_count(image), 6);
        for (int c = 0; c < 6; ++c) assert_string_equal(ty_image_channel_name(image, c), names[c]);
        ty_image_destroy(image);
        def.width = def.height = 0;
    }
    ty_scene_destroy(scene);
}

static void channels_are_those_asked_for(void** state) {
    static const char* const all[] = {"R",
                                      "G",
                                      "B",
                                      "variance.R",
                                      "variance.G",
                                      "variance.B",
                                      "transmittance.R",
                                      "transmittance.G",
                                      "transmittance.B",
                                      "depth.Z",
                                      "normal.X",
                                      "normal.Y",
                                      "normal.Z",
                                      "albedo.R",
                                      "albedo.G",
                                      "albedo.B",
                                      "single.R",
                                      "single.G",
                                      "single.B",
                                      "multiple.R",
                                      "multiple.G",
                                      "multiple.B",
                                      "samples.N",
                                      "surface_albedo.R",
                                      "surface_albedo.G",
                                      "surface_albedo.B"};
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(3);
    def.aovs = TY_AOV_ALL;
    ty_image* image = render(scene, &def, NULL);
    assert_int_equal(ty_image_channel_count(image), sizeof all / sizeof *all);
    for (int c = 0; c < ty_image_channel_count(image); ++c)
        assert_string_equal(ty_image_channel_name(image, c), all[c]);
    for (int i = 0; i < PIXELS; ++i) assert_true(ty_image_plane_const(image, 22)[i] == 3.0f);
    def.aovs = 0;
    ty_image* plain = render(scene, &def, NULL);
    assert_int_equal(ty_image_channel_count(plain), 3);
    for (int c = 0; c < 3; ++c)
        assert_memory_equal(ty_image_plane_const(plain, c), ty_image_plane_const(image, c), PIXELS * sizeof(float));
    ty_image_destroy(plain);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* Light that media scattered is part of the radiance; fractions are fractions; normals have unit length or are 0. */
static void channels_agree_with_one_another(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(64);
    def.aovs = TY_AOV_ALL;
    ty_image* image = render(scene, &def, NULL);
    const float* plane[26];
    for (int c = 0; c < 26; ++c) plane[c] = ty_image_plane_const(image, c);
    for (int i = 0; i < PIXELS; ++i) {
        for (int c = 0; c < 3; ++c) {
            const double radiance = (double)plane[c][i], single = (double)plane[16 + c][i];
            const double multiple = (double)plane[19 + c][i];
            assert_true(single >= 0 && multiple >= 0 && single + multiple <= radiance * (1 + 1e-5));
            assert_true(plane[6 + c][i] >= 0 && plane[6 + c][i] <= 1.00001f);
            assert_true(plane[13 + c][i] >= 0 && plane[13 + c][i] <= 1.00001f);
            assert_true(plane[23 + c][i] >= 0 && plane[23 + c][i] <= plane[6 + c][i]);
            assert_true((plane[23 + c][i] > 0) == (plane[9][i] > 0));
        }
        const double x = (double)plane[10][i], y = (double)plane[11][i], z = (double)plane[12][i];
        const double length = sqrt(x * x + y * y + z * z);
        assert_true(length == 0 || fabs(length - 1) < 1e-6);
        assert_true(plane[9][i] >= 0);
        assert_true((plane[9][i] == 0) == (length == 0));
    }
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* The pixels of a crop are those of the whole frame, bit for bit. */
static void crops_are_cut_from_the_frame(void** state) {
    static const int32_t crops[][4] = {{0, 0, 1, 1}, {18, 10, 1, 1}, {5, 3, 9, 7}, {0, 4, 19, 2}};
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(5);
    ty_image* whole = render(scene, &def, NULL);
    for (size_t k = 0; k < sizeof crops / sizeof *crops; ++k) {
        memcpy(def.crop, crops[k], sizeof def.crop);
        ty_image* part = render(scene, &def, NULL);
        int32_t frame[4];
        ty_image_get_frame(part, frame);
        assert_int_equal(frame[0], crops[k][0]);
        assert_int_equal(frame[1], crops[k][1]);
        assert_int_equal(frame[2], WIDTH);
        assert_int_equal(frame[3], HEIGHT);
        assert_int_equal(ty_image_width(part), crops[k][2]);
        assert_int_equal(ty_image_height(part), crops[k][3]);
        for (int c = 0; c < 6; ++c)
            for (int y = 0; y < crops[k][3]; ++y)
                assert_memory_equal(ty_image_plane_const(part, c) + y * crops[k][2],
                                    ty_image_plane_const(whole, c) + (crops[k][1] + y) * WIDTH + crops[k][0],
                                    (size_t)crops[k][2] * sizeof(float));
        ty_image_destroy(part);
    }
    ty_image_destroy(whole);
    ty_scene_destroy(scene);
}

static void crops_lie_within_the_frame(void** state) {
    static const int32_t crops[][4] = {{-1, 0, 5, 5}, {0, -1, 5, 5}, {15, 0, 5, 5},        {0, 7, 5, 5},
                                       {0, 0, 0, 5},  {1, 1, 5, -5}, {0, 0, INT32_MAX, 5}, {INT32_MAX, 0, 5, 5}};
    ty_scene* scene = dark_scene(*state);
    ty_image* image = NULL;
    for (size_t k = 0; k < sizeof crops / sizeof *crops; ++k) {
        ty_path_def def = small_def(1);
        memcpy(def.crop, crops[k], sizeof def.crop);
        assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_ERROR_ARGUMENT);
        assert_error(*state, "path.crop: ");
        assert_null(image);
    }
    ty_scene_destroy(scene);
}

/* More than any machine has; told at once. */
static void frames_that_do_not_fit_are_refused(void** state) {
    ty_scene* scene = dark_scene(*state);
    ty_path_def def = small_def(1);
    def.width = def.height = 65536;
    def.aovs = TY_AOV_ALL;
    ty_image* image = NULL;
    const double begun = ty_wall_seconds();
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_ERROR_MEMORY);
    assert_error(*state, "path: 65536 x 65536 pixels: not enough memory");
    assert_true(ty_wall_seconds() - begun < 1);
    assert_null(image);
    ty_scene_destroy(scene);
}

static void empty_scenes_are_black(void** state) {
    ty_scene* scene = make_scene(*state);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const ty_path_def def = small_def(2);
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = render(scene, &def, &stats);
    for (int c = 0; c < 6; ++c) assert_true(total(image, c) == 0);
    assert_true(stats.vertices == 0 && stats.error == 0);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void statistics_tell_what_was_done(void** state) {
    ty_scene* scene = foggy_scene(*state);
    const ty_path_def def = small_def(6);
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = render(scene, &def, &stats);
    assert_valid(image);
    assert_int_equal(stats.paths, 6 * PIXELS);
    assert_close(stats.spp, 6, 0);
    assert_true(stats.vertices > PIXELS && stats.seconds > 0 && stats.cpu_seconds > 0);
    assert_true(stats.isa != NULL && stats.isa[0] != '\0');
    /* The error is the root mean square of the pixels' standard errors over the mean. */
    double variance = 0, mean = 0;
    for (int c = 0; c < 3; ++c) {
        mean += total(image, c);
        variance += total(image, 3 + c);
    }
    assert_close(stats.error, sqrt(variance * 3 * PIXELS) / mean, 1e-4 * stats.error);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* ---- progress and bounds ---- */

typedef struct watch {
    int calls, stop_at; /* 0: never */
    ty_progress last;
    bool strange;
    const char* stage;
} watch;

static bool look(void* user, const ty_progress* progress) {
    watch* w = user;
    ++w->calls;
    w->strange = w->strange || !(progress->fraction >= w->last.fraction && progress->fraction <= 1) ||
                 progress->seconds < w->last.seconds || progress->done < w->last.done ||
                 (progress->total > 0 && progress->done > progress->total) || strcmp(progress->stage, w->stage) != 0;
    w->last = *progress;
    return w->calls != w->stop_at;
}

static void progress_runs_to_the_end(void** state) {
    ty_scene* scene = foggy_scene(*state);
    watch w = {.stage = "path"};
    ty_path_def def = small_def(300);
    def.progress = look;
    def.progress_user = &w;
    ty_image* image = render(scene, &def, NULL);
    assert_true(w.calls >= 1 && !w.strange);
    assert_close(w.last.fraction, 1, 0);
    assert_int_equal(w.last.done, 300);
    assert_int_equal(w.last.total, 300);
    assert_close(w.last.remaining, 0, 1e-9);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void callers_can_cancel(void** state) {
    ty_scene* scene = foggy_scene(*state);
    watch w = {.stage = "path", .stop_at = 1};
    ty_path_def def = small_def(1 << 24);
    def.progress = look;
    def.progress_user = &w;
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = NULL;
    const double begun = ty_wall_seconds();
    assert_int_equal(ty_path_render(scene, &def, &image, &stats), TY_CANCELLED);
    assert_true(ty_wall_seconds() - begun < 5);
    assert_non_null(image);
    assert_valid(image);
    assert_true(total(image, 1) > 0 && stats.spp > 0 && stats.spp < 1 << 24);
    assert_string_equal(ty_take_error(*state), "");
    ty_image_destroy(image);

    const double rays[6] = {0, 0, 5, 0, 0, 1}, corner[3] = {0, 0, 0};
    const int32_t size[3] = {1, 1, 1};
    double out[3];
    w = (watch){.stage = "radiance", .stop_at = 1};
    assert_int_equal(ty_path_radiance(scene, &def, rays, 1, out, NULL), TY_CANCELLED);
    w = (watch){.stage = "fluence", .stop_at = 1};
    assert_int_equal(ty_path_fluence(scene, &def, corner, corner, size, out, NULL, NULL), TY_CANCELLED);
    assert_false(w.strange);
    ty_scene_destroy(scene);
}

static void time_bounds_the_work(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(1 << 24);
    def.seconds = 0.15;
    ty_path_stats stats = ty_default_path_stats();
    const double begun = ty_wall_seconds();
    ty_image* image = render(scene, &def, &stats);
    const double seconds = ty_wall_seconds() - begun;
    assert_true(seconds >= 0.15 && seconds < 3);
    assert_true(stats.spp >= 1 && stats.spp < 1 << 24);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* However short the time, every pixel gets a sample. */
static void no_pixel_is_left_out(void** state) {
    ty_scene* scene = dark_scene(*state);
    ty_path_def def = small_def(1 << 24);
    def.width = def.height = 80;
    def.seconds = 1e-9;
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = render(scene, &def, &stats);
    assert_true(stats.spp >= 1);
    for (int i = 0; i < 80 * 80; ++i) assert_true(ty_image_plane_const(image, 0)[i] > 0.1f);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static void error_bounds_the_work(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(1 << 20);
    double spp = 0;
    for (int i = 0; i < 2; ++i) {
        ty_path_stats stats = ty_default_path_stats();
        def.error = i == 0 ? 0.1 : 0.04;
        ty_image* image = render(scene, &def, &stats);
        assert_true(stats.error > 0 && stats.error <= def.error);
        assert_true(stats.spp >= 4 && stats.spp < 10000 && stats.spp > spp);
        spp = stats.spp;
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
}

/* ---- results ---- */

static void threads_do_not_change_bits(void** state) {
    (void)state;
    static const int32_t threads[] = {1, 2, 5};
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1}, rays[12] = {0, 0, 5, 0, 0, 1, 0, 2, 5, 0, 0.3, 1};
    const int32_t size[3] = {5, 6, 7};
    enum { CELLS = 5 * 6 * 7 };
    ty_image* first = NULL;
    static double fluence[2][3 * CELLS], uncollided[2][3 * CELLS], radiance[2][6];
    ty_context* contexts[3];
    for (int i = 0; i < 3; ++i) {
        contexts[i] = make_context(threads[i]);
        ty_scene* scene = foggy_scene(contexts[i]);
        ty_path_def def = small_def(20);
        const int to = i > 0;
        ty_image* image = render(scene, &def, NULL);
        assert_int_equal(ty_path_radiance(scene, &def, rays, 2, radiance[to], NULL), TY_OK);
        assert_int_equal(ty_path_fluence(scene, &def, lower, upper, size, fluence[to], uncollided[to], NULL), TY_OK);
        if (to) {
            assert_true(same_images(image, first));
            assert_memory_equal(fluence[1], fluence[0], sizeof fluence[0]);
            assert_memory_equal(uncollided[1], uncollided[0], sizeof uncollided[0]);
            assert_memory_equal(radiance[1], radiance[0], sizeof radiance[0]);
            ty_image_destroy(image);
        } else {
            first = image;
        }
        ty_scene_destroy(scene);
    }
    ty_image_destroy(first);
    for (int i = 0; i < 3; ++i) ty_context_destroy(contexts[i]);
}

static void seeds_make_other_images_of_the_same_light(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(64);
    ty_image* a = render(scene, &def, NULL);
    ty_image* again = render(scene, &def, NULL);
    def.seed = 1;
    ty_image* b = render(scene, &def, NULL);
    assert_true(same_images(a, again));
    assert_false(same_images(a, b));
    for (int c = 0; c < 3; ++c) assert_close(total(a, c), total(b, c), 6 * sqrt(total(a, 3 + c) + total(b, 3 + c)));
    ty_image_destroy(a);
    ty_image_destroy(again);
    ty_image_destroy(b);
    ty_scene_destroy(scene);
}

/* Variance channels against the scatter over seeds. Sobol points scatter less than the samples' own variance says,
 * never much more. */
static void variance_is_that_of_the_mean(void** state) {
    enum { SEEDS = 60 };
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(1);
    ty_image* single = render(scene, &def, NULL);
    assert_true(total(single, 3) == 0);
    ty_image_destroy(single);
    static double sum[PIXELS], square[PIXELS];
    double claimed = 0, seen = 0;
    def.spp = 8;
    for (int s = 0; s < SEEDS; ++s) {
        def.seed = (uint64_t)s;
        ty_image* image = render(scene, &def, NULL);
        for (int i = 0; i < PIXELS; ++i) {
            const double value = (double)ty_image_plane_const(image, 1)[i];
            sum[i] += value;
            square[i] += value * value;
        }
        claimed += total(image, 4) / SEEDS;
        ty_image_destroy(image);
    }
    for (int i = 0; i < PIXELS; ++i) seen += (square[i] - sum[i] * sum[i] / SEEDS) / (SEEDS - 1);
    assert_true(seen < 1.2 * claimed && seen > 0.2 * claimed);
    ty_scene_destroy(scene);
}

static void deeper_paths_bring_more_light(void** state) {
    ty_scene* scene = foggy_scene(*state);
    static const int32_t depths[] = {1, 2, 8, 0};
    double before = 0;
    for (int i = 0; i < 4; ++i) {
        ty_path_def def = small_def(32);
        def.max_depth = depths[i];
        ty_path_stats stats = ty_default_path_stats();
        ty_image* image = render(scene, &def, &stats);
        assert_true(total(image, 1) > 1.005 * before);
        if (depths[i] == 1) assert_true(stats.vertices <= stats.paths);
        before = total(image, 1);
        ty_image_destroy(image);
    }
    ty_scene_destroy(scene);
}

static void absorbed_rays_are_exact(void** state) {
    ty_scene* scene = dark_scene(*state);
    const double rays[4][6] = {{0, 0, 5, 0, 0, 3}, {0, 0, 0, 0, -2, 0}, {0, 5, 0, 0, -1, 0}, {-5, 0.5, 0.5, -1, 0, 0}};
    const double lengths[4] = {2, 1, 0, 2};
    const ty_path_def def = small_def(4);
    double radiance[12], variance[12];
    assert_int_equal(ty_path_radiance(scene, &def, rays[0], 4, radiance, variance), TY_OK);
    for (int i = 0; i < 12; ++i) {
        assert_close(radiance[i], exp(-0.5 * lengths[i / 3]), 1e-6);
        assert_close(variance[i], 0, 1e-12);
    }
    ty_scene_destroy(scene);
}

static void wrong_rays_are_refused(void** state) {
    ty_scene* scene = dark_scene(*state);
    const ty_path_def def = small_def(1);
    double rays[12] = {0, 0, 5, 0, 0, 1, 0, 0, 5, 0, 0, 0}, radiance[6];
    assert_int_equal(ty_path_radiance(scene, &def, rays, 0, radiance, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "a count of 0 rays");
    assert_int_equal(ty_path_radiance(scene, &def, rays, -1, radiance, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "a count of -1 rays");
    assert_int_equal(ty_path_radiance(scene, &def, rays, 2, radiance, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "rays: direction");
    rays[11] = -1;
    rays[7] = NAN;
    assert_int_equal(ty_path_radiance(scene, &def, rays, 2, radiance, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "rays: point");
    rays[7] = 0;
    assert_int_equal(ty_path_radiance(scene, &def, rays, 2, radiance, NULL), TY_OK);
    ty_scene_destroy(scene);
}

static void wrong_cells_are_refused(void** state) {
    ty_scene* scene = dark_scene(*state);
    const ty_path_def def = small_def(1);
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1}, below[3] = {1, -1, 1}, nowhere[3] = {1, 1, NAN};
    const int32_t none[3] = {1, 1, 0}, many[3] = {65537, 1, 1}, one[3] = {1, 1, 1};
    double out[3];
    assert_int_equal(ty_path_fluence(scene, &def, low, high, none, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: 0 cells");
    assert_int_equal(ty_path_fluence(scene, &def, low, high, many, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: 65537 cells");
    assert_int_equal(ty_path_fluence(scene, &def, low, below, one, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "along y");
    assert_int_equal(ty_path_fluence(scene, &def, low, nowhere, one, out, NULL, NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "fluence: upper[2]");
    ty_scene_destroy(scene);
}

/* A sky of radiance 1 gives a fluence of 4 pi far from anything; points, planes and boxes alike. */
static void fluence_of_a_constant_sky(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_light_def sky = sky_light(1, 1, 1);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const double low[3] = {1, 2, 3}, high[3] = {4, 2, 3};
    const int32_t size[3] = {3, 1, 1};
    const ty_path_def def = small_def(4);
    double fluence[9], uncollided[9], variance[9];
    assert_int_equal(ty_path_fluence(scene, &def, low, high, size, fluence, uncollided, variance), TY_OK);
    for (int i = 0; i < 9; ++i) {
        assert_close(fluence[i], 12.566370614359172, 1e-5);
        assert_close(uncollided[i], fluence[i], 0);
        assert_close(variance[i], 0, 1e-9);
    }
    ty_scene_destroy(scene);
}

/* Sunlight along +x in a medium that absorbs: cells run x fastest, and darken along x only. */
static void cells_are_x_fastest(void** state) {
    ty_scene* scene = make_scene(*state);
    const double low[3] = {0, 0, 0}, high[3] = {2, 3, 4};
    const ty_medium_def fog = box_medium(low, high, 0, 0.5f);
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, 1, 0, 0);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    const int32_t size[3] = {4, 3, 2};
    const ty_path_def def = small_def(64);
    double fluence[3 * 24];
    assert_int_equal(ty_path_fluence(scene, &def, low, high, size, fluence, NULL, NULL), TY_OK);
    for (int i = 0; i < 24; ++i) {
        const double x0 = 0.5 * (i % 4), x1 = x0 + 0.5;
        const double mean = (exp(-0.5 * x0) - exp(-0.5 * x1)) / 0.25;
        assert_close(fluence[3 * i + 2], mean, 5e-3 * mean);
    }
    ty_scene_destroy(scene);
}

static void media_can_be_ignored(void** state) {
    ty_scene *foggy = lit_scene(*state, true), *clear = lit_scene(*state, false);
    ty_path_def def = small_def(4), ignoring = def;
    ignoring.ignore_media = true;
    def.aovs = ignoring.aovs = TY_AOV_ALL;
    ty_image *fog = render(foggy, &def, NULL), *without = render(foggy, &ignoring, NULL);
    ty_image *expected = render(clear, &def, NULL), *nothing = render(clear, &ignoring, NULL);
    assert_true(same_images(without, expected));
    assert_true(same_images(nothing, expected));
    assert_false(same_images(fog, expected));
    ty_image* const images[] = {fog, without, expected, nothing};
    for (int i = 0; i < 4; ++i) ty_image_destroy(images[i]);

    const double from[3] = {0, 0, 5}, to[3] = {0, 3, 0}, ray[6] = {0, 0, 5, 0, -0.03, 1};
    double transmittance[3], a[3], b[3];
    const int32_t size[3] = {1, 1, 1};
    assert_int_equal(ty_path_transmittance(foggy, &ignoring, from, to, transmittance), TY_OK);
    for (int c = 0; c < 3; ++c) assert_true(transmittance[c] == 1);
    assert_int_equal(ty_path_radiance(foggy, &ignoring, ray, 1, a, NULL), TY_OK);
    assert_int_equal(ty_path_radiance(clear, &def, ray, 1, b, NULL), TY_OK);
    assert_memory_equal(a, b, sizeof a);
    assert_int_equal(ty_path_fluence(foggy, &ignoring, to, to, size, a, NULL, NULL), TY_OK);
    assert_int_equal(ty_path_fluence(clear, &def, to, to, size, b, NULL, NULL), TY_OK);
    assert_memory_equal(a, b, sizeof a);
    ty_scene_destroy(foggy);
    ty_scene_destroy(clear);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_defs_are_refused),
        cmocka_unit_test(scenes_must_be_committed),
        cmocka_unit_test(images_have_the_asked_size_and_channels),
        cmocka_unit_test(channels_are_those_asked_for),
        cmocka_unit_test(channels_agree_with_one_another),
        cmocka_unit_test(crops_are_cut_from_the_frame),
        cmocka_unit_test(crops_lie_within_the_frame),
        cmocka_unit_test(frames_that_do_not_fit_are_refused),
        cmocka_unit_test(empty_scenes_are_black),
        cmocka_unit_test(statistics_tell_what_was_done),
        cmocka_unit_test(progress_runs_to_the_end),
        cmocka_unit_test(callers_can_cancel),
        cmocka_unit_test(time_bounds_the_work),
        cmocka_unit_test(no_pixel_is_left_out),
        cmocka_unit_test(error_bounds_the_work),
        cmocka_unit_test(threads_do_not_change_bits),
        cmocka_unit_test(seeds_make_other_images_of_the_same_light),
        cmocka_unit_test(variance_is_that_of_the_mean),
        cmocka_unit_test(deeper_paths_bring_more_light),
        cmocka_unit_test(absorbed_rays_are_exact),
        cmocka_unit_test(wrong_rays_are_refused),
        cmocka_unit_test(wrong_cells_are_refused),
        cmocka_unit_test(fluence_of_a_constant_sky),
        cmocka_unit_test(cells_are_x_fastest),
        cmocka_unit_test(media_can_be_ignored),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
