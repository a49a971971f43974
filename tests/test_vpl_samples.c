/* Reflective shadow maps, and virtual point lights chosen from them. */
#include "direct/shadow/grid_depth.h"
#include "direct/lights/vpl_samples.h"
#include "files.h"
#include "method/pop/ordinate/ordinate.h"
#include "pop_maker.h"

static const double pi = 3.14159265358979323846;

static void add_quad(ty_scene* scene, const double origin[3], const double u[3], const double v[3], const float* rgb) {
    ty_shape_def def = ty_default_shape_def();
    for (int a = 0; a < 3; ++a) {
        def.origin[a] = origin[a];
        def.u[a] = u[a];
        def.v[a] = v[a];
        def.albedo[a] = rgb[a];
    }
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
}

/* A floor of 4 m x 4 m at height y. */
static void add_floor(ty_scene* scene, double y) {
    const double origin[3] = {-2, y, -2}, u[3] = {0, 0, 4}, v[3] = {4, 0, 0};
    const float albedo[3] = {0.2f, 0.4f, 0.8f};
    add_quad(scene, origin, u, v, albedo);
}

static void add_room(ty_scene* scene, double half) {
    ty_shape_def def = ty_default_shape_def();
    def.kind = TY_SHAPE_BOX;
    set3(def.origin, -half, -half, -half);
    set3(def.u, half, half, half);
    set3f(def.albedo, 0.5f, 0.5f, 0.5f);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &def));
}

static void add_lamp(ty_scene* scene, ty_light_kind kind, double cone, double x, double y, double z) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    def.cone = cone;
    def.penumbra = 0;
    set3(def.position, x, y, z);
    set3f(def.color, 3, 2, 1);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &def));
}

static ty_vpl_samples* map_of(ty_scene* scene, const ty_vpl_samples_def* def) {
    ty_vpl_samples* map = NULL;
    check_result(ty_scene_context(scene), ty_scene_commit(scene));
    check_result(ty_scene_context(scene), ty_vpl_samples_create(scene, def, 0, &map));
    return map;
}

/* ---- depth ---- */

static void depth_along_rays(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    ty_grid* grid = direct_noise(context, 7, 5, 6, 3);
    ty_medium_def def = ty_default_medium_def();
    def.density_grid = grid;
    def.bounds = TY_BOUNDS_BOX;
    set3(def.box_max, 7, 5, 6);
    set3f(def.sigma_s, 1, 2, 3);
    check_result(context, ty_scene_add_medium(scene, &def));
    ty_grid_release(grid);
    direct_case made = direct_begin(scene, 64, 1, 1);
    const ty_grid_medium* m = made.medium;
    uint64_t random = 5;
    for (int i = 0; i < 200; ++i) {
        const ty_vec from = ty_vec_make((float)uniform_in(&random, -3, 10), (float)uniform_in(&random, -3, 10),
                                        (float)uniform_in(&random, -3, 10));
        const ty_vec omega = random_unit(&random);
        const float far = (float)uniform_in(&random, 1, 12);
        float depth[3];
        double sum = 0;
        enum { STEPS = 20000 };
        ty_grid_depth(m, NULL, from, omega, far, depth);
        for (int k = 0; k < STEPS; ++k) {
            const ty_vec at = ty_mad(from, omega, far * ((float)k + 0.5f) / STEPS);
            const double place[3] = {(double)at.x, (double)at.y, (double)at.z};
            int32_t cell[3];
            bool inside = true;
            for (int a = 0; a < 3; ++a) {
                cell[a] = (int32_t)floor((place[a] - m->box.lower[a]) / m->cell[a]);
                inside &= cell[a] >= 0 && cell[a] < m->box.size[a];
            }
            if (!inside) continue;
            const size_t index =
                (size_t)cell[0] + (size_t)m->box.size[0] * ((size_t)cell[1] + (size_t)m->box.size[1] * (size_t)cell[2]);
            sum += (double)m->extinction[1][index] * (double)far / STEPS;
        }
        assert_close((double)depth[1], sum, 0.01);
        assert_close((double)depth[2], 1.5 * (double)depth[1], 1e-4);
    }
    direct_end(&made);
}

/* ---- maps ---- */

static void a_sun_on_a_square(void** state) {
    static const double directions[3][3] = {{0, -1, 0}, {1, -2, 0.5}, {-1, -0.4, 2}};
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_vpl_samples_def def = {.side = 256};
        add_floor(scene, -1);
        direct_add_sun(scene, directions[i][0], directions[i][1], directions[i][2], 3);
        ty_vpl_samples* map = map_of(scene, &def);
        const double length = sqrt(directions[i][0] * directions[i][0] + directions[i][1] * directions[i][1] +
                                   directions[i][2] * directions[i][2]);
        const double power = 3 * 16 * -directions[i][1] / length;
        double area = 0;
        assert_close(map->flux[0] / (0.2 * power), 1, 0.004);
        assert_close(map->flux[2] / (0.8 * power), 1, 0.004);
        for (size_t t = 0; t < ty_vpl_samples_count(map); ++t) {
            const ty_vpl_sample* texel = &map->items[t];
            area += (double)texel->area;
            if (isinf(texel->distance)) continue;
            ty_vec origin, direction;
            ty_vpl_samples_ray(map, t, &origin, &direction);
            assert_vec_close(ty_mad(origin, direction, texel->distance), texel->position, 1e-4);
            assert_vec_close(texel->normal, ty_vec_make(0, 1, 0), 1e-6);
            assert_true(texel->position.y > -1);
        }
        assert_close(area / 16, 1, 0.004);
        ty_vpl_samples_destroy(map);
        ty_scene_destroy(scene);
    }
}

static void lamps_in_a_room(void** state) {
    static const double cones[5] = {0, 20, 90, 150, 180}; /* 0: a point */
    for (int i = 0; i < 5; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_vpl_samples_def def = {.side = 61};
        const double cap = i == 0 ? 2 : 1 - cos(pi * cones[i] / 360);
        double area = 0;
        add_room(scene, 2);
        add_lamp(scene, i == 0 ? TY_LIGHT_POINT : TY_LIGHT_SPOT, cones[i], 0.3, -0.5, 0.8);
        ty_vpl_samples* map = map_of(scene, &def);
        assert_close(map->flux[0], 0.5 * 3 * 2 * pi * cap, 1e-4 * 3 * 2 * pi * cap);
        assert_close(map->flux[2], 0.5 * 1 * 2 * pi * cap, 1e-4 * 2 * pi * cap);
        for (size_t t = 0; t < ty_vpl_samples_count(map); ++t) area += (double)map->items[t].area;
        if (i == 0) assert_close(area / (6 * 16), 1, 0.02);
        ty_vpl_samples_destroy(map);
        ty_scene_destroy(scene);
    }
}

/* Texels of spots are of the same solid angle: irradiance on a sphere about the light is even. */
static void directions_are_even(void** state) {
    ty_scene* scene = make_scene(*state);
    const ty_vpl_samples_def def = {.side = 128};
    add_room(scene, 2);
    add_lamp(scene, TY_LIGHT_POINT, 0, 0, 0, 0);
    ty_vpl_samples* map = map_of(scene, &def);
    const size_t count = ty_vpl_samples_count(map);
    double moments[9] = {0};
    for (size_t t = 0; t < count; ++t) {
        ty_vec origin, d;
        ty_vpl_samples_ray(map, t, &origin, &d);
        const double x = (double)d.x, y = (double)d.y, z = (double)d.z;
        const double terms[9] = {x, y, z, x * x, y * y, z * z, x * y, y * z, x * z};
        for (int i = 0; i < 9; ++i) moments[i] += terms[i] / (double)count;
    }
    for (int i = 0; i < 9; ++i) assert_close(moments[i], i >= 3 && i < 6 ? 1.0 / 3 : 0, 1e-3);
    ty_vpl_samples_destroy(map);
    ty_scene_destroy(scene);
}

/* Light passes the fog first; and a box keeps the map to a part of the surfaces. */
static void media_and_parts(void** state) {
    ty_context* context = *state;
    ty_scene* scene = pop_fog(context, 0.3f, 0.2f);
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    add_floor(scene, -1.5);
    direct_add_sun(scene, 0, -1, 0, 1);
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_grid_box_fit(scene, 10, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &medium));
    ty_vpl_samples_def def = {.side = 128, .medium = medium};
    ty_vpl_samples* map = map_of(scene, &def);
    assert_close(map->flux[1] / 0.4, 12 + 4 * exp(-1.0), 0.05);
    ty_vpl_samples_destroy(map);
    const double lower[3] = {-1, -3, -1}, upper[3] = {1, 3, 1};
    def.lower = lower;
    def.upper = upper;
    map = map_of(scene, &def);
    assert_close(map->flux[1] / 0.4, 4 * exp(-1.0), 1e-3);
    ty_vpl_samples_destroy(map);
    const double elsewhere[3] = {-1, 2, -1};
    def.lower = elsewhere;
    map = map_of(scene, &def);
    assert_close(map->flux[1], 0, 0);
    ty_vpl_samples_destroy(map);
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
}

static void nothing_to_meet(void** state) {
    static const ty_light_kind kinds[3] = {TY_LIGHT_DIRECTIONAL, TY_LIGHT_POINT, TY_LIGHT_SPOT};
    for (int i = 0; i < 3; ++i) {
        ty_scene* scene = make_scene(*state);
        const ty_vpl_samples_def def = {.side = 16};
        add_lamp(scene, kinds[i], 40, 0, 0, 0);
        ty_vpl_samples* map = map_of(scene, &def);
        assert_close(map->flux[0], 0, 0);
        assert_true(isinf(map->items[7].distance));
        ty_vpl_samples_destroy(map);
        ty_scene_destroy(scene);
    }
}

static void wrong_lights(void** state) {
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    ty_vpl_samples_def def = {.side = 16};
    ty_vpl_samples* map = NULL;
    pop_add_environment(scene, 0, 0, NULL, 0);
    check_result(context, ty_scene_commit(scene));
    assert_int_equal(ty_vpl_samples_create(scene, &def, 0, &map), TY_ERROR_ARGUMENT);
    assert_error(context, "light 0 is not");
    assert_int_equal(ty_vpl_samples_create(scene, &def, 1, &map), TY_ERROR_ARGUMENT);
    assert_error(context, "light 1 is not");
    def.side = 0;
    assert_int_equal(ty_vpl_samples_create(scene, &def, 0, &map), TY_ERROR_ARGUMENT);
    assert_error(context, "VPL samples: side");
    ty_scene_destroy(scene);
}

/* ---- virtual point lights ---- */

/* Fog over a floor, under a sun, a point and a spot. */
static ty_scene* lit_floor(ty_context* context) {
    ty_scene* scene = pop_fog(context, 0.3f, 0.1f);
    add_floor(scene, -1.2);
    direct_add_sun(scene, 0.5, -2, 0.3, 2);
    add_lamp(scene, TY_LIGHT_POINT, 0, 1.5, 1.5, 0);
    add_lamp(scene, TY_LIGHT_SPOT, 50, -1.5, 1.5, 0);
    check_result(context, ty_scene_commit(scene));
    return scene;
}

typedef struct vpls {
    ty_grid_medium* medium;
    ty_discrete_light_set set;
} vpls;

static vpls find(ty_scene* scene, const ty_pop_def* def) {
    ty_context* context = ty_scene_context(scene);
    vpls out = {.medium = NULL};
    ty_grid_box box;
    check_result(context, ty_grid_box_fit(scene, 16, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &out.medium));
    const ty_vpl_def vpl_def = ty_pop_vpl_def(def);
    check_result(context, ty_vpls_create(scene, &vpl_def, out.medium, &out.set));
    return out;
}

static void forget(ty_scene* scene, vpls* found) {
    ty_discrete_light_set_destroy(ty_scene_context(scene), &found->set);
    ty_grid_medium_destroy(found->medium);
}

static void vpls_carry_all_light(void** state) {
    static const int32_t counts[4] = {1, 7, 64, 1000};
    ty_scene* scene = lit_floor(*state);
    for (int n = 0; n < 4; ++n) {
        ty_pop_def def = pop_def(8);
        double sum[3] = {0, 0, 0}, flux[3] = {0, 0, 0};
        def.vpls = counts[n];
        def.mode = TY_POP_MODE_COLLIDED; /* attenuates as media do */
        vpls found = find(scene, &def);
        assert_true(found.set.count <= counts[n] && found.set.count > counts[n] * 0.9);
        for (int32_t i = 0; i < found.set.count; ++i) {
            const ty_discrete_light* vpl = &found.set.items[i];
            assert_int_equal(vpl->kind, TY_DISCRETE_POINT);
            assert_int_equal(vpl->profile, TY_PROFILE_COSINE);
            assert_vec_close(vpl->direction, ty_vec_make(0, 1, 0), 1e-6);
            assert_close((double)vpl->position.y, -1.2, 1e-3);
            assert_close((double)vpl->min_distance, 0.1, 1e-6);
            assert_int_equal(vpl->shadowed, 1);
            assert_true(vpl->mean_cosine > 0 && vpl->mean_cosine <= 1);
            assert_true(vpl->light >= 0 && vpl->light < 3);
            for (int c = 0; c < 3; ++c) sum[c] += pi * (double)vpl->color[c];
        }
        for (int32_t light = 0; light < 3; ++light) {
            const ty_vpl_samples_def map_def = {.side = def.shadow_texels, .medium = found.medium};
            ty_vpl_samples* map = NULL;
            check_result(*state, ty_vpl_samples_create(scene, &map_def, light, &map));
            for (int c = 0; c < 3; ++c) flux[c] += map->flux[c];
            ty_vpl_samples_destroy(map);
        }
        for (int c = 0; c < 3; ++c) assert_close(sum[c] / flux[c], 1, 1e-4);
        forget(scene, &found);
    }
    ty_scene_destroy(scene);
}

/* Irradiance of a plane above the floor: 64 VPLs against a thousand. */
static double irradiance_above(const vpls* found, ty_vec point) {
    double sum = 0;
    for (int32_t i = 0; i < found->set.count; ++i) {
        const ty_vec off = ty_sub(point, found->set.items[i].position);
        const double distance2 = (double)ty_dot(off, off);
        sum +=
            (double)(found->set.items[i].color[1] * ty_dot(off, found->set.items[i].direction)) / pow(distance2, 1.5);
    }
    return sum;
}

static void few_vpls_are_like_many(void** state) {
    ty_scene* scene = lit_floor(*state);
    ty_pop_def few = pop_def(8), many = pop_def(8);
    few.vpls = 64;
    many.vpls = 4096;
    vpls a = find(scene, &few), b = find(scene, &many);
    double square = 0;
    for (int i = 0; i < 9; ++i) {
        const ty_vec point = ty_vec_make((float)(i % 3) - 1, 0, (float)(i / 3) - 1);
        const double error = irradiance_above(&a, point) / irradiance_above(&b, point) - 1;
        square += error * error / 9;
    }
    assert_true(sqrt(square) < 0.02);
    forget(scene, &a);
    forget(scene, &b);
    ty_scene_destroy(scene);
}

/* The floor's other side lights nothing when the fog is above it. */
static void surfaces_that_face_away(void** state) {
    ty_scene* scene = pop_fog(*state, 0.3f, 0);
    add_floor(scene, -1.2);
    direct_add_sun(scene, 0, 1, 0, 2);
    check_result(*state, ty_scene_commit(scene));
    const ty_pop_def def = pop_def(8);
    vpls found = find(scene, &def);
    assert_int_equal(found.set.count, 0);
    forget(scene, &found);
    ty_scene_destroy(scene);
}

/* A far wall is one small patch for the medium, a near one is not. */
static void prefiltering_of_vpls(void** state) {
    double cosine[2];
    for (int i = 0; i < 2; ++i) {
        ty_scene* scene = pop_fog(*state, 0.3f, 0);
        add_floor(scene, i == 0 ? -1.1 : -12);
        direct_add_sun(scene, 0, -1, 0, 2);
        check_result(*state, ty_scene_commit(scene));
        ty_pop_def def = pop_def(8);
        def.vpls = 1;
        vpls found = find(scene, &def);
        assert_int_equal(found.set.count, 1);
        cosine[i] = (double)found.set.items[0].mean_cosine;
        forget(scene, &found);
        ty_scene_destroy(scene);
    }
    assert_true(cosine[0] < 0.75);
    assert_close(cosine[1], 1 - 16 / (4 * pi * 144), 2e-3);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    vpls found[2];
    ty_scene* scenes[2];
    ty_context* contexts[2];
    const ty_pop_def def = pop_def(8);
    for (int i = 0; i < 2; ++i) {
        contexts[i] = make_context(i + 1);
        scenes[i] = lit_floor(contexts[i]);
        found[i] = find(scenes[i], &def);
    }
    assert_int_equal(found[0].set.count, found[1].set.count);
    assert_memory_equal(found[0].set.items, found[1].set.items,
                        (size_t)found[0].set.count * sizeof *found[0].set.items);
    for (int i = 0; i < 2; ++i) {
        forget(scenes[i], &found[i]);
        ty_scene_destroy(scenes[i]);
        ty_context_destroy(contexts[i]);
    }
}

typedef struct vpl_work {
    const ty_scene* scene;
    const ty_grid_medium* medium;
} vpl_work;

static ty_result create_vpls(ty_context* context, void* user) {
    const vpl_work* work = user;
    const ty_pop_def pop = pop_def(8);
    const ty_vpl_def def = ty_pop_vpl_def(&pop);
    ty_discrete_light_set set;
    const ty_result result = ty_vpls_create(work->scene, &def, work->medium, &set);
    ty_discrete_light_set_destroy(context, &set);
    return result;
}

static void no_memory(void** state) {
    (void)state;
    strict_memory memory = {.limit = SIZE_MAX, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = lit_floor(context);
    ty_grid_box box;
    ty_grid_medium* medium = NULL;
    check_result(context, ty_grid_box_fit(scene, 16, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &medium));
    vpl_work work = {scene, medium};
    assert_true(check_short_memory(context, &memory, create_vpls, &work) > 1);
    ty_grid_medium_destroy(medium);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
}

int main(void) {
#define on_context(f) cmocka_unit_test_setup_teardown(f, start_context, stop_context)
    const struct CMUnitTest tests[] = {
        on_context(depth_along_rays),       on_context(a_sun_on_a_square),
        on_context(lamps_in_a_room),        on_context(directions_are_even),
        on_context(media_and_parts),        on_context(nothing_to_meet),
        on_context(wrong_lights),           on_context(vpls_carry_all_light),
        on_context(few_vpls_are_like_many), on_context(surfaces_that_face_away),
        on_context(prefiltering_of_vpls),   cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
