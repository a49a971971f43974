/* The model of the time of many ranks: one rank takes what was measured, sweeps take the stages of a schedule that is
 * played through block by block, and more ranks than there are columns or blocks gain nothing. */
#include "figures/scaling_model.h"
#include "checks.h"

enum { SIDE_MAX = 8, BLOCKS = 6, CORNERS = 4 };

static const scaling_network network = {2e-6, 1e10}, no_network = {0, INFINITY};
static const scaling_sweep sweep = {.cells = {64, 48, 40},
                                    .directions = 96,
                                    .planes = 8,
                                    .group = 6,
                                    .cell_seconds = 5e-9,
                                    .face_bytes = 4,
                                    .schedule = SCALING_KBA,
                                    .in_a_row = 1,
                                    .octant_factor = 1};

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
    const scaling_multigrid grid = {.cells = {64, 64, 64},
                                    .cycles = 12,
                                    .cell_seconds = 2e-8,
                                    .exchanges = 6,
                                    .face_bytes = 4,
                                    .gathered_cells = 512,
                                    .cell_bytes = 8};
    assert_close(scaling_tasks_seconds(&tasks, &network, 1), 20.3, 1e-12);
    assert_close(scaling_sweep_seconds(&sweep, &network, 1), 64.0 * 48 * 40 * 96 * 5e-9, 1e-9);
    assert_close(scaling_sweep_efficiency(&sweep, &network, 1), 1, 1e-12);
    /* 64^3 + 32^3 + ... + 1 cells. */
    assert_close(scaling_multigrid_cells(&grid), 299593, 0);
    assert_close(scaling_multigrid_seconds(&grid, &network, 1), 12 * 2e-8 * 299593, 1e-9);
}

static void efficiency_is_the_published_one(void** state) {
    (void)state;
    /* 8 x 8 columns of 8 x 6 cells; 8 octants x 2 groups x 5 blocks of planes; 4 x (7 + 7) idle stages. */
    const double idle = 56.0 / 80, block = 5e-9 * 8 * 6 * 8 * 6;
    const double messages = 2 * 2e-6 + (8 + 6) * 8 * 6 * 4 / 1e10;
    assert_close(scaling_sweep_efficiency(&sweep, &network, 64), 1 / ((1 + idle) * (1 + messages / block)), 1e-12);
    assert_close(scaling_sweep_efficiency(&sweep, &no_network, 64), 1 / (1 + idle), 1e-12);
    /* Where columns are equal it is the time of one rank over that of all. */
    const double one = scaling_sweep_seconds(&sweep, &network, 1), all = scaling_sweep_seconds(&sweep, &network, 64);
    assert_close(one / (64 * all), scaling_sweep_efficiency(&sweep, &network, 64), 1e-12);
}

static void octants_apart_take_longer(void** state) {
    (void)state;
    scaling_sweep apart = sweep;
    apart.in_a_row = 8;
    apart.octant_factor = 1.6;
    /* In a row of eight there are no cuts along x: 1 x 8 columns of 64 x 6 cells, 4 x 7 idle stages. */
    assert_close(scaling_sweep_seconds(&apart, &no_network, 8), (80 + 28) * 5e-9 * 64 * 6 * 8 * 6, 1e-9);
    assert_close(scaling_sweep_seconds(&apart, &no_network, 64), 1.6 * scaling_sweep_seconds(&sweep, &no_network, 64),
                 1e-9);
}

/* ---- a schedule played through ---- */

/* Blocks that a rank has done of each corner's pair of octants, at the end of a stage. */
typedef struct play {
    int32_t size[2], done[SIDE_MAX][SIDE_MAX][CORNERS];
} play;

/* Ranks between this one and the corner where the sweep begins, or with `ahead` where it ends. */
static int32_t depth(const play* p, int32_t x, int32_t y, int corner, bool ahead) {
    const bool from_right = ((corner == 1 || corner == 2) != ahead), from_top = ((corner >= 2) != ahead);
    return (from_right ? p->size[0] - 1 - x : x) + (from_top ? p->size[1] - 1 - y : y);
}

/* True if the blocks before the next one are there, as of `before`. */
static bool is_ready(const play* before, int32_t x, int32_t y, int corner) {
    const int32_t next = before->done[x][y][corner];
    const int32_t from[2] = {x + (corner == 1 || corner == 2 ? 1 : -1), y + (corner >= 2 ? 1 : -1)};
    if (next == BLOCKS) return false;
    if (from[0] >= 0 && from[0] < before->size[0] && before->done[from[0]][y][corner] <= next) return false;
    return from[1] < 0 || from[1] >= before->size[1] || before->done[x][from[1]][corner] > next;
}

/* The corner whose block a rank does next, -1: none. KBA takes corners one after another, all ranks together; the other
 * schedule takes the block with most ranks behind it. */
static int choose(const play* before, int32_t x, int32_t y, scaling_schedule schedule, int corner_of_all) {
    if (schedule == SCALING_KBA) return is_ready(before, x, y, corner_of_all) ? corner_of_all : -1;
    int best = -1;
    for (int corner = 0; corner < CORNERS; ++corner)
        if (is_ready(before, x, y, corner) &&
            (best < 0 || depth(before, x, y, corner, true) > depth(before, x, y, best, true)))
            best = corner;
    return best;
}

static int32_t count_stages(int32_t width, int32_t height, scaling_schedule schedule) {
    play now = {.size = {width, height}};
    int32_t left = width * height * BLOCKS * CORNERS, stages = 0;
    for (; left > 0; ++stages) {
        const play before = now;
        const int corner = CORNERS - 1 - (left - 1) / (width * height * BLOCKS);
        for (int32_t x = 0; x < width; ++x)
            for (int32_t y = 0; y < height; ++y) {
                const int chosen = choose(&before, x, y, schedule, corner);
                if (chosen < 0) continue;
                ++now.done[x][y][chosen];
                --left;
            }
    }
    return stages;
}

static void idle_stages_are_those_of_a_schedule(void** state) {
    (void)state;
    static const int32_t sizes[][2] = {{1, 1}, {2, 1}, {2, 2}, {4, 2}, {4, 4}, {6, 4}, {8, 8}, {3, 1}, {3, 3}, {5, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i)
        for (int schedule = 0; schedule < 2; ++schedule) {
            scaling_sweep played = sweep;
            played.schedule = (scaling_schedule)schedule;
            const double idle = scaling_sweep_idle(&played, sizes[i]);
            const int32_t stages = count_stages(sizes[i][0], sizes[i][1], played.schedule);
            if (stages != CORNERS * BLOCKS + (int32_t)idle)
                fail_msg("%d x %d, schedule %d: %d stages, and not %d + %g", (int)sizes[i][0], (int)sizes[i][1],
                         schedule, (int)stages, CORNERS * BLOCKS, idle);
        }
}

/* ---- limits ---- */

static void more_ranks_than_columns_gain_nothing(void** state) {
    (void)state;
    const double columns = 64 * 48;
    const double at_columns = scaling_sweep_seconds(&sweep, &network, (int32_t)columns);
    assert_close(scaling_sweep_seconds(&sweep, &network, 100 * (int32_t)columns), at_columns, 1e-12);
    const scaling_tasks few = {.start = 0, .work = 10, .task = 1, .bytes = 0, .blocks = 10};
    assert_close(scaling_tasks_seconds(&few, &no_network, 10), 1.5, 1e-12);
    assert_close(scaling_tasks_seconds(&few, &no_network, 1000), 1.5, 1e-12);
    assert_close(scaling_tasks_seconds(&few, &no_network, 3), 4.5, 1e-12); /* of ten blocks one rank has four */
}

static void messages_bound_what_ranks_gain(void** state) {
    (void)state;
    const scaling_tasks tasks = {.start = 0, .work = 1000, .task = 0.2, .bytes = 2e10, .blocks = 1000000};
    assert_in_range((int64_t)(1000 * scaling_tasks_seconds(&tasks, &network, 4096)), 2000, 3000); /* 2 s of bytes */
    const scaling_multigrid grid = {.cells = {256, 256, 256},
                                    .cycles = 1,
                                    .cell_seconds = 1e-8,
                                    .exchanges = 1,
                                    .face_bytes = 4,
                                    .gathered_cells = 64,
                                    .cell_bytes = 8};
    /* Without a network it is the cells alone, and with one less than half of that time is won by twice the ranks. */
    assert_close(scaling_multigrid_seconds(&grid, &no_network, 4), 0.25 * scaling_multigrid_seconds(&grid, &network, 1),
                 1e-6);
    const double many = scaling_multigrid_seconds(&grid, &network, 2048);
    const double more = scaling_multigrid_seconds(&grid, &network, 4096);
    assert_true(more > 0.5 * many);
}

static void memory_is_that_of_columns_and_their_halo(void** state) {
    (void)state;
    const int32_t cells[3] = {1024, 1024, 1024};
    assert_close(scaling_memory(cells, 40, 0, 1), 40.0 * 1024 * 1024 * 1024, 1);
    assert_close(scaling_memory(cells, 40, 0, 4096), 40.0 * 16 * 16 * 1024, 1);
    assert_close(scaling_memory(cells, 40, 8, 4096), 1024.0 * (16 * 16 * 40 + 4 * 16 * 8), 1);
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
        cmocka_unit_test(memory_is_that_of_columns_and_their_halo),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
