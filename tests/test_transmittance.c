/* Transmittance between points: closed forms where media are homogeneous, quadrature in grids. */
#include "checks.h"

#include <stddef.h>

typedef struct segment {
    double from[3], to[3];
} segment;

static segment random_segment(uint64_t* random, double reach) {
    segment s;
    for (int a = 0; a < 3; ++a) {
        s.from[a] = uniform_in(random, -reach, reach);
        s.to[a] = uniform_in(random, -reach, reach);
    }
    return s;
}

static double length_of(const segment* s) {
    return sqrt(pow(s->to[0] - s->from[0], 2) + pow(s->to[1] - s->from[1], 2) + pow(s->to[2] - s->from[2], 2));
}

/* The share of a segment, seen from the medium's own space, that is within its bounds. */
static double share_inside(const ty_medium_def* medium, const segment* s) {
    ty_affine inverse;
    double o[3], end[3], enter = 0, leave = 1;
    assert_true(ty_affine_invert(&medium->transform, &inverse));
    ty_affine_point(&inverse, s->from, o);
    ty_affine_point(&inverse, s->to, end);
    double aa = 0, ab = 0, bb = 0;
    for (int a = 0; a < 3; ++a) {
        const double d = end[a] - o[a], off = o[a] - medium->sphere_center[a];
        aa += d * d;
        ab += d * off;
        bb += off * off;
        if (medium->bounds != TY_BOUNDS_BOX) continue;
        const double t0 = (medium->box_min[a] - o[a]) / d, t1 = (medium->box_max[a] - o[a]) / d;
        enter = fmax(enter, fmin(t0, t1));
        leave = fmin(leave, fmax(t0, t1));
    }
    if (medium->bounds == TY_BOUNDS_SPHERE) {
        const double square = ab * ab - aa * (bb - medium->sphere_radius * medium->sphere_radius);
        if (square <= 0) return 0;
        enter = fmax(enter, (-ab - sqrt(square)) / aa);
        leave = fmin(leave, (-ab + sqrt(square)) / aa);
    }
    return fmax(leave - enter, 0);
}

static ty_medium_def turned_box(void) {
    const double lower[3] = {-1, -0.5, -2}, upper[3] = {1.5, 1, 0.5};
    const double move[3] = {0.5, 0.25, -0.5}, turn[3] = {35, -20, 80}, scale[3] = {0.8, 1.2, 1};
    ty_medium_def medium = box_medium(lower, upper, 0, 0);
    medium.transform = ty_affine_compose(move, turn, scale);
    set3f(medium.sigma_s, 0.5f, 0.25f, 0);
    set3f(medium.sigma_a, 0.25f, 1, 0);
    medium.scale = 1.5f;
    return medium;
}

static ty_medium_def stretched_sphere(void) {
    const double move[3] = {0.1, -0.2, 0.3}, turn[3] = {0, 30, 60}, scale[3] = {2, 1, -0.75};
    ty_medium_def medium = ty_default_medium_def();
    medium.bounds = TY_BOUNDS_SPHERE;
    set3(medium.sphere_center, 0.25, 0, 0.5);
    medium.sphere_radius = 0.75;
    medium.transform = ty_affine_compose(move, turn, scale);
    set3f(medium.sigma_a, 0.125f, 2, 0.75f);
    return medium;
}

static ty_scene* scene_of(ty_context* context, const ty_medium_def* media, int count) {
    ty_scene* scene = make_scene(context);
    for (int i = 0; i < count; ++i) assert_int_equal(ty_scene_add_medium(scene, &media[i]), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static void transmit(const ty_scene* scene, const segment* s, int32_t spp, uint64_t seed, double out[3]) {
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    def.seed = seed;
    assert_int_equal(ty_path_transmittance(scene, &def, s->from, s->to, out), TY_OK);
}

static void check_homogeneous(ty_context* context, const ty_medium_def* media, int count) {
    ty_scene* scene = scene_of(context, media, count);
    uint64_t random = 51;
    int crossing = 0;
    for (int i = 0; i < 2000; ++i) {
        const segment s = random_segment(&random, 3);
        double found[3], depth[3] = {0, 0, 0};
        for (int m = 0; m < count; ++m)
            for (int c = 0; c < 3; ++c)
                depth[c] += (double)(media[m].scale * (media[m].sigma_s[c] + media[m].sigma_a[c])) *
                            share_inside(&media[m], &s) * length_of(&s);
        transmit(scene, &s, 1, 0, found);
        for (int c = 0; c < 3; ++c) assert_close(found[c], exp(-depth[c]), 2e-5);
        crossing += depth[1] > 0;
    }
    assert_true(crossing > 200);
    ty_scene_destroy(scene);
}

static void homogeneous_media_are_exact(void** state) {
    const ty_medium_def media[3] = {turned_box(), stretched_sphere(), turned_box()};
    check_homogeneous(*state, &media[0], 1);
    check_homogeneous(*state, &media[1], 1);
    check_homogeneous(*state, media, 3);
}

static void ends_cut_the_way(void** state) {
    const double lower[3] = {0, 0, 0}, upper[3] = {2, 2, 2};
    const ty_medium_def box = box_medium(lower, upper, 0.5f, 0.5f);
    ty_scene* scene = scene_of(*state, &box, 1);
    static const struct {
        segment s;
        double length;
    } cases[] = {
        {{{-1, 1, 1}, {3, 1, 1}}, 2},        {{{1, 1, 1}, {3, 1, 1}}, 1},   {{{-1, 1, 1}, {0.5, 1, 1}}, 0.5},
        {{{0.5, 1, 1}, {1.25, 1, 1}}, 0.75}, {{{-3, 1, 1}, {-1, 1, 1}}, 0}, {{{3, 1, 1}, {5, 1, 1}}, 0},
        {{{1, 3, 1}, {1, 3, 5}}, 0},         {{{1, 1, 1}, {1, 1, 1}}, 0},   {{{-9, 1, 1}, {-9, 1, 1}}, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        double found[3], back[3];
        const segment reverse = {{cases[i].s.to[0], cases[i].s.to[1], cases[i].s.to[2]},
                                 {cases[i].s.from[0], cases[i].s.from[1], cases[i].s.from[2]}};
        transmit(scene, &cases[i].s, 3, 0, found);
        transmit(scene, &reverse, 3, 0, back);
        assert_close(found[0], exp(-cases[i].length), 1e-6);
        assert_close(back[0], exp(-cases[i].length), 1e-6);
    }
    ty_scene_destroy(scene);
}

static void nothing_attenuates_nothing(void** state) {
    ty_scene* scene = scene_of(*state, NULL, 0);
    const segment s = {{0, 0, 0}, {1e6, 0, 0}};
    double found[3];
    transmit(scene, &s, 2, 0, found);
    for (int c = 0; c < 3; ++c) assert_close(found[c], 1, 0);
    ty_scene_destroy(scene);
}

/* ---- grids ---- */

enum { NX = 11, NY = 7, NZ = 9, VOXELS = NX * NY * NZ };

/* Random densities, a third of them 0: bricks have room between their extremes. */
static ty_grid* cloud(ty_context* context, ty_grid_type type, bool placed) {
    uint64_t random = 52;
    float values[VOXELS];
    uint16_t halves[VOXELS];
    for (int i = 0; i < VOXELS; ++i) {
        values[i] = (float)fmax(uniform_in(&random, -1, 2), 0);
        halves[i] = (uint16_t)(0x3400 + 0x800 * uniform(&random)); /* 0.25 to 1 */
    }
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = NX;
    def.size[1] = NY;
    def.size[2] = NZ;
    def.type = type;
    def.values = type == TY_GRID_F16 ? (const void*)halves : values;
    def.placed = placed;
    if (placed) {
        const double move[3] = {-1, -0.5, -1}, turn[3] = {10, 20, 30}, scale[3] = {0.2, 0.3, 0.25};
        def.index_to_local = ty_affine_compose(move, turn, scale);
    }
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
    return grid;
}

/* The map from the world to a grid's indices. */
static ty_affine to_index(const ty_medium_def* medium) {
    const ty_grid_info info = ty_grid_get_info(medium->density_grid);
    ty_affine local = info.index_to_local, inverse;
    for (int a = 0; a < 3 && !info.placed; ++a) {
        const double cell = (medium->box_max[a] - medium->box_min[a]) / info.size[a];
        for (int c = 0; c < 3; ++c) local.m[4 * a + c] = a == c ? cell : 0;
        local.m[4 * a + 3] = medium->box_min[a] + 0.5 * cell;
    }
    local = ty_affine_multiply(&medium->transform, &local);
    assert_true(ty_affine_invert(&local, &inverse));
    return inverse;
}

static bool is_inside(const ty_medium_def* medium, const double point[3]) {
    ty_affine inverse;
    double p[3], square = 0;
    if (medium->bounds == TY_BOUNDS_NONE) return true;
    assert_true(ty_affine_invert(&medium->transform, &inverse));
    ty_affine_point(&inverse, point, p);
    for (int a = 0; a < 3; ++a) {
        if (medium->bounds == TY_BOUNDS_BOX && (p[a] < medium->box_min[a] || p[a] > medium->box_max[a])) return false;
        square += pow(p[a] - medium->sphere_center[a], 2);
    }
    return medium->bounds == TY_BOUNDS_BOX || square <= medium->sphere_radius * medium->sphere_radius;
}

/* The integral of density along a segment by the midpoint rule. */
static double integrate(const ty_medium_def* medium, const segment* s) {
    const ty_affine map = to_index(medium);
    const int steps = 4000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        double point[3], index[3];
        for (int a = 0; a < 3; ++a) point[a] = s->from[a] + (s->to[a] - s->from[a]) * (i + 0.5) / steps;
        if (!is_inside(medium, point)) continue;
        ty_affine_point(&map, point, index);
        sum += (double)ty_grid_sample(medium->density_grid, index);
    }
    return sum / steps * length_of(s);
}

/* Means over batches of independent seeds, whose scatter gives the error of the mean. */
static void check_grid(ty_context* context, const ty_medium_def* medium) {
    enum { BATCHES = 40, SPP = 50 };
    ty_scene* scene = scene_of(context, medium, 1);
    uint64_t random = 53;
    int dense = 0;
    for (int i = 0; i < 24; ++i) {
        const segment s = random_segment(&random, 1.5);
        const double amount = integrate(medium, &s);
        double sum[3] = {0, 0, 0}, square[3] = {0, 0, 0}, batch[3];
        for (uint64_t n = 0; n < BATCHES; ++n) {
            transmit(scene, &s, SPP, 100 * n + (uint64_t)i, batch);
            for (int c = 0; c < 3; ++c) {
                sum[c] += batch[c];
                square[c] += batch[c] * batch[c];
            }
        }
        for (int c = 0; c < 3; ++c) {
            const double depth = amount * (double)(medium->scale * (medium->sigma_s[c] + medium->sigma_a[c]));
            const double mean = sum[c] / BATCHES, variance = fmax(square[c] / BATCHES - mean * mean, 0);
            if (depth > 5) {
                /* Carried by rare bright samples, whose scatter so few batches do not show. */
                assert_true(mean < 0.03);
                continue;
            }
            assert_close(mean, exp(-depth), 5 * sqrt(variance / (BATCHES - 1)) + 2e-3 * exp(-depth));
            dense += depth > 1.5;
        }
    }
    assert_true(dense > 3);
    ty_scene_destroy(scene);
}

static void set_sigmas(ty_medium_def* medium, bool gray) {
    set3f(medium->sigma_s, 1, gray ? 1 : 0.25f, gray ? 1 : 2);
    set3f(medium->sigma_a, 0.5f, gray ? 0.5f : 0, gray ? 0.5f : 1);
    medium->scale = 1.5f;
}

static void grids_that_fill_a_box(void** state) {
    for (int type = TY_GRID_F32; type <= TY_GRID_F16; ++type) {
        ty_medium_def medium = turned_box();
        medium.density_grid = cloud(*state, (ty_grid_type)type, false);
        set_sigmas(&medium, type == TY_GRID_F16);
        check_grid(*state, &medium);
        ty_grid_release(medium.density_grid);
    }
}

static void grids_with_a_place(void** state) {
    static const ty_bounds_kind kinds[] = {TY_BOUNDS_NONE, TY_BOUNDS_BOX, TY_BOUNDS_SPHERE};
    for (int i = 0; i < 3; ++i) {
        ty_medium_def medium = turned_box();
        medium.bounds = kinds[i];
        medium.sphere_radius = 1;
        medium.density_grid = cloud(*state, TY_GRID_F32, true);
        set_sigmas(&medium, i == 1);
        check_grid(*state, &medium);
        ty_grid_release(medium.density_grid);
    }
}

/* A grid of one value leaves nothing to chance. */
static void constant_grids_are_exact_within(void** state) {
    float values[27];
    for (int i = 0; i < 27; ++i) values[i] = 0.75f;
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = 3;
    def.values = values;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create(*state, &def, &grid), TY_OK);
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_medium_def medium = box_medium(lower, upper, 2, 0);
    medium.density_grid = grid;
    ty_scene* scene = scene_of(*state, &medium, 1);
    const segment s = {{-2, 0.1, 0.2}, {2, 0.1, 0.2}};
    double found[3];
    transmit(scene, &s, 1, 0, found);
    assert_close(found[0], exp(-3), 1e-6);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

static void wrong_arguments_are_refused(void** state) {
    ty_scene* scene = make_scene(*state);
    ty_path_def def = ty_default_path_def();
    double found[3];
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, nowhere[3] = {0, NAN, 0}, far[3] = {0, 0, 1e16};
    assert_int_equal(ty_path_transmittance(scene, &def, zero, one, found), TY_ERROR_ARGUMENT);
    assert_error(*state, "not committed");
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    assert_int_equal(ty_path_transmittance(scene, &def, nowhere, one, found), TY_ERROR_ARGUMENT);
    assert_error(*state, "transmittance: from[1]");
    assert_int_equal(ty_path_transmittance(scene, &def, zero, far, found), TY_ERROR_ARGUMENT);
    assert_error(*state, "transmittance: to[2]");
    def.spp = 0;
    assert_int_equal(ty_path_transmittance(scene, &def, zero, one, found), TY_ERROR_ARGUMENT);
    assert_error(*state, "path.spp");
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(homogeneous_media_are_exact), cmocka_unit_test(ends_cut_the_way),
        cmocka_unit_test(nothing_attenuates_nothing),  cmocka_unit_test(grids_that_fill_a_box),
        cmocka_unit_test(grids_with_a_place),          cmocka_unit_test(constant_grids_are_exact_within),
        cmocka_unit_test(wrong_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
