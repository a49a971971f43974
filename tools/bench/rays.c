/* tyndall bench rays: rays per second through a mesh by ty_scene_trace, which also computes hit points and ray offsets,
 * compared with a bare Embree loop on the same triangles, with the robust flag that the library sets and without it.
 * Runs of the three are interleaved. Times are CPU time on one thread, which other load disturbs less, and wall time on
 * all threads. */
#include "bench/bench.h"
#include "bench/embree.h"

#include <stdlib.h>

enum { RUNS_MAX = 99, WIDTH = 1024 };
enum { OURS = 0, ROBUST = 1, PLAIN = 2, SIDES = 3 };

/* The mesh of each implementation, for one number of threads. */
typedef struct tracers {
    ty_context* context;
    ty_scene* scene;
    bench_embree* embree[SIDES]; /* NULL for OURS */
} tracers;

/* Result buffers. */
typedef struct answers {
    ty_ray_hit* ours;
    bench_embree_hit* bare;
    bool* shadowed;
} answers;

/* Materials are made opaque, because the bare Embree loop has no alpha test. */
static ty_result add_file(ty_scene* scene, const char* path) {
    const ty_material_def material = ty_default_material_def();
    ty_mesh_file_def def = ty_default_mesh_file_def();
    def.lights = false;
    def.material = &material;
    return ty_scene_add_mesh_file(scene, path, &def);
}

static ty_result make_embree(tracers* all) {
    const int32_t count = ty_scene_get_info(all->scene).meshes;
    ty_mesh_def* meshes = malloc((size_t)count * sizeof *meshes);
    if (meshes == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t i = 0; i < count && result == TY_OK; ++i) result = ty_scene_get_mesh(all->scene, i, &meshes[i]);
    for (int side = ROBUST; side < SIDES && result == TY_OK; ++side) {
        all->embree[side] = bench_embree_create(meshes, count, side == ROBUST, ty_context_threads(all->context));
        if (all->embree[side] == NULL) result = TY_ERROR_INTERNAL;
    }
    free(meshes);
    return result;
}

static void destroy_tracers(tracers* all) {
    for (int side = ROBUST; side < SIDES; ++side) bench_embree_destroy(all->embree[side]);
    ty_scene_destroy(all->scene);
}

static ty_result make_tracers(ty_context* context, const char* mesh, tracers* all) {
    *all = (tracers){.context = context};
    ty_result result = ty_scene_create(context, TY_AXIS_Y, &all->scene);
    if (result == TY_OK) result = mesh == NULL ? bench_add_terrain(all->scene) : add_file(all->scene, mesh);
    if (result == TY_OK) result = ty_scene_commit(all->scene);
    if (result == TY_OK) result = make_embree(all);
    if (result != TY_OK) destroy_tracers(all);
    return result;
}

/* ---- timing ---- */

static ty_result trace_set(const tracers* all, int side, const ray_set* set, const answers* to) {
    if (side != OURS) {
        bench_embree_trace(all->context, all->embree[side], set, to->bare, to->shadowed);
        return TY_OK;
    }
    const ty_ray_order order = set->coherent ? TY_RAYS_COHERENT : TY_RAYS_INCOHERENT;
    if (set->shadow) return ty_scene_trace_shadows(all->scene, set->rays, set->count, order, to->shadowed);
    return ty_scene_trace(all->scene, set->rays, set->count, order, to->ours);
}

static double seconds_now(int32_t threads) {
    return threads > 1 ? cli_wall_seconds() : cli_cpu_seconds();
}

/* 1e6 rays per second of each implementation, medians after a warm-up run of each. */
static ty_result measure_set(const tracers* all, const ray_set* set, const answers* to, int runs,
                             double speeds[SIDES]) {
    const int32_t threads = ty_context_threads(all->context);
    double samples[SIDES][RUNS_MAX];
    for (int run = -1; run < runs; ++run)
        for (int side = 0; side < SIDES; ++side) {
            const double start = seconds_now(threads);
            const ty_result result = trace_set(all, side, set, to);
            if (result != TY_OK) return result;
            if (run >= 0) samples[side][run] = 1e-6 * (double)set->count / (seconds_now(threads) - start);
        }
    for (int side = 0; side < SIDES; ++side) speeds[side] = bench_median(samples[side], runs);
    return TY_OK;
}

static void print_speeds(const bench_session* bench, const ray_set* set, int32_t threads, const double speeds[SIDES]) {

    json_open_object(bench->json, NULL);
    json_text(bench->json, "rays", set->key);
    bench_numbers(bench->json, {"count", set->count}, {"threads", threads}, {"mrays_per_second", speeds[OURS]},
                  {"embree_robust_mrays_per_second", speeds[ROBUST]}, {"embree_mrays_per_second", speeds[PLAIN]});
    json_close_object(bench->json);
}

static ty_result measure_sets(const bench_session* bench, const tracers* all, const ray_set sets[RAY_SETS],
                              const answers* to) {
    ty_result result = TY_OK;
    for (int set = 0; set < RAY_SETS && result == TY_OK; ++set) {
        double speeds[SIDES];
        if (sets[set].count == 0) continue;
        result = measure_set(all, &sets[set], to, bench->options->runs, speeds);
        if (result == TY_OK) print_speeds(bench, &sets[set], ty_context_threads(all->context), speeds);
    }
    return result;
}

static void print_head(const bench_session* bench, const ty_scene* scene, const int32_t size[2]) {
    const bench_options* options = bench->options;
    const char* mesh = options->mesh == NULL ? "terrain" : options->mesh;
    const int64_t triangles = ty_scene_get_info(scene).triangles;

    json_text(bench->json, "mesh", mesh);
    json_int(bench->json, "triangles", triangles);
    json_numbers(bench->json, "size", (const double[]){size[0], size[1]}, 2);
    json_int(bench->json, "runs", options->runs);
    json_open_array(bench->json, "speeds");
}

/* Repeats the measurements with a context of one thread and a new scene. */
static ty_result measure_one_thread(const bench_session* bench, const ray_set sets[RAY_SETS], const answers* to) {
    ty_context_def def = ty_default_context_def();
    def.threads = 1;
    ty_context* context = NULL;
    ty_result result = ty_context_create(&def, &context);
    if (result != TY_OK) return result;
    tracers one;
    result = make_tracers(context, bench->options->mesh, &one);
    if (result == TY_OK) {
        result = measure_sets(bench, &one, sets, to);
        destroy_tracers(&one);
    }
    ty_context_destroy(context);
    return result;
}

static ty_result measure(const bench_session* bench, const tracers* all, const int32_t size[2]) {
    const size_t count = (size_t)size[0] * (size_t)size[1];
    const answers to = {malloc(count * sizeof(ty_ray_hit)), malloc(count * sizeof(bench_embree_hit)),
                        malloc(count * sizeof(bool))};
    ray_set sets[RAY_SETS];
    ty_result result = TY_ERROR_MEMORY;
    if (to.ours != NULL && to.bare != NULL && to.shadowed != NULL) result = bench_make_rays(all->scene, size, sets);
    if (result == TY_OK) {
        print_head(bench, all->scene, size);
        result = measure_sets(bench, all, sets, &to);
        if (result == TY_OK && ty_context_threads(all->context) > 1) result = measure_one_thread(bench, sets, &to);
        json_close_array(bench->json);
        bench_free_rays(sets);
    }
    free(to.ours);
    free(to.bare);
    free(to.shadowed);
    return result;
}

int bench_rays(const bench_session* bench) {
    const bench_options* options = bench->options;
    int32_t size[2];
    tracers all;
    bench_pixels(options, WIDTH, WIDTH, size);
    ty_result result = make_tracers(bench->session->context, options->mesh, &all);
    if (result != TY_OK) return cli_fail_reading(bench->session, result);
    result = measure(bench, &all, size);
    destroy_tracers(&all);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}
