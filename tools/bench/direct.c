/* tyndall bench direct: uncollided fluence on grids of 64^3, 128^3 and 256^3 cells. Cost is proportional to cells, so
 * the time per cell relative to the first size should stay near 1, except for cache effects. Times are CPU time on one
 * thread, which other load disturbs less, and wall time on several. */
#include "bench/bench.h"

#include "base/context.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/uncollided.h"

#include <string.h>

enum { SIZES = 3, RUNS_MAX = 99, BEAMS = 64, POINTS = 4 };

static const int32_t sides[SIZES] = {64, 128, 256};

typedef struct bench_case {
    const char* name;
    ty_light_kind light;
    double at[3]; /* direction or position */
    bool chromatic, flux, surfaces;
} bench_case;

static const bench_case cases[] = {
    {"beam along z", TY_LIGHT_DIRECTIONAL, {0, 0, 1}, false, false, false},
    {"beam along rows", TY_LIGHT_DIRECTIONAL, {1, 0, 0}, false, false, false},
    {"beam, slanting", TY_LIGHT_DIRECTIONAL, {1, -2, 0.5}, false, false, false},
    {"  and shadows", TY_LIGHT_DIRECTIONAL, {1, -2, 0.5}, false, false, true},
    {"  and flux", TY_LIGHT_DIRECTIONAL, {1, -2, 0.5}, false, true, false},
    {"  chromatic, flux", TY_LIGHT_DIRECTIONAL, {1, -2, 0.5}, true, true, false},
    {"lamp inside", TY_LIGHT_POINT, {0.1, 0.2, 0.3}, false, false, false},
    {"lamp outside", TY_LIGHT_POINT, {0.1, 3, 0.3}, false, false, false},
    {"  and shadows", TY_LIGHT_POINT, {0.1, 3, 0.3}, false, false, true},
    {"  chromatic, flux", TY_LIGHT_POINT, {0.1, 3, 0.3}, true, true, false},
    {"area light, flux", TY_LIGHT_AREA, {-0.2, 2, -0.3}, false, true, false},
    {"environment, flux", TY_LIGHT_ENVIRONMENT, {0, 0, 0}, false, true, false},
};
enum { CASES = sizeof cases / sizeof cases[0] };

typedef struct measured {
    double medium, light; /* medians, s */
    int32_t sources;
} measured;

static double seconds_of(const ty_context* context) {
    return ty_context_threads(context) == 1 ? ty_cpu_seconds() : ty_wall_seconds();
}

/* ---- cases ---- */

/* A cloud in a cube of 2 m with one voxel per cell; optionally with a ball inside. */
static ty_result fill_scene(const bench_case* c, ty_grid* noise, ty_scene* scene) {
    ty_medium_def cloud = ty_default_medium_def();
    cloud.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        cloud.box_min[a] = -1;
        cloud.box_max[a] = 1;
        cloud.sigma_s[a] = c->chromatic ? (float)(2 + a) : 3;
        cloud.sigma_a[a] = 0.3f;
    }
    cloud.density_grid = noise;
    ty_light_def light = ty_default_light_def();
    light.kind = c->light;
    memcpy(light.direction, c->at, sizeof light.direction);
    if (c->light != TY_LIGHT_DIRECTIONAL) light.direction[1] = -1;
    memcpy(light.position, c->at, sizeof light.position);
    light.u[0] = light.v[2] = 0.5;
    light.u[1] = light.u[2] = light.v[0] = light.v[1] = 0;
    ty_shape_def ball = ty_default_shape_def();
    ball.kind = TY_SHAPE_SPHERE;
    ball.radius = 0.4;
    ty_result result = ty_scene_add_medium(scene, &cloud);
    if (result == TY_OK) result = ty_scene_add_light(scene, &light);
    if (result == TY_OK && c->surfaces) result = ty_scene_add_shape(scene, &ball);
    return result == TY_OK ? ty_scene_commit(scene) : result;
}

/* A case on a grid. */
typedef struct problem {
    ty_scene* scene;
    ty_grid_medium* medium;
    ty_light_field* field;
    ty_discrete_light_set sources;
} problem;

static ty_result open_problem(ty_context* context, const bench_case* c, ty_grid* noise, int32_t side, problem* p,
                              double* medium_seconds) {
    *p = (problem){0};
    const ty_grid_box box = {.lower = {-1, -1, -1}, .upper = {1, 1, 1}, .size = {side, side, side}};
    const ty_discretize_def def = {.environment = BEAMS, .surface = POINTS};
    ty_result result = ty_scene_create(context, TY_AXIS_Y, &p->scene);
    if (result == TY_OK) result = fill_scene(c, noise, p->scene);
    const double begun = seconds_of(context);
    if (result == TY_OK) result = ty_grid_medium_create(p->scene, &box, &p->medium);
    *medium_seconds = seconds_of(context) - begun;
    if (result == TY_OK) result = ty_light_field_create(p->medium, c->flux, &p->field);
    if (result == TY_OK) result = ty_discretize_lights(p->scene, &def, &p->sources);
    return result;
}

static void close_problem(ty_context* context, problem* p) {
    ty_discrete_light_set_destroy(context, &p->sources);
    ty_light_field_destroy(p->field);
    ty_grid_medium_destroy(p->medium);
    ty_scene_destroy(p->scene);
}

/* ---- measuring ---- */

/* The first run is not timed, because it includes page faults. */
static ty_result measure_case(const bench_session* bench, const bench_case* c, ty_grid* noise, int32_t side,
                              measured* out) {
    ty_context* context = bench->session->context;
    double light[RUNS_MAX];
    problem p;
    ty_result result = open_problem(context, c, noise, side, &p, &out->medium);
    for (int run = -1; run < bench->options->runs && result == TY_OK; ++run) {
        const double begun = seconds_of(context);
        result = ty_uncollided_add(p.scene, p.medium, NULL, p.sources.items, p.sources.count, p.field);
        light[run < 0 ? 0 : run] = seconds_of(context) - begun;
    }
    out->light = bench_median(light, bench->options->runs);
    out->sources = p.sources.count;
    close_problem(context, &p);
    return result;
}

static ty_result measure_size(const bench_session* bench, int32_t side, measured out[CASES]) {
    ty_grid* noise = NULL;
    ty_noise_def def = ty_default_noise_def();
    def.kind = TY_NOISE_FBM;
    for (int a = 0; a < 3; ++a) def.size[a] = side;
    ty_result result = ty_grid_create_noise(bench->session->context, &def, &noise);
    for (int i = 0; i < CASES && result == TY_OK; ++i) result = measure_case(bench, &cases[i], noise, side, &out[i]);
    ty_grid_release(noise);
    return result;
}

/* ---- printing ---- */

static double nanoseconds(double seconds, int32_t side, int32_t sources) {
    return 1e9 * seconds / ((double)side * side * side * sources);
}

static void print_size(json_writer* json, int32_t side, const measured* m) {
    json_open_object(json, NULL);
    bench_numbers(json, {"side", side}, {"sampling_seconds", m->medium});
    json_open_array(json, "cases");
    for (int i = 0; i < CASES; ++i) {
        json_open_object(json, NULL);
        json_text(json, "name", cases[i].name + strspn(cases[i].name, " "));
        json_bool(json, "chromatic", cases[i].chromatic);
        json_bool(json, "flux", cases[i].flux);
        json_bool(json, "shadows", cases[i].surfaces);
        bench_numbers(json, {"sources", m[i].sources}, {"seconds", m[i].light},
                      {"ns_per_cell_and_source", nanoseconds(m[i].light, side, m[i].sources)});
        json_close_object(json);
    }
    json_close_array(json);
    json_close_object(json);
}

int bench_direct(const bench_session* bench) {
    measured found[SIZES][CASES];
    ty_result result = TY_OK;
    json_open_array(bench->json, "sizes");
    for (int i = 0; i < (bench->options->quick ? 1 : SIZES) && result == TY_OK; ++i) {
        result = measure_size(bench, sides[i], found[i]);
        if (result != TY_OK) break;
        print_size(bench->json, sides[i], found[i]);
    }
    json_close_array(bench->json);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
