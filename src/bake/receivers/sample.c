/* Sampling of receivers in passes, with progress, an error bound and cancellation. */
#include "bake/cache/cache.h"
#include "bake/impulse/impulse.h"
#include "bake/receivers/device/device.h"
#include "bake/receivers/distributed.h"

#include "base/context.h"
#include "base/progress.h"
#include "base/check.h"
#include "device/arrays.h"
#include "scene/interiors.h"

#include <math.h>
#include <string.h>

/* Samples of the first pass; receivers per progress report at first, whole blocks, and of a device's first launch. */
enum { PASS_FIRST = 16, CHUNK_FIRST = 8 * TY_BAKE_BLOCK, LAUNCH_FIRST = 1 << 12 };
/* Paths per gather ray beside the light cache: by default, and with an error bound. */
enum { FOG_EVERY = 32, FOG_EVERY_BOUND = 4 };

static const double chunk_seconds = 0.1;

/* ---- media ---- */

static bool has_density(const ty_medium_view* medium) {
    if (!(medium->sigma_t_max > 0)) return false;
    if (medium->has_grid == 0) return true;
    const int32_t* bricks = medium->grid.bricks;
    const size_t count = (size_t)bricks[0] * (size_t)bricks[1] * (size_t)bricks[2];
    for (size_t i = 0; i < count; ++i)
        if (medium->extremes[2 * i + 1] > 0) return true;
    return false;
}

/* True for methods to which media scatter light. */
static bool solves_enclosed(const ty_bake_run* run) {
    return run->def->method != TY_BAKE_SURFACES && run->def->method != TY_BAKE_ATTENUATION;
}

/* Media of zero density are left out, so that they change nothing, not even the random choice of lights. */
static ty_result select_media(ty_bake_run* run, const ty_scene* solved) {
    const ty_scene_view* scene = ty_scene_get_view(solved);
    if (run->def->method == TY_BAKE_SURFACES || scene->medium_count == 0) return TY_OK;
    run->media_size = (size_t)scene->medium_count;
    run->media = ty_alloc_array(run->context, run->media_size, sizeof *run->media, false);
    if (run->media == NULL) return TY_ERROR_MEMORY;
    int32_t count = 0;
    run->request.gray = 1;
    for (int32_t i = 0; i < scene->medium_count; ++i) {
        if (!has_density(&scene->media[i])) continue;
        if (run->def->method != TY_BAKE_PATH && solves_enclosed(run) && ty_enclosed_fills(solved, i)) continue;
        run->media[count++] = scene->media[i];
        if (!ty_bake_is_gray(&scene->media[i])) run->request.gray = 0;
    }
    run->path.view.media = run->media;
    run->path.view.medium_count = count;
    return TY_OK;
}

ty_result ty_bake_solve_enclosed(const ty_bake_run* run, const ty_scene* scene, ty_enclosed** out) {
    ty_path_def path = ty_default_path_def();
    const ty_enclosed_def def = ty_default_enclosed_def();
    *out = NULL;
    if (!solves_enclosed(run)) return TY_OK;
    path.seed = run->def->seed;
    path.max_depth = run->def->bounces;
    return ty_path_solve_enclosed(scene, &path, &def, out, NULL);
}

static ty_result attach_cache(ty_bake_run* run, const ty_scene* scene) {
    const ty_bake_def* def = run->def;
    const bool fog = run->path.view.medium_count > 0;
    if (def->method != TY_BAKE_CACHE || (!fog && !ty_enclosed_exists(scene))) return TY_OK;
    if (def->cache == NULL) {
        const ty_result result = ty_bake_cache_make(run, scene, &run->cache);
        if (result != TY_OK) return result;
        run->stats.cache_seconds = run->cache->info.seconds;
    }
    const ty_bake_cache* cache = def->cache != NULL ? def->cache : run->cache;
    run->request.path.enclosed = ty_enclosed_fields(cache->enclosed);
    if (!fog) return TY_OK;
    run->request.cache = cache->view;
    /* An error bound should be met soon, whichever term is noisiest. */
    run->request.fog_every = def->error > 0 ? FOG_EVERY_BOUND : FOG_EVERY;
    return TY_OK;
}

/* The published composition of impulse responses has no emission of media. */
static void find_emission(ty_bake_run* run) {
    const ty_bake_def* def = run->def;
    if (def->method != TY_BAKE_CACHE && (def->method != TY_BAKE_IMPULSE || def->composition == TY_BAKE_PUBLISHED))
        return;
    for (int32_t i = 0; i < run->path.view.medium_count; ++i)
        if (run->media[i].emits != 0) run->request.media_emit = 1;
}

static ty_result attach_enclosed(ty_bake_run* run, const ty_scene* scene) {
    if (run->request.path.enclosed != NULL || run->def->method == TY_BAKE_CACHE) return TY_OK;
    const ty_result result = ty_bake_solve_enclosed(run, scene, &run->enclosed);
    run->request.path.enclosed = ty_enclosed_fields(run->enclosed);
    return result;
}

/* ---- setup and results of a run ---- */

static ty_result check_receivers(const ty_bake_run* run, const ty_bake_receiver* receivers, int64_t count) {
    if (count < 0 || (count > 0 && receivers == NULL))
        return ty_fail(run->context, TY_ERROR_ARGUMENT, "bake: a count of %lld receivers", (long long)count);
    if (run->def->first < 0 || run->def->first > (int64_t)1 << 62)
        return ty_fail(run->context, TY_ERROR_ARGUMENT, "bake: first: %lld is outside of 0..2^62",
                       (long long)run->def->first);
    for (int64_t i = 0; i < count; ++i) {
        const ty_bake_receiver* r = &receivers[i];
        float sum = r->margin;
        for (int a = 0; a < 3; ++a) sum += r->position[a] + r->normal[a] + r->face[a];
        if (!isfinite(sum) || r->margin < 0)
            return ty_fail(run->context, TY_ERROR_ARGUMENT, "bake: receiver %lld is not made of finite numbers",
                           (long long)i);
    }
    return TY_OK;
}

static bool is_transparent(const ty_surface* surface) {
    return surface->gloss != NULL && (surface->gloss->dielectric.solid != 0 || surface->gloss->factor.transmission > 0);
}

static void find_transparent(ty_bake_run* run, const ty_scene* scene) {
    for (size_t i = 0; i < scene->surfaces.count && run->request.transparent == 0; ++i)
        run->request.transparent = is_transparent(&scene->surfaces.surfaces[i]);
}

/* Light selection ignores media, whatever the method, so that media of zero density change nothing. */
static ty_result begin_path(ty_bake_run* run, const ty_scene* scene) {
    ty_path_def path = ty_default_path_def();
    path.ignore_media = true;
    path.seed = run->def->seed;
    path.max_depth = run->def->bounces;
    ty_result result = ty_path_prepare(scene, &path, &run->path);
    if (result != TY_OK) return result;
    run->path.item_count = 1;
    result = ty_path_run_begin(&run->path, scene, false);
    run->path.def = NULL;
    return result;
}

ty_result ty_bake_run_prepare(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def) {
    memset(run, 0, sizeof *run);
    run->context = ty_scene_context(scene);
    ty_result result = ty_bake_take_def(run->context, def, &run->known);
    def = run->def = &run->known;
    if (result == TY_OK) result = ty_scene_check_open(scene, "the baker");
    if (result == TY_OK) result = begin_path(run, scene);
    if (result == TY_OK) result = select_media(run, scene);
    if (result != TY_OK) return result;
    run->request.path = run->path.request;
    find_transparent(run, scene);
    if (def->method == TY_BAKE_PATH || def->method == TY_BAKE_CACHE) run->request.path.max_run = def->scatterings;
    return TY_OK;
}

ty_result ty_bake_run_begin(ty_bake_run* run, const ty_scene* scene, const ty_bake_def* def,
                            const ty_bake_receiver* receivers, int64_t count, int32_t terms) {
    ty_result result = ty_bake_run_prepare(run, scene, def);
    if (result == TY_OK) result = check_receivers(run, receivers, count);
    if (result == TY_OK) result = ty_bake_impulse_take_tables(run);
    if (result == TY_OK) result = attach_cache(run, scene);
    if (result == TY_OK) result = attach_enclosed(run, scene);
    if (result != TY_OK) return result;
    find_emission(run);
    ty_interiors_warn(scene, "bake", "glass passes light straight on, and media outside take it for opaque");
    run->count = count;
    ty_bake_request* request = &run->request;
    request->method = (int32_t)def->method;
    request->scatterings = def->scatterings;
    request->back_scattering = def->back_scattering;
    request->impulse.published = def->composition == TY_BAKE_PUBLISHED;
    request->receivers = receivers;
    request->first = run->def->first;
    request->terms = terms;
    run->kernel = TY_BEST_KERNELS(ty_bake_kernel);
    if (def->method == TY_BAKE_PATH && run->path.view.interior_count > 1)
        run->kernel = TY_BEST_KERNELS(ty_bake_path_kernel);
    const size_t size = (size_t)(TY_BAKE_LAYERS * 3 * terms);
    run->sums = ty_alloc_array(run->context, (size_t)count, sizeof *run->sums, true);
    run->light = ty_alloc_array(run->context, (size_t)count, size * sizeof *run->light, true);
    return run->sums != NULL && run->light != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_bake_run_end(ty_bake_run* run) {
    const size_t size = (size_t)(TY_BAKE_LAYERS * 3 * run->request.terms);
    if (run->light != NULL) ty_free_array(run->context, run->light, (size_t)run->count, size * sizeof *run->light);
    if (run->sums != NULL) ty_free_array(run->context, run->sums, (size_t)run->count, sizeof *run->sums);
    if (run->media != NULL) ty_free_array(run->context, run->media, run->media_size, sizeof *run->media);
    ty_bake_impulse_end(run);
    ty_bake_cache_destroy(run->cache);
    ty_enclosed_destroy(run->enclosed);
    if (run->path.items != NULL) ty_path_run_end(&run->path);
}

/* The light cache estimates scattered light from gather rays and the prior. */
static double samples_of(const ty_bake_run* run, int64_t receiver, int layer) {
    const ty_bake_sums* sums = &run->sums[receiver];
    const bool fog = run->request.cache.light != NULL && (layer == TY_BAKE_SINGLE || layer == TY_BAKE_MULTIPLE);
    return fog ? sums->gather_rays + sums->prior_rays : sums->count;
}

double ty_bake_mean(const ty_bake_run* run, int64_t receiver, int layer, int channel, int term) {
    const int32_t terms = run->request.terms;
    const size_t at = (((size_t)receiver * TY_BAKE_LAYERS + (size_t)layer) * 3 + (size_t)channel) * (size_t)terms;
    const double samples = samples_of(run, receiver, layer);
    return samples > 0 ? run->light[at + (size_t)term] / samples : 0;
}

/* Variance of a mean of n samples from their sum and sum of squares. */
static double variance_of(double sum, double square, int32_t n) {
    return n < 2 ? square : fmax(0, (square - sum * sum / n) / (n - 1)) / n;
}

double ty_bake_variance(const ty_bake_sums* sums, int channel) {
    if (sums->count < 2) return 0;
    const double rays = sums->gather_rays + sums->prior_rays, gathered = rays > 0 ? sums->gather_rays / rays : 0;
    return variance_of(sums->mean[channel], sums->square[channel], sums->count) +
           gathered * gathered * variance_of(sums->fog_mean[channel], sums->fog_square[channel], sums->gather_rays) +
           (1 - gathered) * (1 - gathered) * sums->prior_variance[channel];
}

/* ---- passes ---- */

typedef struct pass {
    ty_bake_run* run;
    ty_bake_shared* shared;
    int64_t begin, end; /* receivers of this chunk */
    uint32_t first, count;
} pass;

static void sample_block(void* user, int64_t block, int32_t worker) {
    (void)worker;
    const pass* p = user;
    const int64_t begin = p->begin + block * TY_BAKE_BLOCK;
    const int64_t end = begin + TY_BAKE_BLOCK < p->end ? begin + TY_BAKE_BLOCK : p->end;
    if (!ty_bake_shared_take(p->shared, begin / TY_BAKE_BLOCK)) return;
    p->run->kernel(&p->run->request, begin, end, p->first, p->count, p->run->sums, p->run->light);
}

static bool report(const ty_bake_run* run, double fraction, double seconds, uint64_t done) {
    ty_progress progress = ty_progress_at("bake", fmin(1, fraction), seconds);
    progress.done = done;
    progress.total = (uint64_t)run->def->spp;
    return run->def->progress == NULL || run->def->progress(run->def->progress_user, &progress);
}

/* One pass over all receivers, in chunks of about 0.1 s, on a device of a launch. */
static ty_result sample_pass(ty_bake_run* run, ty_bake_shared* shared, ty_bake_device* on_device, uint32_t first,
                             uint32_t count, double begun) {
    int64_t chunk = CHUNK_FIRST;
    ty_result result = TY_OK;
    uint32_t launch = LAUNCH_FIRST;
    ty_bake_shared_begin_pass(shared, first, count);
    for (int64_t at = 0; at < run->count;) {
        pass p = {run, shared, at, at + chunk < run->count ? at + chunk : run->count, first, count};
        const double start = ty_wall_seconds();
        if (on_device != NULL) {
            p.end = at + launch < run->count ? at + launch : run->count;
            result = ty_bake_device_sample(on_device, p.begin, p.end, first, count);
            if (result != TY_OK) return result;
        } else {
            ty_parallel_for(run->context, (p.end - p.begin + TY_BAKE_BLOCK - 1) / TY_BAKE_BLOCK, sample_block, &p);
        }
        const double now = ty_wall_seconds();
        at = p.end;
        launch = ty_device_next_launch(launch, now - start, TY_BAKE_BLOCK);
        if (now - start < 0.5 * chunk_seconds) chunk *= 2;
        if (now - start > 2 * chunk_seconds && chunk > CHUNK_FIRST) chunk /= 2;
        const double samples = first + (double)count * (double)at / (double)run->count;
        if (result == TY_OK && !report(run, samples / run->def->spp, now - begun, first)) result = TY_CANCELLED;
        if (result != TY_OK) break;
    }
    const ty_result read = on_device != NULL ? ty_bake_device_read(on_device) : TY_OK;
    if (result == TY_OK) ty_bake_shared_end_pass(shared);
    return read == TY_OK ? result : read;
}

static double brightness(const ty_bake_run* run, int64_t receiver) {
    double sum = 0;
    for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
        for (int c = 0; c < 3; ++c) sum += ty_bake_mean(run, receiver, layer, c, 0);
    return sum / 3;
}

/* Marks converged receivers as done; true if all are. */
static bool end_receivers(ty_bake_run* run) {
    if (!(run->def->error > 0)) return false;
    double mean = 0;
    bool all = true;
    for (int64_t i = 0; i < run->count; ++i) mean += brightness(run, i) / (double)run->count;
    for (int64_t i = 0; i < run->count; ++i) {
        ty_bake_sums* sums = &run->sums[i];
        double variance = 0;
        for (int c = 0; c < 3; ++c) variance += ty_bake_variance(sums, c) / 3;
        if (sqrt(variance) <= run->def->error * fmax(mean, brightness(run, i))) sums->done = 1;
        if (sums->done == 0) all = false;
    }
    return all;
}

ty_result ty_bake_sample(ty_bake_run* run) {
    const double begun = ty_wall_seconds();
    const uint32_t spp = (uint32_t)run->def->spp;
    ty_bake_shared shared;
    ty_bake_device* on_device = NULL;
    ty_result result = ty_bake_shared_open(&shared, run);
    if (result != TY_OK) return result;
    if (shared.queue == NULL) result = ty_bake_device_create(run, &on_device);
    if (result == TY_OK && ty_bake_impulse_emits(run))
        result = ty_bake_impulse_begin(run); /* while the other ranks do the same */
    for (uint32_t done = 0; done < spp && result == TY_OK;) {
        const uint32_t max_count = done > 0 ? done : PASS_FIRST,
                       count = spp - done < max_count ? spp - done : max_count;
        result = sample_pass(run, &shared, on_device, done, count, begun);
        done += count;
        if (result == TY_OK && end_receivers(run)) break;
        if (result == TY_OK && on_device != NULL && run->def->error > 0) result = ty_bake_device_write_done(on_device);
    }
    ty_bake_device_destroy(on_device);
    ty_bake_shared_close(&shared);
    run->stats.seconds = ty_wall_seconds() - begun;
    for (int64_t i = 0; i < run->count; ++i) {
        run->stats.paths += (int64_t)run->sums[i].paths;
        run->stats.rays += (int64_t)run->sums[i].rays;
        run->stats.mean_samples += (double)run->sums[i].count / (double)run->count;
    }
    return result;
}
