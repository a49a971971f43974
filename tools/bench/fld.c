/* tyndall bench fld: the diffusion solvers over sizes of grids, and complete images compared with classical diffusion
 * and path tracing. */
#include "bench/bench.h"
#include "bench/fld_box.h"
#include "bench/milk.h"
#include "method/registry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SOR_SIDE = 128, SIZES = 3, RUNS_MAX = 99, WIDTH = 1024 };

static const int32_t sides[SIZES] = {64, 128, 256};
static const double tolerance = 1e-6;

/* ---- test problems ---- */

/* Isotropic fog lit from above: extinction 4/m, albedo 1. */
static void fill_beam(const fld_box* p, size_t at, double x, double y, double z) {
    (void)x;
    (void)z;
    p->extinction[at] = 4;
    p->source[at] = (float)(4 * exp(-4 * (1 - y)));
}

/* An inhomogeneous emissive ball in vacuum, albedo 0.999. */
static void fill_cloud(const fld_box* p, size_t at, double x, double y, double z) {
    const double r = sqrt((x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5) + (z - 0.5) * (z - 0.5));
    const double lumps = sin(23 * x) * sin(19 * y + 1) * sin(21 * z + 2);
    if (r > 0.35 + 0.05 * lumps) return;
    p->extinction[at] = (float)(40 * (1 + 0.8 * lumps));
    p->absorption[at] = 1e-3f * p->extinction[at];
    p->source[at] = (float)fmax(0, 1 + lumps - 2 * r);
}

typedef void (*fill_fn)(const fld_box* p, size_t at, double x, double y, double z);

/* A cube of edge 1 m on side^3 cells. */
static ty_result open_problem(const bench_session* bench, int32_t side, fill_fn fill, fld_box* out) {
    const ty_result result = fld_make_box(bench->session->context, side, 1, out);
    size_t at = 0;
    for (int32_t k = 0; k < side && result == TY_OK; ++k)
        for (int32_t j = 0; j < side; ++j)
            for (int32_t i = 0; i < side; ++i, ++at)
                fill(out, at, (i + 0.5) / side, (j + 0.5) / side, (k + 0.5) / side);
    return result;
}

/* ---- solvers ---- */

static const struct {
    const char* name;
    fill_fn fill;
    ty_limiter limiter;
    ty_diffusion_solver solver;
    double relaxation; /* relaxation factor of SOR, near the optimum for this problem and side */
    int32_t smallest, largest;
    double streaming; /* options of limiters */
} cases[] = {
    {"linear, beam", fill_beam, TY_LIMITER_NONE, TY_DIFFUSION_MULTIGRID, 0, 64, 256, 0.55},
    {"limited, beam", fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_DIFFUSION_MULTIGRID, 0, 64, 256, 0.55},
    {"limited, beam, 1", fill_beam, TY_LIMITER_LEVERMORE_POMRANING, TY_DIFFUSION_MULTIGRID, 0, 64, 256, 1},
    {"linear, cloud", fill_cloud, TY_LIMITER_NONE, TY_DIFFUSION_MULTIGRID, 0, 64, 256, 0.55},
    {"limited, cloud", fill_cloud, TY_LIMITER_LEVERMORE_POMRANING, TY_DIFFUSION_MULTIGRID, 0, 64, 128, 0.55},
    {"linear, beam, sor", fill_beam, TY_LIMITER_NONE, TY_DIFFUSION_SOR, 1.96, SOR_SIDE, SOR_SIDE, 1},
};
enum { CASES = sizeof cases / sizeof cases[0], SOR_CASE = CASES - 1, LINEAR_CASE = 0 };

typedef struct solved {
    int32_t side, iterations, cycles;
    double work, residual, seconds, cpu_seconds, floats; /* medians; floats: memory in floats per cell */
    bool converged;
} solved;

static ty_diffusion_def make_def(int index, const fld_box* p) {
    ty_diffusion_def def = p->def;
    for (int side = 0; side < 6; ++side) def.boundary[side] = ty_default_diffusion_def().boundary[side];
    def.limiter = cases[index].limiter;
    def.streaming = cases[index].streaming;
    def.solver = cases[index].solver;
    def.tolerance = tolerance;
    if (cases[index].relaxation > 0) def.relaxation = cases[index].relaxation;
    return def;
}

static ty_result run_case(const bench_session* bench, int index, int32_t side, solved* out) {
    fld_box p = {0};
    ty_result result = open_problem(bench, side, cases[index].fill, &p);
    if (result != TY_OK) return result;
    ty_diffusion_def def = make_def(index, &p);
    const ty_diffusion_out fluence = {.fluence = p.fluence};
    const size_t bytes = ty_diffusion_memory(&def);
    def.memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
    result = def.memory != NULL ? TY_OK : TY_ERROR_MEMORY;
    const int runs = cases[index].solver == TY_DIFFUSION_SOR ? 1 : bench->options->runs;
    double seconds[RUNS_MAX], cpu_seconds[RUNS_MAX];
    for (int run = 0; run < runs && result == TY_OK; ++run) {
        ty_diffusion_stats stats;
        const double cpu = cli_cpu_seconds();
        result = ty_diffusion_solve(bench->session->context, &def, &fluence, &stats);
        cpu_seconds[run] = cli_cpu_seconds() - cpu;
        seconds[run] = stats.seconds;
        *out = (solved){.side = side,
                        .iterations = stats.iterations,
                        .cycles = stats.cycles,
                        .work = stats.work,
                        .residual = stats.residual,
                        .converged = stats.converged};
    }
    if (result == TY_OK) {
        out->seconds = bench_median(seconds, runs);
        out->cpu_seconds = bench_median(cpu_seconds, runs);
        out->floats = (double)bytes / sizeof(float) / pow(side, 3);
    }
    fld_free_box(bench->session->context, &p);
    free(def.memory);
    return result;
}

/* The largest grid side of a case, at most SOR_SIDE with --quick. */
static int32_t largest_side(const bench_session* bench, int index) {
    return bench->options->quick && cases[index].largest > SOR_SIDE ? SOR_SIDE : cases[index].largest;
}

static void print_solved(const bench_session* bench, int index, const solved* s) {
    const double cells = pow(s->side, 3);
    json_open_object(bench->json, NULL);
    json_text(bench->json, "case", cases[index].name);
    json_int(bench->json, "side", s->side);
    json_bool(bench->json, "converged", s->converged);
    bench_numbers(bench->json, {"iterations", s->iterations}, {"cycles", s->cycles}, {"work", s->work},
                  {"residual", s->residual}, {"seconds", s->seconds}, {"mcells_per_second", 1e-6 * cells / s->seconds},
                  {"mcells_per_core_second", 1e-6 * cells / s->cpu_seconds}, {"floats_per_cell", s->floats});
    json_close_object(bench->json);
}

static ty_result bench_solvers(const bench_session* bench) {
    static solved results[CASES][SIZES];
    ty_result result = TY_OK;
    json_open_array(bench->json, "solvers");
    for (int i = 0; i < CASES && result == TY_OK; ++i)
        for (int s = 0; s < SIZES && result == TY_OK; ++s) {
            if (sides[s] < cases[i].smallest || sides[s] > largest_side(bench, i)) continue;
            result = run_case(bench, i, sides[s], &results[i][s]);
            if (result == TY_OK) print_solved(bench, i, &results[i][s]);
        }
    json_close_array(bench->json);
    if (result != TY_OK) return result;
    const double faster = results[SOR_CASE][1].seconds / results[LINEAR_CASE][1].seconds;
    json_number(bench->json, "multigrid_over_sor", faster);
    json_open_object(bench->json, "work_over_smallest");
    for (int i = 0; i < SOR_CASE; ++i) {
        const int last = largest_side(bench, i) == sides[SIZES - 1] ? SIZES - 1 : SIZES - 2;
        json_number(bench->json, cases[i].name, results[i][last].work / results[i][0].work);
    }
    json_close_object(bench->json);
    return TY_OK;
}

/* ---- images ---- */

typedef struct timed {
    double seconds[2], parts[2][4]; /* medians of fld and cda; medium, direct, solve, march */
    double path;                    /* s, of bench_time_path */
    double floats;                  /* bytes of the solve, per cell and channel */
    ty_fld_stats stats;
} timed;

static ty_result time_method(const bench_session* bench, const ty_scene* scene, bool limited, ty_fld_stats* stats) {
    ty_fld_def def = ty_default_fld_def();
    int32_t size[2];
    bench_pixels(bench->options, WIDTH, WIDTH, size);
    def.width = size[0];
    def.height = size[1];
    if (!limited) def.limiter = TY_FLD_LIMITER_NONE;
    ty_image* image = NULL;
    const ty_result result = ty_fld_render(scene, &def, &image, stats);
    ty_image_destroy(image);
    return result;
}

/* Runs of fld and cda are interleaved. */
static ty_result time_scene(const bench_session* bench, const ty_scene* scene, timed* out) {
    static double seconds[2][RUNS_MAX], parts[2][4][RUNS_MAX];
    const int runs = bench->options->runs;
    ty_result result = TY_OK;
    for (int run = 0; run < runs && result == TY_OK; ++run)
        for (int m = 0; m < 2 && result == TY_OK; ++m) {
            ty_fld_stats stats = ty_default_fld_stats();
            result = time_method(bench, scene, m == 0, &stats);
            if (result != TY_OK) break;
            const double of[4] = {stats.medium_seconds, stats.direct_seconds, stats.solve_seconds, stats.march_seconds};
            seconds[m][run] = stats.seconds;
            for (int i = 0; i < 4; ++i) parts[m][i][run] = of[i];
            if (m == 0) out->stats = stats;
        }
    if (result != TY_OK) return result;
    for (int m = 0; m < 2; ++m) {
        out->seconds[m] = bench_median(seconds[m], runs);
        for (int i = 0; i < 4; ++i) out->parts[m][i] = bench_median(parts[m][i], runs);
    }
    const int32_t* size = out->stats.diffusion_size;
    ty_diffusion_def channel = ty_default_diffusion_def();
    memcpy(channel.size, size, sizeof channel.size);
    for (int a = 0; a < 3; ++a) channel.cell[a] = 1;
    out->floats = (double)ty_diffusion_memory(&channel) / sizeof(float) / ((double)size[0] * size[1] * size[2]);
    return bench_time_path(bench, scene, WIDTH, WIDTH, &out->path);
}

static void print_timed(const bench_session* bench, const char* name, const timed* t) {
    static const char* const methods[] = {"fld", "cda"};
    static const char* const parts[] = {"medium_seconds", "direct_seconds", "solve_seconds", "march_seconds"};
    const int32_t* coarse = t->stats.diffusion_size;
    json_open_object(bench->json, name);
    for (int m = 0; m < 2; ++m) {
        json_open_object(bench->json, methods[m]);
        json_number(bench->json, "seconds", t->seconds[m]);
        for (int i = 0; i < 4; ++i) json_number(bench->json, parts[i], t->parts[m][i]);
        json_close_object(bench->json);
    }
    bench_numbers(bench->json, {"path_seconds_at_1000_spp", t->path}, {"path_over_fld", t->path / t->seconds[0]},
                  {"fld_over_cda", t->seconds[0] / t->seconds[1]}, {"floats_per_cell", t->floats});
    json_numbers(bench->json, "diffusion_size", (const double[]){coarse[0], coarse[1], coarse[2]}, 3);
    json_close_object(bench->json);
}

static ty_result bench_images(const bench_session* bench) {
    static const char* const names[] = {"cloud_sun", "nebulae"};
    ty_result result = TY_OK;
    json_open_object(bench->json, "images");
    for (size_t i = 0; i < sizeof names / sizeof *names && result == TY_OK; ++i) {
        char path[64];
        timed t = {.path = 0};
        ty_scene* scene = NULL;
        snprintf(path, sizeof path, "builtin:%s", names[i]);
        result = ty_scene_load(bench->session->context, path, NULL, 0, &scene);
        if (result == TY_OK) result = time_scene(bench, scene, &t);
        cli_progress_clear(&bench->session->progress);
        if (result == TY_OK) print_timed(bench, names[i], &t);
        ty_scene_destroy(scene);
    }
    json_close_object(bench->json);
    return result;
}

int bench_fld(const bench_session* bench) {
    ty_result result = bench_solvers(bench);
    if (result == TY_OK) result = bench_images(bench);
    if (result == TY_OK) result = bench_milk(bench, &ty_method_fld);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
