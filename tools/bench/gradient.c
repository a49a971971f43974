/* tyndall bench gradient: the processor time of gradients by fld and dom over that of the solves, with a sun and a sky
 * of 64 directions and weights on 32^3 cells. */
#define _GNU_SOURCE
#include "bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

enum { SIDE = 32, WEIGHTS = SIDE * SIDE * SIDE, CASES = 4, RUNS_MAX = 99 };

/* A box of fog, or a lumpy cloud in empty space of so many voxels along a side. */
typedef struct gradient_case {
    const char* name;
    int32_t voxels; /* 0: fog */
    float thickness, albedo, g;
} gradient_case;

static const gradient_case cases[CASES] = {{"fog", 0, 3, 0.9f, 0.4f},
                                           {"cloud_64", 64, 20, 0.999f, 0.85f},
                                           {"cloud_96", 96, 20, 0.999f, 0.85f},
                                           {"cloud_128", 128, 20, 0.999f, 0.85f}};

/* Processor time of all threads of the process, s. */
static double processor_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- scenes ---- */

static float density_at(const double at[3]) {
    const double x = at[0] - 0.5, y = at[1] - 0.5, z = at[2] - 0.5, r = sqrt(x * x + y * y + z * z);
    const double lumps = sin(23 * at[0]) * sin(19 * at[1] + 1) * sin(21 * at[2] + 2);
    return (float)fmax(0, fmin(1, 30 * (0.35 + 0.05 * lumps - r)));
}

static ty_result add_cloud(ty_context* context, int32_t side, ty_medium_def* medium, ty_grid** grid) {
    float* values = malloc(sizeof *values * (size_t)side * (size_t)side * (size_t)side);
    ty_grid_def def = ty_default_grid_def();
    if (values == NULL) return TY_ERROR_MEMORY;
    size_t i = 0;
    for (int32_t z = 0; z < side; ++z)
        for (int32_t y = 0; y < side; ++y)
            for (int32_t x = 0; x < side; ++x, ++i)
                values[i] = density_at((const double[3]){(x + 0.5) / side, (y + 0.5) / side, (z + 0.5) / side});
    for (int a = 0; a < 3; ++a) def.size[a] = side;
    def.values = values;
    const ty_result result = ty_grid_create(context, &def, grid);
    free(values);
    medium->density_grid = *grid;
    return result;
}

static ty_result make_scene(ty_context* context, const gradient_case* of, ty_scene** out) {
    ty_medium_def medium = ty_default_medium_def();
    ty_light_def sun = ty_default_light_def(), sky = ty_default_light_def();
    ty_grid* grid = NULL;
    medium.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        medium.sigma_s[a] = of->albedo * of->thickness;
        medium.sigma_a[a] = (1 - of->albedo) * of->thickness;
        medium.g[a] = of->g;
        medium.box_min[a] = 0;
        medium.box_max[a] = of->voxels > 0 ? 1 : 1 - 0.25 * a;
    }
    sky.kind = TY_LIGHT_ENVIRONMENT;
    sun.direction[0] = -1;
    sun.direction[1] = -2;
    sun.direction[2] = -0.5;
    ty_result result = ty_scene_create(context, TY_AXIS_Y, out);
    if (result == TY_OK && of->voxels > 0) result = add_cloud(context, of->voxels, &medium, &grid);
    if (result == TY_OK) result = ty_scene_add_medium(*out, &medium);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sun);
    if (result == TY_OK) result = ty_scene_add_light(*out, &sky);
    if (result == TY_OK) result = ty_scene_commit(*out);
    ty_grid_release(grid);
    return result;
}

/* ---- gradients ---- */

/* Of the middle one of the runs. */
typedef struct timed {
    double solve, gradient, ratio; /* s, s, gradient over solve */
    int32_t sweeps;                /* of the solve: iterations by fld */
    ty_gradient_stats stats;
} timed;

static const double lower[3] = {0, 0, 0}, upper[3] = {1, 1, 1};
static const int32_t size[3] = {SIDE, SIDE, SIDE};

static void make_weights(double weights[3 * WEIGHTS]) {
    for (int i = 0; i < WEIGHTS; ++i)
        for (int c = 0; c < 3; ++c) weights[3 * i + c] = (i * 7919 % 1000) / 1000.0 - 0.3;
}

static ty_result run_fld(const ty_scene* scene, const double* weights, timed* out) {
    const ty_fld_def def = ty_default_fld_def();
    ty_fld_stats stats = ty_default_fld_stats();
    ty_fld* light = NULL;
    ty_gradient* gradient = NULL;
    const double begun = processor_seconds();
    ty_result result = ty_fld_solve(scene, &def, &light, &stats);
    const double solved = processor_seconds();
    if (result == TY_OK)
        result = ty_fld_gradient(light, scene, &def, lower, upper, size, weights, &gradient, &out->stats);
    out->solve = solved - begun;
    out->gradient = processor_seconds() - solved;
    out->sweeps = stats.iterations[0];
    ty_gradient_destroy(gradient);
    ty_fld_destroy(light);
    return result;
}

static ty_result run_dom(const ty_scene* scene, const double* weights, timed* out) {
    ty_dom_def def = ty_default_dom_def();
    ty_dom_stats stats = ty_default_dom_stats();
    ty_dom* light = NULL;
    ty_gradient* gradient = NULL;
    def.differentiable = true;
    const double begun = processor_seconds();
    ty_result result = ty_dom_solve(scene, &def, &light, &stats);
    const double solved = processor_seconds();
    if (result == TY_OK)
        result = ty_dom_gradient(light, scene, &def, lower, upper, size, weights, &gradient, &out->stats);
    out->solve = solved - begun;
    out->gradient = processor_seconds() - solved;
    out->sweeps = stats.sweeps[0];
    ty_gradient_destroy(gradient);
    ty_dom_destroy(light);
    return result;
}

static int compare_ratios(const void* a, const void* b) {
    const double x = ((const timed*)a)->ratio, y = ((const timed*)b)->ratio;
    return (x > y) - (x < y);
}

static ty_result time_method(const bench_session* bench, const ty_scene* scene, const char* name,
                             ty_result (*run)(const ty_scene*, const double*, timed*), const double* weights) {
    timed runs[RUNS_MAX];
    const int count = bench->options->runs;
    for (int i = 0; i < count; ++i) {
        runs[i] = (timed){.stats = ty_default_gradient_stats()};
        const ty_result result = run(scene, weights, &runs[i]);
        if (result != TY_OK) return result;
        runs[i].ratio = runs[i].gradient / runs[i].solve;
    }
    qsort(runs, (size_t)count, sizeof *runs, compare_ratios);
    const timed* t = &runs[count / 2];
    json_open_object(bench->json, name);
    bench_numbers(bench->json, {"solve_cpu_seconds", t->solve}, {"gradient_cpu_seconds", t->gradient},
                  {"solves", t->ratio}, {"solve_iterations", t->sweeps}, {"gradient_iterations", t->stats.iterations},
                  {"direct_seconds", t->stats.direct_seconds}, {"diffuse_seconds", t->stats.solve_seconds},
                  {"residual", t->stats.residual}, {"imbalance", t->stats.imbalance});
    json_close_object(bench->json);
    return TY_OK;
}

int bench_gradient(const bench_session* bench) {
    static double weights[3 * WEIGHTS];
    ty_result result = TY_OK;
    make_weights(weights);
    for (int i = 0; i < (bench->options->quick ? CASES - 2 : CASES) && result == TY_OK; ++i) {
        ty_scene* scene = NULL;
        result = make_scene(bench->session->context, &cases[i], &scene);
        json_open_object(bench->json, cases[i].name);
        if (result == TY_OK) result = time_method(bench, scene, "fld", run_fld, weights);
        if (result == TY_OK) result = time_method(bench, scene, "dom", run_dom, weights);
        json_close_object(bench->json);
        ty_scene_destroy(scene);
    }
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
