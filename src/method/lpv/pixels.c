/* Images, pass by pass. */
#define _POSIX_C_SOURCE 200809L
#include "method/lpv/pixels.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/random.k.h"
#include "image/aovs.h"
#include "method/lpv/frame.h"

#include <time.h>

/* ---- tiles ---- */

typedef void (*tile_fn)(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom);

/* Rows [top, bottom) of the image. */
typedef struct tile_pass {
    ty_lpv_frame* frame;
    tile_fn body;
    const char* stage;
    int32_t top, bottom, columns;
    int64_t tiles;
    _Atomic int64_t finished;
} tile_pass;

static void report(tile_pass* pass) {
    ty_lpv_frame* frame = pass->frame;
    if (frame->progress.function == NULL || pthread_mutex_trylock(&frame->lock) != 0) return;
    const double fraction = (double)atomic_load(&pass->finished) / (double)pass->tiles;
    if (ty_part_show(&frame->progress, pass->stage, fraction) != TY_OK) atomic_store(&frame->cancelled, true);
    pthread_mutex_unlock(&frame->lock);
}

static void run_tile(void* user, int64_t index, int32_t worker) {
    (void)worker;
    tile_pass* pass = user;
    if (atomic_load_explicit(&pass->frame->cancelled, memory_order_relaxed)) return;
    const int32_t x = (int32_t)(index % pass->columns) * TY_TILE;
    const int32_t y = pass->top + (int32_t)(index / pass->columns) * TY_TILE;
    const int32_t right = x + TY_TILE < pass->frame->width ? x + TY_TILE : pass->frame->width;
    const int32_t bottom = y + TY_TILE < pass->bottom ? y + TY_TILE : pass->bottom;
    pass->body(pass->frame, x, y, right, bottom);
    atomic_fetch_add(&pass->finished, 1);
    report(pass);
}

/* Runs a pass, which takes the progress up to `until`; seconds: is added to. Errors: TY_CANCELLED. */
static ty_result run_tiles(tile_pass* pass, double until, double* seconds) {
    ty_lpv_frame* frame = pass->frame;
    const double begun = ty_wall_seconds();
    if (ty_part_next(&frame->progress, pass->stage, until) != TY_OK) return TY_CANCELLED;
    pass->columns = (frame->width + TY_TILE - 1) / TY_TILE;
    pass->tiles = (int64_t)pass->columns * ((pass->bottom - pass->top + TY_TILE - 1) / TY_TILE);
    ty_parallel_for(frame->context, pass->tiles, run_tile, pass);
    *seconds += ty_wall_seconds() - begun;
    return atomic_load(&frame->cancelled) ? TY_CANCELLED : TY_OK;
}

int64_t ty_lpv_clock(ty_lpv_frame* frame, int clock, int64_t begun) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    const int64_t nanoseconds = (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
    if (clock < TY_CLOCKS) atomic_fetch_add_explicit(&frame->clocks[clock], nanoseconds - begun, memory_order_relaxed);
    return nanoseconds;
}

/* What a tile's pixels see of surfaces, and the air's rays that go through it of media. */
static void see_tile(ty_lpv_frame* frame, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_lpv_tile tile;
    const int32_t shrink = frame->shrink, first[2] = {x / shrink, y / shrink};
    const int32_t end[2] = {(right + shrink - 1) / shrink, (bottom + shrink - 1) / shrink};
    int64_t begun = ty_lpv_clock(frame, TY_CLOCKS, 0);
    ty_lpv_see(frame, x, y, right, bottom, &tile);
    begun = ty_lpv_clock(frame, TY_CLOCK_VIEW, begun);
    ty_lpv_shade(frame, &tile);
    begun = ty_lpv_clock(frame, TY_CLOCK_SURFACES, begun);
    if (frame->air == NULL) return;
    ty_lpv_march_tile(frame, first[0], first[1], end[0], end[1]);
    begun = ty_lpv_clock(frame, TY_CLOCK_MARCH, begun);
    if (frame->job->airlight == NULL || (frame->job->def->parts & TY_LPV_SINGLE) == 0) return;
    ty_lpv_single_tile(frame, first[0], first[1], end[0], end[1]);
    ty_lpv_clock(frame, TY_CLOCK_SINGLE, begun);
}

/* A golden-ratio lattice over the pixel; one ray goes through the middle. */
static void place_sample(ty_lpv_frame* frame, int32_t sample) {
    const float turn = 0.5f + 0.618033989f * (float)sample;
    frame->sample = sample;
    frame->dx = ((float)sample + 0.5f) / (float)frame->samples;
    frame->dy = turn - floorf(turn);
}

/* The first row that cannot be composed yet when so many rows' media are there: it takes media of the next ones. */
static int32_t composable(const ty_lpv_frame* frame, int32_t rows) {
    return rows == frame->height || frame->shrink == 1 ? rows : rows - 1;
}

/* All bands for one ray per pixel; until: as in ty_part_next. */
static ty_result add_sample(ty_lpv_frame* frame, double until) {
    static const double seen_share = 0.9; /* of a band's work */
    const double from = frame->progress.from + frame->progress.share, per_row = (until - from) / frame->height;
    ty_result result = TY_OK;
    for (int32_t top = 0, composed = 0; top < frame->height && result == TY_OK; top += TY_BAND) {
        const int32_t bottom = top + TY_BAND < frame->height ? top + TY_BAND : frame->height;
        const int32_t next = composable(frame, bottom);
        tile_pass see = {.frame = frame, .body = see_tile, .stage = "surfaces and media", .top = top, .bottom = bottom};
        tile_pass compose = {
            .frame = frame, .body = ty_lpv_compose_tile, .stage = "image", .top = composed, .bottom = next};
        result = run_tiles(&see, from + per_row * (top + seen_share * (bottom - top)), &frame->stats.view_seconds);
        if (result == TY_OK) result = run_tiles(&compose, from + per_row * bottom, &frame->stats.compose_seconds);
        composed = next;
    }
    return result;
}

/* ---- from sums to means ---- */

static void finish_normal(float* const normal[3], size_t at) {
    const float square = normal[0][at] * normal[0][at] + normal[1][at] * normal[1][at] + normal[2][at] * normal[2][at];
    for (int c = 0; c < 3; ++c) normal[c][at] = square > 0.0f ? normal[c][at] / sqrtf(square) : 0.0f;
}

static void finish_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const ty_lpv_frame* frame = user;
    const ty_lpv_planes* planes = &frame->planes;
    float* const* means[] = {planes->color, planes->transmittance, planes->albedo, planes->single, planes->multiple};
    const size_t begin = (size_t)row * (size_t)frame->width, end = begin + (size_t)frame->width;
    const float share = 1.0f / (float)frame->samples;
    for (int m = 0; m < 5 && frame->samples > 1; ++m)
        for (int c = 0; c < 3 && means[m][c] != NULL; ++c)
            for (size_t at = begin; at < end; ++at) means[m][c][at] *= share;
    for (size_t at = begin; at < end && planes->normal[0] != NULL; ++at) finish_normal(planes->normal, at);
    for (size_t at = begin; at < end && planes->depth[0] != NULL; ++at)
        planes->depth[0][at] = frame->hits[at] > 0.0f ? planes->depth[0][at] / frame->hits[at] : 0.0f;
}

/* Parts of what tiles see by how their processor time divides. */
static void finish_stats(ty_lpv_frame* frame, ty_lpv_stats* out) {
    double clocks[TY_CLOCK_RAYS], sum = 0;
    for (int i = 0; i < TY_CLOCK_RAYS; ++i) sum += clocks[i] = (double)atomic_load(&frame->clocks[i]);
    const double per_clock = sum > 0 ? frame->stats.view_seconds / sum : 0;
    out->view_seconds = clocks[TY_CLOCK_VIEW] * per_clock;
    out->surface_seconds = clocks[TY_CLOCK_SURFACES] * per_clock;
    out->march_seconds = clocks[TY_CLOCK_MARCH] * per_clock;
    out->single_seconds = clocks[TY_CLOCK_SINGLE] * per_clock;
    out->compose_seconds = frame->stats.compose_seconds;
    out->rays += atomic_load(&frame->rays);
    out->ray_seconds += 1e-9 * (double)atomic_load(&frame->clocks[TY_CLOCK_RAYS]) / ty_context_threads(frame->context);
    out->marched = atomic_load(&frame->marched);
    out->isa = frame->isa;
}

/* ---- frames ---- */

static ty_result create_image(ty_lpv_frame* frame) {
    const char* names[TY_AOV_CHANNELS_MAX];
    const uint32_t asked = frame->job->def->aovs;
    const int32_t count = ty_aov_names(asked, names);
    const ty_result result = ty_image_create(frame->context, frame->width, frame->height, count, names, &frame->image);
    if (result != TY_OK) return result;
    ty_lpv_planes* planes = &frame->planes;
    float** const of[TY_AOV_GROUPS] = {
        planes->color,  NULL,           planes->transmittance, planes->depth, planes->normal,
        planes->albedo, planes->single, planes->multiple,      NULL};
    int32_t channel = 0;
    for (int g = 0; g < TY_AOV_GROUPS; ++g)
        for (int c = 0; ty_aov_is_requested(&ty_aov_groups[g], asked) && c < ty_aov_groups[g].count; ++c) {
            float* plane = ty_image_plane(frame->image, channel++);
            if (of[g] != NULL) of[g][c] = plane;
        }
    return TY_OK;
}

static size_t kept_pixels(const ty_lpv_frame* frame) {
    return (size_t)TY_KEPT * (size_t)frame->width;
}

static size_t kept_rays(const ty_lpv_frame* frame) {
    return (size_t)(TY_KEPT / frame->shrink) * (size_t)frame->air_width;
}

static ty_result take_planes(ty_lpv_frame* frame) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    frame->distance = ty_alloc_array(frame->context, kept_pixels(frame), sizeof(float), false);
    frame->surface = ty_alloc_array(frame->context, kept_pixels(frame), 3 * sizeof(float), false);
    if (frame->distance == NULL || frame->surface == NULL) return TY_ERROR_MEMORY;
    if ((frame->job->def->aovs & TY_AOV_DEPTH) != 0) {
        frame->hits = ty_alloc_array(frame->context, pixels, sizeof(float), true);
        if (frame->hits == NULL) return TY_ERROR_MEMORY;
    }
    if (!frame->foggy) return TY_OK;
    frame->air = ty_alloc_array(frame->context, kept_rays(frame), sizeof *frame->air, false);
    frame->upsample.air = frame->air;
    frame->upsample.mask = TY_KEPT / frame->shrink - 1;
    return frame->air != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result begin_frame(const ty_lpv_image_job* job, ty_lpv_frame* frame) {
    const ty_lpv_def* def = job->def;
    const ty_camera_def camera = ty_scene_camera(job->scene);
    frame->job = job;
    frame->context = ty_scene_context(job->scene);
    frame->scene = ty_scene_get_view(job->scene);
    if (frame->scene == NULL) return TY_ERROR_ARGUMENT;
    frame->kernels = TY_BEST_KERNELS(ty_pixels_kernels);
    frame->isa = ty_isa_name(ty_best_isa());
    frame->camera = ty_camera_get_view(&camera, def->width, def->height);
    frame->foggy = job->medium != NULL;
    frame->width = def->width;
    frame->height = def->height;
    frame->samples = def->view != NULL ? 1 : def->spp;
    frame->shrink = def->half ? 2 : 1;
    frame->air_width = (def->width + frame->shrink - 1) / frame->shrink;
    frame->air_height = (def->height + frame->shrink - 1) / frame->shrink;
    frame->upsample.width = frame->air_width;
    frame->upsample.height = frame->air_height;
    frame->first = def->seed != 0 ? (float)(ty_mix64(def->seed) >> 40) * 0x1p-24f : 0;
    frame->progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    const bool looks = frame->foggy && (def->parts & TY_LPV_MARCH) != 0 && job->light.count > 0;
    frame->fog = (ty_fog_request){
        .scene = frame->scene, .medium = job->medium, .look = looks ? &frame->look : NULL, .step = (float)def->step};
    pthread_mutex_init(&frame->lock, NULL);
    ty_lpv_find_weights(frame);
    ty_result result = TY_OK;
    if (looks || (def->parts & TY_LPV_SURFACES) != 0)
        result = ty_look_begin(frame->context, job->light.lattices, job->light.count, &frame->look);
    if (result == TY_OK) result = take_planes(frame);
    if (result == TY_OK) result = create_image(frame);
    return result;
}

static void end_frame(ty_lpv_frame* frame) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    ty_look_end(frame->context, &frame->look);
    ty_free_array(frame->context, frame->distance, kept_pixels(frame), sizeof(float));
    ty_free_array(frame->context, frame->surface, kept_pixels(frame), 3 * sizeof(float));
    ty_free_array(frame->context, frame->hits, pixels, sizeof(float));
    ty_free_array(frame->context, frame->air, kept_rays(frame), sizeof *frame->air);
    pthread_mutex_destroy(&frame->lock);
}

ty_result ty_lpv_image(const ty_lpv_image_job* job, ty_image** out, ty_lpv_stats* stats) {
    ty_lpv_frame frame = {0};
    *out = NULL;
    ty_result result = begin_frame(job, &frame);
    for (int32_t i = 0; i < frame.samples && result == TY_OK; ++i) {
        place_sample(&frame, i);
        result = add_sample(&frame, (double)(i + 1) / frame.samples);
    }
    if (result == TY_OK) {
        ty_parallel_for(frame.context, frame.height, finish_row, &frame);
        if (stats != NULL) finish_stats(&frame, stats);
        *out = frame.image;
    } else {
        ty_image_destroy(frame.image);
    }
    end_frame(&frame);
    return result;
}
