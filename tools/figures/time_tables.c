/* Timings compared with papers, by the code of the benches: light propagation volumes (Table 1), principal-ordinates
 * propagation (the typical setting of Fig. 14), impulse responses (Section 5). */
#include "bench/tables.h"
#include "figures/figure.h"

#include <math.h>
#include <string.h>

enum { RUNS = 5 };

static void note_row(figure_run* run, const bench_table* table, int row) {
    for (int i = 0; i < table->columns; ++i) {
        /* The corresponding column of the paper: columns are aligned at the last one. */
        const int paper = i - (table->columns - table->paper_columns);
        const double expected = paper >= 0 && table->paper[row][paper] > 0 ? table->paper[row][paper] : NAN;
        figure_expect(run, table->titles[i], table->row_names[row], table->units[row], table->measured[row][i],
                      expected, NAN);
    }
}

static void set_head(const bench_table* table, plot_table* out) {
    for (int i = 0; i < table->columns; ++i) plot_set_cell(out, 0, 1 + i, "%s", table->titles[i]);
    for (int i = 0; i < table->paper_columns; ++i)
        plot_set_cell(out, 0, 1 + table->columns + i, "(paper%s%s)", table->paper_titles[i][0] != '\0' ? ", " : "",
                      table->paper_titles[i]);
}

static void set_row(const bench_table* table, int row, plot_table* out) {
    plot_set_cell(out, 1 + row, 0, "%s, %s", table->row_names[row], table->units[row]);
    for (int i = 0; i < table->columns; ++i)
        plot_set_cell(out, 1 + row, 1 + i, "%.*f", strcmp(table->units[row], "s") == 0 ? 3 : 2,
                      table->measured[row][i]);
    for (int i = 0; i < table->paper_columns; ++i)
        if (table->paper[row][i] > 0) plot_set_cell(out, 1 + row, 1 + table->columns + i, "(%g)", table->paper[row][i]);
}

static ty_result show_table(figure_run* run, const bench_table* table) {
    plot_table page_table;
    ty_result result = plot_create_table(1 + table->rows, 1 + table->columns + table->paper_columns, 1, &page_table);
    if (result != TY_OK) return result;
    set_head(table, &page_table);
    for (int row = 0; row < table->rows && result == TY_OK; ++row) {
        set_row(table, row, &page_table);
        note_row(run, table, row);
    }
    if (result == TY_OK) plot_page_table(&run->page, &page_table);
    plot_free_table(&page_table);
    return TY_OK;
}

static ty_result make_table(figure_run* run, ty_result (*measure)(const bench_session* bench, bench_table* out)) {
    const bench_options options = {
        .quick = run->options->quick, .runs = run->options->quick ? 1 : RUNS, .data = run->options->data};
    const bench_session bench = {run->session, &options, NULL};
    bench_table table;
    ty_result result = measure(&bench, &table);
    if (result == TY_OK) result = figure_check_interrupt();
    if (result == TY_OK) result = show_table(run, &table);
    figure_caption(run,
                   "%s. Medians of %d, on %d threads of this machine (%s). In brackets what the paper has, of %s: "
                   "another machine and scene, for comparison of the ratios alone.",
                   table.setting, (int)options.runs, (int)ty_context_threads(run->session->context), bench_isa(),
                   table.paper_machine);
    return result;
}

ty_result figure_lpv_table(figure_run* run) {
    return make_table(run, bench_lpv_table);
}

ty_result figure_pop_table(figure_run* run) {
    return make_table(run, bench_pop_table);
}

ty_result figure_bake_table(figure_run* run) {
    return make_table(run, bench_bake_table);
}
