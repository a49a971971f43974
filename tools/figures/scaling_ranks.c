/* One command by many ranks: strong and weak scaling by processor time, and the model of it to thousands of ranks. */
#include "figures/scaling_measure.h"
#include "figures/scaling_model.h"

#include <math.h>
#include <string.h>

enum { MEASURED = 3, RANKS_END = 4096, PLAN_EDGE = 1024, CHARTS = 4, MEMORIES = 7 };

static const int32_t ranks_measured[MEASURED] = {1, 2, SCALING_RANKS_MAX};

/* Bytes of a pixel and pass that rank 0 sends and receives, and of a receiver: docs/farm.md. */
static const double pixel_bytes = 112;
/* Seconds of a task, and items of a block of path and bake. */
static const double task_seconds = 0.2;
/* Of dom's sweeps, as docs/farm.md tells: up to eight ranks stand in a row along y, and an octant by itself takes 1.6
 * times as long for a cell and direction. */
static const int32_t ranks_in_a_row = 8;
static const double octant_factor = 1.6;
enum { PATH_BLOCK = 64, BAKE_BLOCK = 8 };

/* ---- cases ---- */

typedef enum case_model { BY_TASKS, BY_SWEEPS, BY_MULTIGRID } case_model;

typedef struct scaling_case {
    const char* name;
    case_model model;
    int32_t strong, weak, smallest, quick; /* numbers of the command; weak: of one rank; quick: of both, with --quick */
    double power;                          /* work goes with the number to this power */
    int64_t items, block;                  /* tasks: items of the command, and of a block */
    int64_t plan_items;                    /* and of the planned one, with plan_number */
    int32_t plan_number;
    scaling_command command;
} scaling_case;

/* Three channels of their own. */
#define COLOURED "media[0].albedo=[0.9,0.95,0.99]"

static const scaling_case cases[] = {
    {.name = "path",
     .model = BY_TASKS,
     .strong = 64,
     .weak = 16,
     .smallest = 1,
     .quick = 4,
     .power = 1,
     .items = 160 * 120,
     .block = PATH_BLOCK,
     .plan_items = 1920 * 1080,
     .plan_number = 1024,
     .command = {{"render", "builtin:cloud_sun", "--method", "path", "--size", "160x120", "--spp=", "-o",
                  "@/path.exr"}}},
    {.name = "bake",
     .model = BY_TASKS,
     .strong = 512,
     .weak = 128,
     .smallest = 1,
     .quick = 32,
     .power = 1,
     .items = 512,
     .block = BAKE_BLOCK,
     .plan_items = 64 * 32 * 64,
     .plan_number = 1024,
     .command = {{"bake", "builtin:cornell_fog", "--grid", "8,8,8", "--cache", "8", "--cache-paths", "8",
                  "--spp=", "-o", "@/bake"}}},
    {.name = "dom",
     .model = BY_SWEEPS,
     .strong = 96,
     .weak = 64,
     .smallest = 4,
     .quick = 24,
     .power = 3,
     .command = {{"render", "builtin:cloud_sun", "--method", "dom", "--size", "8x6", "-o", "@/dom.exr", "-D", COLOURED,
                  "-D", "render.dom.resolution="}}},
    {.name = "fld",
     .model = BY_MULTIGRID,
     .strong = 96,
     .weak = 48,
     .smallest = 4,
     .quick = 48,
     .power = 3,
     .command = {{"render", "builtin:cloud_sun", "--method", "fld", "--size", "8x6", "-o", "@/fld.exr", "-D", COLOURED,
                  "-D", "render.fld.resolution="}}},
};
enum { CASES = sizeof cases / sizeof cases[0] };

/* Processor seconds that count: tasks go to who is free by the clock, so that ranks of a busy machine do unequal
 * shares, and their mean counts; of divided grids the rank with the most. */
static double seconds_of(const scaling_case* c, const scaling_run* run) {
    return c->model == BY_TASKS ? run->sum / run->ranks : run->max;
}

static int32_t strong_number(const figure_run* run, const scaling_case* c) {
    return run->options->quick ? c->quick : c->strong;
}

static int32_t weak_number(const figure_run* run, const scaling_case* c, int32_t ranks) {
    return (int32_t)lround((run->options->quick ? c->quick : c->weak) * pow(ranks, 1 / c->power));
}

/* ---- measuring ---- */

/* A case as measured, and the parameters of its model. */
typedef struct case_result {
    const scaling_case* of;
    double strong[MEASURED], weak[MEASURED]; /* s */
    double work, start[2]; /* s: of the strong problem; of what is not divided, by one rank and more */
    double bytes;          /* of messages of rank 0, strong */
    double other;          /* s of the work that is neither sweeps nor cycles */
    scaling_tasks tasks;
    scaling_sweep sweep;
    double sweeps; /* over all channels */
    scaling_multigrid grid;
    double cell_bytes, cut_bytes; /* of memory: of a cell, and of a face at a cut */
} case_result;

static ty_result measure(figure_run* run, const char* folder, const scaling_case* c, int32_t number, int32_t ranks,
                         scaling_run* out) {
    char stage[FIGURE_NAME_SIZE];
    snprintf(stage, sizeof stage, "%s by %d", c->name, (int)ranks);
    cli_progress_step(&run->session->progress, stage, 0, 1, cli_wall_seconds() - run->session->started);
    return scaling_measure(run, folder, &c->command, number, ranks, out);
}

static void note_run(figure_run* run, const scaling_case* c, const char* problem, const scaling_run* measured) {
    char item[FIGURE_NAME_SIZE];
    snprintf(item, sizeof item, "%s, %s, %d ranks", c->name, problem, (int)measured->ranks);
    figure_notes(run, item, {"processor time", "s", measured->sum}, {"of the rank with most", "s", measured->max},
                 {"messages of rank 0", "1", measured->messages}, {"their bytes", "B", measured->bytes});
}

/* Seconds of one problem by each number of ranks; the statistics of one rank stay the caller's. */
static ty_result measure_all(figure_run* run, const char* folder, const scaling_case* c, bool weak,
                             double seconds[MEASURED], case_result* out, json_t** stats) {
    ty_result result = TY_OK;
    for (int i = 0; i < MEASURED && result == TY_OK; ++i) {
        scaling_run measured;
        const int32_t ranks = ranks_measured[i], number = weak ? weak_number(run, c, ranks) : strong_number(run, c);
        result = measure(run, folder, c, number, ranks, &measured);
        if (result != TY_OK) break;
        seconds[i] = seconds_of(c, &measured);
        note_run(run, c, weak ? "weak" : "strong", &measured);
        if (!weak) out->bytes = measured.bytes;
        if (i == 0 && stats != NULL)
            *stats = measured.stats;
        else
            json_decref(measured.stats);
    }
    return result;
}

/* The parts of the time of one rank and more that ranks do not share, from a problem of smallest work. */
static ty_result measure_start(figure_run* run, const char* folder, const scaling_case* c, case_result* out) {
    const double share = pow((double)c->smallest / strong_number(run, c), c->power);
    for (int i = 0; i < 2; ++i) {
        scaling_run measured;
        const int32_t ranks = i == 0 ? 1 : SCALING_RANKS_MAX;
        const ty_result result = measure(run, folder, c, c->smallest, ranks, &measured);
        if (result != TY_OK) return result;
        json_decref(measured.stats);
        if (i == 0) out->work = fmax((out->strong[0] - measured.sum) / (1 - share), 1e-6);
        out->start[i] = fmax(seconds_of(c, &measured) - out->work * share / ranks, 0);
    }
    return TY_OK;
}

/* ---- models of what was measured ---- */

static double number_of(const json_t* stats, const char* name) {
    return json_number_value(json_object_get(stats, name));
}

/* The three elements of an array, values may be NULL, and their sum. */
static double sum(const json_t* stats, const char* name, int32_t values[3]) {
    const json_t* array = json_object_get(stats, name);
    double all = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double value = json_number_value(json_array_get(array, i));
        if (values != NULL) values[i] = (int32_t)value;
        all += value;
    }
    return all;
}

/* Multigrid of smoothings by colours: so many exchanges of halos on a level and cycle; levels of at most 4096 cells go
 * to one rank, there and back. */
static scaling_multigrid make_grid(const int32_t cells[3], double cycles, double seconds) {
    scaling_multigrid grid = {
        .cycles = cycles, .exchanges = 8, .face_bytes = 4, .gathered_cells = 4096, .cell_bytes = 8};
    memcpy(grid.cells, cells, sizeof grid.cells);
    grid.cell_seconds = seconds / fmax(cycles * scaling_multigrid_cells(&grid), 1);
    return grid;
}

/* Parts of the processor time go as the clock says. */
static void fit_sweeps(case_result* r, const json_t* stats) {
    const json_t* dom = json_object_get(stats, "dom");
    const double all = number_of(stats, "seconds");
    const double sweeping = r->strong[0] * number_of(dom, "sweep_seconds") / all;
    const double solving = r->strong[0] * number_of(dom, "solve_seconds") / all;
    int32_t cells[3];
    sum(dom, "size", cells);
    r->sweeps = sum(dom, "sweeps", NULL);
    r->sweep = (scaling_sweep){.directions = (int32_t)number_of(dom, "directions"),
                               .face_bytes = 4,
                               .in_a_row = ranks_in_a_row,
                               .octant_factor = octant_factor};
    memcpy(r->sweep.cells, cells, sizeof cells);
    r->sweep.group = r->sweep.directions / 8;
    r->sweep.cell_seconds = sweeping / (r->sweeps * (double)cells[0] * cells[1] * cells[2] * r->sweep.directions);
    r->grid = make_grid(cells, sum(dom, "cycles", NULL), fmax(solving - sweeping, 0));
    r->other = fmax(r->work - solving, 0);
    r->cell_bytes = number_of(stats, "peak_memory_bytes") / ((double)cells[0] * cells[1] * cells[2]);
    r->cut_bytes = 0.5 * r->sweep.face_bytes * r->sweep.directions; /* incoming radiance across x and y */
}

static void fit_multigrid(case_result* r, const json_t* stats) {
    const json_t* fld = json_object_get(stats, "fld");
    const double solving = r->strong[0] * number_of(fld, "solve_seconds") / number_of(stats, "seconds");
    int32_t cells[3];
    sum(fld, "diffusion_size", cells);
    r->grid = make_grid(cells, sum(fld, "cycles", NULL), solving);
    r->other = fmax(r->work - solving, 0);
    sum(fld, "direct_size", cells);
    r->cell_bytes = number_of(stats, "peak_memory_bytes") / ((double)cells[0] * cells[1] * cells[2]);
    r->cut_bytes = r->grid.face_bytes;
}

static void fit(case_result* r, const json_t* stats) {
    const scaling_case* c = r->of;
    if (c->model == BY_SWEEPS) fit_sweeps(r, stats);
    if (c->model == BY_MULTIGRID) fit_multigrid(r, stats);
    r->tasks = (scaling_tasks){.start = r->start[1],
                               .work = r->work,
                               .task = task_seconds,
                               .bytes = r->bytes,
                               .blocks = (c->items + c->block - 1) / (c->block > 0 ? c->block : 1)};
}

static ty_result measure_case(figure_run* run, const char* folder, const scaling_case* c, case_result* out) {
    json_t* stats = NULL;
    *out = (case_result){.of = c};
    ty_result result = measure_all(run, folder, c, false, out->strong, out, &stats);
    if (result == TY_OK) result = measure_start(run, folder, c, out);
    if (result == TY_OK) result = measure_all(run, folder, c, true, out->weak, out, NULL);
    if (result == TY_OK) fit(out, stats);
    json_decref(stats);
    return result;
}

static double sweeps_seconds(const case_result* r, const scaling_network* network, int32_t ranks,
                             scaling_schedule schedule) {
    scaling_sweep sweep = r->sweep;
    sweep.schedule = schedule;
    sweep.planes = scaling_best_planes(&sweep, network, ranks);
    return r->sweeps * scaling_sweep_seconds(&sweep, network, ranks) +
           scaling_multigrid_seconds(&r->grid, network, ranks);
}

/* Seconds of the measured problem by the model. */
static double model_seconds(const case_result* r, const scaling_network* network, int32_t ranks) {
    const double start = ranks > 1 ? r->start[1] : r->start[0];
    scaling_tasks tasks = r->tasks;
    switch (r->of->model) {
    case BY_SWEEPS: return start + r->other + sweeps_seconds(r, network, ranks, SCALING_MINIMAL);
    case BY_MULTIGRID: return start + r->other + scaling_multigrid_seconds(&r->grid, network, ranks);
    case BY_TASKS: break;
    }
    tasks.start = start;
    return scaling_tasks_seconds(&tasks, network, ranks);
}

/* The planned problem: an image of 1920 x 1080 pixels, a bake of 131,072 probes, solves of 1024^3 cells in three
 * channels; of the latter without what is not the solve. */
static case_result plan(const case_result* measured, int32_t number) {
    const scaling_case* c = measured->of;
    case_result r = *measured;
    const int32_t cells[3] = {PLAN_EDGE, PLAN_EDGE, PLAN_EDGE};
    const double grids = r.grid.cell_seconds, cycles = r.grid.cycles, passes = ceil(c->plan_number / 256.0);
    if (c->model == BY_TASKS) {
        r.work = r.tasks.work *= (double)c->plan_items / (double)c->items * c->plan_number / number;
        r.tasks.blocks = (c->plan_items + c->block - 1) / c->block;
        r.tasks.bytes = c->block == PATH_BLOCK ? pixel_bytes * (double)c->plan_items * passes
                                               : r.bytes * (double)c->plan_items / (double)c->items;
        return r;
    }
    memcpy(r.sweep.cells, cells, sizeof cells);
    r.grid = make_grid(cells, cycles, 0);
    r.grid.cell_seconds = grids;
    r.other = r.start[0] = r.start[1] = 0;
    return r;
}

/* ---- charts ---- */

static plot_series* add_series(plot_chart* chart, plot_style style, int color, const char* format, const char* name) {
    plot_series* series = &chart->series[chart->series_count++];
    snprintf(series->name, sizeof series->name, format, name);
    series->style = style;
    series->color = color;
    return series;
}

static void draw_measured(plot_chart charts[CHARTS], const case_result* r, int color) {
    plot_series* strong = add_series(&charts[0], PLOT_LINE_AND_DOTS, color, "%s", r->of->name);
    plot_series* weak = add_series(&charts[1], PLOT_LINE_AND_DOTS, color, "%s", r->of->name);
    plot_series* work = add_series(&charts[0], PLOT_DASHES, color, "%s without start", r->of->name);
    for (int i = 0; i < MEASURED; ++i) {
        const int32_t ranks = ranks_measured[i];
        plot_add_point(strong, ranks, r->strong[0] / (ranks * r->strong[i]), 0);
        plot_add_point(weak, ranks, r->weak[0] / r->weak[i], 0);
        plot_add_point(work, ranks, r->work / (ranks * fmax(r->strong[i] - r->start[i > 0], 1e-6)), 0);
    }
}

static void draw_model(plot_chart charts[CHARTS], const case_result* r, const scaling_network* network, int color) {
    plot_series* model = add_series(&charts[2], PLOT_LINE, color, "%s", r->of->name);
    plot_series* dots = add_series(&charts[2], PLOT_DOTS, color, "", "");
    for (int32_t ranks = 1; ranks <= RANKS_END; ranks *= 2)
        plot_add_point(model, ranks, model_seconds(r, network, ranks), 0);
    for (int i = 0; i < MEASURED; ++i) plot_add_point(dots, ranks_measured[i], r->strong[i], 0);
}

/* Efficiency of the planned problem; sweeps also by the published schedule. */
static void draw_plan(figure_run* run, plot_chart charts[CHARTS], const case_result* planned,
                      const scaling_network* network, int color) {
    const bool swept = planned->of->model == BY_SWEEPS;
    plot_series* model = add_series(&charts[3], PLOT_LINE, color, "%s", planned->of->name);
    plot_series* published = swept ? add_series(&charts[3], PLOT_DASHES, color, "%s, KBA's schedule", "dom") : NULL;
    const double one = model_seconds(planned, network, 1);
    for (int32_t ranks = 1; ranks <= RANKS_END; ranks *= 2) {
        char item[FIGURE_NAME_SIZE];
        const double seconds = model_seconds(planned, network, ranks);
        snprintf(item, sizeof item, "%s, planned, %d ranks", planned->of->name, (int)ranks);
        plot_add_point(model, ranks, one / (ranks * seconds), 0);
        figure_notes(run, item, {"time by the model", "s", seconds}, {"efficiency", "1", one / (ranks * seconds)});
        if (!swept) continue;
        const double kba = sweeps_seconds(planned, network, ranks, SCALING_KBA);
        plot_add_point(published, ranks, one / (ranks * kba), 0);
        figure_note(run, item, "efficiency, KBA's schedule", "1", one / (ranks * kba));
    }
}

/* ---- memory ---- */

/* Memory of a rank in the planned solves of three channels. */
static ty_result draw_memory(figure_run* run, const case_result results[CASES]) {
    static const int32_t ranks[MEMORIES] = {1, 16, 64, 256, 512, 1024, RANKS_END};
    static const int32_t cells[3] = {PLAN_EDGE, PLAN_EDGE, PLAN_EDGE};
    plot_table table;
    int row = 1;
    const ty_result result = plot_create_table(3, MEMORIES + 1, 1, &table);
    if (result != TY_OK) return result;
    plot_set_cell(&table, 0, 0, "%d³ cells, 3 channels: GB a rank", PLAN_EDGE);
    for (int i = 0; i < MEMORIES; ++i) plot_set_cell(&table, 0, i + 1, "%d ranks", (int)ranks[i]);
    for (int c = 0; c < CASES; ++c) {
        const case_result* r = &results[c];
        if (r->of->model == BY_TASKS) continue;
        plot_set_cell(&table, row, 0, "%s, %.0f bytes a cell", r->of->name, r->cell_bytes);
        for (int i = 0; i < MEMORIES; ++i) {
            char item[FIGURE_NAME_SIZE];
            const double gigabytes = 1e-9 * scaling_memory(cells, r->cell_bytes, r->cut_bytes, ranks[i]);
            plot_set_cell(&table, row, i + 1, "%.3g", gigabytes);
            snprintf(item, sizeof item, "%s, planned, %d ranks", r->of->name, (int)ranks[i]);
            figure_note(run, item, "memory of a rank", "GB", gigabytes);
        }
        ++row;
    }
    plot_page_table(&run->page, &table);
    plot_free_table(&table);
    return result;
}

/* ---- the page ---- */

static void begin_charts(plot_chart charts[CHARTS]) {
    charts[0] = (plot_chart){.title = "strong: the same problem", .y_label = "efficiency"};
    charts[1] = (plot_chart){.title = "weak: a problem as large as the ranks", .y_label = "efficiency"};
    charts[2] =
        (plot_chart){.title = "the strong problem, measured and by the model", .y_label = "s", .y_logarithmic = true};
    charts[3] = (plot_chart){.title = "a planned problem, by the model", .y_label = "efficiency"};
    for (int i = 0; i < CHARTS; ++i) {
        charts[i].x_label = "ranks";
        charts[i].x_logarithmic = true;
    }
}

ty_result figure_scaling_ranks(figure_run* run) {
    static plot_chart charts[CHARTS];
    char folder[FIGURE_PATH_SIZE];
    case_result results[CASES];
    const scaling_network network = {run->options->latency, run->options->bandwidth};
    begin_charts(charts);
    ty_result result = scaling_open_folder(run, folder);
    if (result != TY_OK || !scaling_can_start(run, folder)) return result;
    for (int c = 0; c < CASES && result == TY_OK; ++c) {
        result = measure_case(run, folder, &cases[c], &results[c]);
        if (result != TY_OK) return result;
        const case_result planned = plan(&results[c], strong_number(run, &cases[c]));
        draw_measured(charts, &results[c], 1 + c);
        draw_model(charts, &results[c], &network, 1 + c);
        draw_plan(run, charts, &planned, &network, 1 + c);
    }
    plot_page_charts(&run->page, charts, 2);
    plot_page_charts(&run->page, charts + 2, 2);
    result = draw_memory(run, results);
    figure_caption(run,
                   "Ranks of one thread under mpirun on this machine, by processor time; waiting is not in it. path, "
                   "bake: the mean of the ranks, whose tasks go to who is free; others: the rank with the most. Model: "
                   "docs/farm.md, %g µs and %g GB/s a message. Planned: an image of 1920 x 1080 with 1024 samples, "
                   "131,072 probes, and solves of %d³ cells in three channels.",
                   1e6 * network.latency, 1e-9 * network.bandwidth, PLAN_EDGE);
    return result;
}
