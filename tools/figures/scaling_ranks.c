/* One command by many ranks: strong and weak scaling by processor time, and the model of it to thousands of ranks. */
#include "figures/scaling_measure.h"
#include "figures/scaling_model.h"
#include "solve/diffusion/divided/plan.h"
#include "solve/ordinates/divided/plan.h"

#include <math.h>
#include <string.h>

enum { MEASURED = 3, PLAN_EDGE = 1024, CHARTS = 4, MEMORIES = 7, POWERS = 13 };

static const int32_t ranks_measured[MEASURED] = {1, 2, SCALING_RANKS_MAX};

/* Bytes of a pixel and pass that rank 0 sends and receives, and of a receiver: docs/farm.md. */
static const double pixel_bytes = 112;
/* Seconds of a task, and items of a block of path and bake. */
static const double task_seconds = 0.2;
/* Layers that a cycle of limited diffusion exchanges, in units of those of a linear cycle: test_fld_divided counts 5.3
 * to 7.8. */
static const double limited_layers = 7.5;
/* Of dom's sweeps: an octant by itself takes so many times as long for a cell and direction. */
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

/* The plans of a grid's solves for 1, 2, 4 ... ranks. */
typedef struct grid_plans {
    int32_t count; /* so many can share it */
    ty_ordinates_plan sweeps[POWERS];
    ty_diffusion_plan cycles[POWERS];
} grid_plans;

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
    int32_t bands, cells[3];
    double cycles, cycle_cell_seconds;
    grid_plans plans;
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

/* Plans of the case's cells. A grid of few cells is planned for few ranks. */
static ty_result make_plans(figure_run* run, case_result* r) {
    ty_context* context = run->session->context;
    static ty_angular_quadrature set;
    ty_ordinates_def sweep = ty_default_ordinates_def();
    ty_diffusion_def diffusion = ty_default_diffusion_def();
    const bool swept = r->of->model == BY_SWEEPS;
    ty_result result = TY_OK;
    for (int a = 0; a < 3; ++a) {
        sweep.size[a] = diffusion.size[a] = r->cells[a];
        sweep.cell[a] = diffusion.cell[a] = 1;
    }
    if (swept) {
        result = ty_angular_quadrature_create(context, r->sweep.directions, &set, NULL);
        sweep.set = &set;
        sweep.bands = r->bands;
        sweep.output_order = r->bands < 2 ? 2 : r->bands;
        sweep.source_terms = r->bands * r->bands;
        sweep.accelerated = true;
    }
    r->plans.count = 0;
    for (int32_t i = 0; i < POWERS && result == TY_OK; ++i) {
        if (swept) result = ty_ordinates_plan_ranks(context, &sweep, 1 << i, &r->plans.sweeps[i]);
        if (result != TY_OK) break;
        /* The acceleration of few cells is rank 0's. */
        result = ty_diffusion_plan_ranks(context, &diffusion, 1 << i, &r->plans.cycles[i]);
        if (swept && result == TY_ERROR_ARGUMENT)
            result = ty_diffusion_plan_ranks(context, &diffusion, 1, &r->plans.cycles[i]);
        r->plans.count += result == TY_OK ? 1 : 0;
    }
    if (result == TY_ERROR_ARGUMENT && r->plans.count > 0) ty_take_error(context);
    return result == TY_ERROR_ARGUMENT && r->plans.count > 0 ? TY_OK : result;
}

static void fit_cycles(case_result* r, double cycles, double seconds) {
    r->cycles = cycles;
    r->cycle_cell_seconds = seconds / fmax(cycles * r->plans.cycles[0].cells, 1);
}

/* Parts of the processor time go as the clock says. */
static ty_result fit_sweeps(figure_run* run, case_result* r, const json_t* stats) {
    const json_t* dom = json_object_get(stats, "dom");
    const double all = number_of(stats, "seconds");
    const double sweeping = r->strong[0] * number_of(dom, "sweep_seconds") / all;
    const double solving = r->strong[0] * number_of(dom, "solve_seconds") / all;
    sum(dom, "size", r->cells);
    r->sweeps = sum(dom, "sweeps", NULL);
    r->bands = (int32_t)number_of(dom, "bands");
    r->sweep = (scaling_sweep){.directions = (int32_t)number_of(dom, "directions"), .octant_factor = octant_factor};
    memcpy(r->sweep.cells, r->cells, sizeof r->sweep.cells);
    r->sweep.cell_seconds =
        sweeping / (r->sweeps * (double)r->cells[0] * r->cells[1] * r->cells[2] * r->sweep.directions);
    r->other = fmax(r->work - solving, 0);
    const ty_result result = make_plans(run, r);
    if (result == TY_OK) fit_cycles(r, sum(dom, "cycles", NULL), fmax(solving - sweeping, 0));
    return result;
}

static ty_result fit_multigrid(figure_run* run, case_result* r, const json_t* stats) {
    const json_t* fld = json_object_get(stats, "fld");
    const double solving = r->strong[0] * number_of(fld, "solve_seconds") / number_of(stats, "seconds");
    sum(fld, "diffusion_size", r->cells);
    r->other = fmax(r->work - solving, 0);
    const ty_result result = make_plans(run, r);
    if (result == TY_OK) fit_cycles(r, sum(fld, "cycles", NULL), solving);
    return result;
}

static ty_result fit(figure_run* run, case_result* r, const json_t* stats) {
    const scaling_case* c = r->of;
    r->tasks = (scaling_tasks){.start = r->start[1],
                               .work = r->work,
                               .task = task_seconds,
                               .bytes = r->bytes,
                               .blocks = (c->items + c->block - 1) / (c->block > 0 ? c->block : 1)};
    if (c->model == BY_SWEEPS) return fit_sweeps(run, r, stats);
    return c->model == BY_MULTIGRID ? fit_multigrid(run, r, stats) : TY_OK;
}

static ty_result measure_case(figure_run* run, const char* folder, const scaling_case* c, case_result* out) {
    json_t* stats = NULL;
    *out = (case_result){.of = c};
    ty_result result = measure_all(run, folder, c, false, out->strong, out, &stats);
    if (result == TY_OK) result = measure_start(run, folder, c, out);
    if (result == TY_OK) result = measure_all(run, folder, c, true, out->weak, out, NULL);
    if (result == TY_OK) result = fit(run, out, stats);
    json_decref(stats);
    return result;
}

static double cycles_seconds(const case_result* r, const scaling_network* network, int32_t power) {
    const ty_diffusion_plan* plan = &r->plans.cycles[power];
    const double layers = r->of->model == BY_MULTIGRID ? limited_layers : 1;
    const scaling_cycle cycle = {plan->cells, layers * plan->messages, layers * plan->halo_bytes + plan->gather_bytes};
    return r->cycles * scaling_cycle_seconds(&cycle, network, r->cycle_cell_seconds);
}

/* The stages of a plan; one rank has a single one. */
static scaling_stages stages_of(const ty_ordinates_plan* plan) {
    const bool alone = plan->ranks[0] * plan->ranks[1] == 1;
    return (scaling_stages){{plan->ranks[0], plan->ranks[1]},
                            alone ? 1 : plan->units,
                            alone ? 1 : plan->stages,
                            plan->messages,
                            plan->message_bytes};
}

/* Seconds of all sweeps and of their acceleration. */
static double sweeps_seconds(const case_result* r, const scaling_network* network, int32_t power,
                             const scaling_stages* stages) {
    const double moved = r->plans.sweeps[power].cell_bytes / (1 << power);
    return r->sweeps * (scaling_sweep_seconds(&r->sweep, network, stages) + moved / network->bandwidth) +
           cycles_seconds(r, network, power);
}

/* True if 2^power ranks can share the problem. */
static bool is_planned(const case_result* r, int32_t power) {
    return r->of->model == BY_TASKS || power < r->plans.count;
}

/* Seconds of the problem by the model, of 2^power ranks. */
static double model_seconds(const case_result* r, const scaling_network* network, int32_t power) {
    const double start = power > 0 ? r->start[1] : r->start[0];
    scaling_tasks tasks = r->tasks;
    scaling_stages stages;
    switch (r->of->model) {
    case BY_SWEEPS:
        stages = stages_of(&r->plans.sweeps[power]);
        return start + r->other + sweeps_seconds(r, network, power, &stages);
    case BY_MULTIGRID: return start + r->other + cycles_seconds(r, network, power);
    case BY_TASKS: break;
    }
    tasks.start = start;
    return scaling_tasks_seconds(&tasks, network, 1 << power);
}

/* The planned problem: an image of 1920 x 1080 pixels, a bake of 131,072 probes, solves of 1024^3 cells in three
 * channels; of the latter without what is not the solve. */
static ty_result plan(figure_run* run, const case_result* measured, int32_t number, case_result* out) {
    const scaling_case* c = measured->of;
    *out = *measured;
    const double passes = ceil(c->plan_number / 256.0);
    if (c->model == BY_TASKS) {
        out->work = out->tasks.work *= (double)c->plan_items / (double)c->items * c->plan_number / number;
        out->tasks.blocks = (c->plan_items + c->block - 1) / c->block;
        out->tasks.bytes = c->block == PATH_BLOCK ? pixel_bytes * (double)c->plan_items * passes
                                                  : out->bytes * (double)c->plan_items / (double)c->items;
        return TY_OK;
    }
    for (int a = 0; a < 3; ++a) out->cells[a] = out->sweep.cells[a] = PLAN_EDGE;
    out->other = out->start[0] = out->start[1] = 0;
    return make_plans(run, out);
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
    for (int32_t i = 0; i < POWERS && is_planned(r, i); ++i)
        plot_add_point(model, 1 << i, model_seconds(r, network, i), 0);
    for (int i = 0; i < MEASURED; ++i) plot_add_point(dots, ranks_measured[i], r->strong[i], 0);
}

/* Sweeps of the planned problem by the published schedule: with the same division and blocks, and with its own best
 * ones. */
static void draw_published(figure_run* run, plot_series* series, const case_result* planned, double one,
                           const scaling_network* network, int32_t power, const char* item) {
    const int32_t ranks = 1 << power;
    const ty_ordinates_plan* own = &planned->plans.sweeps[power];
    const scaling_stages best = scaling_best_kba(&planned->sweep, network, ranks);
    const double kba = sweeps_seconds(planned, network, power, &best);
    plot_add_point(series, ranks, one / (ranks * kba), 0);
    figure_notes(run, item, {"efficiency, KBA's schedule", "1", one / (ranks * kba)}, {"units", "1", own->units},
                 {"stages", "1", own->stages}, {"stages corner by corner", "1", ty_ordinates_stages_kba(own)},
                 {"units, KBA's", "1", best.units}, {"stages, KBA's", "1", best.stages});
}

/* Efficiency of the planned problem; sweeps also by the published schedule. */
static void draw_plan(figure_run* run, plot_chart charts[CHARTS], const case_result* planned,
                      const scaling_network* network, int color) {
    const bool swept = planned->of->model == BY_SWEEPS;
    plot_series* model = add_series(&charts[3], PLOT_LINE, color, "%s", planned->of->name);
    plot_series* published = swept ? add_series(&charts[3], PLOT_DASHES, color, "%s, KBA's schedule", "dom") : NULL;
    const double one = model_seconds(planned, network, 0);
    for (int32_t i = 0; i < POWERS && is_planned(planned, i); ++i) {
        char item[FIGURE_NAME_SIZE];
        const int32_t ranks = 1 << i;
        const double seconds = model_seconds(planned, network, i);
        snprintf(item, sizeof item, "%s, planned, %d ranks", planned->of->name, (int)ranks);
        plot_add_point(model, ranks, one / (ranks * seconds), 0);
        figure_notes(run, item, {"time by the model", "s", seconds}, {"efficiency", "1", one / (ranks * seconds)});
        if (swept) draw_published(run, published, planned, one, network, i, item);
    }
}

/* ---- memory ---- */

/* Memory of a rank in the planned solves; channels are solved one after another. */
static ty_result draw_memory(figure_run* run, const case_result planned[CASES]) {
    static const int32_t powers[MEMORIES] = {0, 4, 6, 8, 9, 10, POWERS - 1};
    plot_table table;
    int row = 1;
    const ty_result result = plot_create_table(3, MEMORIES + 1, 1, &table);
    if (result != TY_OK) return result;
    plot_set_cell(&table, 0, 0, "%d³ cells: GB a rank, of its part alone", PLAN_EDGE);
    for (int i = 0; i < MEMORIES; ++i) plot_set_cell(&table, 0, i + 1, "%d ranks", 1 << powers[i]);
    for (int c = 0; c < CASES; ++c) {
        const case_result* r = &planned[c];
        if (r->of->model == BY_TASKS) continue;
        plot_set_cell(&table, row, 0, "%s", r->of->name);
        for (int i = 0; i < MEMORIES; ++i) {
            char item[FIGURE_NAME_SIZE];
            const ty_ordinates_plan* sweeps = &r->plans.sweeps[powers[i]];
            const ty_diffusion_plan* cycles = &r->plans.cycles[powers[i]];
            if (!is_planned(r, powers[i])) continue;
            const double gigabytes =
                1e-9 * (r->of->model == BY_SWEEPS ? sweeps->arrays + sweeps->solve : cycles->arrays + cycles->solve);
            plot_set_cell(&table, row, i + 1, "%.3g", gigabytes);
            snprintf(item, sizeof item, "%s, planned, %d ranks", r->of->name, 1 << powers[i]);
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
    static case_result results[CASES], planned[CASES];
    const scaling_network network = {run->options->latency, run->options->bandwidth};
    begin_charts(charts);
    ty_result result = scaling_open_folder(run, folder);
    if (result != TY_OK || !scaling_can_start(run, folder)) return result;
    for (int c = 0; c < CASES && result == TY_OK; ++c) {
        result = measure_case(run, folder, &cases[c], &results[c]);
        if (result == TY_OK) result = plan(run, &results[c], strong_number(run, &cases[c]), &planned[c]);
        if (result != TY_OK) return result;
        draw_measured(charts, &results[c], 1 + c);
        draw_model(charts, &results[c], &network, 1 + c);
        draw_plan(run, charts, &planned[c], &network, 1 + c);
    }
    plot_page_charts(&run->page, charts, 2);
    plot_page_charts(&run->page, charts + 2, 2);
    result = draw_memory(run, planned);
    figure_caption(run,
                   "Ranks of one thread under mpirun on this machine, by processor time; waiting is not in it. path, "
                   "bake: the mean of the ranks, whose tasks go to who is free; others: the rank with the most. Model: "
                   "docs/farm.md, %g µs and %g GB/s a message. Planned: an image of 1920 x 1080 with 1024 samples, "
                   "131,072 probes, and solves of %d³ cells in three channels.",
                   1e6 * network.latency, 1e-9 * network.bandwidth, PLAN_EDGE);
    return result;
}
