/* Procedural densities: what each kind promises, and that nothing but the def decides the result. */
#include "checks.h"

#include <math.h>
#include <string.h>

static ty_grid* make_noise(ty_context* context, const ty_noise_def* def) {
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create_noise(context, def, &grid), TY_OK);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_memory_equal(info.size, def->size, sizeof info.size);
    assert_int_equal(info.type, TY_GRID_F16);
    assert_false(info.placed);
    assert_true(info.min >= 0 && info.max <= 1);
    return grid;
}

static ty_noise_def sized(ty_noise_kind kind, int32_t x, int32_t y, int32_t z) {
    ty_noise_def def = ty_default_noise_def();
    def.kind = kind;
    def.size[0] = x;
    def.size[1] = y;
    def.size[2] = z;
    return def;
}

static int64_t count_differing(const ty_grid* a, const ty_grid* b, const int32_t size[3]) {
    int64_t differing = 0;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i) differing += ty_grid_voxel(a, i, j, k) != ty_grid_voxel(b, i, j, k);
    return differing;
}

static double share_above(const ty_grid* grid, const int32_t size[3], float bound) {
    int64_t above = 0;
    for (int32_t k = 0; k < size[2]; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i) above += ty_grid_voxel(grid, i, j, k) > bound;
    return (double)above / ((double)size[0] * size[1] * size[2]);
}

static void threads_do_not_matter(void** state) {
    (void)state;
    ty_context* one = make_context(1);
    ty_context* three = make_context(3);
    for (int kind = TY_NOISE_FBM; kind <= TY_NOISE_NEBULA; ++kind) {
        const ty_noise_def def = sized((ty_noise_kind)kind, 41, 33, 27);
        ty_grid* a = make_noise(one, &def);
        ty_grid* b = make_noise(three, &def);
        assert_int_equal(count_differing(a, b, def.size), 0);
        ty_grid_release(a);
        ty_grid_release(b);
    }
    ty_context_destroy(one);
    ty_context_destroy(three);
}

static void constant_is_one(void** state) {
    ty_context* context = *state;
    const ty_noise_def def = sized(TY_NOISE_CONSTANT, 5, 4, 3);
    ty_grid* grid = make_noise(context, &def);
    const ty_grid_info info = ty_grid_get_info(grid);
    assert_true(info.min == 1 && info.max == 1 && info.mean == 1);
    ty_grid_release(grid);
}

static void cloud_vanishes_at_the_faces(void** state) {
    ty_context* context = *state;
    for (int full = 0; full < 2; ++full) {
        ty_noise_def def = sized(TY_NOISE_CLOUD, 48, 40, 44);
        def.coverage = full != 0 ? 1.0f : 0.5f;
        ty_grid* grid = make_noise(context, &def);
        int64_t on_faces = 0;
        for (int32_t k = 0; k < 44; ++k)
            for (int32_t j = 0; j < 40; ++j)
                for (int32_t i = 0; i < 48; ++i)
                    if (i == 0 || i == 47 || j == 0 || j == 39 || k == 0 || k == 43)
                        on_faces += ty_grid_voxel(grid, i, j, k) != 0;
        assert_int_equal(on_faces, 0);
        assert_true(ty_grid_get_info(grid).mean > (full != 0 ? 0.5 : 0.1));
        ty_grid_release(grid);
    }
}

/* Solid inside, thin edge, flat base, wide foot, narrow top: for any seed. */
static void cloud_is_a_cumulus(void** state) {
    ty_context* context = *state;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        ty_noise_def def = sized(TY_NOISE_CLOUD, 64, 64, 64);
        def.seed = seed;
        ty_grid* grid = make_noise(context, &def);
        const double some = share_above(grid, def.size, 0), solid = share_above(grid, def.size, 0.95f);
        assert_true(some > 0.15 && some < 0.5);
        assert_true(solid > 0.6 * some && solid < 0.95 * some);
        double level[64] = {0};
        for (int32_t j = 0; j < 64; ++j)
            for (int32_t k = 0; k < 64; ++k)
                for (int32_t i = 0; i < 64; ++i) level[j] += (double)ty_grid_voxel(grid, i, j, k) / 4096;
        for (int32_t j = 0; j < 4; ++j) assert_true(level[j] == 0);
        assert_true(level[14] > 0.25);
        assert_true(level[14] > 4 * level[7]);
        assert_true(level[48] > 0 && level[48] < 0.5 * level[14]);
        ty_grid_release(grid);
    }
}

/* Dense in the arch and in the ball, thin about both, nothing under the arch beside the ball and on the faces. */
static void nebula_has_an_arch_and_a_ball(void** state) {
    ty_context* context = *state;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        ty_noise_def def = sized(TY_NOISE_NEBULA, 64, 64, 64);
        def.seed = seed;
        ty_grid* grid = make_noise(context, &def);
        const double some = share_above(grid, def.size, 0), solid = share_above(grid, def.size, 0.5f);
        assert_true(some > 0.05 && some < 0.3);
        assert_true(solid > 0.05 * some && solid < 0.7 * some);
        double top = 0, middle = 0, ball = 0;
        for (int32_t k = 26; k < 38; ++k)
            for (int32_t j = 0; j < 64; ++j) {
                const double value = (double)ty_grid_voxel(grid, 32, j, k);
                if (j >= 40) top = fmax(top, value);
                if (j >= 26 && j < 32) middle = fmax(middle, value);
                if (j < 22) ball = fmax(ball, value);
                assert_true(j > 0 || value == 0);
            }
        assert_true(top > 0.3 && ball > 0.3 && middle < 0.3);
        ty_grid_release(grid);
    }
}

/* A cloud that rises along z is the same one turned: (x, y, z) -> (x, -z, y). */
static void up_axis_turns_the_cloud(void** state) {
    ty_context* context = *state;
    ty_noise_def def = sized(TY_NOISE_CLOUD, 40, 36, 32);
    ty_grid* y_up = make_noise(context, &def);
    def.up_axis = 2;
    def.size[1] = 32;
    def.size[2] = 36;
    ty_grid* z_up = make_noise(context, &def);
    int64_t differing = 0;
    for (int32_t k = 0; k < 32; ++k)
        for (int32_t j = 0; j < 36; ++j)
            for (int32_t i = 0; i < 40; ++i)
                differing += ty_grid_voxel(y_up, i, j, k) != ty_grid_voxel(z_up, i, 31 - k, j);
    assert_int_equal(differing, 0);
    ty_grid_release(y_up);
    ty_grid_release(z_up);
}

static void seeds_differ(void** state) {
    ty_context* context = *state;
    ty_noise_def def = sized(TY_NOISE_FBM, 48, 48, 48);
    def.sharpness = 1;
    def.frequency = 8;
    ty_grid* grids[3];
    for (uint32_t s = 0; s < 3; ++s) {
        def.seed = s == 2 ? 7 : 7 + s;
        grids[s] = make_noise(context, &def);
    }
    assert_int_equal(count_differing(grids[0], grids[2], def.size), 0);
    double mean[2] = {ty_grid_get_info(grids[0]).mean, ty_grid_get_info(grids[1]).mean};
    double covariance = 0, variance[2] = {0, 0};
    for (int32_t k = 0; k < 48; ++k)
        for (int32_t j = 0; j < 48; ++j)
            for (int32_t i = 0; i < 48; ++i) {
                const double a = (double)ty_grid_voxel(grids[0], i, j, k) - mean[0];
                const double b = (double)ty_grid_voxel(grids[1], i, j, k) - mean[1];
                covariance += a * b;
                variance[0] += a * a;
                variance[1] += b * b;
            }
    assert_true(variance[0] > 0 && variance[1] > 0);
    assert_true(fabs(covariance) < 0.12 * sqrt(variance[0] * variance[1]));
    for (int s = 0; s < 3; ++s) ty_grid_release(grids[s]);
    ty_noise_def cloud = sized(TY_NOISE_CLOUD, 32, 32, 32);
    ty_grid* a = make_noise(context, &cloud);
    cloud.seed = 2;
    ty_grid* b = make_noise(context, &cloud);
    assert_true(count_differing(a, b, cloud.size) > 32 * 32 * 32 / 20);
    ty_grid_release(a);
    ty_grid_release(b);
}

static void coverage_is_a_share(void** state) {
    ty_context* context = *state;
    const float coverages[] = {0, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 1};
    for (int octaves = 1; octaves <= 4; octaves += 3)
        for (size_t c = 0; c < sizeof coverages / sizeof *coverages; ++c) {
            ty_noise_def def = sized(TY_NOISE_FBM, 64, 64, 64);
            def.frequency = 10;
            def.octaves = octaves;
            def.sharpness = 1000;
            def.coverage = coverages[c];
            ty_grid* grid = make_noise(context, &def);
            const double share = share_above(grid, def.size, 0.5f);
            assert_true(fabs(share - (double)coverages[c]) < 0.04);
            if (c == 0) assert_true(ty_grid_get_info(grid).max == 0);
            if (coverages[c] == 1) assert_true(ty_grid_get_info(grid).min == 1);
            ty_grid_release(grid);
        }
    double before = -1;
    for (size_t c = 0; c < sizeof coverages / sizeof *coverages; ++c) {
        ty_noise_def def = sized(TY_NOISE_CLOUD, 32, 32, 32);
        def.coverage = coverages[c];
        ty_grid* grid = make_noise(context, &def);
        const double mean = ty_grid_get_info(grid).mean;
        assert_true(c == 0 ? mean == 0 : mean >= before);
        if (coverages[c] == 0.5f) assert_true(mean > before);
        before = mean;
        ty_grid_release(grid);
    }
    assert_true(before > 0.6);
}

/* Neighbours are close to one another, across lattice cells too. */
static void noise_is_continuous(void** state) {
    ty_context* context = *state;
    for (int kind = TY_NOISE_FBM; kind <= TY_NOISE_NEBULA; ++kind) {
        ty_noise_def def = sized((ty_noise_kind)kind, 96, 96, 96);
        def.octaves = 1;
        def.frequency = kind == TY_NOISE_FBM ? 4 : 2;
        def.sharpness = kind == TY_NOISE_FBM ? 1.0f : kind == TY_NOISE_CLOUD ? 0.5f : 4.0f;
        ty_grid* grid = make_noise(context, &def);
        float step[3] = {0, 0, 0};
        for (int32_t k = 1; k < 96; ++k)
            for (int32_t j = 1; j < 96; ++j)
                for (int32_t i = 1; i < 96; ++i) {
                    const float here = ty_grid_voxel(grid, i, j, k);
                    step[0] = fmaxf(step[0], fabsf(here - ty_grid_voxel(grid, i - 1, j, k)));
                    step[1] = fmaxf(step[1], fabsf(here - ty_grid_voxel(grid, i, j - 1, k)));
                    step[2] = fmaxf(step[2], fabsf(here - ty_grid_voxel(grid, i, j, k - 1)));
                }
        for (int a = 0; a < 3; ++a) assert_true(step[a] > 0.02f && step[a] < 0.2f);
        ty_grid_release(grid);
    }
}

/* Twice the voxels show the same field. */
static void resolution_keeps_the_field(void** state) {
    ty_context* context = *state;
    for (int kind = TY_NOISE_FBM; kind <= TY_NOISE_NEBULA; ++kind) {
        ty_noise_def def = sized((ty_noise_kind)kind, 40, 24, 32);
        def.octaves = 2;
        ty_grid* coarse = make_noise(context, &def);
        for (int a = 0; a < 3; ++a) def.size[a] *= 2;
        ty_grid* fine = make_noise(context, &def);
        double difference = 0, spread = 0;
        const double mean = ty_grid_get_info(coarse).mean;
        for (int32_t k = 0; k < 32; ++k)
            for (int32_t j = 0; j < 24; ++j)
                for (int32_t i = 0; i < 40; ++i) {
                    double average = 0;
                    for (int corner = 0; corner < 8; ++corner)
                        average += 0.125 * (double)ty_grid_voxel(fine, 2 * i + (corner & 1), 2 * j + (corner >> 1 & 1),
                                                                 2 * k + (corner >> 2));
                    const double value = (double)ty_grid_voxel(coarse, i, j, k);
                    difference += (value - average) * (value - average);
                    spread += (value - mean) * (value - mean);
                }
        assert_true(spread > 0 && difference < 0.01 * spread);
        ty_grid_release(coarse);
        ty_grid_release(fine);
    }
}

static void thin_grids_are_filled(void** state) {
    ty_context* context = *state;
    const ty_noise_def line = sized(TY_NOISE_FBM, 1, 1, 50), cloud = sized(TY_NOISE_CLOUD, 50, 1, 1);
    ty_grid* grid = make_noise(context, &line);
    assert_true(ty_grid_get_info(grid).max > ty_grid_get_info(grid).min);
    ty_grid_release(grid);
    grid = make_noise(context, &cloud);
    assert_true(ty_grid_get_info(grid).max == 0);
    ty_grid_release(grid);
}

static void refuse(ty_context* context, const ty_noise_def* def, const char* word) {
    ty_grid* grid = NULL;
    ty_take_error(context);
    assert_int_equal(ty_grid_create_noise(context, def, &grid), TY_ERROR_ARGUMENT);
    assert_null(grid);
    assert_non_null(strstr(ty_take_error(context), word));
}

static void arguments_are_checked(void** state) {
    ty_context* context = *state;
    const ty_noise_def good = ty_default_noise_def();
    ty_noise_def def;
    ty_grid* grid = NULL;
    assert_int_equal(ty_grid_create_noise(context, &good, NULL), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_grid_create_noise(NULL, &good, &grid), TY_ERROR_ARGUMENT);
    refuse(context, NULL, "ty_default_noise_def");
    memset(&def, 0, sizeof def);
    refuse(context, &def, "ty_default_noise_def");
    def = good, def.kind = (ty_noise_kind)4, refuse(context, &def, "kind");
    def = good, def.size[1] = 0, refuse(context, &def, "size along y");
    def = good, def.size[2] = 4097, refuse(context, &def, "size along z");
    def = good, def.up_axis = 0, refuse(context, &def, "up_axis");
    def = good, def.octaves = 0, refuse(context, &def, "octaves");
    def = good, def.octaves = 13, refuse(context, &def, "octaves");
    def = good, def.frequency = 0, refuse(context, &def, "frequency");
    def = good, def.frequency = INFINITY, refuse(context, &def, "frequency");
    def = good, def.gain = 0, refuse(context, &def, "gain");
    def = good, def.gain = 1.01f, refuse(context, &def, "gain");
    def = good, def.lacunarity = 0.99f, refuse(context, &def, "lacunarity");
    def = good, def.coverage = -0.01f, refuse(context, &def, "coverage");
    def = good, def.coverage = NAN, refuse(context, &def, "coverage");
    def = good, def.sharpness = 0, refuse(context, &def, "sharpness");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(constant_is_one),
        cmocka_unit_test(cloud_vanishes_at_the_faces),
        cmocka_unit_test(cloud_is_a_cumulus),
        cmocka_unit_test(nebula_has_an_arch_and_a_ball),
        cmocka_unit_test(up_axis_turns_the_cloud),
        cmocka_unit_test(seeds_differ),
        cmocka_unit_test(coverage_is_a_share),
        cmocka_unit_test(noise_is_continuous),
        cmocka_unit_test(resolution_keeps_the_field),
        cmocka_unit_test(thin_grids_are_filled),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
