/* The map of importance: the fraction of the light from each direction that the camera sees. */
#include "files.h"
#include "method/pop/ordinate/ordinate.h"
#include "pop_maker.h"

static const double pi = 3.14159265358979323846;
enum { WIDTH = TY_POP_IMPORTANCE_WIDTH, HEIGHT = TY_POP_IMPORTANCE_HEIGHT, DIRECTIONS = WIDTH * HEIGHT };

typedef struct gaze {
    ty_axis up;
    double from[3], to[3];
    float sigma_s, sigma_a, g;
    bool wall; /* whether the medium stands before a black wall, as the camera has it */
    int32_t threads;
} gaze;

static const gaze ahead = {.up = TY_AXIS_Y, .from = {0, 0, 6}, .sigma_s = 1, .g = 0.85f, .threads = 2};

static ty_scene* make_view(ty_context* context, const gaze* g) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = NULL;
    check_result(context, ty_scene_create(context, g->up, &scene));
    ty_medium_def fog = box_medium(lower, upper, g->sigma_s, g->sigma_a);
    set3f(fog.g, g->g, g->g, g->g);
    check_result(context, ty_scene_add_medium(scene, &fog));
    ty_camera_def camera = ty_default_camera_def();
    for (int a = 0; a < 3; ++a) {
        camera.position[a] = g->from[a];
        camera.target[a] = g->to[a];
    }
    if (g->up == TY_AXIS_Z) set3(camera.up, 0, 0, 1);
    check_result(context, ty_scene_set_camera(scene, &camera));
    ty_shape_def wall = quad_shape((const double[3][3]){{-50, -50, -1.5}, {100, 0, 0}, {0, 100, 0}});
    if (g->wall) check_result(context, ty_scene_add_shape(scene, &wall));
    check_result(context, ty_scene_commit(scene));
    return scene;
}

static void find_with(const gaze* g, const ty_pop_def* def, float map[DIRECTIONS]) {
    ty_context* context = make_context(g->threads);
    ty_scene* scene = make_view(context, g);
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    check_result(context, ty_grid_box_fit(scene, 20, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &medium));
    check_result(context, ty_pop_importance_find(scene, def, medium, map));
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

static void find(const gaze* g, float map[DIRECTIONS]) {
    const ty_pop_def def = pop_def(64);
    find_with(g, &def, map);
}

/* The environment's convention, with z up too. */
static ty_vec look_of(ty_axis up, int32_t at) {
    const double angle = 2 * pi * ((at % WIDTH + 0.5) / WIDTH - 0.5), down = pi * (at / WIDTH + 0.5) / HEIGHT;
    const float x = (float)(sin(down) * cos(angle)), y = (float)(sin(down) * sin(angle)), z = (float)cos(down);
    return up == TY_AXIS_Y ? ty_vec_make(x, z, y) : ty_vec_make(x, -y, z);
}

/* Mean over the sphere; where the map's light comes from in the mean; the brightest direction. */
static double mean_of(const gaze* g, const float map[DIRECTIONS], ty_vec* flow, ty_vec* brightest) {
    double sum = 0;
    int32_t best = 0;
    *flow = ty_vec_make(0, 0, 0);
    for (int32_t i = 0; i < DIRECTIONS; ++i) {
        const int32_t row = i / WIDTH;
        const double fraction = (cos(pi * row / HEIGHT) - cos(pi * (row + 1) / HEIGHT)) / (2 * WIDTH);
        assert_true(map[i] >= 0 && isfinite(map[i]));
        sum += fraction * (double)map[i];
        *flow = ty_mad(*flow, look_of(g->up, i), (float)fraction * map[i]);
        if (map[i] > map[best]) best = i;
    }
    *brightest = look_of(g->up, best);
    return sum;
}

/* Forward scattering: the other side of the medium; backward: the camera's own. */
static void behind_or_before(void** state) {
    (void)state;
    static const float gs[2] = {0.85f, -0.6f};
    static const double views[4][3] = {{0.5, 0.3, 6}, {5, 1, -2}, {1, 7, 1}, {-4, -4, 0.5}};
    for (int i = 0; i < 16; ++i) {
        gaze g = ahead;
        float map[DIRECTIONS];
        ty_vec flow, brightest;
        g.up = i % 2 == 0 ? TY_AXIS_Y : TY_AXIS_Z;
        g.g = gs[i / 2 % 2];
        memcpy(g.from, views[i / 4], sizeof g.from);
        find(&g, map);
        const ty_vec view = ty_normalize(ty_vec_make((float)-g.from[0], (float)-g.from[1], (float)-g.from[2]));
        const float side = g.g > 0 ? 1 : -1;
        assert_close(mean_of(&g, map, &flow, &brightest), 1, 1e-4);
        assert_true(side * ty_dot(view, brightest) > 0.93f);
        assert_true(side * ty_dot(view, ty_normalize(flow)) > 0.995f);
        assert_true(side * ty_dot(view, flow) > 0.3f);
    }
}

/* Isotropic and thin: all directions alike. */
static void even_where_nothing_tells(void** state) {
    (void)state;
    gaze g = ahead;
    float map[DIRECTIONS];
    g.sigma_s = 0.01f;
    g.g = 0;
    find(&g, map);
    for (int32_t i = 0; i < DIRECTIONS; ++i) assert_close((double)map[i], 1, 0.02);
}

/* Isotropic, thick and absorbing: only the side that the camera sees is lit. */
static void thick_media_are_seen_from_outside(void** state) {
    (void)state;
    gaze g = ahead;
    float map[DIRECTIONS];
    ty_vec flow, brightest;
    g.sigma_s = g.sigma_a = 5;
    g.g = 0;
    find(&g, map);
    mean_of(&g, map, &flow, &brightest);
    assert_true(flow.z > 0.2f);
}

static void nothing_seen(void** state) {
    (void)state;
    static const gaze away = {.up = TY_AXIS_Y, .from = {0, 0, 6}, .to = {0, 0, 12}, .sigma_s = 1, .threads = 2};
    static const gaze beside = {.up = TY_AXIS_Y, .from = {0, 0, 6}, .to = {6, 0, 3}, .sigma_s = 1, .threads = 2};
    static const gaze clear = {.up = TY_AXIS_Y, .from = {0, 0, 6}, .sigma_a = 1, .threads = 2};
    const gaze* const all[3] = {&away, &beside, &clear};
    for (int n = 0; n < 3; ++n) {
        float map[DIRECTIONS];
        find(all[n], map);
        for (int32_t i = 0; i < DIRECTIONS; ++i) assert_true(map[i] == 1);
    }
}

static void from_within(void** state) {
    (void)state;
    gaze g = ahead;
    float map[DIRECTIONS];
    ty_vec flow, brightest;
    set3(g.from, 0.2, 0.1, 0);
    set3(g.to, 5, 0.1, 0);
    find(&g, map);
    assert_close(mean_of(&g, map, &flow, &brightest), 1, 1e-4);
    assert_true(brightest.x > 0.95f);
}

/* Behind a wall there is no light. */
static void surfaces_hide_directions(void** state) {
    (void)state;
    gaze g = ahead;
    float map[DIRECTIONS], open[DIRECTIONS];
    ty_vec flow, brightest;
    g.g = 0.3f;
    find(&g, open);
    g.wall = true;
    find(&g, map);
    mean_of(&g, open, &flow, &brightest);
    assert_true(flow.z < -0.05f);
    mean_of(&g, map, &flow, &brightest);
    assert_true(flow.z > 0.1f);
}

/* The frame before counts as much as this one, and is replaced. */
static void history_is_mixed(void** state) {
    (void)state;
    float history[DIRECTIONS] = {0}, fresh[DIRECTIONS], map[DIRECTIONS];
    ty_pop_def def = pop_def(64);
    find(&ahead, fresh);
    def.history = history;
    find_with(&ahead, &def, map);
    assert_memory_equal(history, map, sizeof map);
    for (int32_t i = 0; i < DIRECTIONS; ++i) assert_close((double)map[i], (double)fresh[i], 1e-4);
    for (int32_t i = 0; i < DIRECTIONS; ++i) history[i] = 1;
    find_with(&ahead, &def, map);
    for (int32_t i = 0; i < DIRECTIONS; ++i) assert_close((double)map[i], 0.5 * (1 + (double)fresh[i]), 1e-4);
    assert_memory_equal(history, map, sizeof map);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    float one[DIRECTIONS], two[DIRECTIONS];
    gaze g = ahead;
    find(&g, two);
    g.threads = 1;
    find(&g, one);
    assert_memory_equal(one, two, sizeof one);
}

/* The public call samples the media on cells of its own, which a homogeneous medium does not depend on. */
static void callers_get_the_same_map(void** state) {
    (void)state;
    const ty_pop_def def = ty_default_pop_def();
    ty_context* context = make_context(2);
    ty_scene *scene = make_view(context, &ahead), *empty = NULL;
    float map[DIRECTIONS], expected[DIRECTIONS];
    ty_vec flow, brightest;
    check_result(context, ty_pop_importance(scene, &def, map));
    find(&ahead, expected);
    assert_close(mean_of(&ahead, map, &flow, &brightest), 1, 1e-5);
    float most = 0, off = 0;
    for (int32_t i = 0; i < DIRECTIONS; ++i) {
        most = fmaxf(most, expected[i]);
        off = fmaxf(off, fabsf(map[i] - expected[i]));
    }
    if (!(off <= 1e-5f * most)) fail_msg("a direction is off by %g of %g", (double)off, (double)most);
    check_result(context, ty_scene_create(context, TY_AXIS_Y, &empty));
    check_result(context, ty_scene_commit(empty));
    assert_int_equal(ty_pop_importance(empty, &def, map), TY_ERROR_ARGUMENT);
    ty_scene_destroy(empty);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(behind_or_before),
        cmocka_unit_test(even_where_nothing_tells),
        cmocka_unit_test(thick_media_are_seen_from_outside),
        cmocka_unit_test(nothing_seen),
        cmocka_unit_test(from_within),
        cmocka_unit_test(surfaces_hide_directions),
        cmocka_unit_test(history_is_mixed),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(callers_get_the_same_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
