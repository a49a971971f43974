/* Maps of lights whose texels are on straight lines: where texels are, what they meet, what callers may hand in. */
#include "direct/shadow/rsm.h"
#include "direct_maker.h"
#include "files.h"

static const double pi = 3.14159265358979323846;

static void add_box(ty_scene* scene, double half) {
    ty_shape_def def = ty_default_shape_def();
    def.kind = TY_SHAPE_BOX;
    set3(def.origin, -half, -half, -half);
    set3(def.u, half, half, half);
    set3f(def.albedo, 0.25f, 0.5f, 0.75f);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
}

static void add_lamp(ty_scene* scene, ty_light_kind kind, double cone, double penumbra, const double way[3]) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    def.cone = cone;
    def.penumbra = penumbra;
    set3(def.position, 0.3, -0.2, 0.1);
    set3(def.direction, way[0], way[1], way[2]);
    set3f(def.color, 3, 2, 1);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &def));
}

static const ty_light_view* light_of(ty_scene* scene, int32_t light) {
    return &ty_scene_get_view(scene)->lights.lights[light];
}

static ty_rsm* map_of(ty_scene* scene, const ty_rsm_def* def, int32_t light, ty_ray_counter* rays) {
    ty_rsm* map = NULL;
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
    check_result(ty_scene_context(scene), ty_rsm_trace(scene, def, light, &map, rays));
    check_result(ty_scene_context(scene), ty_rsm_check(ty_scene_context(scene), light_of(scene, light), map, 0));
    return map;
}

/* Power of the light through all texels, relative to its intensity. */
static double sum_shares(const ty_rsm* map, const ty_light_view* light) {
    double sum = 0;
    for (int32_t face = 0; face < map->faces; ++face)
        for (int32_t y = 0; y < map->side; ++y)
            for (int32_t x = 0; x < map->side; ++x) {
                ty_vec origin, way;
                ty_rsm_ray(map, light, face, (float)x + 0.5f, (float)y + 0.5f, &origin, &way);
                const float profile = light->kind == TY_KIND_SPOT
                                          ? ty_spot_falloff(light, ty_dot(ty_normalize(way), light->direction))
                                          : 1.0f;
                sum += (double)(profile * ty_rsm_texel_measure(map, light, face, x, y));
            }
    return sum;
}

/* The integral of a spot's profile over its cone: a smoothstep between the cosines. */
static double cone_of(double cone, double penumbra) {
    const double outer = cos(pi * cone / 360), inner = cos(pi * cone / 360 * (1 - penumbra));
    return 2 * pi * (1 - inner + 0.5 * (inner - outer));
}

static void shares_are_the_cone(void** state) {
    static const double cones[5] = {20, 70, 120, 159, 175};
    static const double ways[2][3] = {{0, -1, 0}, {1, 0.4, -2}};
    for (int i = 0; i < 5; ++i)
        for (int penumbra = 0; penumbra < 2; ++penumbra) {
            ty_scene* scene = make_scene(*state);
            const ty_rsm_def def = {.side = 256, .reflective = true};
            add_box(scene, 2);
            add_lamp(scene, TY_LIGHT_SPOT, cones[i], 0.5 * penumbra, ways[penumbra]);
            ty_rsm* map = map_of(scene, &def, 0, NULL);
            assert_int_equal(map->faces, cones[i] > 160 ? 6 : 1);
            assert_close(sum_shares(map, light_of(scene, 0)) / cone_of(cones[i], 0.5 * penumbra), 1,
                         penumbra ? 2e-4 : 2e-3);
            ty_rsm_destroy(*state, map);
            ty_scene_destroy(scene);
        }
}

/* Six faces are the sphere, down to few texels; and no direction is missed or met twice. */
static void points_see_all(void** state) {
    static const int32_t sides[3] = {1, 16, 128};
    static const double tolerance[3] = {0.15, 1e-4, 1e-5};
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_rsm_def def = {.side = sides[i], .reflective = true};
        ty_ray_counter rays = {.rays = 5};
        add_box(scene, 2);
        add_lamp(scene, TY_LIGHT_POINT, 40, 0, (const double[3]){0, 1, 0});
        ty_rsm* map = map_of(scene, &def, 0, &rays);
        const ty_light_view* light = light_of(scene, 0);
        double square = 0;
        assert_int_equal(rays.rays, 5 + 6 * sides[i] * sides[i]);
        assert_close(sum_shares(map, light) / (4 * pi), 1, tolerance[i]);
        for (int32_t t = 0; t < 6 * sides[i] * sides[i]; ++t) {
            const int32_t face = t / (sides[i] * sides[i]), y = t / sides[i] % sides[i], x = t % sides[i];
            ty_vec origin, way;
            ty_rsm_ray(map, light, face, (float)x + 0.5f, (float)y + 0.5f, &origin, &way);
            const ty_vec point = ty_mad(origin, way, map->depth[t]);
            const float far = ty_maxf(fabsf(point.x), ty_maxf(fabsf(point.y), fabsf(point.z)));
            const ty_vec unit = ty_normalize(way);
            assert_close((double)far, 2, 1e-5);
            assert_close((double)map->albedo[3 * t + 2], 0.75, 1e-6);
            assert_true(ty_dot(ty_vec_load(map->normal + 3 * t), unit) < 0);
            square += (double)(unit.x * unit.x * ty_rsm_texel_measure(map, light, face, x, y));
        }
        if (i == 2) assert_close(square / (4 * pi), 1.0 / 3, 1e-4);
        ty_rsm_destroy(*state, map);
        ty_scene_destroy(scene);
    }
}

static void suns_cover_boxes(void** state) {
    static const double ways[4][3] = {{0, -1, 0}, {1, -2, 0.5}, {-1, -0.4, 2}, {0, 1, 0}};
    const double lower[3] = {-1, -3, -1}, upper[3] = {2, 3, 1};
    for (int i = 0; i < 4; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_rsm_def def = {.side = 64, .lower = lower, .upper = upper};
        add_box(scene, 8);
        direct_add_sun(scene, ways[i][0], ways[i][1], ways[i][2], 3);
        ty_rsm* map = map_of(scene, &def, 0, NULL);
        const ty_light_view* light = light_of(scene, 0);
        double edge = 0;
        assert_null(map->normal);
        for (int corner = 0; corner < 8; ++corner) {
            double at[2] = {0, 0}, length[2] = {0, 0};
            for (int a = 0; a < 3; ++a) {
                const double off = (corner >> a & 1 ? upper[a] : lower[a]) - map->origin[a];
                at[0] += off * map->right[0][a];
                at[1] += off * map->up[0][a];
                length[0] += map->right[0][a] * map->right[0][a];
                length[1] += map->up[0][a] * map->up[0][a];
            }
            for (int k = 0; k < 2; ++k) {
                assert_true(fabs(at[k] / length[k]) < 1 + 1e-6);
                edge = fmax(edge, fabs(at[k] / length[k]));
            }
        }
        assert_close(edge, 1, 1e-6);
        for (int32_t t = 0; t < 64 * 64; ++t) {
            ty_vec origin, way;
            ty_rsm_ray(map, light, 0, (float)(t % 64) + 0.5f, (float)(t / 64) + 0.5f, &origin, &way);
            /* The first surface is the box from outside. */
            const ty_vec point = ty_mad(origin, way, map->depth[t]);
            assert_true(map->depth[t] >= 0);
            assert_close((double)ty_maxf(fabsf(point.x), ty_maxf(fabsf(point.y), fabsf(point.z))), 8, 1e-4);
        }
        ty_rsm_destroy(*state, map);
        ty_scene_destroy(scene);
    }
}

/* A light that turns a little has texels that turn a little. */
static void texels_move_smoothly(void** state) {
    static const double from[3][3] = {{0.001, -1, 0}, {1, -0.5, 0.0005}, {0, 0.2, -1}};
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
        const ty_rsm_def def = {.side = 8, .lower = lower, .upper = upper};
        add_box(scene, 3);
        direct_add_sun(scene, from[i][0], from[i][1], from[i][2], 1);
        direct_add_sun(scene, from[i][0] - 0.002, from[i][1] + 0.001, from[i][2] - 0.001, 1);
        ty_rsm *a = map_of(scene, &def, 0, NULL), *b = map_of(scene, &def, 1, NULL);
        for (int k = 0; k < 3; ++k) {
            assert_close(a->right[0][k], b->right[0][k], 0.02);
            assert_close(a->up[0][k], b->up[0][k], 0.02);
        }
        ty_rsm_destroy(*state, a);
        ty_rsm_destroy(*state, b);
        ty_scene_destroy(scene);
    }
}

static void nothing_to_meet(void** state) {
    static const ty_light_kind kinds[3] = {TY_LIGHT_DIRECTIONAL, TY_LIGHT_POINT, TY_LIGHT_SPOT};
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_rsm_def def = {.side = 16, .reflective = true, .lower = lower, .upper = upper};
        ty_ray_counter rays = {.rays = 0};
        add_lamp(scene, kinds[i], 40, 0, (const double[3]){0, -1, 0});
        ty_rsm* map = map_of(scene, &def, 0, &rays);
        assert_int_equal(rays.rays, 0);
        for (int32_t t = 0; t < map->faces * 256; ++t) assert_true(isinf(map->depth[t]));
        ty_rsm_destroy(*state, map);
        ty_scene_destroy(scene);
    }
}

static void threads_do_not_matter(void** state) {
    (void)state;
    ty_rsm* maps[2];
    ty_context* contexts[2];
    for (int i = 0; i < 2; ++i) {
        contexts[i] = make_context(1 + 2 * i);
        ty_scene* scene = make_scene(contexts[i]);
        const ty_rsm_def def = {.side = 33, .reflective = true};
        add_box(scene, 2);
        add_lamp(scene, TY_LIGHT_POINT, 40, 0, (const double[3]){0, 1, 0});
        maps[i] = map_of(scene, &def, 0, NULL);
        ty_scene_destroy(scene);
    }
    const size_t count = (size_t)6 * 33 * 33;
    assert_memory_equal(maps[0]->depth, maps[1]->depth, count * sizeof(float));
    assert_memory_equal(maps[0]->normal, maps[1]->normal, 3 * count * sizeof(float));
    for (int i = 0; i < 2; ++i) {
        ty_rsm_destroy(contexts[i], maps[i]);
        ty_context_destroy(contexts[i]);
    }
}

static void wrong_lights(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    ty_rsm_def def = {.side = 16};
    ty_rsm* map = NULL;
    ty_light_def sky = sky_light(1, 1, 1);
    check_result(context, ty_scene_add_light(scene, &sky));
    check_result(context, ty_scene_commit(scene));
    assert_int_equal(ty_rsm_trace(scene, &def, 0, &map, NULL), TY_ERROR_ARGUMENT);
    assert_error(context, "RSM: light 0 is not");
    assert_int_equal(ty_rsm_trace(scene, &def, 1, &map, NULL), TY_ERROR_ARGUMENT);
    assert_error(context, "RSM: light 1 is not");
    def.side = 8193;
    assert_int_equal(ty_rsm_trace(scene, &def, 0, &map, NULL), TY_ERROR_ARGUMENT);
    assert_error(context, "RSM: side");
    ty_scene_destroy(scene);
}

static void callers_maps(void** state) {
    ty_context* context = *state;
    const ty_light_view spot = {.kind = TY_KIND_SPOT}, point = {.kind = TY_KIND_POINT};
    float depth[4] = {1, 2, INFINITY, 0}, normal[12] = {1, 0, 0, 0, 1, 0, 9, 9, 9, 0, 0, 1}, albedo[12] = {0.5f};
    const ty_rsm good = {.side = 2,
                         .faces = 1,
                         .forward = {{0, 0, 1}},
                         .right = {{0.5, 0, 0}},
                         .up = {{0, 0.3, 0}},
                         .depth = depth,
                         .normal = normal,
                         .albedo = albedo};
    check_result(context, ty_rsm_check(context, &spot, &good, 3));
#define REFUSED(light, words, ...)                                                                                     \
    do {                                                                                                               \
        ty_rsm bad = good;                                                                                             \
        __VA_ARGS__;                                                                                                   \
        assert_int_equal(ty_rsm_check(context, light, &bad, 3), TY_ERROR_ARGUMENT);                                    \
        assert_error(context, words);                                                                                  \
    } while (0)
    REFUSED(&spot, "maps[3].side", bad.side = 0);
    REFUSED(&point, "maps[3].faces", bad.faces = 1);
    REFUSED(&spot, "maps[3].faces", bad.faces = 2);
    REFUSED(&spot, "forward[0]", bad.forward[0][2] = 2);
    REFUSED(&spot, "forward[0]", bad.right[0][2] = 0.2);
    REFUSED(&spot, "forward[0]", bad.up[0][1] = (double)NAN);
    REFUSED(&spot, "forward[0]", bad.up[0][1] = 0);
    REFUSED(&spot, "no depth", bad.depth = NULL);
    REFUSED(&spot, "only one of", bad.albedo = NULL);
    depth[1] = NAN;
    REFUSED(&spot, "texel 1", (void)bad);
    depth[1] = -1;
    REFUSED(&spot, "texel 1", (void)bad);
    depth[1] = 1;
    normal[4] = 2;
    REFUSED(&spot, "texel 1", (void)bad);
    normal[4] = 1;
    albedo[9] = 1.5f;
    REFUSED(&spot, "texel 3", (void)bad);
}

static void no_memory(void** state) {
    (void)state;
    strict_memory memory = {.limit = (size_t)1 << 30, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = make_scene(context);
    const ty_rsm_def def = {.side = 16, .reflective = true};
    add_box(scene, 2);
    add_lamp(scene, TY_LIGHT_POINT, 40, 0, (const double[3]){0, 1, 0});
    check_result(context, ty_scene_commit(scene));
    const size_t before = memory.used;
    for (int64_t n = 0; n < 4; ++n) {
        ty_rsm* map = NULL;
        memory.until_refusal = n;
        assert_int_equal(ty_rsm_trace(scene, &def, 0, &map, NULL), TY_ERROR_MEMORY);
        assert_null(map);
        assert_int_equal(memory.used, before);
        ty_take_error(context);
    }
    memory.until_refusal = -1;
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(shares_are_the_cone, start_context, stop_context),
        cmocka_unit_test_setup_teardown(points_see_all, start_context, stop_context),
        cmocka_unit_test_setup_teardown(suns_cover_boxes, start_context, stop_context),
        cmocka_unit_test_setup_teardown(texels_move_smoothly, start_context, stop_context),
        cmocka_unit_test_setup_teardown(nothing_to_meet, start_context, stop_context),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test_setup_teardown(wrong_lights, start_context, stop_context),
        cmocka_unit_test_setup_teardown(callers_maps, start_context, stop_context),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
