/* Table 1 of the paper: milliseconds of each step at 1, 2 and 4 Mpixel, by filter. */
#include "bench/bench.h"
#include "figures/screen_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SIZES = 3,
    SETUPS = 7,
    RUNS = 9,
    RUNS_QUICK = 3,
    QUICK_SHRINK = 8,
    COLUMNS = 8,
    ROWS_EACH = 3,
    WORKSPACE_ALIGNMENT = 64
};

static const struct {
    const char* name;
    int32_t width, height;
    double step1, step2[4], step3, total; /* the paper's, ms; step 2: 2x2, 4x4, 6x6, naive */
} sizes[SIZES] = {
    {"1 Mpixel", 1024, 1024, 0.3, {0.7, 1.1, 2.6, 1.0}, 1.2, 2.6},
    {"2 Mpixel", 2048, 1024, 0.6, {1.2, 1.6, 4.6, 1.5}, 2.1, 4.3},
    {"4 Mpixel", 2048, 2048, 1.2, {1.9, 2.6, 8.6, 2.3}, 4.2, 8.0},
};

static const screen_water water = {.thickness = 6, .g = 0.97f};

/* Measured setups; the first three and the following four form one row each. */
typedef enum setup { SCATTER_2, SCATTER_4, SCATTER_6, GATHER_2, GATHER_4, GATHER_6, NAIVE } setup;

/* Median seconds of the steps and of the total. */
typedef struct timing {
    double step[3], total;
} timing;

static ty_screen_def make_def(const screen_view* view, int which) {
    static const int32_t filters[SETUPS] = {2, 4, 6, 2, 4, 6, 4};
    ty_screen_def def = screen_room_def(view, &water);
    if (which >= GATHER_2) def.variant = TY_SCREEN_GATHER;
    if (which == NAIVE) ty_screen_naive_def(&def);
    def.filter = filters[which];
    return def;
}

/* A synthetic image with gentle slopes, edges and highlights, and distances of 2 to 20 m with steps at the edges; the
 * cost does not depend on the content. */
static ty_result make_view(figure_run* run, int32_t width, int32_t height, screen_view* out) {
    screen_view view = {.width = width, .height = height, .center = {-1, -1}};
    ty_result result = ty_image_create_rgb(run->session->context, width, height, &view.surface);
    if (result != TY_OK) return result;
    view.distance = malloc((size_t)width * (size_t)height * sizeof *view.distance);
    if (view.distance == NULL) {
        screen_free_view(&view);
        return TY_ERROR_MEMORY;
    }
    for (int32_t y = 0; y < height; ++y)
        for (int32_t x = 0; x < width; ++x) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            const int tile = (x / 128 * 5 + y / 128 * 3) % 7;
            const bool highlight = x % 128 < 4 && y % 128 < 4;
            view.distance[i] = 2 + 3 * (float)(tile % 6) + 3 * (float)y / (float)height;
            for (int c = 0; c < 3; ++c)
                ty_image_plane(view.surface, c)[i] =
                    highlight ? 100 : 0.1f + 0.1f * (float)((tile + c) % 7) + 0.3f * (float)x / (float)width;
        }
    view.focal[0] = view.focal[1] = ty_screen_focal(height, 42);
    *out = view;
    return TY_OK;
}

/* One call on the planes of a view, with a common workspace. */
typedef struct table_job {
    ty_screen_image image;
    void* workspace;
    size_t workspace_size;
} table_job;

static ty_result prepare(figure_run* run, const screen_view* view, ty_image* out, table_job* job) {
    *job = (table_job){.image = ty_default_screen_image()};
    job->image.width = view->width;
    job->image.height = view->height;
    job->image.distance = view->distance;
    job->image.color.row = job->image.out.row = job->image.distance_row = view->width;
    for (int c = 0; c < 3; ++c) {
        job->image.color.data[c] = ty_image_plane(view->surface, c);
        job->image.out.data[c] = ty_image_plane(out, c);
    }
    for (int which = 0; which < SETUPS; ++which) {
        const ty_screen_def def = make_def(view, which);
        const size_t size = ty_screen_workspace(run->session->context, &def, view->width, view->height);
        if (size > job->workspace_size) job->workspace_size = size;
    }
    const size_t rounded = (job->workspace_size / WORKSPACE_ALIGNMENT + 1) * WORKSPACE_ALIGNMENT;
    job->workspace = aligned_alloc(WORKSPACE_ALIGNMENT, rounded);
    return job->workspace == NULL ? TY_ERROR_MEMORY : TY_OK;
}

static ty_result run_once(figure_run* run, const screen_view* view, const table_job* job, int which, timing* out,
                          const char** isa) {
    const ty_screen_def def = make_def(view, which);
    ty_screen_stats stats;
    const ty_result result =
        ty_screen_apply(run->session->context, &def, &job->image, job->workspace, job->workspace_size, &stats);
    if (result != TY_OK) return result;
    memcpy(out->step, stats.step_seconds, sizeof out->step);
    out->total = stats.seconds;
    *isa = stats.isa;
    return figure_check_interrupt();
}

static timing median_timing(const timing* timings, int count) {
    double values[4][RUNS];
    for (int i = 0; i < count; ++i) {
        for (int step = 0; step < 3; ++step) values[step][i] = timings[i].step[step];
        values[3][i] = timings[i].total;
    }
    timing median;
    for (int step = 0; step < 3; ++step) median.step[step] = bench_median(values[step], count);
    median.total = bench_median(values[3], count);
    return median;
}

/* Runs of all setups are interleaved, so that other load affects all alike. The first round is a warm-up. */
static ty_result measure(figure_run* run, const screen_view* view, const table_job* job, timing medians[SETUPS],
                         const char** isa) {
    timing timings[SETUPS][RUNS];
    const int runs = run->options->quick ? RUNS_QUICK : RUNS;
    ty_result result = TY_OK;
    for (int round = -1; round < runs; ++round)
        for (int which = 0; which < SETUPS && result == TY_OK; ++which)
            result = run_once(run, view, job, which, &timings[which][round < 0 ? 0 : round], isa);
    for (int which = 0; which < SETUPS && result == TY_OK; ++which)
        medians[which] = median_timing(timings[which], runs);
    return result;
}

static ty_result measure_size(figure_run* run, int size, timing medians[SETUPS], const char** isa) {
    const int32_t shrink = run->options->quick ? QUICK_SHRINK : 1;
    screen_view view = {0};
    table_job job = {0};
    ty_image* out = NULL;
    ty_result result = make_view(run, sizes[size].width / shrink, sizes[size].height / shrink, &view);
    if (result == TY_OK) result = ty_image_create_rgb(run->session->context, view.width, view.height, &out);
    if (result == TY_OK) result = prepare(run, &view, out, &job);
    if (result == TY_OK) result = measure(run, &view, &job, medians, isa);
    free(job.workspace);
    ty_image_destroy(out);
    screen_free_view(&view);
    return result;
}

/* ---- results ---- */

static ty_result note_size(figure_run* run, int size, const timing medians[SETUPS]) {
    static const char* const names[SETUPS] = {"scatter 2x2", "scatter 4x4", "scatter 6x6", "gather 2x2",
                                              "gather 4x4",  "gather 6x6",  "naive 4x4"};
    ty_result result = TY_OK;
    for (int which = 0; which < SETUPS && result == TY_OK; ++which) {
        char item[FIGURE_NAME_SIZE];
        const timing* t = &medians[which];
        const bool has_all_steps = which == GATHER_4; /* the paper lists steps 1 and 3 and the total for this setup */
        const double filtering = which >= GATHER_2 ? sizes[size].step2[which - GATHER_2] : NAN;
        snprintf(item, sizeof item, "%s, %s", sizes[size].name, names[which]);
        figure_expect(run, item, "step 1", "ms", 1e3 * t->step[0], has_all_steps ? sizes[size].step1 : NAN, NAN);
        if (result == TY_OK) figure_expect(run, item, "step 2", "ms", 1e3 * t->step[1], filtering, NAN);
        if (result == TY_OK)
            figure_expect(run, item, "step 3", "ms", 1e3 * t->step[2], has_all_steps ? sizes[size].step3 : NAN, NAN);
        if (result == TY_OK)
            figure_expect(run, item, "total", "ms", 1e3 * t->total, has_all_steps ? sizes[size].total : NAN, NAN);
    }
    return TY_OK;
}

static void set_head(plot_table* table) {
    static const char* const above[COLUMNS] = {"ms", "Step 1", "Step 2:", "", "", "", "Step 3", "Total"};
    static const char* const below[COLUMNS] = {"", "", "2 × 2", "4 × 4", "6 × 6", "naive", "", ""};
    for (int column = 0; column < COLUMNS; ++column) {
        plot_set_cell(table, 0, column, "%s", above[column]);
        plot_set_cell(table, 1, column, "%s", below[column]);
    }
}

/* medians: of 2x2, 4x4, 6x6 and, unless NULL, of naive. */
static void set_measured(plot_table* table, int row, const timing* medians, const timing* naive) {
    plot_set_cell(table, row, 1, "%.2f", 1e3 * medians[1].step[0]);
    for (int filter = 0; filter < 3; ++filter)
        plot_set_cell(table, row, 2 + filter, "%.2f", 1e3 * medians[filter].step[1]);
    if (naive != NULL) plot_set_cell(table, row, 5, "%.2f", 1e3 * naive->step[1]);
    plot_set_cell(table, row, 6, "%.2f", 1e3 * medians[1].step[2]);
    plot_set_cell(table, row, 7, "%.2f", 1e3 * medians[1].total);
}

static void set_published(plot_table* table, int row, int size) {
    plot_set_cell(table, row, 0, "    the paper, on its GPU");
    plot_set_cell(table, row, 1, "(%.1f)", sizes[size].step1);
    for (int i = 0; i < 4; ++i) plot_set_cell(table, row, 2 + i, "(%.1f)", sizes[size].step2[i]);
    plot_set_cell(table, row, 6, "(%.1f)", sizes[size].step3);
    plot_set_cell(table, row, 7, "(%.1f)", sizes[size].total);
}

static void set_size(plot_table* table, int size, const timing medians[SETUPS]) {
    const int row = 2 + ROWS_EACH * size;
    plot_set_cell(table, row, 0, "%s, scatter (ours)", sizes[size].name);
    plot_set_cell(table, row + 1, 0, "    gather (the paper's method)");
    set_measured(table, row, medians + SCATTER_2, NULL);
    set_measured(table, row + 1, medians + GATHER_2, &medians[NAIVE]);
    set_published(table, row + 2, size);
}

static void write_caption(figure_run* run, const char* isa) {
    const int32_t shrink = run->options->quick ? QUICK_SHRINK : 1;
    figure_caption(run,
                   "Medians of %d runs that take turns, on %d threads of this machine (%s), %d × %d, %d × %d and %d × "
                   "%d pixels. Totals are with the 4 × 4 filter. In brackets what the paper measured on a GeForce GTX "
                   "485 Mobile: another machine, for comparison of the ratios alone.",
                   run->options->quick ? RUNS_QUICK : RUNS, ty_context_threads(run->session->context),
                   isa == NULL ? "generic" : isa, sizes[0].width / shrink, sizes[0].height / shrink,
                   sizes[1].width / shrink, sizes[1].height / shrink, sizes[2].width / shrink,
                   sizes[2].height / shrink);
}

ty_result figure_screen_table(figure_run* run) {
    plot_table table = {0};
    const char* isa = NULL;
    ty_result result = plot_create_table(2 + ROWS_EACH * SIZES, COLUMNS, 2, &table);
    if (result == TY_OK) set_head(&table);
    for (int size = 0; size < SIZES && result == TY_OK; ++size) {
        timing medians[SETUPS];
        result = measure_size(run, size, medians, &isa);
        if (result == TY_OK) result = note_size(run, size, medians);
        if (result == TY_OK) set_size(&table, size, medians);
    }
    if (result == TY_OK) plot_page_table(&run->page, &table);
    plot_free_table(&table);
    write_caption(run, isa);
    return result;
}
