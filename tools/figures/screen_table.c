/* Table 1 of the paper: milliseconds of each step at 1, 2 and 4 Mpixel, by filter. */
#include "bench/tables.h"
#include "figures/figure.h"

#include <math.h>

enum { SIZES = 3, RUNS = 9, RUNS_QUICK = 3, QUICK_SHRINK = 8, COLUMNS = 8, ROWS_EACH = 3, FILTERS = 4 };

/* The paper's, ms; step 2: gather with filters of 2, 4 and 6 pixels, and naive with 4. */
static const struct {
    const char* name;
    int32_t width, height;
    double step1, step2[FILTERS], step3, total;
} sizes[SIZES] = {
    {"1 Mpixel", 1024, 1024, 0.3, {0.7, 1.1, 2.6, 1.0}, 1.2, 2.6},
    {"2 Mpixel", 2048, 1024, 0.6, {1.2, 1.6, 4.6, 1.5}, 2.1, 4.3},
    {"4 Mpixel", 2048, 2048, 1.2, {1.9, 2.6, 8.6, 2.3}, 4.2, 8.0},
};

/* Cases of bench_screen_times by column, -1: none. */
static const int scatter[FILTERS] = {0, 1, 2, -1}, gather[FILTERS] = {5, 3, 6, 4};
enum { GATHER_4 = 3 };

/* The paper lists steps 1 and 3 and the total of gather with a filter of 4 pixels. */
static void note_case(figure_run* run, int size, int index, const bench_screen_time* time) {
    char item[FIGURE_NAME_SIZE];
    const bool listed = index == GATHER_4;
    double filtering = NAN;
    for (int f = 0; f < FILTERS; ++f)
        if (gather[f] == index) filtering = sizes[size].step2[f];
    snprintf(item, sizeof item, "%s, %s", sizes[size].name, time->name);
    figure_expect(run, item, "step 1", "ms", 1e3 * time->step[0], listed ? sizes[size].step1 : NAN, NAN);
    figure_expect(run, item, "step 2", "ms", 1e3 * time->step[1], filtering, NAN);
    figure_expect(run, item, "step 3", "ms", 1e3 * time->step[2], listed ? sizes[size].step3 : NAN, NAN);
    figure_expect(run, item, "total", "ms", 1e3 * time->total, listed ? sizes[size].total : NAN, NAN);
}

static void set_measured(plot_table* table, int row, const bench_screen_time* times, const int order[FILTERS]) {
    const bench_screen_time* by_4 = &times[order[1]];
    plot_set_cell(table, row, 1, "%.2f", 1e3 * by_4->step[0]);
    for (int f = 0; f < FILTERS; ++f)
        if (order[f] >= 0) plot_set_cell(table, row, 2 + f, "%.2f", 1e3 * times[order[f]].step[1]);
    plot_set_cell(table, row, 6, "%.2f", 1e3 * by_4->step[2]);
    plot_set_cell(table, row, 7, "%.2f", 1e3 * by_4->total);
}

static void set_size(plot_table* table, int size, const bench_screen_time* times) {
    const int row = 2 + ROWS_EACH * size;
    plot_set_cell(table, row, 0, "%s, scatter (ours)", sizes[size].name);
    plot_set_cell(table, row + 1, 0, "    gather (the paper's method)");
    plot_set_cell(table, row + 2, 0, "    the paper, on its GPU");
    set_measured(table, row, times, scatter);
    set_measured(table, row + 1, times, gather);
    plot_set_cell(table, row + 2, 1, "(%.1f)", sizes[size].step1);
    for (int f = 0; f < FILTERS; ++f) plot_set_cell(table, row + 2, 2 + f, "(%.1f)", sizes[size].step2[f]);
    plot_set_cell(table, row + 2, 6, "(%.1f)", sizes[size].step3);
    plot_set_cell(table, row + 2, 7, "(%.1f)", sizes[size].total);
}

static ty_result fill_table(figure_run* run, plot_table* table) {
    static const char* const heads[2][COLUMNS] = {{"ms", "Step 1", "Step 2:", "", "", "", "Step 3", "Total"},
                                                  {"", "", "2 × 2", "4 × 4", "6 × 6", "naive", "", ""}};
    const bool quick = run->options->quick;
    ty_result result = TY_OK;
    for (int i = 0; i < 2 * COLUMNS; ++i)
        plot_set_cell(table, i / COLUMNS, i % COLUMNS, "%s", heads[i / COLUMNS][i % COLUMNS]);
    for (int size = 0; size < SIZES && result == TY_OK; ++size) {
        const int32_t shrink = quick ? QUICK_SHRINK : 1;
        const int32_t pixels[2] = {sizes[size].width / shrink, sizes[size].height / shrink};
        bench_screen_time times[BENCH_SCREEN_CASES];
        result = bench_screen_times(run->session->context, pixels, quick ? RUNS_QUICK : RUNS, times);
        if (result != TY_OK) return result;
        for (int i = 0; i < BENCH_SCREEN_CASES; ++i) note_case(run, size, i, &times[i]);
        set_size(table, size, times);
    }
    return result;
}

ty_result figure_screen_table(figure_run* run) {
    plot_table table;
    ty_result result = plot_create_table(2 + ROWS_EACH * SIZES, COLUMNS, 2, &table);
    if (result != TY_OK) return result;
    result = fill_table(run, &table);
    if (result == TY_OK) plot_page_table(&run->page, &table);
    plot_free_table(&table);
    figure_caption(run,
                   "Medians of %d runs that take turns, on %d threads of this machine (%s), 1024 × 1024, 2048 × 1024 "
                   "and 2048 × 2048 pixels%s. Totals are with the 4 × 4 filter. In brackets what the paper measured on "
                   "a GeForce GTX 485 Mobile: another machine, for comparison of the ratios alone.",
                   run->options->quick ? RUNS_QUICK : RUNS, ty_context_threads(run->session->context), bench_isa(),
                   run->options->quick ? ", an eighth of each with --quick" : "");
    return result;
}
