/* The passes of an image over bands of tiles. */
#define _POSIX_C_SOURCE 200809L
#include "method/lpv/image/image.h"

#include "base/context.h"
#include "base/parallel.h"
#include "base/random.k.h"
#include "method/lpv/image/composite.h"
#include "method/lpv/image/media_pass.h"
#include "method/lpv/image/shading.h"
#include "method/lpv/image/visible_surfaces.h"

/* ---- tiles ---- */

typedef void (*tile_fn)(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom);

/* Rows [top, bottom) of the image. */
typedef struct tile_pass {
    ty_lpv_march_state* state;
    tile_fn body;
    const char* stage;
    int32_t top, bottom, columns;
    int64_t tiles;
    _Atomic int64_t finished;
} tile_pass;

static void report(tile_pass* pass) {
    ty_lpv_march_state* state = pass->state;
    if (state->progress.function == NULL || pthread_mutex_trylock(&state->lock) != 0) return;
    const double fraction = (double)atomic_load(&pass->finished) / (double)pass->tiles;
    if (ty_part_show(&state->progress, pass->stage, fraction) != TY_OK) atomic_store(&state->cancelled, true);
    pthread_mutex_unlock(&state->lock);
}

static void run_tile(void* user, int64_t index, int32_t worker) {
    (void)worker;
    tile_pass* pass = user;
    if (atomic_load_explicit(&pass->state->cancelled, memory_order_relaxed)) return;
    const int32_t x = (int32_t)(index % pass->columns) * TY_TILE;
    const int32_t y = pass->top + (int32_t)(index / pass->columns) * TY_TILE;
    const int32_t right = x + TY_TILE < pass->state->width ? x + TY_TILE : pass->state->width;
    const int32_t bottom = y + TY_TILE < pass->bottom ? y + TY_TILE : pass->bottom;
    pass->body(pass->state, x, y, right, bottom);
    atomic_fetch_add(&pass->finished, 1);
    report(pass);
}

/* Runs a pass, which moves the progress to `until`, and adds its time to `seconds`. Errors: TY_CANCELLED. */
static ty_result run_tiles(tile_pass* pass, double until, double* seconds) {
    ty_lpv_march_state* state = pass->state;
    const double begun = ty_wall_seconds();
    if (ty_part_next(&state->progress, pass->stage, until) != TY_OK) return TY_CANCELLED;
    pass->columns = (state->width + TY_TILE - 1) / TY_TILE;
    pass->tiles = (int64_t)pass->columns * ((pass->bottom - pass->top + TY_TILE - 1) / TY_TILE);
    ty_parallel_for(state->context, pass->tiles, run_tile, pass);
    *seconds += ty_wall_seconds() - begun;
    return atomic_load(&state->cancelled) ? TY_CANCELLED : TY_OK;
}

/* Visible surfaces of a tile, their shading, and the media samples in it. */
static void surfaces_and_media_tile(ty_lpv_march_state* state, int32_t x, int32_t y, int32_t right, int32_t bottom) {
    ty_lpv_tile tile;
    const int32_t pixels_per_ray = state->pixels_per_ray, first[2] = {x / pixels_per_ray, y / pixels_per_ray};
    const int32_t end[2] = {(right + pixels_per_ray - 1) / pixels_per_ray,
                            (bottom + pixels_per_ray - 1) / pixels_per_ray};
    int64_t begun = ty_lpv_clock_now();
    ty_lpv_find_visible_surfaces(state, x, y, right, bottom, &tile);
    begun = ty_lpv_clock_add(&state->clocks, TY_CLOCK_VIEW, begun);
    ty_lpv_shade_surfaces(state, &tile);
    begun = ty_lpv_clock_add(&state->clocks, TY_CLOCK_SURFACES, begun);
    if (state->media_samples == NULL) return;
    ty_lpv_ray_march_tile(state, first[0], first[1], end[0], end[1]);
    begun = ty_lpv_clock_add(&state->clocks, TY_CLOCK_MARCH, begun);
    if (state->job->airlight == NULL || (state->job->def->parts & TY_LPV_SINGLE) == 0) return;
    ty_lpv_single_scattering_tile(state, first[0], first[1], end[0], end[1]);
    ty_lpv_clock_add(&state->clocks, TY_CLOCK_SINGLE, begun);
}

/* A golden-ratio lattice over the pixel; a single sample is at the center. */
static void place_sample(ty_lpv_march_state* state, int32_t sample) {
    const float turn = 0.5f + 0.618033989f * (float)sample;
    state->sample = sample;
    state->dx = ((float)sample + 0.5f) / (float)state->samples;
    state->dy = turn - floorf(turn);
}

/* The first row that cannot be composited yet when the media samples of `rows` rows exist, because it needs the row
 * after it. */
static int32_t composable(const ty_lpv_march_state* state, int32_t rows) {
    return rows == state->height || state->pixels_per_ray == 1 ? rows : rows - 1;
}

/* The points of this sample on lights with extent. */
static ty_result place_light_points(ty_lpv_march_state* state) {
    const ty_lpv_def* def = state->job->def;
    ty_light_points_destroy(&state->light_points);
    if (state->job->extended == NULL) return TY_OK;
    return ty_light_points_create(state->context, def->light_samples, def->seed, state->sample, &state->light_points);
}

/* Renders all bands of one sample; until: as in ty_part_next. */
static ty_result add_sample(ty_lpv_march_state* state, double until) {
    static const double surfaces_share = 0.9; /* of the work of a band */
    const double from = state->progress.from + state->progress.span, per_row = (until - from) / state->height;
    ty_result result = place_light_points(state);
    for (int32_t top = 0, composed = 0; top < state->height && result == TY_OK; top += TY_BAND) {
        const int32_t bottom = top + TY_BAND < state->height ? top + TY_BAND : state->height;
        const int32_t next = composable(state, bottom);
        tile_pass see = {.state = state,
                         .body = surfaces_and_media_tile,
                         .stage = "surfaces and media",
                         .top = top,
                         .bottom = bottom};
        tile_pass compose = {
            .state = state, .body = ty_lpv_composite_tile, .stage = "image", .top = composed, .bottom = next};
        result = run_tiles(&see, from + per_row * (top + surfaces_share * (bottom - top)), &state->stats.view_seconds);
        if (result == TY_OK) result = run_tiles(&compose, from + per_row * bottom, &state->stats.compose_seconds);
        composed = next;
    }
    return result;
}

/* ---- statistics ---- */

/* Divides the wall time of the surfaces-and-media pass in proportion to the processor time of its stages. */
static void finish_stats(ty_lpv_march_state* state, ty_lpv_stats* out) {
    double clocks[TY_CLOCK_RAYS], sum = 0;
    for (int i = 0; i < TY_CLOCK_RAYS; ++i) sum += clocks[i] = (double)atomic_load(&state->clocks.nanoseconds[i]);
    const double per_clock = sum > 0 ? state->stats.view_seconds / sum : 0;
    out->view_seconds = clocks[TY_CLOCK_VIEW] * per_clock;
    out->surface_seconds = clocks[TY_CLOCK_SURFACES] * per_clock;
    out->march_seconds = clocks[TY_CLOCK_MARCH] * per_clock;
    out->single_seconds = clocks[TY_CLOCK_SINGLE] * per_clock;
    out->compose_seconds = state->stats.compose_seconds;
    out->rays += atomic_load(&state->rays);
    out->ray_seconds +=
        1e-9 * (double)atomic_load(&state->clocks.nanoseconds[TY_CLOCK_RAYS]) / ty_context_threads(state->context);
    out->marched = atomic_load(&state->marched);
    out->isa = state->isa;
}

/* ---- state ---- */

static size_t band_pixels(const ty_lpv_march_state* state) {
    return (size_t)TY_BAND_ROWS_STORED * (size_t)state->width;
}

static size_t band_rays(const ty_lpv_march_state* state) {
    return (size_t)(TY_BAND_ROWS_STORED / state->pixels_per_ray) * (size_t)state->media_width;
}

static ty_result allocate_bands(ty_lpv_march_state* state) {
    state->distance = ty_alloc_array(state->context, band_pixels(state), sizeof(float), false);
    state->surface = ty_alloc_array(state->context, band_pixels(state), 3 * sizeof(float), false);
    if (state->distance == NULL || state->surface == NULL) return TY_ERROR_MEMORY;
    if (!state->has_media) return TY_OK;
    state->media_samples = ty_alloc_array(state->context, band_rays(state), sizeof *state->media_samples, false);
    state->upsample.media_samples = state->media_samples;
    state->upsample.mask = TY_BAND_ROWS_STORED / state->pixels_per_ray - 1;
    return state->media_samples != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result begin_uncollided(const ty_lpv_image_job* job, ty_lpv_march_state* state) {
    state->uncollided_march = state->ray_march;
    state->uncollided_march.lattices = NULL;
    if (!state->has_media || (job->def->parts & TY_LPV_SINGLE) == 0 || job->light.count == 0 ||
        job->light.lattices[0]->uncollided[0][0] == NULL)
        return TY_OK;
    state->uncollided_march.lattices = &state->uncollided;
    return ty_packed_lattices_create(state->context, job->light.lattices, job->light.count, &state->camera.origin,
                                     &state->uncollided);
}

static ty_result begin_state(const ty_lpv_image_job* job, ty_lpv_march_state* state) {
    const ty_lpv_def* def = job->def;
    const ty_camera_def camera = ty_scene_camera(job->scene);
    state->job = job;
    state->context = ty_scene_context(job->scene);
    state->scene = ty_scene_get_view(job->scene);
    if (state->scene == NULL) return TY_ERROR_ARGUMENT;
    state->kernels = TY_BEST_KERNELS(ty_lpv_image_kernels);
    state->isa = ty_isa_name(ty_best_isa());
    state->camera = ty_camera_get_view(&camera, def->width, def->height);
    state->has_media = job->medium != NULL;
    state->width = def->width;
    state->height = def->height;
    state->samples = def->view != NULL ? 1 : def->spp;
    state->pixels_per_ray = def->half_resolution_march ? 2 : 1;
    state->media_width = (def->width + state->pixels_per_ray - 1) / state->pixels_per_ray;
    state->media_height = (def->height + state->pixels_per_ray - 1) / state->pixels_per_ray;
    state->upsample.width = state->media_width;
    state->upsample.height = state->media_height;
    state->first = def->seed != 0 ? (float)(ty_mix64(def->seed) >> 40) * 0x1p-24f : 0;
    state->progress = ty_part_begin(def->progress, def->progress_user, 0, 0);
    const bool has_lookups = state->has_media && (def->parts & TY_LPV_MARCH) != 0 && job->light.count > 0;
    state->ray_march = (ty_ray_march_request){.scene = state->scene,
                                              .medium = job->medium,
                                              .lattices = has_lookups ? &state->lattices : NULL,
                                              .step = (float)def->step};
    pthread_mutex_init(&state->lock, NULL);
    ty_lpv_find_upsample_weights(state);
    ty_result result = TY_OK;
    if (has_lookups || (def->parts & TY_LPV_SURFACES) != 0)
        result =
            ty_packed_lattices_create(state->context, job->light.lattices, job->light.count, NULL, &state->lattices);
    if (result == TY_OK) result = begin_uncollided(job, state);
    if (result == TY_OK) result = allocate_bands(state);
    if (result == TY_OK)
        result = ty_lpv_output_planes_create(state->context, state->width, state->height, def->aovs, &state->planes);
    return result;
}

static void end_state(ty_lpv_march_state* state) {
    ty_packed_lattices_destroy(state->context, &state->lattices);
    ty_packed_lattices_destroy(state->context, &state->uncollided);
    ty_light_points_destroy(&state->light_points);
    ty_free_array(state->context, state->distance, band_pixels(state), sizeof(float));
    ty_free_array(state->context, state->surface, band_pixels(state), 3 * sizeof(float));
    ty_free_array(state->context, state->media_samples, band_rays(state), sizeof *state->media_samples);
    ty_lpv_output_planes_free(&state->planes);
    pthread_mutex_destroy(&state->lock);
}

ty_result ty_lpv_image(const ty_lpv_image_job* job, ty_image** out, ty_lpv_stats* stats) {
    ty_lpv_march_state state = {0};
    *out = NULL;
    ty_result result = begin_state(job, &state);
    for (int32_t i = 0; i < state.samples && result == TY_OK; ++i) {
        place_sample(&state, i);
        result = add_sample(&state, (double)(i + 1) / state.samples);
    }
    if (result == TY_OK) {
        ty_lpv_output_planes_finish(&state.planes, state.samples);
        finish_stats(&state, stats);
        *out = state.planes.image;
    } else {
        ty_image_destroy(state.planes.image);
    }
    end_state(&state);
    return result;
}
