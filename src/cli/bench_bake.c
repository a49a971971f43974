/* tyndall bench bake: what light from media costs on top of a bake without them, at equal paths per receiver (paper:
 * 4.7 % at low and 14.6 % at high quality), by a cache of the media's light, whose filling is told apart, and by
 * impulse responses; how much sooner both are as free of noise as paths through the media (the square of the relative
 * error times the time); and how many rays a second of a bake traces, beside a bare loop over Embree on the same
 * triangles. Receivers are where a camera's rays end. Methods take turns, run by run. */
#include "cli/bench_embree.h"
#include "cli/bench_ray_sets.h"
#include "cli/bench_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tyndall/bake.h>

enum { SIDE = 48, RUNS_MAX = 99, QUALITIES = 2, BLOCK_RAYS = 4096, EMBREE_PIXELS = 512 };
enum { SURFACES = 0, CACHE = 1, IMPULSE = 2, PATH = 3, METHODS = 4 };

static const char scene_name[] = "builtin:cornell_fog";
static const char* const method_names[METHODS] = {"surfaces", "cache", "impulse", "path"};
static const ty_bake_method methods[METHODS] = {TY_BAKE_SURFACES, TY_BAKE_CACHE, TY_BAKE_IMPULSE, TY_BAKE_PATH};

static const struct {
    const char* name;
    int32_t spp;
    double paper; /* what light from media costs there */
} qualities[QUALITIES] = {{"low", 64, 0.047}, {"high", 1024, 0.146}};

/* ---- receivers ---- */

typedef struct places {
    ty_bake_receiver* at;
    ty_bake_light* light;
    int64_t count;
} places;

static void free_places(places* p) {
    free(p->at);
    free(p->light);
}

/* Where rays end on fronts. */
static ty_result take_hits(const ty_scene* scene, const ty_ray* rays, int64_t count, places* out) {
    *out = (places){.at = malloc((size_t)count * sizeof *out->at), .light = calloc((size_t)count, sizeof *out->light)};
    ty_ray_hit* hits = malloc((size_t)count * sizeof *hits);
    ty_result result = out->at == NULL || out->light == NULL || hits == NULL ? TY_ERROR_MEMORY : TY_OK;
    if (result == TY_OK) result = ty_scene_trace(scene, rays, count, false, hits);
    for (int64_t i = 0; i < count && result == TY_OK; ++i) {
        if (hits[i].surface < 0) continue;
        ty_bake_receiver* receiver = &out->at[out->count++];
        memcpy(receiver->position, hits[i].position, sizeof receiver->position);
        memcpy(receiver->normal, hits[i].normal, sizeof receiver->normal);
        memcpy(receiver->face, hits[i].normal, sizeof receiver->face);
        receiver->margin = hits[i].margin;
    }
    free(hits);
    if (result != TY_OK) free_places(out);
    return result;
}

static ty_result find_places(const bench_session* bench, const ty_scene* scene, places* out) {
    const bench_options* options = bench->options;
    int32_t size[2];
    bench_pixels(options, SIDE, SIDE, size);
    const double origin[3] = {0, -0.95, 0}; /* inside the box, so that all directions end on it */
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
    const ty_result result = take_hits(scene, rays, count, out);
    free(rays);
    return result;
}

/* ---- methods ---- */

typedef struct timed {
    double seconds, error; /* median; standard errors' root mean square over the mean */
    ty_bake_stats stats;
} timed;

static double relative_error(const places* p) {
    double mean = 0, variance = 0;
    for (int64_t i = 0; i < p->count; ++i)
        for (int c = 0; c < 3; ++c) {
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) mean += (double)p->light[i].irradiance[layer][c];
            variance += (double)p->light[i].variance[c];
        }
    const double values = 3 * (double)p->count;
    return sqrt(variance / values) / (mean / values);
}

/* What media's light is looked up in. */
typedef struct lookups {
    ty_impulse* tables;
    ty_bake_cache* cache;
} lookups;

static ty_result time_methods(const bench_session* bench, const ty_scene* scene, const lookups* look, const places* p,
                              int32_t spp, int method_count, timed out[METHODS]) {
    static double seconds[METHODS][RUNS_MAX];
    const int runs = bench->options->runs;
    ty_result result = TY_OK;
    for (int run = -1; run < runs; ++run)
        for (int m = 0; m < method_count && result == TY_OK; ++m) {
            ty_bake_def def = ty_default_bake_def();
            def.method = methods[m];
            def.spp = spp;
            def.tables = look->tables;
            def.cache = look->cache;
            def.scatterings = m == IMPULSE ? def.scatterings : TY_IMPULSE_BOUNCES_MAX;
            result = ty_bake_surfaces(scene, &def, p->at, p->count, p->light, &out[m].stats);
            if (result == TY_OK && cli_interrupted()) result = TY_CANCELLED;
            seconds[m][run < 0 ? 0 : run] = out[m].stats.seconds;
            out[m].error = relative_error(p);
        }
    for (int m = 0; m < method_count && result == TY_OK; ++m) out[m].seconds = bench_median(seconds[m], runs);
    return result;
}

static void print_quality(const bench_session* bench, int q, double filling, const timed t[METHODS]) {
    const double surfaces = t[SURFACES].seconds;
    if (bench->json == NULL) {
        printf("  %-5s %5d paths: surfaces %8.3f s (paper: %.1f %% more)\n", qualities[q].name, (int)qualities[q].spp,
               surfaces, 100 * qualities[q].paper);
        for (int m = CACHE; m < PATH; ++m)
            printf("    %-8s %8.3f s: %+.1f %%\n", method_names[m], t[m].seconds, 100 * (t[m].seconds / surfaces - 1));
        printf("    with the cache's filling %+.1f %%\n", 100 * ((t[CACHE].seconds + filling) / surfaces - 1));
        fflush(stdout);
        return;
    }
    json_open_object(bench->json, qualities[q].name);
    json_integer(bench->json, "spp", qualities[q].spp);
    json_number(bench->json, "surfaces_seconds", surfaces);
    json_number(bench->json, "cache_seconds", t[CACHE].seconds);
    json_number(bench->json, "cache_overhead", t[CACHE].seconds / surfaces - 1);
    json_number(bench->json, "cache_overhead_with_filling", (t[CACHE].seconds + filling) / surfaces - 1);
    json_number(bench->json, "impulse_seconds", t[IMPULSE].seconds);
    json_number(bench->json, "overhead", t[IMPULSE].seconds / surfaces - 1);
    json_number(bench->json, "paper_overhead", qualities[q].paper);
    json_close_object(bench->json);
}

/* Time grows with the inverse square of the error. */
static void print_paths(const bench_session* bench, const timed t[METHODS]) {
    double cost[METHODS];
    for (int m = 0; m < METHODS; ++m) cost[m] = t[m].error * t[m].error * t[m].seconds;
    if (bench->json == NULL) {
        printf("to a relative error of 1 %%:\n");
        for (int m = 0; m < METHODS; ++m)
            printf("  %-10s %8.2f s (%.2f %% at %d paths in %.3f s)\n", method_names[m], 1e4 * cost[m],
                   100 * t[m].error, (int)qualities[0].spp, t[m].seconds);
        for (int m = CACHE; m < PATH; ++m)
            printf("  %s is %.1f times as fast as paths through media\n", method_names[m], cost[PATH] / cost[m]);
        fflush(stdout);
        return;
    }
    json_open_object(bench->json, "equal_error");
    for (int m = 0; m < METHODS; ++m) {
        json_open_object(bench->json, method_names[m]);
        json_number(bench->json, "relative_error", t[m].error);
        json_number(bench->json, "seconds", t[m].seconds);
        json_number(bench->json, "seconds_to_1_percent", 1e4 * cost[m]);
        json_close_object(bench->json);
    }
    json_number(bench->json, "cache_over_path", cost[PATH] / cost[CACHE]);
    json_number(bench->json, "impulse_over_path", cost[PATH] / cost[IMPULSE]);
    json_close_object(bench->json);
}

static ty_result bench_methods(const bench_session* bench, const ty_scene* scene, const lookups* look) {
    const ty_bake_cache_info cache = ty_bake_cache_get_info(look->cache);
    places p;
    ty_result result = find_places(bench, scene, &p);
    if (result != TY_OK) return result;
    if (bench->json == NULL)
        printf("light from media on top of light from surfaces (%s, %lld receivers, medians of %d)\n", scene_name,
               (long long)p.count, (int)bench->options->runs);
    else
        json_integer(bench->json, "receivers", p.count);
    if (bench->json == NULL)
        printf("  filling the cache, %d x %d x %d cells, %lld paths: %.3f s\n", (int)cache.size[0], (int)cache.size[1],
               (int)cache.size[2], (long long)cache.paths, cache.seconds);
    else
        json_number(bench->json, "cache_filling_seconds", cache.seconds);
    timed t[METHODS];
    for (int q = 0; q < QUALITIES && result == TY_OK; ++q) {
        result = time_methods(bench, scene, look, &p, qualities[q].spp, PATH, t);
        if (result == TY_OK) print_quality(bench, q, cache.seconds, t);
    }
    if (result == TY_OK) result = time_methods(bench, scene, look, &p, qualities[0].spp, METHODS, t);
    if (result == TY_OK) print_paths(bench, t);
    free_places(&p);
    return result;
}

/* ---- rays ---- */

typedef struct bare_job {
    const bench_embree* embree;
    const ray_set* set;
    bench_embree_hit* hits;
} bare_job;

static void trace_block(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const bare_job* job = user;
    const int64_t begin = index * BLOCK_RAYS, left = job->set->count - begin;
    bench_embree_trace(job->embree, job->set->rays + begin, left < BLOCK_RAYS ? left : BLOCK_RAYS, false,
                       job->hits + begin);
}

/* 1e6 rays that bounced about, per second, through bare Embree; 0: it failed. */
static double measure_embree(const bench_session* bench, ty_context* context, const ty_mesh_def* mesh,
                             const ray_set* set) {
    double seconds[RUNS_MAX];
    bench_embree* embree = bench_embree_create(mesh, 1, true, ty_context_threads(context));
    bench_embree_hit* hits = malloc((size_t)(set->count + 1) * sizeof *hits);
    double speed = 0;
    if (embree != NULL && hits != NULL) {
        bare_job job = {embree, set, hits};
        for (int run = -1; run < bench->options->runs; ++run) {
            const double start = cli_wall_seconds();
            ty_parallel_for(context, (set->count + BLOCK_RAYS - 1) / BLOCK_RAYS, trace_block, &job);
            seconds[run < 0 ? 0 : run] = cli_wall_seconds() - start;
        }
        speed = 1e-6 * (double)set->count / bench_median(seconds, bench->options->runs);
    }
    bench_embree_destroy(embree);
    free(hits);
    return speed;
}

static void print_rays(const bench_session* bench, double own, double embree) {
    if (bench->json == NULL) {
        printf(
            "1e6 rays/s on a terrain of 260642 triangles: %.2f of a bake without media, %.2f of bare Embree (%.2f)\n",
            own, embree, own / embree);
        return;
    }
    json_number(bench->json, "mrays_per_second", own);
    json_number(bench->json, "embree_robust_mrays_per_second", embree);
}

static ty_result measure_rays(const bench_session* bench, ty_context* context, const ty_scene* scene) {
    static const int32_t size[2] = {EMBREE_PIXELS, EMBREE_PIXELS};
    ray_set sets[RAY_SETS];
    ty_mesh_def mesh;
    places p = {.count = 0};
    ty_bake_stats stats = {.seconds = 0};
    ty_bake_def def = ty_default_bake_def();
    ty_result result = ty_scene_get_mesh(scene, 0, &mesh);
    if (result == TY_OK) result = bench_make_rays(scene, size, sets);
    if (result != TY_OK) return result;
    def.method = TY_BAKE_SURFACES;
    def.spp = 4;
    result = take_hits(scene, sets[RAYS_CAMERA].rays, sets[RAYS_CAMERA].count, &p);
    if (result == TY_OK) {
        result = ty_bake_surfaces(scene, &def, p.at, p.count, p.light, &stats);
        free_places(&p);
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

/* The scene, and what its media's light is looked up in. */
static ty_result open_lookups(ty_context* context, ty_scene** scene, lookups* out) {
    const ty_impulse_def impulse = ty_default_impulse_def();
    ty_bake_def def = ty_default_bake_def();
    *out = (lookups){.tables = NULL};
    ty_result result = ty_scene_load(context, scene_name, NULL, 0, scene);
    def.scatterings = TY_IMPULSE_BOUNCES_MAX;
    if (result == TY_OK) result = ty_impulse_create(context, &impulse, &out->tables, NULL);
    if (result == TY_OK) result = ty_bake_cache_create(*scene, &def, &out->cache);
    return result;
}

static void close_lookups(ty_scene* scene, lookups* look) {
    ty_bake_cache_destroy(look->cache);
    ty_impulse_destroy(look->tables);
    ty_scene_destroy(scene);
}

int bench_bake(const bench_session* bench) {
    ty_scene* scene = NULL;
    lookups look;
    ty_result result = open_lookups(bench->session->context, &scene, &look);
    if (result == TY_OK) result = bench_methods(bench, scene, &look);
    if (result == TY_OK) result = bench_tracing(bench);
    close_lookups(scene, &look);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

/* ---- the table of a figure ---- */

static void add_row(bench_table* table, const char* name, const char* unit, double measured, double paper) {
    table->row_names[table->rows] = name;
    table->units[table->rows] = unit;
    table->measured[table->rows][0] = measured;
    table->paper[table->rows++][0] = paper;
}

/* More than surfaces alone, in percent. */
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
    lookups look;
    places p = {.count = 0};
    timed t[METHODS];
    *out = (bench_table){.columns = 1, .paper_columns = 1, .paper_machine = "a game's level"};
    ty_result result = open_lookups(bench->session->context, &scene, &look);
    if (result == TY_OK) result = find_places(bench, scene, &p);
    if (result != TY_OK) p = (places){.count = 0}; /* what there was of it is freed */
    for (int q = 0; q < QUALITIES && result == TY_OK; ++q) {
        result = time_methods(bench, scene, &look, &p, qualities[q].spp, PATH, t);
        if (result == TY_OK) add_quality(out, q, t);
    }
    if (result == TY_OK) add_row(out, "filling the cells, once", "s", ty_bake_cache_get_info(look.cache).seconds, 0);
    snprintf(out->titles[0], BENCH_TABLE_TITLE, "measured");
    snprintf(out->setting, sizeof out->setting, "%s, %lld receivers, %d and %d paths each", scene_name,
             (long long)p.count, (int)qualities[0].spp, (int)qualities[1].spp);
    free_places(&p);
    close_lookups(scene, &look);
    return result;
}
