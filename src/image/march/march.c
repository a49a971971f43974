/* Marching all pixels of an image: checks, tiles over threads, channels. */
#define _POSIX_C_SOURCE 200809L
#include "image/march/march.h"

#include "base/context.h"
#include "base/progress.h"
#include "image/aovs.h"
#include "image/march/channels.k.h"
#include "image/march/device/device.h"
#include "image/march/edges.h"
#include "image/march/froxels.h"
#include "image/image.h"
#include "image/march/gathered.h"
#include "image/march/request.h"
#include "image/march/spaced.h"
#include "base/check.h"

#include <pthread.h>
#include <stdatomic.h>

enum { TILE = 16, REDUCED_MAX = 12, LENS_RAYS = 32 };

typedef struct march_job {
    ty_context* context;
    const ty_march_def* def;
    ty_packed_request packed;
    ty_march_kernel kernel;
    ty_spaced_rays spaced; /* spacing 1: unused */
    const ty_spaced_kernels* spaced_kernels;
    const ty_froxel_kernels* froxel_kernels;
    int32_t sample;       /* the ray of each pixel that spaced rays are at */
    ty_march_pixel* sums; /* of the pixels, for several spaced rays per pixel; NULL: none */
    ty_image* image;
    const float* unscattered[3]; /* planes of def->unscattered; NULL: none */
    int64_t tiles;               /* of the whole work */
    double begun, cpu_begun;
    pthread_mutex_t lock; /* guards reporting */
    double reported;
    _Atomic int64_t finished;
    _Atomic uint64_t steps;
    _Atomic bool cancelled;
} march_job;

ty_march_def ty_default_march_def(void) {
    return (ty_march_def){.spp = 1, .edge_rays = 1, .step = 1, .bilateral_sigma = 0.25, .ray_spacing = 1};
}

ty_march_def ty_march_def_of(const ty_scene* scene, const ty_image_options* options) {
    ty_march_def def = ty_default_march_def();
    int32_t size[2];
    ty_image_resolution(scene, options->width, options->height, size);
    def.width = size[0];
    def.height = size[1];
    def.spp = options->spp;
    def.seed = options->seed;
    def.step = options->step;
    def.aovs = options->aovs;
    return def;
}

/* ---- options ---- */

static ty_result check_box(ty_context* context, const char* name, const ty_grid_box* box) {
    for (int a = 0; a < 3; ++a)
        if (!(box->upper[a] > box->lower[a]) || box->size[a] < 1)
            return ty_fail(context, TY_ERROR_ARGUMENT, "march.%s: %d cells from %g to %g along %c", name,
                           (int)box->size[a], box->lower[a], box->upper[a], "xyz"[a]);
    return TY_OK;
}

static ty_result check_field(ty_context* context, const ty_source_field* field) {
    if (field->term_count != 1 && field->term_count != TY_FIELD_TERMS)
        return ty_fail(context, TY_ERROR_ARGUMENT, "march.field: %d terms are neither 1 nor %d", (int)field->term_count,
                       (int)TY_FIELD_TERMS);
    for (int c = 0; c < (field->shared ? 1 : 3); ++c)
        for (int t = 0; t < field->term_count; ++t)
            if (field->terms[c][t] == NULL)
                return ty_fail(context, TY_ERROR_ARGUMENT, "march.field: terms[%d][%d] is NULL", c, t);
    return check_box(context, "field", &field->box);
}

static ty_result check_unscattered(ty_context* context, const ty_march_def* def) {
    const float* planes[3];
    const ty_image* image = def->unscattered;
    if (ty_image_width(image) != def->width || ty_image_height(image) != def->height)
        return ty_fail(context, TY_ERROR_ARGUMENT, "march.unscattered: %d x %d pixels, and the image has %d x %d",
                       (int)ty_image_width(image), (int)ty_image_height(image), (int)def->width, (int)def->height);
    if (!ty_image_rgb_planes(image, planes))
        return ty_fail(context, TY_ERROR_ARGUMENT, "march.unscattered: no R, G and B");
    return TY_OK;
}

static ty_result check_froxels(ty_context* context, const ty_march_def* def) {
    static const char* const names[] = {"march.froxels[0]", "march.froxels[1]", "march.froxels[2]"};
    static const int32_t max[] = {TY_FROXEL_COLUMNS_MAX, TY_FROXEL_ROWS_MAX, TY_FROXEL_SLICES_MAX};
    for (int a = 0; a < 3; ++a) {
        const ty_result result = ty_check_number(context, names[a], def->froxels[a], 1, max[a]);
        if (result != TY_OK) return result;
    }
    return def->field == NULL ? TY_OK : ty_fail(context, TY_ERROR_ARGUMENT, "march.froxels: they hold no source field");
}

static ty_result check_def(ty_context* context, const ty_march_def* def) {
    const ty_image_options options = {def->width, def->height, def->spp, def->seed, def->step, def->aovs};
    ty_result result = ty_check_number(context, "march.width", def->width, 1, TY_IMAGE_SIDE_MAX);
    if (result == TY_OK) result = ty_check_number(context, "march.height", def->height, 1, TY_IMAGE_SIDE_MAX);
    if (result == TY_OK) result = ty_check_image(context, "march", &options, TY_MARCH_AOVS);
    if (result == TY_OK) result = ty_check_number(context, "march.spp", def->spp, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "march.edge_rays", def->edge_rays, 1, 64);
    if (result == TY_OK) result = ty_check_number(context, "march.step", def->step, 0.05, 8);
    if (result == TY_OK) result = ty_check_number(context, "march.ray_spacing", def->ray_spacing, 1, TY_SPACING_MAX);
    if (result == TY_OK) result = ty_check_number(context, "march.bilateral_sigma", def->bilateral_sigma, 0, 1e6);
    if (result == TY_OK)
        result = ty_check_number(context, "march.light_count", def->light_count, 0, TY_MARCH_LIGHTS_MAX);
    if (result == TY_OK) result = ty_check_number(context, "march.reduced", def->reduced, 0, REDUCED_MAX);
    if (result == TY_OK && ty_march_has_froxels(def)) result = check_froxels(context, def);
    if (result == TY_OK && def->light_count > 0) result = check_box(context, "light_box", &def->light_box);
    if (result == TY_OK && def->field != NULL) result = check_field(context, def->field);
    if (result == TY_OK && def->surface_field != NULL) result = check_field(context, def->surface_field);
    if (result == TY_OK && def->unscattered != NULL) result = check_unscattered(context, def);
    return result;
}

/* ---- pixels ---- */

static ty_result create_image(march_job* job) {
    const char* names[TY_AOV_CHANNELS_MAX];
    const int32_t count = ty_aov_names(job->def->aovs, names);
    return ty_image_create(job->context, job->def->width, job->def->height, count, names, &job->image);
}

static float background(const march_job* job, int c, size_t index) {
    return job->unscattered[c] != NULL ? job->unscattered[c][index] : 0;
}

static void store_row(const march_job* job, int32_t y, int32_t begin, int32_t end, const ty_march_pixel* pixels) {
    const size_t first = (size_t)y * (size_t)job->def->width;
    int32_t channel = 0;
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int c = 0; ty_aov_is_requested(&ty_aov_groups[g], job->def->aovs) && c < ty_aov_groups[g].count; ++c) {
            float* plane = ty_image_plane(job->image, channel++) + first;
            for (int32_t x = begin; x < end; ++x)
                plane[x] = ty_pixel_value(&pixels[x - begin], ty_aov_groups[g].aov, c, job->def->spp,
                                          background(job, c, first + (size_t)x));
        }
}

static void report(march_job* job, bool always) {
    const ty_march_def* def = job->def;
    if (def->progress == NULL || (always ? pthread_mutex_lock : pthread_mutex_trylock)(&job->lock) != 0) return;
    if (ty_report_due(&job->reported) || always) {
        const double fraction = (double)atomic_load(&job->finished) / (double)job->tiles;
        const ty_progress progress = ty_progress_at("march", fraction, ty_wall_seconds() - job->begun);
        if (!def->progress(def->progress_user, &progress)) atomic_store(&job->cancelled, true);
    }
    pthread_mutex_unlock(&job->lock);
}

static int32_t smaller(int32_t a, int32_t b) {
    return a < b ? a : b;
}

static int32_t tiles_along(int32_t side) {
    return (side + TILE - 1) / TILE;
}

static int64_t tiles_of(int32_t width, int32_t height) {
    return (int64_t)tiles_along(width) * tiles_along(height);
}

/* Pixels or rays [x, right) x [y, bottom). */
typedef struct tile {
    int32_t x, y, right, bottom;
} tile;

static tile tile_at(int64_t index, int32_t width, int32_t height) {
    const int32_t x = (int32_t)(index % tiles_along(width)) * TILE, y = (int32_t)(index / tiles_along(width)) * TILE;
    return (tile){x, y, smaller(x + TILE, width), smaller(y + TILE, height)};
}

static bool is_cancelled(march_job* job) {
    return atomic_load_explicit(&job->cancelled, memory_order_relaxed);
}

static void finish_tile(march_job* job, uint64_t steps) {
    atomic_fetch_add(&job->steps, steps);
    atomic_fetch_add(&job->finished, 1);
}

static void march_tile(void* user, int64_t index, int32_t worker) {
    (void)worker;
    march_job* job = user;
    const tile t = tile_at(index, job->def->width, job->def->height);
    ty_march_pixel pixels[TILE];
    uint64_t steps = 0;
    for (int32_t row = t.y; row < t.bottom; ++row) {
        if (is_cancelled(job)) return;
        steps += job->kernel(&job->packed.request, row, t.x, t.right, pixels);
        store_row(job, row, t.x, t.right, pixels);
        report(job, false);
    }
    finish_tile(job, steps);
}

/* ---- rays several pixels apart ---- */

static void march_spaced_tile(void* user, int64_t index, int32_t worker) {
    (void)worker;
    march_job* job = user;
    const tile t = tile_at(index, job->spaced.columns, job->spaced.rows);
    uint64_t steps = 0;
    for (int32_t row = t.y; row < t.bottom; ++row) {
        if (is_cancelled(job)) return;
        steps += job->spaced_kernels->march(&job->packed.request, &job->spaced, job->sample, row, t.x, t.right);
        report(job, false);
    }
    finish_tile(job, steps);
}

static void fill_tile(void* user, int64_t index, int32_t worker) {
    (void)worker;
    march_job* job = user;
    const tile t = tile_at(index, job->def->width, job->def->height);
    ty_march_pixel own[TILE], *pixels = own;
    uint64_t steps = 0;
    for (int32_t row = t.y; row < t.bottom; ++row) {
        if (is_cancelled(job)) return;
        if (job->sums != NULL)
            pixels = job->sums + (size_t)row * (size_t)job->def->width + (size_t)t.x;
        else
            memset(own, 0, sizeof own);
        steps += job->spaced_kernels->fill(&job->packed.request, &job->spaced, job->sample, row, t.x, t.right, pixels);
        if (job->sample + 1 == job->def->spp) store_row(job, row, t.x, t.right, pixels);
        report(job, false);
    }
    finish_tile(job, steps);
}

static ty_result create_spaced(march_job* job) {
    const ty_march_def* def = job->def;
    ty_spaced_rays* spaced = &job->spaced;
    *spaced = (ty_spaced_rays){.spacing = def->ray_spacing, .width = def->width, .height = def->height};
    if (spaced->spacing == 1 || ty_march_has_froxels(def)) return TY_OK;
    spaced->columns = ty_spaced_count(def->width, spaced->spacing);
    spaced->rows = ty_spaced_count(def->height, spaced->spacing);
    spaced->rays =
        ty_alloc_array(job->context, (size_t)spaced->columns * (size_t)spaced->rows, sizeof *spaced->rays, false);
    if (spaced->rays == NULL) return TY_ERROR_MEMORY;
    if (def->spp == 1) return TY_OK;
    job->sums = ty_alloc_array(job->context, (size_t)def->width * (size_t)def->height, sizeof *job->sums, true);
    return job->sums != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static void free_spaced(march_job* job) {
    const ty_march_def* def = job->def;
    ty_spaced_rays* spaced = &job->spaced;
    ty_free_array(job->context, spaced->rays, (size_t)spaced->columns * (size_t)spaced->rows, sizeof *spaced->rays);
    ty_free_array(job->context, job->sums, (size_t)def->width * (size_t)def->height, sizeof *job->sums);
}

static void march_spaced(march_job* job, int64_t tiles) {
    const int64_t spaced_tiles = tiles_of(job->spaced.columns, job->spaced.rows);
    job->tiles = job->def->spp * (spaced_tiles + tiles);
    for (job->sample = 0; job->sample < job->def->spp; ++job->sample) {
        ty_parallel_for(job->context, spaced_tiles, march_spaced_tile, job);
        ty_parallel_for(job->context, tiles, fill_tile, job);
    }
}

/* ---- froxels ---- */

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    march_job* job = user;
    if (is_cancelled(job)) return;
    const uint64_t steps = job->froxel_kernels->fill(&job->packed.request, (int32_t)row);
    report(job, false);
    finish_tile(job, steps);
}

static void march_froxels(march_job* job, int64_t tiles) {
    const int32_t rows = job->packed.request.froxels.size[1];
    job->tiles = rows + tiles;
    ty_parallel_for(job->context, rows, fill_row, job);
    job->kernel = job->froxel_kernels->look_up;
    ty_parallel_for(job->context, tiles, march_tile, job);
}

/* ---- all pixels ---- */

static ty_result march(march_job* job) {
    pthread_mutex_init(&job->lock, NULL);
    job->tiles = tiles_of(job->def->width, job->def->height);
    if (ty_march_has_froxels(job->def))
        march_froxels(job, job->tiles);
    else if (job->spaced.spacing > 1)
        march_spaced(job, job->tiles);
    else
        ty_parallel_for(job->context, job->tiles, march_tile, job);
    const bool cancelled = atomic_load(&job->finished) < job->tiles;
    if (!cancelled) report(job, true);
    pthread_mutex_destroy(&job->lock);
    return cancelled ? TY_CANCELLED : TY_OK;
}

/* A lens or a moving camera is seen by rays of its own through each pixel. */
static ty_march_def def_of_camera(const ty_scene* scene, const ty_march_def* given) {
    const ty_camera_def camera = ty_scene_camera(scene);
    ty_march_def def = *given;
    if (!ty_camera_is_sampled(&camera)) return def;
    if (def.spp < LENS_RAYS) def.spp = LENS_RAYS;
    def.ray_spacing = def.edge_rays = 1;
    return def;
}

/* By the processor's own kernels. */
static ty_result march_here(march_job* job, const ty_scene* scene) {
    const ty_march_def* def = job->def;
    ty_march_request* request = &job->packed.request;
    const bool has_froxels = ty_march_has_froxels(def);
    job->kernel =
        request->camera.sampled != 0 ? TY_BEST_KERNELS(ty_march_sampled_kernel) : TY_BEST_KERNELS(ty_march_kernel);
    job->spaced_kernels = TY_BEST_KERNELS(ty_spaced_kernels);
    job->froxel_kernels = TY_BEST_KERNELS(ty_froxel_kernels);
    uint64_t gathering_steps = 0;
    ty_result result = create_spaced(job);
    if (result == TY_OK && has_froxels)
        result = ty_froxels_create(job->context, request, def->froxels, def->width, def->height);
    if (result == TY_OK && ty_march_gathers(def, request))
        result = ty_gathered_create(scene, request, def->width, def->height, &gathering_steps);
    atomic_fetch_add(&job->steps, gathering_steps);
    if (result == TY_OK && ty_march_has_edges(def))
        result = ty_edges_create(scene, def->width, def->height, def->edge_rays, request);
    if (result == TY_OK) result = march(job);
    free_spaced(job);
    ty_froxels_destroy(job->context, &request->froxels);
    ty_gathered_destroy(job->context, &request->gathered);
    ty_edges_destroy(job->context, &request->edges);
    return result;
}

ty_result ty_march(const ty_scene* scene, const ty_march_def* given, ty_image** out, ty_march_stats* stats) {
    const ty_march_def own = def_of_camera(scene, given), *def = &own;
    march_job job = {.context = ty_scene_context(scene), .def = def};
    job.begun = job.reported = ty_wall_seconds();
    job.cpu_begun = ty_cpu_seconds();
    ty_result result = check_def(job.context, def);
    if (def->unscattered != NULL && result == TY_OK) ty_image_rgb_planes(def->unscattered, job.unscattered);
    const ty_camera_def camera = ty_scene_camera(scene);
    if (result == TY_OK && ty_march_has_froxels(def))
        result = ty_camera_check_pinhole(job.context, &camera, "march.froxels");
    if (result == TY_OK) result = ty_march_request_make(scene, def, &job.packed);
    if (result == TY_OK) result = create_image(&job);
    const char* isa = ty_isa_name(ty_best_isa());
    ty_marched_on_device on_device = {.stats = stats != NULL};
    if (result == TY_OK) result = ty_march_on_device(scene, def, &job.packed, job.image, &on_device);
    if (on_device.kind != NULL) {
        isa = on_device.kind;
        atomic_store(&job.steps, on_device.steps);
    } else if (result == TY_OK) {
        result = march_here(&job, scene);
    }
    ty_march_request_free(&job.packed);
    if (result != TY_OK) {
        ty_image_destroy(job.image);
        *out = NULL;
        return result;
    }
    *out = job.image;
    if (stats != NULL)
        *stats = (ty_march_stats){.seconds = ty_wall_seconds() - job.begun,
                                  .cpu_seconds = ty_cpu_seconds() - job.cpu_begun,
                                  .steps = atomic_load(&job.steps),
                                  .isa = isa};
    return TY_OK;
}
