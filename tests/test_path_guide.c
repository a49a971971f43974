/* Paths led by dom: the mean stays as it is for any guide, on any number of threads, and from any state. */
#include "fog.h"

#include "effort.h"
#include "method/path/driver.h"

/* A dark corner: a lamp behind a wall in a foggy room, scattering forwards; patchy: the fog is a grid. */
static ty_scene* corner_scene(ty_context* context, bool patchy) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = box_medium(lower, upper, 0.4f, 0.02f);
    set3f(fog.g, 0.5f, 0.5f, 0.5f);
    set3f(fog.sigma_s, 0.3f, 0.4f, 0.5f);
    if (patchy) assert_int_equal(ty_grid_create_exponential(context, 1, -1, 1, 0.8, &fog.density_grid), TY_OK);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_AREA;
    set3(lamp.position, 0.5, 0.9, -0.7);
    set3(lamp.u, 0.4, 0, 0);
    set3(lamp.v, 0, 0, 0.4);
    set3f(lamp.color, 30, 20, 10);
    ty_shape_def room = ty_default_shape_def(), wall = room;
    room.kind = wall.kind = TY_SHAPE_BOX;
    set3(room.origin, -1.001, -1.001, -1.001);
    set3(room.u, 1.001, 1.001, 1.001);
    set3(wall.origin, 0.2, -1, -1);
    set3(wall.u, 0.3, 1, 0.3);
    set3f(room.albedo, 0.6f, 0.5f, 0.4f);
    set3f(wall.albedo, 0.7f, 0.7f, 0.7f);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    ty_grid_release(fog.density_grid);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &room), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &wall), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

enum { RAYS = 24, BLOCK = 6 };

/* Rays through the dark part of the corner scene, in all directions. */
static void make_rays(double rays[6 * RAYS]) {
    uint64_t random = 5;
    for (int i = 0; i < RAYS; ++i) {
        const ty_vec direction = random_unit(&random);
        set3(rays + 6 * i, uniform_in(&random, -0.9, 0.1), uniform_in(&random, -0.9, 0.9),
             uniform_in(&random, -0.9, 0.9));
        set3(rays + 6 * i + 3, direction.x, direction.y, direction.z);
    }
}

/* Ways to spoil a guide, one after another. */
typedef enum spoiling { AS_IT_IS, DOUBLED, NOISE, ZERO } spoiling;

static void spoil(ty_path_guide* guide, spoiling how) {
    uint64_t random = 3;
    for (size_t i = 0; i < guide->cells * TY_GUIDE_BINS; ++i) {
        if (how == ZERO) guide->radiance[i] = 0;
        if (how == NOISE) guide->radiance[i] = (float)uniform(&random) < 0.5f ? 0 : (float)uniform(&random);
        if (how == DOUBLED) guide->radiance[i] *= 2;
    }
    for (size_t i = 0; i < guide->cells; ++i) {
        if (how == ZERO) guide->light[i].fluence = 0;
        if (how == NOISE) guide->light[i].fluence = (float)uniform(&random);
        if (how == DOUBLED) guide->light[i].fluence *= 2;
    }
}

/* Radiance along rays, and its variance. */
typedef struct estimate {
    double mean[3 * RAYS], variance[3 * RAYS];
} estimate;

/* A run over rays, with or without a guide. */
static void begin_run(const ty_scene* scene, ty_path_guide_kind kind, int32_t spp, const double* rays,
                      ty_path_run* run) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.guide = kind;
    assert_int_equal(ty_path_prepare(scene, &def, run), TY_OK);
    run->request.kind = TY_PATH_RAYS;
    run->request.rays = rays;
    run->item_count = RAYS;
    assert_int_equal(ty_path_run_begin(run, scene, false), TY_OK);
    assert_true((run->guide != NULL) == (kind == TY_PATH_GUIDE_DOM));
}

static void sample_run(ty_path_run* run, uint64_t seed, estimate* out) {
    run->request.seed = seed;
    memset(run->items, 0, RAYS * sizeof *run->items);
    run->stats = ty_default_path_stats();
    assert_int_equal(ty_path_sample(run), TY_OK);
    for (int i = 0; i < 3 * RAYS; ++i) {
        out->mean[i] = ty_path_item_mean(&run->items[i / 3], i % 3);
        out->variance[i] = ty_path_item_variance(&run->items[i / 3], i % 3);
    }
}

/* Blocks of rays agree within four standard errors; all of them within three. */
static void assert_same_means(const estimate* a, const estimate* b) {
    double all = 0, all_variance = 0;
    for (int block = 0; block < RAYS / BLOCK; ++block)
        for (int c = 0; c < 3; ++c) {
            double difference = 0, variance = 0;
            for (int i = block * BLOCK; i < (block + 1) * BLOCK; ++i) {
                difference += b->mean[3 * i + c] - a->mean[3 * i + c];
                variance += a->variance[3 * i + c] + b->variance[3 * i + c];
            }
            assert_close(difference / sqrt(variance), 0, 4);
            all += difference;
            all_variance += variance;
        }
    /* The channels of a path are nearly one number, so the variance of their sum is up to three times that. */
    assert_close(all / sqrt(3 * all_variance), 0, 3);
}

static void check_guides(ty_context* context, bool patchy) {
    enum { SPP = 1000 };
    ty_scene* scene = corner_scene(context, patchy);
    double rays[6 * RAYS];
    ty_path_run run;
    estimate plain, guided;
    make_rays(rays);
    begin_run(scene, TY_PATH_GUIDE_NONE, SPP, rays, &run);
    sample_run(&run, 1, &plain);
    for (int i = 0; i < 3 * RAYS; ++i) assert_true(plain.mean[i] > 0);
    ty_path_run_end(&run);
    begin_run(scene, TY_PATH_GUIDE_DOM, SPP, rays, &run);
    for (int how = AS_IT_IS; how <= ZERO; ++how) {
        spoil(run.guide, (spoiling)how);
        sample_run(&run, 2 + (uint64_t)how, &guided);
        assert_same_means(&plain, &guided);
    }
    ty_path_run_end(&run);
    ty_scene_destroy(scene);
}

static void any_guide_leaves_the_mean(void** state) {
    check_guides(*state, false);
}

static void any_guide_leaves_the_mean_of_grids(void** state) {
    check_guides(*state, true);
}

/* In a white room, and in fog that does not absorb, radiance is that of the sky in all directions. */
static void furnaces_stay_even(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    ty_medium_def fog = box_medium(lower, upper, 1.5f, 0);
    set3f(fog.g, 0.6f, 0.6f, 0.6f);
    ty_light_def sky = sky_light(1, 1, 1);
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.4;
    set3f(ball.albedo, 1, 1, 1);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &ball), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_path_def def = small_def(128);
    ty_path_stats stats = ty_default_path_stats();
    def.guide = TY_PATH_GUIDE_DOM;
    ty_image* image = render(scene, &def, &stats);
    /* The standard error of the image's mean. */
    const double error = stats.error / sqrt(PIXELS);
    assert_true(error < 0.004);
    assert_close(total(image, 1) / PIXELS, 1, 4 * error);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

static bool stop_at_once(void* user, const ty_progress* progress) {
    (void)user;
    (void)progress;
    return false;
}

/* The guide of a render of so many samples per pixel that nothing more is done of. */
static ty_path_guide_kind guide_of(const ty_scene* scene, int32_t spp, double seconds) {
    ty_path_def def = small_def(spp);
    ty_path_stats stats = ty_default_path_stats();
    ty_image* image = NULL;
    assert_int_equal(def.guide, TY_PATH_GUIDE_AUTO);
    def.seconds = seconds;
    def.progress = stop_at_once;
    assert_int_equal(ty_path_render(scene, &def, &image, &stats), TY_CANCELLED);
    ty_image_destroy(image);
    return stats.guide;
}

static void add_box(ty_scene* scene, const double lower[3], const double upper[3], float albedo) {
    ty_shape_def box = ty_default_shape_def();
    box.kind = TY_SHAPE_BOX;
    for (int a = 0; a < 3; ++a) {
        box.origin[a] = lower[a];
        box.u[a] = upper[a];
    }
    set3f(box.albedo, albedo, albedo, albedo);
    assert_int_equal(ty_scene_add_shape(scene, &box), TY_OK);
}

/* A room in fog, a lamp in a closet of it with a gap of 0.6 m, and a camera that looks into the dark part. */
static ty_scene* hidden_lamp_scene(ty_context* context) {
    static const double boxes[][2][3] = {
        {{-3, 0, -3}, {3, 3, 3}}, {{0.8, 0, -3}, {1, 3, -0.8}}, {{0.8, 0, -0.8}, {2.4, 3, -0.6}}};
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = box_medium(boxes[0][0], boxes[0][1], 0.15f, 0.005f);
    ty_light_def lamp = ty_default_light_def();
    ty_camera_def camera = ty_default_camera_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 2.3, 1.4, -2.4);
    set3(camera.position, -2.8, 1.5, 2.6);
    set3(camera.target, 0.6, 1.3, -0.4);
    camera.fov_y = 62;
    for (int i = 0; i < 3; ++i) add_box(scene, boxes[i][0], boxes[i][1], 0.7f);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

/* The pilot finds less noise in the same time with a guide where a lamp is hidden, and not where it lights all fog. */
static void long_renders_have_the_guide_that_pays(void** state) {
    enum { LONG = 1 << 17, SHORT = 1 << 12 };
    ty_scene *hidden = hidden_lamp_scene(*state), *foggy = foggy_scene(*state);
    assert_int_equal(guide_of(hidden, LONG, 0), TY_PATH_GUIDE_DOM);
    assert_int_equal(guide_of(hidden, SHORT, 0), TY_PATH_GUIDE_NONE);
    assert_int_equal(guide_of(hidden, LONG, 5), TY_PATH_GUIDE_NONE);
    if (!UNDER_ADDRESS_SANITIZER) assert_int_equal(guide_of(foggy, LONG, 0), TY_PATH_GUIDE_NONE);
    ty_scene_destroy(hidden);
    ty_scene_destroy(foggy);
}

static void threads_change_no_bits(void** state) {
    ty_context* alone = make_context(1);
    ty_scene *scene = foggy_scene(*state), *same = foggy_scene(alone);
    ty_path_def def = small_def(6);
    def.guide = TY_PATH_GUIDE_DOM;
    ty_image *image = render(scene, &def, NULL), *other = render(same, &def, NULL);
    assert_true(same_images(image, other));
    ty_image_destroy(image);
    ty_image_destroy(other);
    ty_scene_destroy(scene);
    ty_scene_destroy(same);
    ty_context_destroy(alone);
}

/* Keeps the first state and cancels the work. */
typedef struct keeper {
    uint8_t* bytes;
    size_t size;
} keeper;

static bool keep(void* user, const void* state, size_t size) {
    keeper* k = user;
    free(k->bytes);
    k->bytes = malloc(size);
    k->size = size;
    assert_non_null(k->bytes);
    memcpy(k->bytes, state, size);
    return false;
}

static void states_resume_to_the_same_bits(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(20);
    def.guide = TY_PATH_GUIDE_DOM;
    ty_image *whole = render(scene, &def, NULL), *part = NULL;
    keeper k = {NULL, 0};
    ty_path_def first = def;
    first.state = keep;
    first.state_user = &k;
    first.state_seconds = 0;
    assert_int_equal(ty_path_render(scene, &first, &part, NULL), TY_CANCELLED);
    ty_image_destroy(part);
    def.resume = k.bytes;
    def.resume_size = k.size;
    ty_image* resumed = render(scene, &def, NULL);
    assert_true(same_images(whole, resumed));
    ty_image_destroy(resumed);
    def.guide = TY_PATH_GUIDE_AUTO;
    resumed = render(scene, &def, NULL);
    assert_true(same_images(whole, resumed));
    def.guide = TY_PATH_GUIDE_NONE;
    ty_image* refused = NULL;
    assert_int_equal(ty_path_render(scene, &def, &refused, NULL), TY_ERROR_INPUT);
    assert_error(*state, "the state is with a guide");
    ty_image_destroy(whole);
    ty_image_destroy(resumed);
    free(k.bytes);
    ty_scene_destroy(scene);
}

/* A closed white room, and fog that does not absorb: only the roulette of long walks ends paths. */
static void paths_end_in_white_rooms(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    const ty_medium_def fog = box_medium(lower, upper, 0.5f, 0);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 0.3, 0);
    ty_shape_def room = ty_default_shape_def();
    room.kind = TY_SHAPE_BOX;
    set3(room.origin, -1.001, -1.001, -1.001);
    set3(room.u, 1.001, 1.001, 1.001);
    set3f(room.albedo, 1, 1, 1);
    assert_int_equal(ty_scene_add_medium(scene, &fog), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &lamp), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &room), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    double ray[6] = {0.5, 0.5, 0.5, 1, 1, 1}, radiance[3];
    ty_path_def def = ty_default_path_def();
    def.spp = 4;
    def.guide = TY_PATH_GUIDE_DOM;
    assert_int_equal(ty_path_radiance(scene, &def, ray, 1, radiance, NULL), TY_OK);
    assert_true(radiance[0] > 0);
    ty_scene_destroy(scene);
}

/* Scenes without media, and media that only attenuate, have no guide and the bits of none, whatever is asked for. */
static void without_media_there_is_none(void** state) {
    ty_scene *clear = lit_scene(*state, false), *foggy = lit_scene(*state, true);
    for (int i = 0; i < 2; ++i) {
        ty_path_def def = small_def(4);
        def.unscattered = i == 1;
        ty_image* plain = render(i == 1 ? foggy : clear, &def, NULL);
        def.guide = TY_PATH_GUIDE_DOM;
        ty_image* guided = render(i == 1 ? foggy : clear, &def, NULL);
        assert_true(same_images(plain, guided));
        ty_image_destroy(plain);
        ty_image_destroy(guided);
    }
    ty_scene_destroy(clear);
    ty_scene_destroy(foggy);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_guide_leaves_the_mean),   cmocka_unit_test(any_guide_leaves_the_mean_of_grids),
        cmocka_unit_test(furnaces_stay_even),          cmocka_unit_test(paths_end_in_white_rooms),
        cmocka_unit_test(threads_change_no_bits),      cmocka_unit_test(states_resume_to_the_same_bits),
        cmocka_unit_test(without_media_there_is_none), cmocka_unit_test(long_renders_have_the_guide_that_pays),
    };
    return cmocka_run_group_tests_name("path guide", tests, start_context, stop_context);
}
