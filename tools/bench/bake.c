/* tyndall bench bake: (1) the overhead of media in a bake at equal paths per receiver (paper: 4.7 % at low and 14.6 %
 * at high quality), by a radiance cache in the media, whose filling is timed separately, and by impulse responses; (2)
 * the speedup of both over path tracing through the media at equal error, of total and of scattered irradiance; (3)
 * rays per second, beside a bare Embree loop on the same triangles. Times are CPU times of all threads, which other
 * load disturbs less. Receivers are hit points of camera rays. Runs of the methods are interleaved. */
#include "bench/embree.h"
#include "bench/ray_sets.h"
#include "bench/tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <tyndall/bake.h>

enum { SIDE = 48, RUNS_MAX = 99, QUALITIES = 2, EMBREE_PIXELS = 512 };
enum { SURFACES = 0, ATTENUATION = 1, CACHE = 2, IMPULSE = 3, PUBLISHED = 4, PATH = 5, METHODS = 6 };
/* Numbers of bakes with independent seeds: of a method, and of the reference. */
enum { SEEDS = 2, TRUTH_SPP = 2048 };

static const char scene_name[] = "builtin:cornell_fog";
static const char* const method_names[METHODS] = {"surfaces", "attenuation",       "cache",
                                                  "impulse",  "impulse_published", "path"};
static const ty_bake_method methods[METHODS] = {TY_BAKE_SURFACES, TY_BAKE_ATTENUATION, TY_BAKE_CACHE,
                                                TY_BAKE_IMPULSE,  TY_BAKE_IMPULSE,     TY_BAKE_PATH};

static const struct {
    const char* name;
    int32_t spp;
    double paper; /* overhead of media in the paper */
} qualities[QUALITIES] = {{"low", 64, 0.047}, {"high", 1024, 0.146}};

/* ---- receivers ---- */

typedef struct receivers {
    ty_bake_receiver* at;
    ty_bake_light* light;
    int64_t count;
} receivers;

static void free_receivers(receivers* p) {
    free(p->at);
    free(p->light);
}

/* Hit points of rays on front faces, except those on the box's area light or closer to it than 0.3 m. */
static ty_result select_hits(const ty_scene* scene, const ty_ray* rays, int64_t count, receivers* out) {
    *out =
        (receivers){.at = malloc((size_t)count * sizeof *out->at), .light = calloc((size_t)count, sizeof *out->light)};
    ty_ray_hit* hits = malloc((size_t)count * sizeof *hits);
    ty_result result = out->at == NULL || out->light == NULL || hits == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) result = ty_scene_trace(scene, rays, count, TY_RAYS_INCOHERENT, hits);
    for (int64_t i = 0; i < count && result == TY_OK; ++i) {
        const float* at = hits[i].position;
        if (hits[i].surface < 0 || (at[2] > 0.99f && at[2] < 1.01f && hypotf(at[0], at[1]) < 0.3f)) continue;
        ty_bake_receiver* receiver = &out->at[out->count++];
        memcpy(receiver->position, hits[i].position, sizeof receiver->position);
        memcpy(receiver->normal, hits[i].normal, sizeof receiver->normal);
        memcpy(receiver->face, hits[i].normal, sizeof receiver->face);
        receiver->margin = hits[i].margin;
    }
    free(hits);
    if (result != TY_OK) free_receivers(out);
    return result;
}

static ty_result find_receivers(const bench_session* bench, const ty_scene* scene, receivers* out) {
    const bench_options* options = bench->options;
    int32_t size[2];
    bench_pixels(options, SIDE, SIDE, size);
    const double origin[3] = {0, -0.95, 0}; /* inside the box, so that rays in all directions hit it */
    const int64_t count = (int64_t)size[0] * size[1];
    ty_ray* rays = malloc((size_t)count * sizeof *rays);
    if (rays == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < count; ++i) { /* a spiral over the sphere */
        const double z = 1 - (2 * (double)i + 1) / (double)count, r = sqrt(1 - z * z),
                     turn = 2.399963229728653 * (double)i;
        rays[i] = (ty_ray){.origin = {(float)origin[0], (float)origin[1], (float)origin[2]},
                           .direction = {(float)(r * cos(turn)), (float)(r * sin(turn)), (float)z},
                           .far = INFINITY};
    }
    const ty_result result = select_hits(scene, rays, count, out);
    free(rays);
    return result;
}

/* ---- methods ---- */

static double processor_seconds(void) {
    return (double)clock() / CLOCKS_PER_SEC;
}

typedef struct timed {
    double seconds; /* median */
} timed;

/* Lookup structures of the media's radiance. */
typedef struct lookups {
    ty_impulse* tables;
    ty_bake_cache* cache[SEEDS];
    double filling; /* CPU seconds of filling one cache */
} lookups;

static ty_result bake(const ty_scene* scene, const lookups* lookup, const receivers* p, int method, int32_t spp,
                      int seed) {
    ty_bake_def def = ty_default_bake_def();
    def.method = methods[method];
    def.composition = method == PUBLISHED ? TY_BAKE_PUBLISHED : TY_BAKE_COLLISIONS;
    def.spp = spp;
    def.seed = (uint64_t)seed;
    def.tables = lookup->tables;
    def.cache = lookup->cache[seed % SEEDS];
    def.scatterings = method == IMPULSE ? def.scatterings : TY_IMPULSE_BOUNCES_MAX;
    const ty_result result = ty_bake_surfaces(scene, &def, p->at, p->count, p->light, NULL);
    return result == TY_OK && cli_interrupted() ? TY_CANCELLED : result;
}

static ty_result time_methods(const bench_session* bench, const ty_scene* scene, const lookups* lookup,
                              const receivers* p, int32_t spp, int method_count, timed out[METHODS]) {
    static double seconds[METHODS][RUNS_MAX];
    const int runs = bench->options->runs;
    ty_result result = TY_OK;
    for (int run = -1; run < runs; ++run)
        for (int m = 0; m < method_count && result == TY_OK; ++m) {
            const double start = processor_seconds();
            result = bake(scene, lookup, p, m, spp, 0);
            seconds[m][run < 0 ? 0 : run] = processor_seconds() - start;
        }
    for (int m = 0; m < method_count && result == TY_OK; ++m) out[m].seconds = bench_median(seconds[m], runs);
    return result;
}

static void print_quality(const bench_session* bench, int q, double filling, const timed t[METHODS]) {
    const double surfaces = t[SURFACES].seconds;

    json_open_object(bench->json, qualities[q].name);
    bench_numbers(bench->json, {"spp", qualities[q].spp}, {"surfaces_seconds", surfaces},
                  {"attenuation_seconds", t[ATTENUATION].seconds}, {"cache_seconds", t[CACHE].seconds},
                  {"cache_overhead", t[CACHE].seconds / surfaces - 1},
                  {"cache_overhead_with_filling", (t[CACHE].seconds + filling) / surfaces - 1},
                  {"impulse_seconds", t[IMPULSE].seconds}, {"overhead", t[IMPULSE].seconds / surfaces - 1},
                  {"paper_overhead", qualities[q].paper});
    json_close_object(bench->json);
}

/* ---- errors ---- */

/* Errors of total irradiance, and of irradiance scattered by the media. */
enum { ALL = 0, SCATTERED = 1, PARTS = 2 };
static const char* const component_names[PARTS] = {"all_light", "scattered_light"};

/* Irradiance of a light component, by receiver and channel. */
static void extract_component(const receivers* p, int component, double* out) {
    for (int64_t i = 0; i < p->count; ++i)
        for (int c = 0; c < 3; ++c) {
            out[3 * i + c] = 0;
            for (int layer = component == ALL ? 0 : TY_BAKE_SINGLE; layer < TY_BAKE_LAYERS; ++layer)
                out[3 * i + c] += (double)p->light[i].irradiance[layer][c];
        }
}

/* Two bakes with independent seeds. */
typedef struct bake_pair {
    double* light[SEEDS][PARTS]; /* number of values of each */
    int64_t values;
} bake_pair;

static void free_pair(bake_pair* t) {
    for (int seed = 0; seed < SEEDS; ++seed)
        for (int component = 0; component < PARTS; ++component) free(t->light[seed][component]);
}

/* seed: the seed of the first bake. */
static ty_result bake_both_seeds(const ty_scene* scene, const lookups* lookup, const receivers* p, int method,
                                 int32_t spp, int seed, bake_pair* out) {
    ty_result result = TY_OK;
    out->values = 3 * p->count;
    for (int i = 0; i < SEEDS && result == TY_OK; ++i) {
        result = bake(scene, lookup, p, method, spp, seed + i);
        for (int component = 0; component < PARTS && result == TY_OK; ++component) {
            out->light[i][component] = malloc((size_t)out->values * sizeof(double));
            if (out->light[i][component] == NULL) return TY_ERROR_MEMORY;
            extract_component(p, component, out->light[i][component]);
        }
    }
    return result;
}

/* Relative to the mean of the reference: the noise, from the difference of two bakes; the RMSE against the reference,
 * after subtraction of the reference's noise. */
typedef struct errors {
    double noise, error;
} errors;

static errors compare(const bake_pair* is, const bake_pair* truth, int component) {
    const double *a = is->light[0][component], *b = is->light[1][component];
    const double *s = truth->light[0][component], *t = truth->light[1][component];
    double mean = 0, noise = 0, error = 0;
    for (int64_t i = 0; i < is->values; ++i) {
        const double should = 0.5 * (s[i] + t[i]), off = 0.25 * (s[i] - t[i]) * (s[i] - t[i]);
        mean += should;
        noise += 0.5 * (a[i] - b[i]) * (a[i] - b[i]);
        error += 0.5 * ((a[i] - should) * (a[i] - should) + (b[i] - should) * (b[i] - should)) - off;
    }
    const double values = (double)is->values;
    return (errors){sqrt(noise / values) / (mean / values), sqrt(fmax(0, error) / values) / (mean / values)};
}

/* The cost of a method at one quality. */
typedef struct cost {
    double seconds[PARTS]; /* total, and extra time over attenuation only */
    double filling;
    errors errors[PARTS];
} cost;

/* Time of path tracing to an error: it grows with the inverse square of the error. */
static double path_seconds(const cost* path, int component, double error) {
    const double times = path->errors[component].error / error;
    return path->seconds[ALL] * times * times;
}

static void print_cost(const bench_session* bench, int m, int32_t spp, const cost* is, const cost* path) {
    json_open_object(bench->json, method_names[m]);
    json_int(bench->json, "spp", spp);
    for (int component = 0; component < PARTS; ++component) {
        const errors* e = &is->errors[component];
        const double paths = path_seconds(path, component, e->error), own_seconds = is->seconds[component];

        json_open_object(bench->json, component_names[component]);
        bench_numbers(bench->json, {"relative_error", e->error}, {"noise", e->noise}, {"seconds", own_seconds},
                      {"path_seconds", paths}, {"over_path", paths / own_seconds},
                      {"over_path_with_filling", paths / (own_seconds + is->filling)});
        json_close_object(bench->json);
    }
    json_close_object(bench->json);
}

static ty_result find_cost(const ty_scene* scene, const lookups* lookup, const receivers* p, int m, int32_t spp,
                           const timed t[METHODS], const bake_pair* truth, cost* out) {
    bake_pair is = {.values = 0};
    const ty_result result = bake_both_seeds(scene, lookup, p, m, spp, 0, &is);
    *out = (cost){.filling = m == CACHE ? lookup->filling : 0};
    out->seconds[ALL] = t[m].seconds;
    out->seconds[SCATTERED] = fmax(1e-6, t[m].seconds - t[ATTENUATION].seconds);
    for (int component = 0; component < PARTS && result == TY_OK; ++component)
        out->errors[component] = compare(&is, truth, component);
    free_pair(&is);
    return result;
}

/* t: times of all methods at the first quality, and of all except path tracing at the second. */
static ty_result bench_errors(const bench_session* bench, const ty_scene* scene, const lookups* lookup,
                              const receivers* p, const timed t[QUALITIES][METHODS]) {
    bake_pair truth = {.values = 0};
    cost path, is;
    ty_result result = bake_both_seeds(scene, lookup, p, PATH, TRUTH_SPP, SEEDS, &truth);
    if (result == TY_OK) result = find_cost(scene, lookup, p, PATH, qualities[0].spp, t[0], &truth, &path);
    if (result == TY_OK) {
        json_open_object(bench->json, "path_of_truth");
        json_int(bench->json, "spp", qualities[0].spp);
        json_numbers(bench->json, "relative_errors",
                     (const double[]){path.errors[ALL].error, path.errors[SCATTERED].error}, PARTS);
        json_number(bench->json, "elapsed", path.seconds[ALL]);
        json_close_object(bench->json);
    }
    for (int q = 0; q < QUALITIES && result == TY_OK; ++q) {
        json_open_object(bench->json, q == 0 ? "equal_error_low" : "equal_error_high");
        for (int m = CACHE; m < PATH && result == TY_OK; ++m) {
            result = find_cost(scene, lookup, p, m, qualities[q].spp, t[q], &truth, &is);
            if (result == TY_OK) print_cost(bench, m, qualities[q].spp, &is, &path);
        }
        json_close_object(bench->json);
    }
    free_pair(&truth);
    return result;
}

static ty_result bench_methods(const bench_session* bench, const ty_scene* scene, const lookups* lookup) {
    const ty_bake_cache_info cache = ty_bake_cache_get_info(lookup->cache[0]);
    receivers p;
    ty_result result = find_receivers(bench, scene, &p);
    if (result != TY_OK) return result;
    json_int(bench->json, "receivers", p.count);
    json_numbers(bench->json, "cache_cells", (const double[]){cache.size[0], cache.size[1], cache.size[2]}, 3);
    json_number(bench->json, "cache_filling_seconds", lookup->filling);
    timed t[QUALITIES][METHODS];
    for (int q = 0; q < QUALITIES && result == TY_OK; ++q) {
        result = time_methods(bench, scene, lookup, &p, qualities[q].spp, q == 0 ? METHODS : PATH, t[q]);
        if (result == TY_OK) print_quality(bench, q, lookup->filling, t[q]);
    }
    if (result == TY_OK) result = bench_errors(bench, scene, lookup, &p, (const timed(*)[METHODS])t);
    free_receivers(&p);
    return result;
}

/* ---- rays ---- */

/* 1e6 incoherent bounce rays per second with bare Embree; 0: failure. */
static double measure_embree(const bench_session* bench, ty_context* context, const ty_mesh_def* mesh,
                             const ray_set* set) {
    double seconds[RUNS_MAX];
    bench_embree* embree = bench_embree_create(mesh, 1, true, ty_context_threads(context));
    bench_embree_hit* hits = malloc((size_t)(set->count + 1) * sizeof *hits);
    double speed = 0;
    if (embree != NULL && hits != NULL) {
        for (int run = -1; run < bench->options->runs; ++run) {
            const double start = cli_wall_seconds();
            bench_embree_trace(context, embree, set, hits, NULL);
            seconds[run < 0 ? 0 : run] = cli_wall_seconds() - start;
        }
        speed = 1e-6 * (double)set->count / bench_median(seconds, bench->options->runs);
    }
    bench_embree_destroy(embree);
    free(hits);
    return speed;
}

static void print_rays(const bench_session* bench, double own_seconds, double embree) {

    bench_numbers(bench->json, {"mrays_per_second", own_seconds}, {"embree_robust_mrays_per_second", embree});
}

static ty_result measure_rays(const bench_session* bench, ty_context* context, const ty_scene* scene) {
    static const int32_t size[2] = {EMBREE_PIXELS, EMBREE_PIXELS};
    ray_set sets[RAY_SETS];
    ty_mesh_def mesh;
    receivers p = {.count = 0};
    ty_bake_stats stats = ty_default_bake_stats();
    ty_bake_def def = ty_default_bake_def();
    ty_result result = ty_scene_get_mesh(scene, 0, &mesh);
    if (result == TY_OK) result = bench_make_rays(scene, size, sets);
    if (result != TY_OK) return result;
    def.method = TY_BAKE_SURFACES;
    def.spp = 4;
    result = select_hits(scene, sets[RAYS_CAMERA].rays, sets[RAYS_CAMERA].count, &p);
    if (result == TY_OK) {
        result = ty_bake_surfaces(scene, &def, p.at, p.count, p.light, &stats);
        free_receivers(&p);
    }
    if (result == TY_OK)
        print_rays(bench, 1e-6 * (double)stats.rays / stats.seconds,
                   measure_embree(bench, context, &mesh, &sets[RAYS_BOUNCE]));
    bench_free_rays(sets);
    return result;
}

static ty_result bench_tracing(const bench_session* bench) {
    ty_context* context = bench->session->context;
    ty_scene* scene = NULL;
    ty_light_def sun = ty_default_light_def();
    sun.direction[0] = 0.5;
    ty_result result = ty_scene_create(context, TY_AXIS_Y, &scene);
    if (result == TY_OK) result = bench_add_terrain(scene);
    if (result == TY_OK) result = ty_scene_add_light(scene, &sun);
    if (result == TY_OK) result = ty_scene_commit(scene);
    if (result == TY_OK) result = measure_rays(bench, context, scene);
    ty_scene_destroy(scene);
    return result;
}

/* The scene and the lookup structures of its media's radiance. */
static ty_result open_lookups(ty_context* context, ty_scene** scene, lookups* out) {
    const ty_impulse_def impulse = ty_default_impulse_def();
    ty_bake_def def = ty_default_bake_def();
    *out = (lookups){.tables = NULL};
    ty_result result = ty_scene_load(context, scene_name, NULL, 0, scene);
    def.scatterings = TY_IMPULSE_BOUNCES_MAX;
    if (result == TY_OK) result = ty_impulse_create(context, &impulse, &out->tables, NULL);
    for (int seed = 0; seed < SEEDS && result == TY_OK; ++seed) {
        const double start = processor_seconds();
        def.seed = (uint64_t)seed;
        result = ty_bake_cache_create(*scene, &def, &out->cache[seed]);
        out->filling = processor_seconds() - start;
    }
    return result;
}

static void close_lookups(ty_scene* scene, lookups* lookup) {
    for (int seed = 0; seed < SEEDS; ++seed) ty_bake_cache_destroy(lookup->cache[seed]);
    ty_impulse_destroy(lookup->tables);
    ty_scene_destroy(scene);
}

int bench_bake(const bench_session* bench) {
    ty_scene* scene = NULL;
    lookups lookup;
    ty_result result = open_lookups(bench->session->context, &scene, &lookup);
    if (result == TY_OK) result = bench_methods(bench, scene, &lookup);
    if (result == TY_OK) result = bench_tracing(bench);
    close_lookups(scene, &lookup);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

/* ---- the table of a figure ---- */

static void add_row(bench_table* table, const char* name, const char* unit, double measured, double paper) {
    table->row_names[table->rows] = name;
    table->units[table->rows] = unit;
    table->measured[table->rows][0] = measured;
    table->paper[table->rows++][0] = paper;
}

/* Overhead over surfaces alone, percent. */
static double more(double seconds, const timed* surfaces) {
    return 100 * (seconds / surfaces->seconds - 1);
}

static void add_quality(bench_table* table, int q, const timed t[METHODS]) {
    static const char* const names[QUALITIES][3] = {
        {"low quality, surfaces alone", "low quality, impulse responses, more", "low quality, light in cells, more"},
        {"high quality, surfaces alone", "high quality, impulse responses, more",
         "high quality, light in cells, more"}};
    add_row(table, names[q][0], "s", t[SURFACES].seconds, 0);
    add_row(table, names[q][1], "%", more(t[IMPULSE].seconds, &t[SURFACES]), 100 * qualities[q].paper);
    add_row(table, names[q][2], "%", more(t[CACHE].seconds, &t[SURFACES]), 0);
}

ty_result bench_bake_table(const bench_session* bench, bench_table* out) {
    ty_scene* scene = NULL;
    lookups lookup;
    receivers p = {.count = 0};
    timed t[METHODS];
    *out = (bench_table){.columns = 1, .paper_columns = 1, .paper_machine = "a game's level"};
    ty_result result = open_lookups(bench->session->context, &scene, &lookup);
    if (result == TY_OK) result = find_receivers(bench, scene, &p);
    if (result != TY_OK) p = (receivers){.count = 0}; /* partial results are already freed */
    for (int q = 0; q < QUALITIES && result == TY_OK; ++q) {
        result = time_methods(bench, scene, &lookup, &p, qualities[q].spp, PATH, t);
        if (result == TY_OK) add_quality(out, q, t);
    }
    if (result == TY_OK) add_row(out, "filling the cells, once", "s", lookup.filling, 0);
    snprintf(out->titles[0], BENCH_TABLE_TITLE, "measured");
    snprintf(out->setting, sizeof out->setting, "%s, %lld receivers, %d and %d paths each", scene_name,
             (long long)p.count, (int)qualities[0].spp, (int)qualities[1].spp);
    free_receivers(&p);
    close_lookups(scene, &lookup);
    return result;
}
