/* The model of the time of many ranks: one rank takes what was measured, sweeps take the stages of a schedule that is
 * played through block by block, and more ranks than there are columns or blocks gain nothing. */
#include "figures/scaling_model.h"
#include "checks.h"

enum { SIDE_MAX = 8, BLOCKS = 6, CORNERS = 4 };

static const scaling_network network = {2e-6, 1e10}, no_network = {0, INFINITY};
static const scaling_sweep sweep = {.cells = {64, 48, 40}, .directions = 96, .cell_seconds = 5e-9, .octant_factor = 1};

static void ranks_are_divided_into_the_squarest_columns(void** state) {
    (void)state;
    static const struct {
        int32_t cells[3], ranks, counts[2];
    } cases[] = {{{64, 64, 64}, 1, {1, 1}},   {{64, 64, 64}, 4096, {64, 64}},     {{64, 64, 64}, 100000, {64, 64}},
                 {{100, 10, 5}, 10, {10, 1}}, {{64, 64, 8}, 4, {2, 2}},           {{5, 1, 9}, 7, {5, 1}},
                 {{64, 128, 64}, 32, {4, 8}}, {{1024, 1024, 1024}, 256, {16, 16}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        int32_t counts[2];
        scaling_divide(cases[i].cells, cases[i].ranks, counts);
        assert_int_equal(counts[0], cases[i].counts[0]);
        assert_int_equal(counts[1], cases[i].counts[1]);
    }
}

static void one_rank_takes_what_was_measured(void** state) {
    (void)state;
    const scaling_tasks tasks = {.start = 0.3, .work = 20, .task = 0.2, .bytes = 1e9, .blocks = 300};
    const scaling_cycle cycle = {.cells = 3e6};
    const scaling_stages alone = scaling_kba(&sweep, 1, 8);
    assert_close(scaling_tasks_seconds(&tasks, &network, 1), 20.3, 1e-12);
    assert_close(scaling_sweep_seconds(&sweep, &network, &alone), 64.0 * 48 * 40 * 96 * 5e-9, 1e-9);
    assert_close(scaling_cycle_seconds(&cycle, &network, 2e-8), 0.06, 1e-12);
}

static void efficiency_is_the_published_one(void** state) {
    (void)state;
    /* 8 x 8 columns of 8 x 6 cells; 8 octants x 5 blocks of 8 planes; 4 x (7 + 7) idle stages. */
    const double idle = 56.0 / 40, block = 5e-9 * 8 * 6 * 8 * 12;
    const double messages = 2 * 2e-6 + (8 + 6) * 8 * 12 * 4 / 1e10;
    const scaling_stages one = scaling_kba(&sweep, 1, 8), all = scaling_kba(&sweep, 64, 8);
    const double alone = scaling_sweep_seconds(&sweep, &network, &one);
    assert_close(alone / (64 * scaling_sweep_seconds(&sweep, &network, &all)),
                 1 / ((1 + idle) * (1 + messages / block)), 1e-12);
    assert_close(alone / (64 * scaling_sweep_seconds(&sweep, &no_network, &all)), 1 / (1 + idle), 1e-12);
    const scaling_stages best = scaling_best_kba(&sweep, &network, 64);
    for (int32_t planes = 1; planes <= 32; planes *= 2) {
        const scaling_stages tried = scaling_kba(&sweep, 64, planes);
        assert_true(scaling_sweep_seconds(&sweep, &network, &best) <= scaling_sweep_seconds(&sweep, &network, &tried));
    }
}

static void octants_apart_take_longer(void** state) {
    (void)state;
    scaling_sweep apart = sweep;
    apart.octant_factor = 1.6;
    /* In a row there are no cuts along x. */
    const scaling_stages row = {{1, 8}, 40, 68, 40, 0}, square = {{8, 8}, 40, 96, 80, 0};
    assert_close(scaling_sweep_seconds(&apart, &no_network, &row), 68 * 5e-9 * 64 * 6 * 8 * 12, 1e-9);
    assert_close(scaling_sweep_seconds(&apart, &no_network, &square),
                 1.6 * scaling_sweep_seconds(&sweep, &no_network, &square), 1e-9);
}

/* ---- a schedule played through ---- */

/* Blocks that a rank has done of each corner's pair of octants, at the end of a stage. */
typedef struct play {
    int32_t size[2], done[SIDE_MAX][SIDE_MAX][CORNERS];
} play;

/* True if the blocks before the next one are there, as of `before`. */
static bool is_ready(const play* before, int32_t x, int32_t y, int corner) {
    const int32_t next = before->done[x][y][corner];
    const int32_t from[2] = {x + (corner == 1 || corner == 2 ? 1 : -1), y + (corner >= 2 ? 1 : -1)};
    if (next == BLOCKS) return false;
    if (from[0] >= 0 && from[0] < before->size[0] && before->done[from[0]][y][corner] <= next) return false;
    return from[1] < 0 || from[1] >= before->size[1] || before->done[x][from[1]][corner] > next;
}

/* Corners one after another, all ranks together. */
static int32_t count_stages(int32_t width, int32_t height) {
    play now = {.size = {width, height}};
    int32_t left = width * height * BLOCKS * CORNERS, stages = 0;
    for (; left > 0; ++stages) {
        const play before = now;
        const int corner = CORNERS - 1 - (left - 1) / (width * height * BLOCKS);
        for (int32_t x = 0; x < width; ++x)
            for (int32_t y = 0; y < height; ++y) {
                if (!is_ready(&before, x, y, corner)) continue;
                ++now.done[x][y][corner];
                --left;
            }
    }
    return stages;
}

static void idle_stages_are_those_of_a_schedule(void** state) {
    (void)state;
    static const int32_t sizes[][2] = {{1, 1}, {2, 1}, {2, 2}, {4, 2}, {4, 4}, {6, 4}, {8, 8}, {3, 1}, {3, 3}, {5, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        /* Two octants of a corner with blocks of 8 of 24 planes. */
        const scaling_sweep played = {.cells = {4 * sizes[i][0], 4 * sizes[i][1], 4 * BLOCKS}};
        const scaling_stages kba = scaling_kba(&played, sizes[i][0] * sizes[i][1], 8);
        for (int a = 0; a < 2; ++a) assert_int_equal(kba.ranks[a], sizes[i][a]);
        assert_close(kba.units, CORNERS * BLOCKS, 0);
        assert_close(kba.stages, count_stages(sizes[i][0], sizes[i][1]), 0);
    }
}

/* ---- limits ---- */

static void more_ranks_than_columns_gain_nothing(void** state) {
    (void)state;
    const scaling_stages columns = scaling_kba(&sweep, 64 * 48, 8), more = scaling_kba(&sweep, 100 * 64 * 48, 8);
    assert_close(scaling_sweep_seconds(&sweep, &network, &more), scaling_sweep_seconds(&sweep, &network, &columns),
                 1e-12);
    const scaling_tasks few = {.start = 0, .work = 10, .task = 1, .bytes = 0, .blocks = 10};
    assert_close(scaling_tasks_seconds(&few, &no_network, 10), 1.5, 1e-12);
    assert_close(scaling_tasks_seconds(&few, &no_network, 1000), 1.5, 1e-12);
    assert_close(scaling_tasks_seconds(&few, &no_network, 3), 4.5, 1e-12); /* of ten blocks one rank has four */
}

static void messages_bound_what_ranks_gain(void** state) {
    (void)state;
    const scaling_tasks tasks = {.start = 0, .work = 1000, .task = 0.2, .bytes = 2e10, .blocks = 1000000};
    assert_in_range((int64_t)(1000 * scaling_tasks_seconds(&tasks, &network, 4096)), 2000, 3000); /* 2 s of bytes */
    const scaling_cycle cycle = {.cells = 1e6, .messages = 500, .bytes = 1e8};
    assert_close(scaling_cycle_seconds(&cycle, &network, 1e-8), 0.01 + 0.001 + 0.01, 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranks_are_divided_into_the_squarest_columns),
        cmocka_unit_test(one_rank_takes_what_was_measured),
        cmocka_unit_test(efficiency_is_the_published_one),
        cmocka_unit_test(octants_apart_take_longer),
        cmocka_unit_test(idle_stages_are_those_of_a_schedule),
        cmocka_unit_test(more_ranks_than_columns_gain_nothing),
        cmocka_unit_test(messages_bound_what_ranks_gain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
