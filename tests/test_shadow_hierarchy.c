/* Which stretches of rays lights reach, against points on them one by one. */
#include "direct/shadow/shadow_hierarchy.h"
#include "rsm_maker.h"

#include <stdio.h>

enum { POINTS = 4096, RAYS = 400 };

static ty_light_view light_of(int32_t kind, ty_vec position, ty_vec direction, double half_angle) {
    return (ty_light_view){.kind = kind,
                           .position = position,
                           .direction = direction,
                           .cos_outer = (float)cos(half_angle),
                           .cos_inner = (float)cos(0.8 * half_angle)};
}

static ty_shadow_hierarchy* lit_of(ty_context* context, const ty_light_view* light, const ty_rsm* map) {
    ty_shadow_hierarchy* lit = NULL;
    assert_int_equal(ty_shadow_hierarchy_create(context, light, map, &lit), TY_OK);
    return lit;
}

static ty_vec random_in(uint64_t* random, double half) {
    const double x = uniform_in(random, -half, half), y = uniform_in(random, -half, half);
    return ty_vec_make((float)x, (float)y, (float)uniform_in(random, -half, half));
}

/* ---- one by one ---- */

/* The result that ty_shadow_lit_segments promises for a point, with the texels that it has; slow, and in double. */
static bool is_lit(const ty_shadow_hierarchy* lit, const double point[3]) {
    const ty_rsm* map = lit->map;
    const bool flat = lit->light.kind == TY_KIND_DIRECTIONAL;
    const ty_vec position = lit->light.position, axis = lit->light.direction;
    const double start[3] = {(double)position.x, (double)position.y, (double)position.z};
    const double along[3] = {(double)axis.x, (double)axis.y, (double)axis.z};
    double off[3], length = 0, ahead = 0;
    for (int a = 0; a < 3; ++a) {
        off[a] = point[a] - (flat ? map->origin[a] : start[a]);
        length += off[a] * off[a];
        ahead += off[a] * along[a];
    }
    if (lit->light.kind == TY_KIND_SPOT && ahead < (double)lit->light.cos_outer * sqrt(length)) return false;
    for (int32_t face = 0; face < map->faces; ++face) {
        double depth = 0, s = 0, t = 0, right = 0, up = 0;
        for (int a = 0; a < 3; ++a) {
            depth += off[a] * map->forward[face][a];
            s += off[a] * map->right[face][a];
            t += off[a] * map->up[face][a];
            right += map->right[face][a] * map->right[face][a];
            up += map->up[face][a] * map->up[face][a];
        }
        s /= right * (flat ? 1 : depth);
        t /= up * (flat ? 1 : depth);
        if ((!flat && depth <= 0) || fabs(s) >= 1 || fabs(t) >= 1) continue;
        const int32_t x = (int32_t)((s + 1) / 2 * map->side), y = (int32_t)((t + 1) / 2 * map->side);
        const double texel = (double)lit->faces[face].texels[y * map->side + x];
        return (flat ? -depth : 1 / depth) >= texel;
    }
    return true;
}

static double lit_fraction(const ty_shadow_hierarchy* lit, ty_vec origin, ty_vec direction, double from, double to) {
    int count = 0;
    for (int i = 0; i < POINTS; ++i) {
        const double t = from + (to - from) * (i + 0.5) / POINTS;
        const double point[3] = {(double)origin.x + t * (double)direction.x, (double)origin.y + t * (double)direction.y,
                                 (double)origin.z + t * (double)direction.z};
        count += is_lit(lit, point);
    }
    return (double)count / POINTS;
}

static void check_order(float stretches[TY_LIT_SEGMENTS_MAX][2], int32_t count, float from, float to) {
    assert_in_range(count, 0, TY_LIT_SEGMENTS_MAX);
    for (int32_t i = 0; i < count; ++i) {
        assert_true(stretches[i][0] < stretches[i][1]);
        assert_true(stretches[i][0] >= (i > 0 ? stretches[i - 1][1] : from));
        assert_true(stretches[i][1] <= to);
    }
}

/* Random rays about a light; its map is made of random depths. */
static void check_rays(ty_context* context, const char* name, const ty_light_view* light, const ty_rsm* map,
                       double reach, uint64_t random) {
    ty_shadow_hierarchy* lit = lit_of(context, light, map);
    double sum = 0, mean_lit = 0, worst = 0;
    int64_t stretches_found = 0;
    int32_t measured = 0;
    for (int i = 0; i < RAYS; ++i) {
        const ty_vec origin = random_in(&random, reach), direction = random_unit(&random);
        const float from = (float)uniform_in(&random, 0, 0.5), to = from + (float)uniform_in(&random, 0.1, 2 * reach);
        float stretches[TY_LIT_SEGMENTS_MAX][2];
        const int32_t count = ty_shadow_lit_segments(lit, origin, direction, from, to, stretches);
        check_order(stretches, count, from, to);
        stretches_found += count;
        if (count == TY_LIT_SEGMENTS_MAX) continue;
        double found = 0;
        for (int32_t k = 0; k < count; ++k) found += (double)(stretches[k][1] - stretches[k][0]) / (double)(to - from);
        const double wanted = lit_fraction(lit, origin, direction, (double)from, (double)to);
        /* Each stretch has two ends that points find to a point's distance. */
        if (fabs(found - wanted) > (1.0 * count + 2) / POINTS + 1e-4)
            fail_msg("%s, ray %d: %.5f lit, not %.5f (%d stretches)", name, i, found, wanted, count);
        sum += found - wanted;
        mean_lit += wanted;
        worst = fmax(worst, fabs(found - wanted));
        ++measured;
    }
    printf("%-26s %4d^2: lit %.3f, mean error %+.1e, worst %.1e, %.1f stretches a ray\n", name, map->side,
           mean_lit / measured, sum / measured, worst, (double)stretches_found / RAYS);
    assert_true(measured > RAYS / 2);
    assert_close(sum / measured, 0, 1e-3);
    ty_shadow_hierarchy_destroy(lit);
}

/* Blocks of even depth, some of them empty. */
typedef struct random_depths {
    double low, high;
    int32_t blocks; /* along a unit of direction or length */
} random_depths;

static double random_depth(const void* user, const double origin[3], const double direction[3]) {
    const random_depths* depths = user;
    uint64_t bits = 17;
    for (int a = 0; a < 3; ++a)
        bits = 31 * bits + (uint64_t)(int64_t)floor((origin[a] + direction[a]) * depths->blocks + 1000);
    uniform(&bits);
    if (uniform(&bits) < 0.2) return INFINITY;
    return uniform_in(&bits, depths->low, depths->high);
}

static void random_maps(void** state) {
    static const int32_t sides[] = {1, 7, 64, 100, 513};
    static const random_depths depths = {1, 6, 3};
    const ty_vec way = ty_normalize(ty_vec_make(1, -2, 0.5f)), here = ty_vec_make(0.3f, 0.1f, -0.2f);
    const ty_light_view sun = light_of(TY_KIND_DIRECTIONAL, here, way, 0),
                        point = light_of(TY_KIND_POINT, here, way, 0);
    const ty_light_view spot = light_of(TY_KIND_SPOT, here, way, 0.6);
    for (size_t i = 0; i < sizeof sides / sizeof *sides; ++i) {
        ty_rsm maps[3] = {made_light_map(&sun, sides[i], 4, ty_scale(way, -4)),
                          made_light_map(&point, sides[i], 1, here), made_light_map(&spot, sides[i], tan(0.6), here)};
        const ty_light_view* lights[3] = {&sun, &point, &spot};
        static const char* const names[3] = {"sun, random depths", "point, random depths", "spot, random depths"};
        for (int k = 0; k < 3; ++k) {
            made_trace(&maps[k], lights[k], random_depth, &depths);
            check_rays(*state, names[k], lights[k], &maps[k], k == 2 ? 2 : 6, 7 + (uint64_t)k);
            free((float*)maps[k].depth);
        }
    }
}

/* ---- a block on a floor ---- */

static const double floor_height = -1, block_lower[3] = {-0.5, -1, -0.4}, block_upper[3] = {0.4, 0.3, 0.5};

static double room_depth(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    double part[2] = {0, INFINITY};
    if (made_clip(block_lower, block_upper, origin, direction, part)) return part[0];
    const double t = (floor_height - origin[1]) / direction[1];
    return t > 0 ? t : INFINITY;
}

/* From an eye to the floor: its end is lit wherever no block is in the way, but for the block's own edges. */
static void check_floor(ty_context* context, const char* name, const ty_light_view* light, ty_rsm* map) {
    made_trace(map, light, room_depth, NULL);
    ty_shadow_hierarchy* lit = lit_of(context, light, map);
    uint64_t random = 5;
    int lit_ends = 0, dark_ends = 0;
    double dark_slivers = 0;
    for (int i = 0; i < 4 * RAYS; ++i) {
        const ty_vec eye = ty_vec_make(1.5f, 0.7f, 1.2f);
        const ty_vec end = ty_vec_make((float)uniform_in(&random, -2, 2), -1, (float)uniform_in(&random, -2, 2));
        const bool flat = light->kind == TY_KIND_DIRECTIONAL;
        const ty_vec back = flat ? ty_scale(light->direction, -1) : ty_sub(light->position, end);
        const double from[3] = {(double)end.x, (double)end.y, (double)end.z};
        const double way[3] = {(double)back.x, (double)back.y, (double)back.z};
        const double wide[2][3] = {{-0.6, -2, -0.5}, {0.5, 0.4, 0.6}},
                     narrow[2][3] = {{-0.4, -2, -0.3}, {0.3, 0.2, 0.4}};
        double part[2] = {0, flat ? INFINITY : 1}, inner[2] = {0, part[1]};
        const bool dark = made_clip(narrow[0], narrow[1], from, way, inner);
        if (!dark && made_clip(wide[0], wide[1], from, way, part)) continue;
        const ty_vec ray = ty_sub(end, eye);
        const float far = sqrtf(ty_dot(ray, ray));
        float stretches[TY_LIT_SEGMENTS_MAX][2];
        const int32_t count = ty_shadow_lit_segments(lit, eye, ty_scale(ray, 1 / far), 0, far, stretches);
        const float last = count > 0 ? stretches[count - 1][1] : 0;
        dark_ends += dark;
        if (dark) {
            assert_true(last < far - 0.01f);
            continue;
        }
        ++lit_ends;
        dark_slivers += (double)(far - last);
        if (!(last >= far * (1 - 1e-5f))) fail_msg("%s: dark from %g of %g on", name, (double)last, (double)far);
    }
    printf("%-26s %4d^2: %d ends lit, %d dark, mean sliver %.1e m\n", name, map->side, lit_ends, dark_ends,
           dark_slivers / lit_ends);
    assert_true(lit_ends > RAYS && dark_ends > 20);
    check_rays(context, name, light, map, 1.5, 3);
    ty_shadow_hierarchy_destroy(lit);
    free((float*)map->depth);
}

static void ends_on_surfaces(void** state) {
    const ty_vec way = ty_normalize(ty_vec_make(-0.6f, -1, -0.3f)), lamp = ty_vec_make(0.8f, 1.6f, 0.9f);
    const ty_vec aim = ty_normalize(ty_sub(ty_vec_make(0, -1, 0), lamp));
    const ty_light_view sun = light_of(TY_KIND_DIRECTIONAL, lamp, way, 0),
                        point = light_of(TY_KIND_POINT, lamp, way, 0);
    const ty_light_view spot = light_of(TY_KIND_SPOT, lamp, aim, 1.2);
    ty_rsm maps[3] = {made_light_map(&sun, 256, 4, ty_scale(way, -6)), made_light_map(&point, 128, 1, lamp),
                      made_light_map(&spot, 512, tan(1.2), lamp)};
    check_floor(*state, "sun, block on a floor", &sun, &maps[0]);
    check_floor(*state, "point, block on a floor", &point, &maps[1]);
    check_floor(*state, "spot, block on a floor", &spot, &maps[2]);
}

/* ---- cones, nothing, too much ---- */

static double nothing(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    (void)origin;
    (void)direction;
    return INFINITY;
}

/* Visibility of the light from a level surface that faces up, and whether it is sure. */
static void check_share(const ty_shadow_hierarchy* lit, ty_vec point, double share, bool sure) {
    bool is_sure = !sure;
    assert_close(ty_shadow_visibility(lit, point, ty_vec_make(0, 1, 0), 0.1f, 0.3f, &is_sure), share, 1e-4);
    assert_int_equal(is_sure, sure);
}

static void cones(void** state) {
    const ty_vec down = ty_vec_make(0, -1, 0), lamp = ty_vec_make(0, 2, 0);
    const double half = 0.5;
    const ty_light_view spot = light_of(TY_KIND_SPOT, lamp, down, half);
    ty_rsm map = made_light_map(&spot, 8, tan(half), lamp);
    made_trace(&map, &spot, nothing, NULL);
    ty_shadow_hierarchy* lit = lit_of(*state, &spot, &map);
    float stretches[TY_LIT_SEGMENTS_MAX][2];
    /* Across the axis 2 m below, past the cone, along the axis from both sides, within it, and behind the lamp. */
    assert_int_equal(ty_shadow_lit_segments(lit, ty_vec_make(-5, 0, 0), ty_vec_make(1, 0, 0), 0, 9, stretches), 1);
    assert_close(stretches[0][0], 5 - 2 * tan(half), 1e-5);
    assert_close(stretches[0][1], 5 + 2 * tan(half), 1e-5);
    assert_int_equal(ty_shadow_lit_segments(lit, ty_vec_make(-5, 0, 2), ty_vec_make(1, 0, 0), 0, 9, stretches), 0);
    assert_int_equal(ty_shadow_lit_segments(lit, ty_vec_make(0, 5, 0), down, 0, 9, stretches), 1);
    assert_close(stretches[0][0], 3, 1e-5);
    assert_close(stretches[0][1], 9, 0);
    assert_int_equal(ty_shadow_lit_segments(lit, ty_vec_make(0, -4, 0), ty_vec_make(0, 1, 0), 0, 9, stretches), 1);
    assert_close(stretches[0][0], 0, 0);
    assert_close(stretches[0][1], 6, 1e-5);
    assert_int_equal(ty_shadow_lit_segments(lit, ty_vec_make(-5, 2.5f, 0), ty_vec_make(1, 0, 0), 0, 9, stretches), 0);
    check_share(lit, ty_vec_make(0, 1, 0), 1, true);
    check_share(lit, ty_vec_make(1, 1, 0), 0, true);
    check_share(lit, ty_vec_make(0, 3, 0), 0, true);
    ty_shadow_hierarchy_destroy(lit);
    free((float*)map.depth);
}

/* Stripes: more stretches than there is room for. */
static double stripes(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    (void)direction;
    const double wide = origin[0] > 0 ? 0.02 : 0.01;
    return fmod(floor((origin[0] + 8) / wide), 2) == 0 ? 1 : INFINITY;
}

static void too_many_stretches(void** state) {
    const ty_vec down = ty_vec_make(0, -1, 0);
    const ty_light_view sun = light_of(TY_KIND_DIRECTIONAL, down, down, 0);
    ty_rsm map = made_light_map(&sun, 200, 1, ty_vec_make(0, 2, 0));
    made_trace(&map, &sun, stripes, NULL);
    ty_shadow_hierarchy* lit = lit_of(*state, &sun, &map);
    float stretches[TY_LIT_SEGMENTS_MAX][2];
    const int32_t count = ty_shadow_lit_segments(lit, ty_vec_make(-1.5f, 0, 0), ty_vec_make(1, 0, 0), 0, 3, stretches);
    assert_int_equal(count, TY_LIT_SEGMENTS_MAX);
    check_order(stretches, count, 0, 3);
    double dark = 0, least = 1;
    for (int32_t i = 1; i < count; ++i) {
        dark += (double)(stretches[i][0] - stretches[i - 1][1]);
        least = fmin(least, (double)(stretches[i][0] - stretches[i - 1][1]));
    }
    /* 25 wide ones are kept, and of 50 narrow ones as many as there is room for. */
    assert_close(dark, 25 * 0.02 + 38 * 0.01, 0.005);
    assert_true(least > 0.009);
    ty_shadow_hierarchy_destroy(lit);
    free((float*)map.depth);
}

/* ---- points ---- */

static double edge(const void* user, const double origin[3], const double direction[3]) {
    (void)user;
    (void)direction;
    return origin[0] < 0 ? 1 : 3;
}

static void points(void** state) {
    const ty_vec down = ty_vec_make(0, -1, 0);
    const ty_light_view sun = light_of(TY_KIND_DIRECTIONAL, down, down, 0);
    ty_rsm map = made_light_map(&sun, 100, 1, ty_vec_make(0, 2, 0));
    made_trace(&map, &sun, edge, NULL);
    ty_shadow_hierarchy* lit = lit_of(*state, &sun, &map);
    bool sure = false;
    check_share(lit, ty_vec_make(-0.5f, 0.5f, 0), 0, true);
    check_share(lit, ty_vec_make(-0.5f, 0.8f, 0), 0, false); /* it may be the surface itself that is nearer */
    check_share(lit, ty_vec_make(-0.5f, 0.95f, 0), 1, true); /* within slack */
    check_share(lit, ty_vec_make(-0.5f, 1.5f, 0), 1, true);
    check_share(lit, ty_vec_make(0.5f, 0.5f, 0), 1, true);
    check_share(lit, ty_vec_make(0.005f, 0.5f, 0), 0.75, false); /* a quarter of a texel beside the edge */
    check_share(lit, ty_vec_make(-0.005f, 0.5f, 0), 0.25, false);
    check_share(lit, ty_vec_make(0.5f, -1.5f, 0), 0, true);
    check_share(lit, ty_vec_make(2, -1.5f, 0), 1, true); /* beside the map */
    check_share(lit, ty_vec_make(1, 0.5f, 1), 1, true);  /* its corner */
    assert_close(ty_shadow_visibility(lit, ty_vec_make(0.5f, 0.5f, 0), ty_vec_make(0, -1, 0), 0.1f, 0.3f, &sure), 0, 0);
    assert_true(sure);
    ty_shadow_hierarchy_destroy(lit);
    free((float*)map.depth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_maps),        cmocka_unit_test(ends_on_surfaces), cmocka_unit_test(cones),
        cmocka_unit_test(too_many_stretches), cmocka_unit_test(points),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
