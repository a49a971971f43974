/* Random numbers: Sobol points, their scrambling, white noise. */
#include "checks.h"

#include "base/random.k.h"

enum { POINTS_LOG2 = 12, POINTS = 1 << POINTS_LOG2 };

static ty_sobol sobol;

static int start(void** state) {
    (void)state;
    ty_sobol_matrices(&sobol);
    return 0;
}

static uint32_t plain_point(int dimension, uint32_t index) {
    uint32_t point = 0;
    for (int bit = 0; bit < TY_SOBOL_BITS; ++bit)
        if ((index >> bit & 1u) != 0) point ^= sobol.matrix[dimension][bit];
    return point;
}

/* Number `dimension` of a sample, the way a path draws it. */
static float scrambled_point(int dimension, uint64_t item, uint32_t index) {
    ty_sampler random = ty_sampler_begin(&sobol, 7, item, index);
    for (int d = 0; d < dimension; ++d) ty_sobol_next(&random);
    return ty_sobol_next(&random);
}

/* The first POINTS of every dimension as words of 24 bits, plain or scrambled for an item. */
static uint32_t points[TY_SOBOL_DIMENSIONS][POINTS];

static void make_points(bool scrambled, uint64_t item) {
    for (uint32_t i = 0; i < POINTS; ++i) {
        ty_sampler random = ty_sampler_begin(&sobol, 7, item, i);
        for (int d = 0; d < TY_SOBOL_DIMENSIONS; ++d)
            points[d][i] = scrambled ? (uint32_t)(ty_sobol_next(&random) * 0x1p24f) : plain_point(d, i) >> 8;
    }
}

/* True if the first 2^(a + b) points fall one into each cell of 2^a x 2^b. */
static bool even_cells(int dx, int dy, int a, int b) {
    static uint8_t cells[POINTS];
    memset(cells, 0, sizeof cells);
    for (uint32_t i = 0; i < 1u << (a + b); ++i) {
        const uint32_t x = a == 0 ? 0 : points[dx][i] >> (24 - a), y = b == 0 ? 0 : points[dy][i] >> (24 - b);
        if (++cells[x << b | y] > 1) return false;
    }
    return true;
}

static void check_strata(void) {
    for (int d = 0; d < TY_SOBOL_DIMENSIONS; ++d)
        for (int k = 1; k <= POINTS_LOG2; ++k)
            if (!even_cells(d, d, k, 0)) fail_msg("dimension %d, 2^%d points", d, k);
}

static void check_first_pair(void) {
    for (int k = 1; k <= POINTS_LOG2; ++k)
        for (int a = 0; a <= k; ++a)
            if (!even_cells(0, 1, a, k - a)) fail_msg("2^%d x 2^%d cells", a, k - a);
}

static void each_dimension_hits_every_stratum(void** state) {
    (void)state;
    make_points(false, 0);
    check_strata();
    check_first_pair();
}

static void scrambling_keeps_strata(void** state) {
    (void)state;
    for (uint64_t item = 0; item < 5; ++item) {
        make_points(true, item * 1000003);
        check_strata();
        check_first_pair();
    }
}

/* Properties that typing errors in the table would break: no two dimensions are alike, and the first 4096 points of
 * each pair cover 8 x 8 cells evenly. */
static void pairs_of_dimensions_are_spread(void** state) {
    (void)state;
    make_points(false, 0);
    for (int x = 0; x < TY_SOBOL_DIMENSIONS; ++x)
        for (int y = 0; y < x; ++y) {
            int count[64] = {0};
            for (int i = 0; i < POINTS; ++i) ++count[(points[x][i] >> 21) << 3 | points[y][i] >> 21];
            for (int c = 0; c < 64; ++c) assert_int_equal(count[c], POINTS / 64);
        }
}

/* The first points as published with the direction numbers (dimension 1 to 5, in Gray code order: 1, 3, 2, 6, 7). */
static void first_points_are_the_published_ones(void** state) {
    (void)state;
    static const uint32_t index[] = {1, 3, 2, 6, 7};
    static const double expected[5][5] = {{0.5, 0.5, 0.5, 0.5, 0.5},
                                          {0.75, 0.25, 0.25, 0.25, 0.75},
                                          {0.25, 0.75, 0.75, 0.75, 0.25},
                                          {0.375, 0.375, 0.625, 0.875, 0.375},
                                          {0.875, 0.875, 0.125, 0.375, 0.875}};
    for (int i = 0; i < 5; ++i)
        for (int d = 0; d < 5; ++d) assert_close(plain_point(d, index[i]) * 0x1p-32, expected[i][d], 0);
}

static void assert_uniform(const int64_t* bins, int count, int64_t total) {
    double chi = 0;
    const double expected = (double)total / count;
    for (int i = 0; i < count; ++i) chi += ((double)bins[i] - expected) * ((double)bins[i] - expected) / expected;
    const double limit = count - 1 + 4.5 * sqrt(2.0 * (count - 1));
    if (chi > limit) fail_msg("chi-square %g of %d bins", chi, count);
}

/* Over items, any one number of any one sample is uniform: scrambling adds no bias. */
static void one_number_is_uniform_over_items(void** state) {
    (void)state;
    static const uint32_t samples[] = {0, 1, 5, 4095, 0xffffff};
    for (int s = 0; s < 5; ++s)
        for (int d = 0; d < TY_SOBOL_DIMENSIONS; d += 3) {
            int64_t bins[16] = {0};
            double sum = 0;
            const int count = 20000;
            for (int item = 0; item < count; ++item) {
                const float u = scrambled_point(d, (uint64_t)item, samples[s]);
                assert_true(u >= 0 && u < 1);
                ++bins[(int)(u * 16)];
                sum += (double)u;
            }
            assert_uniform(bins, 16, count);
            assert_close(sum / count, 0.5, 4.5 * sqrt(1.0 / 12 / count));
        }
}

static double correlation(const float* a, const float* b, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += ((double)a[i] - 0.5) * ((double)b[i] - 0.5);
    return 12 * sum / count;
}

static void items_samples_and_dimensions_are_independent(void** state) {
    (void)state;
    enum { COUNT = 40000 };
    static float a[COUNT], next_item[COUNT], next_dimension[COUNT], other_seed[COUNT], far_dimension[COUNT];
    for (int i = 0; i < COUNT; ++i) {
        const uint64_t item = (uint64_t)i * 2;
        ty_sampler random = ty_sampler_begin(&sobol, 8, item, 3);
        a[i] = scrambled_point(2, item, 3);
        next_item[i] = scrambled_point(2, item + 1, 3);
        next_dimension[i] = scrambled_point(3, item, 3);
        far_dimension[i] = scrambled_point(15, item, 3);
        ty_sobol_next(&random);
        ty_sobol_next(&random);
        other_seed[i] = ty_sobol_next(&random);
    }
    const double limit = 4.5 / sqrt(COUNT);
    assert_close(correlation(a, next_item, COUNT), 0, limit);
    assert_close(correlation(a, next_dimension, COUNT), 0, limit);
    assert_close(correlation(a, far_dimension, COUNT), 0, limit);
    assert_close(correlation(a, other_seed, COUNT), 0, limit);
}

static void white_noise_is_uniform(void** state) {
    (void)state;
    enum { COUNT = 1000000, SIDE = 16 };
    ty_sampler random = ty_sampler_begin(&sobol, 1, 2, 3);
    int64_t bins[SIDE * SIDE] = {0};
    double sum = 0, square = 0;
    for (int i = 0; i < COUNT; ++i) {
        const float u = ty_rng_uniform(&random), v = ty_rng_uniform(&random);
        assert_true(u >= 0 && u < 1 && v >= 0 && v < 1);
        ++bins[(int)(u * SIDE) * SIDE + (int)(v * SIDE)];
        sum += (double)u;
        square += (double)u * (double)u;
    }
    assert_uniform(bins, SIDE * SIDE, COUNT);
    assert_close(sum / COUNT, 0.5, 4.5 * sqrt(1.0 / 12 / COUNT));
    assert_close(square / COUNT, 1.0 / 3, 4.5 * sqrt(4.0 / 45 / COUNT));
}

/* The first white numbers of neighbouring samples, items and seeds: no pattern where keys differ by little. */
static void white_noise_of_neighbours_is_uniform(void** state) {
    (void)state;
    int64_t bins[64] = {0};
    const int side = 60;
    for (int seed = 0; seed < side; ++seed)
        for (int item = 0; item < side; ++item)
            for (int sample = 0; sample < side; ++sample) {
                ty_sampler random = ty_sampler_begin(&sobol, (uint64_t)seed, (uint64_t)item, (uint32_t)sample);
                ++bins[(int)(ty_rng_uniform(&random) * 64)];
            }
    assert_uniform(bins, 64, (int64_t)side * side * side);
}

static void numbers_past_the_sobol_dimensions_are_white(void** state) {
    (void)state;
    ty_sampler random = ty_sampler_begin(&sobol, 4, 5, 6), white = random;
    for (int d = 0; d < TY_SOBOL_DIMENSIONS; ++d) ty_sobol_next(&random);
    for (int i = 0; i < 100; ++i) assert_true(ty_sobol_next(&random) == ty_rng_uniform(&white));
}

static void one_is_never_reached(void** state) {
    (void)state;
    assert_true(ty_unit_float(0xffffffffu) < 1);
    assert_true(ty_unit_float(0) == 0);
    assert_true(ty_exponential(0) == 0);
    assert_close(ty_exponential(ty_unit_float(0xffffffffu)), 24 * log(2), 1e-5);
}

static void exponential_numbers_have_mean_one(void** state) {
    (void)state;
    const int count = 1000000;
    ty_sampler random = ty_sampler_begin(&sobol, 9, 9, 9);
    double sum = 0, square = 0;
    for (int i = 0; i < count; ++i) {
        const double x = (double)ty_exponential(ty_rng_uniform(&random));
        sum += x;
        square += x * x;
    }
    assert_close(sum / count, 1, 4.5 / sqrt(count));
    assert_close(square / count, 2, 4.5 * sqrt(20.0 / count));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_dimension_hits_every_stratum),
        cmocka_unit_test(scrambling_keeps_strata),
        cmocka_unit_test(pairs_of_dimensions_are_spread),
        cmocka_unit_test(first_points_are_the_published_ones),
        cmocka_unit_test(one_number_is_uniform_over_items),
        cmocka_unit_test(items_samples_and_dimensions_are_independent),
        cmocka_unit_test(white_noise_is_uniform),
        cmocka_unit_test(white_noise_of_neighbours_is_uniform),
        cmocka_unit_test(numbers_past_the_sobol_dimensions_are_white),
        cmocka_unit_test(one_is_never_reached),
        cmocka_unit_test(exponential_numbers_have_mean_one),
    };
    return cmocka_run_group_tests(tests, start, NULL);
}
