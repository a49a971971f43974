/* Sampling many items in passes over threads, with progress, bounds on time and error, and cancelling. */
#include "method/path/driver.h"

#include "base/context.h"
#include "method/path/equiangular.k.h"
#include "scene/check.h"

#include <pthread.h>
#include <stdatomic.h>

enum { BLOCK = 64, SPP_MAX = 1 << 24, PASS_MAX = 16 };

static const double progress_interval = 0.1;

/* Of the radiance that an isotropic medium scatters under the typical light. */
static const float faint_fraction = 0.5f;

typedef struct sampling {
    ty_path_run* run;
    ty_path_kernel kernel;
    uint32_t first, count; /* samples of each item */
    uint32_t done_before;  /* samples per item that earlier passes finished */
    double begun;          /* when the run began */
    pthread_mutex_t lock;  /* guards reporting */
    double reported;
    _Atomic int64_t finished; /* blocks of this pass */
    _Atomic uint64_t vertices, paths;
    _Atomic bool cancelled, out_of_time;
} sampling;

ty_path_def ty_default_path_def(void) {
    return (ty_path_def){.cookie = TY_DEF_COOKIE, .spp = 64, .aovs = TY_AOV_VARIANCE, .state_seconds = 60};
}

/* The best kernel this processor runs. */
static ty_path_kernel choose_kernel(const char** isa) {
#if TY_ISA_X86
    __builtin_cpu_init();
    const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
    if (v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) {
        *isa = "x86-64-v4";
        return ty_path_kernel_v4;
    }
    if (v3) {
        *isa = "x86-64-v3";
        return ty_path_kernel_v3;
    }
    *isa = "x86-64";
#else
    *isa = "generic";
#endif
    return ty_path_kernel_v1;
}

static ty_result check_def(ty_context* context, const ty_path_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_path_def");
    if (result == TY_OK) result = ty_check_number(context, "path.spp", def->spp, 1, SPP_MAX);
    if (result == TY_OK) result = ty_check_number(context, "path.max_depth", def->max_depth, 0, INT32_MAX);
    if (result == TY_OK) result = ty_check_number(context, "path.seconds", def->seconds, 0, 1e9);
    if (result == TY_OK) result = ty_check_number(context, "path.error", def->error, 0, 1e9);
    if (result != TY_OK) return result;
    if ((def->width == 0) != (def->height == 0) || def->width < 0 || def->height < 0 || def->width > 65536 ||
        def->height > 65536)
        return ty_fail(context, TY_ERROR_ARGUMENT, "path: %d x %d is not a resolution in 1..65536", def->width,
                       def->height);
    return TY_OK;
}

/* Lights with a place or direction of their own, the likeliest first: what high-g media are guided towards. */
static void choose_guides(ty_path_request* request) {
    const ty_scene_view* scene = request->scene;
    float sum = 0;
    while (request->guide_count < TY_GUIDES_MAX) {
        int32_t best = -1;
        for (int32_t i = 0; i < scene->lights.count; ++i) {
            bool usable = scene->lights.lights[i].kind != TY_KIND_ENVIRONMENT && scene->lights.lights[i].typical > 0;
            for (int32_t j = 0; j < request->guide_count; ++j) usable = usable && request->guide_light[j] != i;
            if (usable && (best < 0 || scene->lights.lights[i].typical > scene->lights.lights[best].typical)) best = i;
        }
        if (best < 0) break;
        sum += scene->lights.lights[best].typical;
        request->guide_share[request->guide_count] = scene->lights.lights[best].typical;
        request->guide_light[request->guide_count++] = best;
    }
    for (int32_t j = 0; j < request->guide_count; ++j) request->guide_share[j] /= sum;
}

static float faint_radiance(const ty_light_set* lights) {
    float sum = 0;
    for (int32_t i = 0; i < lights->count; ++i) sum += faint_fraction * lights->lights[i].typical * TY_INV_4PI;
    return sum;
}

ty_result ty_path_prepare(const ty_scene* scene, const ty_path_def* def, ty_path_run* run) {
    memset(run, 0, sizeof *run);
    run->context = ty_scene_context(scene);
    run->def = def;
    const ty_result result = check_def(run->context, def);
    if (result != TY_OK) return result;
    run->request.scene = ty_scene_get_view(scene);
    if (run->request.scene == NULL) return TY_ERROR_ARGUMENT;
    ty_sobol_matrices(&run->sobol);
    run->request.sobol = &run->sobol;
    run->request.seed = def->seed;
    run->request.max_depth = def->max_depth;
    choose_guides(&run->request);
    run->request.faint = faint_radiance(&run->request.scene->lights);
    return TY_OK;
}

double ty_path_item_mean(const ty_path_item* item, int channel) {
    return item->count > 0 ? item->sums.mean[channel] / item->count : 0;
}

double ty_path_item_variance(const ty_path_item* item, int channel) {
    if (item->count < 2) return 0;
    const double n = item->count, mean = item->sums.mean[channel] / n;
    const double variance = (item->sums.square[channel] - n * mean * mean) / (n - 1);
    return variance > 0 ? variance / n : 0;
}

/* Root mean square standard error over the mean, all items and channels together. */
static double relative_error(const ty_path_run* run) {
    double variance = 0, mean = 0;
    for (int64_t i = 0; i < run->item_count; ++i)
        for (int c = 0; c < 3; ++c) {
            variance += ty_path_item_variance(&run->items[i], c);
            mean += ty_path_item_mean(&run->items[i], c);
        }
    const double n = 3.0 * (double)run->item_count;
    return mean > 0 ? sqrt(variance / n) / (mean / n) : 0;
}

static int64_t block_count(const ty_path_run* run) {
    return (run->item_count + BLOCK - 1) / BLOCK;
}

/* Fraction of the work that is done, whichever bound is nearest. */
static double fraction_done(const sampling* pass, double seconds, double samples) {
    const ty_path_def* def = pass->run->def;
    double fraction = samples / def->spp;
    if (def->seconds > 0) fraction = fmax(fraction, seconds / def->seconds);
    if (def->error > 0 && pass->run->stats.error > 0 && pass->done_before > 0) {
        const double needed = pass->done_before * pow(pass->run->stats.error / def->error, 2);
        fraction = fmax(fraction, samples / needed);
    }
    return fmin(fraction, 1);
}

/* Tells the caller where things stand, if it is time to; sets cancelled when the caller wishes. */
static void report(sampling* pass, bool always) {
    const ty_path_def* def = pass->run->def;
    const double seconds = ty_wall_seconds() - pass->begun;
    if (def->seconds > 0 && seconds >= def->seconds) atomic_store(&pass->out_of_time, true);
    if (def->progress == NULL || (always ? pthread_mutex_lock : pthread_mutex_trylock)(&pass->lock) != 0) return;
    if (always || seconds - pass->reported >= progress_interval) {
        pass->reported = seconds;
        const double share = (double)atomic_load(&pass->finished) / (double)block_count(pass->run);
        const double fraction = fraction_done(pass, seconds, pass->done_before + share * pass->count);
        const ty_progress progress = {
            .stage = pass->run->stage,
            .fraction = fraction,
            .seconds = seconds,
            .remaining = fraction > 0.005 ? seconds * (1 - fraction) / fraction : -1,
            .done = pass->done_before,
            .total = def->spp < SPP_MAX ? (uint64_t)def->spp : 0,
        };
        if (!def->progress(def->progress_user, &progress)) atomic_store(&pass->cancelled, true);
    }
    pthread_mutex_unlock(&pass->lock);
}

static void sample_block(void* user, int64_t block, int32_t worker) {
    (void)worker;
    sampling* pass = user;
    ty_path_run* run = pass->run;
    if (atomic_load_explicit(&pass->cancelled, memory_order_relaxed)) return;
    /* Time ends work only once every item has a sample. */
    if (pass->done_before > 0 && atomic_load_explicit(&pass->out_of_time, memory_order_relaxed)) return;
    const int64_t begin = block * BLOCK;
    const int64_t end = begin + BLOCK < run->item_count ? begin + BLOCK : run->item_count;
    ty_path_sums sums[BLOCK];
    for (int64_t i = begin; i < end; ++i) sums[i - begin] = run->items[i].sums;
    const uint64_t vertices = pass->kernel(&run->request, begin, end, pass->first, pass->count, sums,
                                           run->parts != NULL ? run->parts + begin : NULL);
    for (int64_t i = begin; i < end; ++i) {
        run->items[i].sums = sums[i - begin];
        run->items[i].count += pass->count;
    }
    atomic_fetch_add(&pass->vertices, vertices);
    atomic_fetch_add(&pass->paths, (uint64_t)(end - begin) * pass->count);
    atomic_fetch_add(&pass->finished, 1);
    report(pass, false);
}

/* Samples of the next pass: few at first so that time and error are noticed soon, then more. */
static uint32_t next_pass(const ty_path_run* run, uint32_t done) {
    uint32_t count = done < 1 ? 1 : done < PASS_MAX ? done : PASS_MAX;
    if (done + count > (uint32_t)run->def->spp) count = (uint32_t)run->def->spp - done;
    return count;
}

ty_result ty_path_sample(ty_path_run* run) {
    sampling pass = {.run = run, .begun = ty_wall_seconds()};
    const double cpu_begun = ty_cpu_seconds();
    pass.kernel = choose_kernel(&run->stats.isa);
    pthread_mutex_init(&pass.lock, NULL);
    const uint32_t spp = (uint32_t)run->def->spp;
    while (pass.done_before < spp) {
        pass.first = pass.done_before;
        pass.count = next_pass(run, pass.done_before);
        atomic_store(&pass.finished, 0);
        ty_parallel_for(run->context, block_count(run), sample_block, &pass);
        if (atomic_load(&pass.finished) < block_count(run)) break;
        pass.done_before += pass.count;
        if (run->def->error > 0) {
            run->stats.error = relative_error(run);
            if (pass.done_before >= 4 && run->stats.error <= run->def->error) break;
        }
        if (run->def->seconds > 0 && ty_wall_seconds() - pass.begun >= run->def->seconds) break;
    }
    const bool cancelled = atomic_load(&pass.cancelled);
    report(&pass, true);
    pthread_mutex_destroy(&pass.lock);
    run->stats.error = relative_error(run);
    run->stats.seconds = ty_wall_seconds() - pass.begun;
    run->stats.cpu_seconds = ty_cpu_seconds() - cpu_begun;
    run->stats.paths = atomic_load(&pass.paths);
    run->stats.vertices = atomic_load(&pass.vertices);
    run->stats.spp = (double)run->stats.paths / (double)run->item_count;
    return cancelled && pass.done_before < spp ? TY_CANCELLED : TY_OK;
}
