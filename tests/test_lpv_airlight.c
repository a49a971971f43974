/* Airlight against sums over many points of each ray. */
#include "method/lpv/image/airlight.h"
#include "direct/media/transmittance.k.h"
#include "direct_maker.h"
#include "rsm_maker.h"
#include "scene/media/phase.k.h"

#include <stdio.h>

enum { RAYS = 60, POINTS = 2000 };

/* A scene, its lights' maps by hand, and airlight. */
typedef struct air_case {
    direct_case made;
    ty_rsm maps[4];
    ty_shadow_hierarchy* lit[4];
    ty_airlight* airlight;
} air_case;

static const double block_lower[3] = {-0.4, -0.6, -0.3}, block_upper[3] = {0.2, -0.1, 0.5};

static double block_depth(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    double part[2] = {0, INFINITY};
    return made_clip(block_lower, block_upper, origin, direction, part) ? part[0] : INFINITY;
}

static double no_depth(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    (void)origin;
    (void)direction;
    return INFINITY;
}

/* Maps are pointed to: a case stays where it is. */
static void air_begin(air_case* made, ty_scene* scene, made_depth depth) {
    ty_context* context = ty_scene_context(scene);
    *made = (air_case){.made = direct_begin(scene, 48, 1, 1)};
    const ty_scene_view* view = ty_scene_get_view(scene);
    for (int32_t i = 0; i < view->lights.count; ++i) {
        const ty_light_view* light = &view->lights.lights[i];
        const double half = light->kind == TY_KIND_SPOT ? tan(acos((double)light->cos_outer)) : 3;
        made->maps[i] = made_light_map(light, 128, half, ty_scale(light->direction, -5));
        made_trace(&made->maps[i], light, depth, NULL);
        check_result(context, ty_shadow_hierarchy_create(context, light, &made->maps[i], &made->lit[i]));
    }
    const ty_airlight_def def = {
        .medium = made->made.medium, .maps = (const ty_shadow_hierarchy* const*)made->lit, .count = view->lights.count};
    check_result(context, ty_airlight_create(scene, &def, &made->airlight));
}

static void air_end(air_case* made) {
    ty_airlight_destroy(made->airlight);
    for (int i = 0; i < 4; ++i) {
        ty_shadow_hierarchy_destroy(made->lit[i]);
        free((float*)made->maps[i].depth);
    }
    direct_end(&made->made);
}

/* ---- point by point ---- */

static bool is_in(const ty_medium_view* medium, ty_vec origin, ty_vec direction, float t) {
    float enter = 0, leave = TY_FLOAT_MAX;
    return ty_medium_interval(medium, origin, direction, &enter, &leave) && t >= enter && t <= leave;
}

static void add_point(const air_case* made, int32_t l, ty_vec origin, ty_vec direction, float t, double weight,
                      double sum[3]) {
    const ty_scene_view* view = ty_scene_get_view(made->made.scene);
    const ty_light_view* light = &view->lights.lights[l];
    const ty_vec point = ty_mad(origin, direction, t);
    ty_light_sample sample;
    float seen[3], reached[3];
    if (!ty_light_sample_from(light, point, 0, 0, &sample)) return;
    ty_transmittance(view->media, view->medium_count, origin, direction, t, NULL, seen);
    ty_transmittance(view->media, view->medium_count, point, sample.wi, sample.distance, NULL, reached);
    for (int32_t m = 0; m < view->medium_count; ++m) {
        if (!is_in(&view->media[m], origin, direction, t)) continue;
        for (int c = 0; c < 3; ++c)
            sum[c] += weight * (double)(view->media[m].sigma_s[c] * seen[c] * reached[c] * sample.radiance[c] *
                                        ty_hg(ty_dot(sample.wi, direction), view->media[m].g[c]));
    }
}

/* Where the ray next enters or leaves a medium, after t. */
static double next_end(const ty_scene_view* view, ty_vec origin, ty_vec direction, double t, double to) {
    for (int32_t m = 0; m < view->medium_count; ++m) {
        float at[2] = {0, TY_FLOAT_MAX};
        if (!ty_medium_interval(&view->media[m], origin, direction, &at[0], &at[1])) continue;
        for (int i = 0; i < 2; ++i)
            if ((double)at[i] > t) to = fmin(to, (double)at[i]);
    }
    return to;
}

static void sum_points(const air_case* made, ty_vec origin, ty_vec direction, float far, double sum[3]) {
    const ty_scene_view* view = ty_scene_get_view(made->made.scene);
    sum[0] = sum[1] = sum[2] = 0;
    for (int32_t l = 0; l < view->lights.count; ++l) {
        float lit[TY_LIT_SEGMENTS_MAX][2];
        const int32_t count = ty_shadow_lit_segments(made->lit[l], origin, direction, 0, far, lit);
        for (int32_t i = 0; i < count; ++i) {
            double from = (double)lit[i][0];
            while (from < (double)lit[i][1]) {
                const double to = next_end(view, origin, direction, from, (double)lit[i][1]);
                for (int k = 0; k < POINTS; ++k)
                    add_point(made, l, origin, direction, (float)(from + (to - from) * (k + 0.5) / POINTS),
                              (to - from) / POINTS, sum);
                from = to;
            }
        }
    }
}

/* Rays from around the scene and within it. The largest error, relative to the mean radiance. */
static void check_rays(const char* name, const air_case* made, double reach, double tolerance) {
    uint64_t random = 11;
    double worst = 0, mean = 0;
    for (int i = 0; i < RAYS; ++i) {
        const ty_vec origin = ty_scale(random_unit(&random), (float)uniform_in(&random, 0.1, reach));
        const ty_vec aim = ty_scale(random_unit(&random), 0.8f);
        const ty_vec direction = ty_normalize(ty_sub(aim, origin));
        const float far = (float)uniform_in(&random, 0.2, 2 * reach);
        float found[3], passing[3], expected[3];
        double wanted[3];
        const ty_scene_view* view = ty_scene_get_view(made->made.scene);
        ty_airlight_ray(made->airlight, origin, direction, far, 1, found, passing);
        ty_transmittance(view->media, view->medium_count, origin, direction, far, NULL, expected);
        sum_points(made, origin, direction, far, wanted);
        for (int c = 0; c < 3; ++c) {
            assert_close((double)passing[c], (double)expected[c], 1e-5);
            worst = fmax(worst, fabs((double)found[c] - wanted[c]) / (wanted[c] + 1e-6));
            mean += wanted[c] / (3 * RAYS);
            if (!(fabs((double)found[c] - wanted[c]) <= tolerance * wanted[c] + 1e-6))
                fail_msg("%s, ray %d, channel %d: %.7g, not %.7g", name, i, c, (double)found[c], wanted[c]);
        }
    }
    printf("%-34s mean %.4g, worst relative error %.1e\n", name, mean, worst);
    assert_true(mean > 1e-4);
}

/* ---- scenes ---- */

static ty_medium_def fog_box(double half, double sigma_s, double g) {
    const double lower[3] = {-half, -0.8 * half, -0.9 * half}, upper[3] = {half, 0.9 * half, half};
    ty_medium_def def = box_medium(lower, upper, (float)sigma_s, (float)(0.2 * sigma_s));
    for (int c = 0; c < 3; ++c) def.g[c] = (float)g;
    return def;
}

static ty_medium_def coloured(ty_medium_def def) {
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] *= 0.5f + 0.5f * (float)c;
        def.g[c] *= 1 - 0.3f * (float)c;
    }
    return def;
}

static void add_medium(ty_scene* scene, ty_medium_def def) {
    check_result(ty_scene_context(scene), ty_scene_add_medium(scene, &def));
}

static void add_lamp(ty_scene* scene, ty_light_kind kind, double x, double y, double z) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    set3(def.position, x, y, z);
    set3(def.direction, -x, -y, -z);
    def.cone = 70;
    def.penumbra = 0.4;
    set3f(def.color, 3, 2, 1);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &def));
}

static ty_medium_def turned(ty_medium_def def, double turn, double x, double y, double z) {
    const double at[3] = {x, y, z};
    const ty_affine about = def.transform;
    for (int a = 0; a < 3; ++a) {
        def.transform.m[a] = cos(turn) * about.m[a] - sin(turn) * about.m[4 + a];
        def.transform.m[4 + a] = sin(turn) * about.m[a] + cos(turn) * about.m[4 + a];
        def.transform.m[4 * a + 3] = at[a];
    }
    return def;
}

static void check_scene(const char* name, ty_scene* scene, double tolerance) {
    air_case made;
    air_begin(&made, scene, block_depth);
    check_rays(name, &made, 2, tolerance);
    air_end(&made);
}

static void sun_in_boxes(void** state) {
    for (int i = 0; i < 4; ++i) {
        static const char* const names[4] = {"sun, one box", "sun along an axis", "sun, coloured boxes",
                                             "sun, dense box"};
        ty_scene* scene = make_scene(*state);
        add_medium(scene, coloured(fog_box(1, i == 3 ? 8 : 0.7, 0.7)));
        if (i == 2) add_medium(scene, turned(fog_box(0.6, 1.5, -0.3), 0.5, 0.5, 0.2, 0.1));
        if (i == 2) add_medium(scene, turned(fog_box(0.3, 2, 0), -0.8, -0.9, 0.3, 0));
        direct_add_sun(scene, i == 1 ? 0 : -0.5, -1, i == 1 ? 0 : -0.4, 3);
        check_scene(names[i], scene, 2e-3);
    }
}

static void sun_in_curved_media(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_medium_def ball = fog_box(1, 0.9, 0.5);
    ball.bounds = TY_BOUNDS_SPHERE;
    ball.sphere_radius = 1;
    add_medium(scene, ball);
    direct_add_sun(scene, -0.5, -1, -0.4, 3);
    check_scene("sun, ball", scene, 5e-3);
}

static void lamps_in_boxes(void** state) {
    static const double g[4] = {0, 0.7, -0.5, 0.93};
    for (int i = 0; i < 4; ++i) {
        char name[64];
        ty_scene* scene = make_scene(*state);
        add_medium(scene, coloured(fog_box(1, 0.8, g[i])));
        add_lamp(scene, TY_LIGHT_POINT, 0.5, 0.4, -0.3);
        snprintf(name, sizeof name, "point inside, g %g", g[i]);
        check_scene(name, scene, 5e-3);
        scene = make_scene(*state);
        add_medium(scene, fog_box(1, 0.8, g[i]));
        add_lamp(scene, TY_LIGHT_SPOT, 0.7, 1.3, -0.5);
        snprintf(name, sizeof name, "spot outside, g %g", g[i]);
        check_scene(name, scene, 5e-3);
    }
}

static void many_of_all(void** state) {
    ty_scene* scene = make_scene(*state);
    add_medium(scene, fog_box(1, 0.5, 0.6));
    add_medium(scene, turned(coloured(fog_box(0.5, 2, 0.2)), 0.6, 0.6, -0.2, 0.1));
    direct_add_sun(scene, -0.5, -1, -0.4, 3);
    add_lamp(scene, TY_LIGHT_POINT, 0.5, 0.6, -0.3);
    add_lamp(scene, TY_LIGHT_SPOT, -0.7, 0.5, 0.5);
    check_scene("three lights, two boxes", scene, 1e-2);
}

/* ---- on cells ---- */

static ty_grid* even_grid(ty_context* context, int32_t size) {
    ty_grid_def def = ty_default_grid_def();
    const size_t count = (size_t)size * (size_t)size * (size_t)size;
    float* values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; ++i) values[i] = 1;
    for (int a = 0; a < 3; ++a) def.size[a] = size;
    def.values = values;
    ty_grid* grid = NULL;
    check_result(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

static ty_scene* fog_of(ty_context* context, int32_t light, bool on_cells) {
    ty_scene* scene = make_scene(context);
    ty_medium_def fog = fog_box(1, 0.7, 0.5);
    set3(fog.box_min, -1, -1, -1);
    set3(fog.box_max, 1, 1, 1);
    fog = coloured(fog);
    if (on_cells) fog.density_grid = even_grid(context, 48);
    add_medium(scene, fog);
    ty_grid_release(fog.density_grid);
    if (light == 0) direct_add_sun(scene, -0.2, -1, -0.1, 3);
    if (light == 1) add_lamp(scene, TY_LIGHT_POINT, 0.3, 0.4, -0.3);
    if (light == 2) add_lamp(scene, TY_LIGHT_SPOT, 0.7, 1.3, -0.5);
    return scene;
}

/* The same fog in closed form and on cells: mean over rays, and points' transmittance from lights. */
static void even_media_on_cells(void** state) {
    static const char* const names[3] = {"sun", "point", "spot"};
    for (int32_t light = 0; light < 3; ++light) {
        air_case even, cells;
        air_begin(&even, fog_of(*state, light, false), block_depth);
        air_begin(&cells, fog_of(*state, light, true), block_depth);
        uint64_t random = 3;
        double sums[2] = {0, 0}, off = 0, reach = 0, passed = 0;
        for (int i = 0; i < 20 * RAYS; ++i) {
            const ty_vec origin = ty_scale(random_unit(&random), 2), aim = ty_scale(random_unit(&random), 0.9f);
            const ty_vec direction = ty_normalize(ty_sub(aim, origin));
            float found[2][3], passing[2][3];
            ty_airlight_ray(even.airlight, origin, direction, INFINITY, 1, found[0], passing[0]);
            ty_airlight_ray(cells.airlight, origin, direction, INFINITY, (float)(1 - uniform(&random)), found[1],
                            passing[1]);
            for (int c = 0; c < 3; ++c) {
                sums[0] += (double)found[0][c];
                sums[1] += (double)found[1][c];
                off += fabs((double)(found[1][c] - found[0][c]));
                passed = fmax(passed, (double)fabsf(passing[1][c] - passing[0][c]));
            }
            ty_airlight_transmittance(even.airlight, 0, aim, found[0]);
            ty_airlight_transmittance(cells.airlight, 0, aim, found[1]);
            for (int c = 0; c < 3; ++c) reach = fmax(reach, (double)fabsf(found[1][c] - found[0][c]));
        }
        printf("%-6s on 48^3 cells: ratio %.4f, mean error %.4f; reach off by %.3f, transmittance by %.3f at most\n",
               names[light], sums[1] / sums[0], off / sums[0], reach, passed);
        assert_close(sums[1] / sums[0], 1, 0.02);
        assert_true(off < 0.02 * sums[0] && reach < 0.06 && passed < 0.03);
        air_end(&even);
        air_end(&cells);
    }
}

/* The tables behind that, which surfaces do not take part in. */
static void media_without_surfaces(void** state) {
    for (int32_t light = 0; light < 2; ++light) {
        float* planes[2][3] = {{NULL}};
        direct_case made[2];
        for (int i = 0; i < 2; ++i) {
            ty_scene* scene = fog_of(*state, light, true);
            ty_shape_def ball = ty_default_shape_def();
            ball.kind = TY_SHAPE_SPHERE;
            ball.radius = 0.5;
            set3(ball.origin, -0.1, 0.1, 0.4);
            if (i == 1) check_result(*state, ty_scene_add_shape(scene, &ball));
            made[i] = direct_begin(scene, 24, 1, 1);
            for (int c = 0; c < 3; ++c) planes[i][c] = calloc(made[i].medium->cells, sizeof(float));
        }
        check_result(*state, ty_uncollided_transmittance(made[0].scene, made[0].medium, NULL, made[0].sources.items,
                                                         planes[0], NULL));
        check_result(*state, ty_uncollided_in_media(made[1].medium, made[1].sources.items, planes[1]));
        for (int c = 0; c < 3; ++c)
            assert_memory_equal(planes[0][c], planes[1][c], made[0].medium->cells * sizeof(float));
        for (int i = 0; i < 2; ++i) {
            for (int c = 0; c < 3; ++c) free(planes[i][c]);
            direct_end(&made[i]);
        }
    }
}

/* ---- points ---- */

static void reach_of_points(void** state) {
    ty_scene* scene = make_scene(*state);
    const double lower[3] = {-1, 0, -1}, upper[3] = {1, 1, 1};
    add_medium(scene, box_medium(lower, upper, 0.5f, 0.25f));
    direct_add_sun(scene, 0, -1, 0, 3);
    add_lamp(scene, TY_LIGHT_POINT, 0, 3, 0);
    air_case made;
    air_begin(&made, scene, no_depth);
    float passing[3];
    ty_airlight_transmittance(made.airlight, 0, ty_vec_make(0.2f, 0.4f, 0.3f), passing);
    assert_close((double)passing[1], exp(-0.75 * 0.6), 1e-5);
    ty_airlight_transmittance(made.airlight, 1, ty_vec_make(0, -2, 0), passing);
    assert_close((double)passing[0], exp(-0.75), 1e-5);
    ty_airlight_transmittance(made.airlight, 1, ty_vec_make(0, 2, 0), passing);
    assert_close((double)passing[0], 1, 0);
    ty_airlight_transmittance(made.airlight, 0, ty_vec_make(2, 0.5f, 0), passing);
    assert_close((double)passing[0], 1, 0);
    air_end(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sun_in_boxes),        cmocka_unit_test(sun_in_curved_media),
        cmocka_unit_test(lamps_in_boxes),      cmocka_unit_test(many_of_all),
        cmocka_unit_test(even_media_on_cells), cmocka_unit_test(media_without_surfaces),
        cmocka_unit_test(reach_of_points),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
