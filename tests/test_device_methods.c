/* Marching, propagation and screen-space scattering on the host backend, against the processor's own kernels. `tyndall
 * bench device` tests GPUs against the host backend. */
#define _POSIX_C_SOURCE 200809L
#include "checks.h"
#include "effort.h"
#include "files.h"
#include "on_device.h"

#include "device/device.h"
#include "image/march/device/device.h"
#include "image/march/march.h"
#include "image/march/march.k.h"
#include "method/lpv/propagate/propagate.h"

#include <tyndall/dom.h>
#include <tyndall/fld.h>
#include <tyndall/io.h>
#include <tyndall/octaves.h>
#include <tyndall/pop.h>
#include <tyndall/screen.h>

/* No center of a pixel lies on an edge of the scenes, beside which rays may hit one surface or the other. */
enum { VIEW_WIDTH = 24, VIEW_HEIGHT = 17 };
enum { AOVS = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_DEPTH };

/* ---- images by marching ---- */

typedef struct view_case {
    const char* scene;
    int32_t spp, ray_spacing, froxels;
    double most; /* root mean square difference of a channel over its mean */
} view_case;

static ty_image* view(ty_context* context, const ty_scene* scene, const char* method, const view_case* of) {
    ty_image* image = NULL;
    ty_result result = TY_ERROR_ARGUMENT;
#define VIEW(name, ...)                                                                                                \
    if (strcmp(method, #name) == 0) {                                                                                  \
        ty_##name##_def def = ty_default_##name##_def();                                                               \
        def.width = VIEW_WIDTH;                                                                                        \
        def.height = VIEW_HEIGHT;                                                                                      \
        def.spp = of->spp;                                                                                             \
        def.aovs = AOVS;                                                                                               \
        def.ray_spacing = of->ray_spacing;                                                                             \
        __VA_ARGS__;                                                                                                   \
        result = ty_##name##_render(scene, &def, &image, NULL);                                                        \
    }
    VIEW(fld, def.resolution = 12)
    VIEW(dom, def.resolution = 8)
    VIEW(pop, def.resolution = 8)
    VIEW(octaves, def.resolution = 12; def.froxels = of->froxels)
#undef VIEW
    if (result != TY_OK) fail_msg("%s: %s", method, ty_take_error(context));
    return image;
}

/* An image, and the context that it belongs to. */
typedef struct viewed {
    ty_context* context;
    ty_image* image;
} viewed;

static viewed view_on(const char* device, int32_t threads, const char* method, const view_case* of) {
    viewed out = {.context = context_on(device, threads)};
    ty_scene* scene = NULL;
    const char* coarse = "media[0].density.noise.resolution=32"; /* its noise takes longer than its image */
    const bool cloud = strcmp(of->scene, "builtin:cloud_sun") == 0;
    if (ty_scene_load(out.context, of->scene, &coarse, cloud ? 1 : 0, &scene) != TY_OK)
        fail_msg("%s", ty_take_error(out.context));
    out.image = view(out.context, scene, method, of);
    ty_scene_destroy(scene);
    return out;
}

static void end(viewed* v) {
    ty_image_destroy(v->image);
    ty_context_destroy(v->context);
}

/* The largest difference of a channel: root mean square over the channel's mean. */
static double difference(const ty_image* a, const ty_image* b) {
    const size_t count = (size_t)ty_image_width(a) * (size_t)ty_image_height(a);
    double most = 0;
    assert_int_equal(ty_image_channel_count(a), ty_image_channel_count(b));
    for (int32_t c = 0; c < ty_image_channel_count(a); ++c) {
        const float *x = ty_image_plane_const(a, c), *y = ty_image_plane_const(b, c);
        double square = 0, sum = 0;
        for (size_t i = 0; i < count; ++i) {
            square += ((double)x[i] - (double)y[i]) * ((double)x[i] - (double)y[i]);
            sum += fabs((double)y[i]);
        }
        const double n = (double)count, relative = square > 0 ? sqrt(square / n) / (sum / n) : 0;
        if (!(relative <= most)) most = relative;
    }
    return most;
}

static bool same(const ty_image* a, const ty_image* b) {
    const size_t bytes = (size_t)ty_image_width(a) * (size_t)ty_image_height(a) * sizeof(float);
    bool equal = ty_image_channel_count(a) == ty_image_channel_count(b);
    for (int32_t c = 0; c < ty_image_channel_count(a) && equal; ++c)
        equal = memcmp(ty_image_plane_const(a, c), ty_image_plane_const(b, c), bytes) == 0;
    return equal;
}

static void expect_view(const char* method, const view_case* of) {
    viewed cpu = view_on("cpu", 2, method, of), host = view_on("host", 2, method, of);
    const double got = difference(host.image, cpu.image);
    printf("%s, %s, spp %d, spacing %d, froxels %d: %.1e\n", method, of->scene, of->spp, of->ray_spacing, of->froxels,
           got);
    assert_true(got > 0); /* products and sums are contracted on the processor alone */
    if (got > of->most) fail_msg("%s, %s: %g", method, of->scene, got);
    end(&cpu);
    end(&host);
}

static void media_are_marched_as_on_the_processor(void** state) {
    (void)state;
    static const view_case cloud = {"builtin:cloud_sun", 1, 1, 0, 1e-5}, spaced = {"builtin:cloud_sun", 2, 3, 0, 1e-5},
                           froxels = {"builtin:cloud_sun", 1, 1, 12, 1e-5};
    expect_view("fld", &cloud);
    expect_view("fld", &spaced);
    if (numbers_count()) {
        expect_view("dom", &cloud);
        expect_view("pop", &cloud);
    }
    expect_view("octaves", &cloud);
    expect_view("octaves", &froxels);
}

/* Surfaces reflect light of media; rays hit them within rounding. */
static void surfaces_are_marched_as_on_the_processor(void** state) {
    (void)state;
    static const view_case box = {"builtin:cornell_fog", 1, 1, 0, 1e-5},
                           spaced = {"builtin:cornell_fog", 1, 2, 0, 1e-5};
    expect_view("fld", &box);
    expect_view("fld", &spaced);
    expect_view("dom", &box);
}

static void images_depend_on_no_threads(void** state) {
    (void)state;
    static const view_case spaced = {"builtin:cornell_fog", 2, 3, 0, 0}, froxels = {"builtin:cloud_sun", 1, 1, 12, 0};
    viewed one = view_on("host", 1, "fld", &spaced), three = view_on("host", 3, "fld", &spaced);
    assert_true(same(one.image, three.image));
    end(&one);
    end(&three);
    one = view_on("host", 1, "octaves", &froxels);
    three = view_on("host", 3, "octaves", &froxels);
    assert_true(same(one.image, three.image));
    end(&one);
    end(&three);
}

/* ---- the marcher itself ---- */

static ty_scene* scene_of_boxes(ty_context* context, int count) {
    ty_scene* scene = make_scene(context);
    for (int i = 0; i < count; ++i) {
        const double lower[3] = {i, 0, 0}, upper[3] = {i + 0.5, 1, 1};
        const ty_medium_def fog = box_medium(lower, upper, 1, 0);
        assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    }
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* Even light in a box of this width, and of edges of 1 along other axes. */
static ty_source_field bright_field(double width) {
    static const float light[8] = {1, 1, 1, 1, 1, 1, 1, 1};
    return (ty_source_field){.box = {.size = {2, 2, 2}, .upper = {width, 1, 1}},
                             .term_count = 1,
                             .terms = {{light}},
                             .shared = true,
                             .color = {1, 1, 1}};
}

static ty_march_def small_march(void) {
    ty_march_def def = ty_default_march_def();
    def.width = 16;
    def.height = 12;
    return def;
}

/* A box so thick that pixels at its edges have more rays, over a floor that is outside of the field, and on which
 * irradiance is gathered; by a pinhole and by a lens. Measured: 3e-5, at an edge, and 2e-6. */
static void edges_and_floors_are_marched_as_on_the_processor(void** state) {
    (void)state;
    const ty_source_field field = bright_field(1);
    for (int lens = 0; lens < 2; ++lens) {
        ty_image* images[2];
        ty_context* contexts[2];
        for (int i = 0; i < 2; ++i) {
            contexts[i] = context_on(i == 0 ? "cpu" : "host", 2);
            ty_scene* scene = make_scene(contexts[i]);
            const double lower[3] = {0, 0, 0}, upper[3] = {1, 1, 1};
            const ty_medium_def block = box_medium(lower, upper, 40, 1);
            const ty_shape_def floor = quad_shape((const double[3][3]){{-3, -0.25, -3}, {0, 0, 6}, {6, 0, 0}});
            ty_camera_def camera = ty_default_camera_def();
            set3(camera.position, 3, 2.1, 4.2);
            set3(camera.target, 0.5, 0.4, 0.5);
            camera.aperture_radius = lens * 0.05;
            camera.focus_distance = 4;
            assert_int_equal(ty_scene_add_medium(scene, &block), TY_OK);
            assert_int_equal(ty_scene_add_shape(scene, &floor), TY_OK);
            assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
            assert_int_equal(ty_scene_commit(scene), TY_OK);
            ty_march_def def = small_march();
            def.field = &field;
            def.edge_rays = 8;
            def.aovs = TY_MARCH_AOVS;
            if (ty_march(scene, &def, &images[i], NULL) != TY_OK) fail_msg("%s", ty_take_error(contexts[i]));
            ty_scene_destroy(scene);
        }
        const double got = difference(images[1], images[0]);
        printf("lens %d: %.1e\n", lens, got);
        assert_true(got <= 1e-4);
        for (int i = 0; i < 2; ++i) {
            ty_image_destroy(images[i]);
            ty_context_destroy(contexts[i]);
        }
    }
}

/* Scenes of more media than a thread of a device has memory for are marched by the processor. */
static void many_media_are_marched_by_the_processor(void** state) {
    (void)state;
    ty_context* context = context_on("host", 2);
    for (int more = 0; more < 2; ++more) {
        ty_scene* scene = scene_of_boxes(context, TY_MARCH_DEVICE_MEDIA + more);
        ty_march_stats stats;
        ty_image* image = NULL;
        const ty_march_def def = small_march();
        assert_int_equal(ty_march(scene, &def, &image, &stats), TY_OK);
        assert_true((strcmp(stats.isa, "host") == 0) == (more == 0));
        ty_image_destroy(image);
        ty_scene_destroy(scene);
    }
    ty_context_destroy(context);
}

static void steps_are_counted(void** state) {
    (void)state;
    const ty_source_field field = bright_field(2);
    uint64_t steps[2];
    for (int i = 0; i < 2; ++i) {
        ty_context* context = context_on(i == 0 ? "cpu" : "host", 2);
        ty_scene* scene = scene_of_boxes(context, 2);
        ty_march_stats stats;
        ty_image* image = NULL;
        ty_march_def def = small_march();
        def.field = &field;
        assert_int_equal(ty_march(scene, &def, &image, &stats), TY_OK);
        steps[i] = stats.steps;
        ty_image_destroy(image);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
    }
    /* Rounding decides whether a step ends at a boundary of cells: measured 46 and 45. */
    assert_true(steps[0] > 0 && llabs((int64_t)steps[0] - (int64_t)steps[1]) <= (int64_t)steps[0] / 10);
}

static bool never(void* user, const ty_progress* progress) {
    (void)user;
    (void)progress;
    return false;
}

static void marching_is_cancelled(void** state) {
    (void)state;
    ty_context* context = context_on("host", 2);
    ty_scene* scene = scene_of_boxes(context, 1);
    ty_image* image = NULL;
    ty_march_def def = small_march();
    def.progress = never;
    assert_int_equal(ty_march(scene, &def, &image, NULL), TY_CANCELLED);
    assert_null(image);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static ty_result march_once(ty_context* context, void* user) {
    ty_image* image = NULL;
    (void)context;
    ty_fld_def def = ty_default_fld_def();
    def.width = def.height = 8;
    def.resolution = 4;
    const ty_result result = ty_fld_render(user, &def, &image, NULL);
    ty_image_destroy(image);
    return result;
}

/* ---- propagation in lattices ---- */

enum { SIDE = 11, LATTICE = SIDE * SIDE * SIDE };

typedef struct propagation {
    int32_t bands;
    bool blocked;
    ty_lpv_mode mode;
    double most; /* largest difference of a term over the largest light */
} propagation;

/* Light of all terms that exist; SIDE is no multiple of the strips or blocks of rows. */
static ty_result propagate(ty_context* context, const propagation* of, ty_progress_fn progress, float* out,
                           ty_lattice_power* power) {
    ty_lattice* lattice = NULL;
    const ty_lpv_def def = {.mode = of->mode, .tolerance = 0.01};
    ty_result result = ty_lattice_create_sample(context, SIDE, of->bands, of->blocked, &lattice);
    if (result == TY_OK) result = ty_lattice_propagate(lattice, &def, NULL, NULL, progress, NULL, power);
    for (int32_t i = 0; i < 3 * of->bands * of->bands && result == TY_OK && out != NULL; ++i)
        memcpy(out + (size_t)i * LATTICE, lattice->light[i / (of->bands * of->bands)][i % (of->bands * of->bands)],
               LATTICE * sizeof *out);
    ty_lattice_destroy(lattice);
    return result;
}

static void propagate_on(const char* device, int32_t threads, const propagation* of, float* out,
                         ty_lattice_power* power) {
    ty_context* context = context_on(device, threads);
    if (propagate(context, of, NULL, out, power) != TY_OK) fail_msg("%s", ty_take_error(context));
    ty_context_destroy(context);
}

/* Measured: at most 2.5e-7 of the largest light. */
static void light_propagates_as_on_the_processor(void** state) {
    (void)state;
    static float cpu[27 * LATTICE], host[27 * LATTICE], three[27 * LATTICE];
    static const propagation all[] = {{2, false, TY_LPV_MODE_LINKS, 1e-6},
                                      {2, true, TY_LPV_MODE_LINKS, 1e-6},
                                      {2, true, TY_LPV_MODE_PUBLISHED, 1e-6},
                                      {3, false, TY_LPV_MODE_PUBLISHED, 1e-6},
                                      {3, true, TY_LPV_MODE_LINKS, 1e-6}};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) {
        ty_lattice_power power[3];
        const size_t count = (size_t)(3 * all[i].bands * all[i].bands) * LATTICE;
        propagate_on("cpu", 2, &all[i], cpu, &power[0]);
        propagate_on("host", 1, &all[i], host, &power[1]);
        propagate_on("host", 3, &all[i], three, &power[2]);
        double most = 0, largest = 0;
        for (size_t k = 0; k < count; ++k) {
            most = fmax(most, fabs((double)host[k] - (double)cpu[k]));
            largest = fmax(largest, fabs((double)cpu[k]));
        }
        printf("bands %d, blocked %d, mode %d: %.1e, %d iterations\n", all[i].bands, all[i].blocked, (int)all[i].mode,
               most / largest, power[0].iterations);
        assert_true(most <= all[i].most * largest);
        assert_memory_equal(host, three, count * sizeof *host);
        assert_int_equal(power[0].iterations, power[1].iterations);
        for (int c = 0; c < 3; ++c) {
            assert_close(power[1].entered[c], power[0].entered[c], 1e-6 * power[0].entered[c]);
            assert_close(power[1].blocked[c], power[0].blocked[c], 1e-5 * power[0].entered[c]);
            assert_close(power[1].escaped[c], power[0].escaped[c], 1e-5 * power[0].entered[c]);
            assert_close(power[1].left[c], power[0].left[c], 1e-5 * power[0].entered[c]);
        }
    }
}

static ty_result propagate_once(ty_context* context, void* user) {
    ty_lattice_power power;
    return propagate(context, user, NULL, NULL, &power);
}

/* The device is free again after that. */
static void propagation_is_cancelled(void** state) {
    (void)state;
    propagation of = {2, true, TY_LPV_MODE_LINKS, 0};
    ty_lattice_power power;
    ty_context* context = context_on("host", 2);
    assert_int_equal(propagate(context, &of, never, NULL, &power), TY_CANCELLED);
    assert_int_equal(propagate_once(context, &of), TY_OK);
    ty_context_destroy(context);
}

static ty_screen_def haze(void);
static ty_result scatter_once(ty_context* context, void* user);

static void memory_may_run_out(void** state) {
    (void)state;
    strict_memory memory = {.limit = 1 << 28, .until_refusal = -1};
    ty_scene* scene = strict_scene_on_host(&memory, "builtin:cube_g0");
    ty_context* context = ty_scene_context(scene);
    assert_true(check_short_memory(context, &memory, march_once, scene) > 20);
    assert_true(check_short_memory(context, &memory, scatter_once, NULL) > 10);
    propagation of = {2, true, TY_LPV_MODE_LINKS, 0};
    assert_true(check_short_memory(context, &memory, propagate_once, &of) > 20);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

/* ---- screen-space scattering ---- */

enum { WIDTH = 61, HEIGHT = 37, PIXELS = WIDTH * HEIGHT };

static ty_screen_def haze(void) {
    ty_screen_def def = ty_default_screen_def();
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = 0.05f + 0.01f * (float)c;
        def.sigma_a[c] = 0.002f;
        def.g[c] = 0.9f;
        def.environment[c] = 0.3f;
    }
    def.focal[0] = def.focal[1] = ty_screen_focal(HEIGHT, 40);
    return def;
}

/* Lamps before boxes, with a value that is no number and pixels without a distance; color and distance, interleaved. */
static void fill(float* pixels) {
    for (int32_t i = 0; i < PIXELS; ++i) {
        const int32_t x = i % WIDTH, y = i / WIDTH;
        for (int32_t c = 0; c < 3; ++c)
            pixels[4 * i + c] =
                (x * 7 + y * 5) % 23 == 0 ? 40.0f : 0.1f * (float)(1 + c) * (float)((x / 9 + y / 7) % 3);
        pixels[4 * i + 3] = (x + y) % 17 == 0 ? 0.0f : 3.0f + (float)((x / 11) * 4);
    }
    pixels[4 * (WIDTH * 3 + 5)] = NAN;
}

/* in_place: the image is overwritten. */
static void scatter(const char* device, const ty_screen_def* def, bool in_place, float* out, ty_screen_stats* stats) {
    static float pixels[4 * PIXELS], planes[3][PIXELS];
    ty_context* context = context_on(device, 2);
    ty_screen_image image = ty_default_screen_image();
    fill(pixels);
    image.width = WIDTH;
    image.height = HEIGHT;
    image.distance = pixels + 3;
    image.color.step = image.distance_step = 4;
    image.color.row = image.distance_row = 4 * WIDTH;
    image.out.step = in_place ? 4 : 1;
    image.out.row = in_place ? 4 * WIDTH : WIDTH;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = pixels + c;
        image.out.data[c] = in_place ? pixels + c : planes[c];
    }
    *stats = ty_default_screen_stats();
    if (ty_screen_apply(context, def, &image, NULL, 0, stats) != TY_OK) fail_msg("%s", ty_take_error(context));
    for (int32_t c = 0; c < 3; ++c)
        for (int32_t i = 0; i < PIXELS; ++i) out[c * PIXELS + i] = in_place ? pixels[4 * i + c] : planes[c][i];
    ty_context_destroy(context);
}

static ty_result scatter_once(ty_context* context, void* user) {
    static float planes[4][PIXELS], out[3][PIXELS];
    (void)user;
    ty_screen_image image = ty_default_screen_image();
    image.width = WIDTH;
    image.height = HEIGHT;
    image.distance = planes[3];
    image.color.row = image.distance_row = image.out.row = WIDTH;
    for (int c = 0; c < 3; ++c) {
        image.color.data[c] = planes[c];
        image.out.data[c] = out[c];
    }
    const ty_screen_def def = haze();
    return ty_screen_apply(context, &def, &image, NULL, 0, NULL);
}

/* The largest difference over the mean. */
static double unlike(const float* a, const float* b) {
    double most = 0, sum = 0;
    for (int32_t i = 0; i < 3 * PIXELS; ++i) {
        const double apart = fabs((double)a[i] - (double)b[i]);
        if (!(apart <= most)) most = apart;
        sum += (double)b[i];
    }
    return most / (sum / (3 * PIXELS));
}

static void light_is_scattered_as_on_the_processor(void** state) {
    (void)state;
    static float cpu[3 * PIXELS], host[3 * PIXELS], place[3 * PIXELS];
    static const ty_screen_spread spreads[] = {TY_SCREEN_SPREAD_GAUSSIAN, TY_SCREEN_SPREAD_SMALL_ANGLE};
    for (int i = 0; i < 12; ++i) {
        ty_screen_def def = haze();
        ty_screen_stats on_cpu, on_host, in_place;
        def.filter = 2 + 2 * (i % 3);
        def.spread = spreads[i / 3 % 2];
        def.distance_kind = i < 6 ? TY_SCREEN_DISTANCE_RAY : TY_SCREEN_DISTANCE_AXIS;
        scatter("cpu", &def, false, cpu, &on_cpu);
        scatter("host", &def, false, host, &on_host);
        scatter("host", &def, true, place, &in_place);
        const double got = unlike(host, cpu);
        printf("filter %d, spread %d, kind %d: %.1e\n", (int)def.filter, (int)def.spread, (int)def.distance_kind, got);
        assert_true(got <= 1e-4);
        assert_memory_equal(host, place, sizeof host);
        assert_string_equal(on_host.isa, "host");
        assert_int_equal(on_host.levels, on_cpu.levels);
        assert_true(on_host.nonfinite_fixed == on_cpu.nonfinite_fixed && on_cpu.nonfinite_fixed == 1);
        assert_true(on_host.missing_depth == on_cpu.missing_depth && on_cpu.missing_depth > 0);
        assert_true(on_host.oversized == on_cpu.oversized);
        assert_close(on_host.spread, on_cpu.spread, 1e-5 * on_cpu.spread);
        assert_close(on_host.max_spread, on_cpu.max_spread, 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(media_are_marched_as_on_the_processor),
        cmocka_unit_test(surfaces_are_marched_as_on_the_processor),
        cmocka_unit_test(images_depend_on_no_threads),
        cmocka_unit_test(edges_and_floors_are_marched_as_on_the_processor),
        cmocka_unit_test(many_media_are_marched_by_the_processor),
        cmocka_unit_test(steps_are_counted),
        cmocka_unit_test(marching_is_cancelled),
        cmocka_unit_test(light_propagates_as_on_the_processor),
        cmocka_unit_test(propagation_is_cancelled),
        cmocka_unit_test(memory_may_run_out),
        cmocka_unit_test(light_is_scattered_as_on_the_processor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
