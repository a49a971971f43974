/* Light cache of the media: the layout of its cells, and filling them. */
#include "base/context.h"
#include "base/progress.h"
#include "bake/cache/cache.h"
#include "scene/media/medium.h"
#include "scene/scene.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { BLOCK = 8, CHUNK_FIRST = 64 };
/* Bytes of one surfel. The memory estimate assumes SURFELS_TYPICAL * (cells per side)^2 surfels: six faces of the
 * lattice, and as many inside. */
enum { SURFEL_BYTES = TY_SURFEL_FLOATS * (int)sizeof(float), SURFELS_TYPICAL = 12 };

static const double chunk_seconds = 0.1;
/* Fraction of the filling time spent on cells; surfels take the rest. */
static const double cells_fraction = 0.75;
/* Seed offset that separates the random numbers of cells from those of receivers. */
static const uint64_t seed_salt = 0x9d8f3c5a1b7e2460u;

/* ---- layout ---- */

/* The bounding box of the media, clipped where it is farther from all surfaces than the surfaces extend: light out
 * there is negligible. */
static void find_box(const ty_scene* scene, double lower[3], double upper[3]) {
    double scene_lower[3], scene_upper[3], side = 0;
    for (int a = 0; a < 3; ++a) {
        lower[a] = INFINITY;
        upper[a] = -INFINITY;
    }
    for (size_t m = 0; m < scene->medium_count; ++m) ty_medium_extent(&scene->media[m], lower, upper);
    ty_scene_surface_extent(scene, scene_lower, scene_upper);
    for (int a = 0; a < 3; ++a) side = fmax(side, scene_upper[a] - scene_lower[a]);
    if (!(side > 0)) return;
    for (int a = 0; a < 3; ++a) {
        const double from = fmax(lower[a], scene_lower[a] - side), to = fmin(upper[a], scene_upper[a] + side);
        if (!(from < to)) continue;
        lower[a] = from;
        upper[a] = to;
    }
}

/* True if any medium scatters anisotropically, so that cells must store a mean direction. */
static bool is_anisotropic(const ty_scene_view* view) {
    for (int32_t m = 0; m < view->medium_count; ++m) {
        const ty_medium_view* medium = &view->media[m];
        if (medium->has_g_field != 0 || medium->g[0] != 0 || medium->g[1] != 0 || medium->g[2] != 0) return true;
    }
    return false;
}

static bool is_gray_color(const float v[3]) {
    return v[0] == v[1] && v[0] == v[2];
}

bool ty_bake_is_gray(const ty_medium_view* medium) {
    return medium->gray != 0 && medium->gray_g != 0 && is_gray_color(medium->sigma_s) && medium->albedo_fields < 3 &&
           medium->transfer_albedo == 0;
}

static bool is_colored(const ty_scene_view* view) {
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (!ty_bake_is_gray(&view->media[m])) return true;
    return false;
}

/* media: those of non-zero density. */
static void lay_out(const ty_scene* scene, const ty_bake_def* def, const ty_scene_view* media, ty_cache_view* view,
                    ty_bake_cache_info* info) {
    double lower[3], upper[3], side = 0;
    const int32_t longest = def->cells;
    view->floats = !is_anisotropic(media) ? TY_CACHE_ISOTROPIC : is_colored(media) ? TY_CACHE_COLORED : TY_CACHE_GRAY;
    info->bytes = (double)(TY_CACHE_SIDES * (TY_CACHE_KINDS * view->floats + 3)) * sizeof(float) + 6;
    find_box(scene, lower, upper);
    for (int a = 0; a < 3; ++a) side = fmax(side, upper[a] - lower[a]);
    const double cell = side / longest;
    info->cell = cell;
    view->per_metre = (float)(1 / cell);
    for (int a = 0; a < 3; ++a) {
        const int32_t count = (int32_t)fmax(1, ceil((upper[a] - lower[a]) / cell - 1e-6));
        info->size[a] = view->size[a] = count;
        info->bytes *= count;
        view->lower[a] = (float)(0.5 * (lower[a] + upper[a] - cell * count));
    }
    const double cells = (double)info->size[0] * info->size[1] * info->size[2];
    info->bytes += fmin(cells, SURFELS_TYPICAL * cbrt(cells) * cbrt(cells)) * (double)SURFEL_BYTES;
}

/* ---- scattering regions ---- */

static bool scatters(const ty_medium_view* medium) {
    return medium->albedo_fields > 0 || medium->transfer_albedo != 0 || medium->sigma_s[0] > 0 ||
           medium->sigma_s[1] > 0 || medium->sigma_s[2] > 0;
}

/* The range of grid bricks of a medium that a world-space box may touch; false: none. */
static bool find_bricks(const ty_medium_view* medium, ty_vec box_lower, ty_vec box_upper, int32_t first[3],
                        int32_t last[3]) {
    float from[3] = {INFINITY, INFINITY, INFINITY}, to[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; ++corner) {
        const ty_vec p = ty_map_point(medium->to_index, ty_vec_make((corner & 1) != 0 ? box_upper.x : box_lower.x,
                                                                    (corner & 2) != 0 ? box_upper.y : box_lower.y,
                                                                    (corner & 4) != 0 ? box_upper.z : box_lower.z));
        const float at[3] = {p.x, p.y, p.z};
        for (int a = 0; a < 3; ++a) {
            from[a] = fminf(from[a], at[a]);
            to[a] = fmaxf(to[a], at[a]);
        }
    }
    for (int a = 0; a < 3; ++a) {
        const int32_t count = medium->grid.bricks[a];
        if (to[a] < -1 || from[a] > (float)medium->grid.size[a]) return false;
        first[a] = (int32_t)fmaxf(0, floorf((from[a] + 1) / (float)TY_BRICK));
        last[a] = (int32_t)fminf((float)(count - 1), floorf((to[a] + 1) / (float)TY_BRICK));
    }
    return true;
}

/* True if points that look up the light of a cell, those in it and in its neighbours, may lie in a scattering medium.
 */
static bool may_scatter(const ty_medium_view* medium, ty_vec box_lower, ty_vec box_upper) {
    int32_t first[3], last[3];
    if (!scatters(medium)) return false;
    if (medium->has_grid == 0) return true;
    if (!find_bricks(medium, box_lower, box_upper, first, last)) return false;
    const int32_t* bricks = medium->grid.bricks;
    for (int32_t k = first[2]; k <= last[2]; ++k)
        for (int32_t j = first[1]; j <= last[1]; ++j)
            for (int32_t i = first[0]; i <= last[0]; ++i) {
                const size_t at = (size_t)i + (size_t)bricks[0] * ((size_t)j + (size_t)bricks[1] * (size_t)k);
                if (medium->extremes[2 * at + 1] > 0) return true;
            }
    return false;
}

/* Lists the cells to fill; the others are dark and never occlude. */
static int64_t list_cells(ty_bake_cache* cache, const ty_scene_view* scene, int32_t* cells) {
    const ty_cache_view* view = &cache->view;
    const float metres = 1 / view->per_metre;
    int64_t count = 0;
    for (size_t i = 0; i < cache->cells; ++i) {
        const size_t x = i % (size_t)view->size[0], y = i / (size_t)view->size[0] % (size_t)view->size[1],
                     z = i / ((size_t)view->size[0] * (size_t)view->size[1]);
        const ty_vec box_lower =
            ty_vec_make(view->lower[0] + metres * ((float)x - 1), view->lower[1] + metres * ((float)y - 1),
                        view->lower[2] + metres * ((float)z - 1));
        const ty_vec box_upper =
            ty_vec_make(box_lower.x + 3 * metres, box_lower.y + 3 * metres, box_lower.z + 3 * metres);
        bool fills = false;
        for (int32_t m = 0; m < scene->medium_count && !fills; ++m)
            fills = may_scatter(&scene->media[m], box_lower, box_upper);
        if (fills) {
            cells[count++] = (int32_t)i;
            continue;
        }
        float* anchor = view->anchor + i * (3 * TY_CACHE_SIDES);
        anchor[0] = box_lower.x + 1.5f * metres;
        anchor[1] = box_lower.y + 1.5f * metres;
        anchor[2] = box_lower.z + 1.5f * metres;
        cache->flags[i] = 1;
    }
    return count;
}

/* ---- filling ---- */

typedef struct fill {
    ty_cache_request request;
    ty_cache_kernel kernel;
    uint8_t* flags;
    int64_t begin, end; /* cells of this chunk */
    _Atomic uint64_t rays;
} fill;

static void fill_block(void* user, int64_t block, int32_t worker) {
    (void)worker;
    fill* f = user;
    const int64_t begin = f->begin + block * BLOCK, end = begin + BLOCK < f->end ? begin + BLOCK : f->end;
    f->rays += f->kernel(&f->request, begin, end, f->flags);
}

static bool report(const ty_bake_def* def, double seconds, double fraction) {
    const ty_progress progress = ty_progress_at("fog", fraction, seconds);
    return def->progress == NULL || def->progress(def->progress_user, &progress);
}

/* Runs the kernel on the first `count` entries of the request; from, to: range of the overall progress. */
static ty_result fill_all_of(ty_bake_cache* cache, const ty_bake_def* def, fill* f, int64_t count, double from,
                             double to) {
    const double begun = ty_wall_seconds(), before = cache->info.seconds;
    int64_t chunk = CHUNK_FIRST;
    f->rays = 0;
    for (int64_t at = 0; at < count;) {
        const double start = ty_wall_seconds();
        f->begin = at;
        f->end = at + chunk < count ? at + chunk : count;
        ty_parallel_for(cache->context, (f->end - f->begin + BLOCK - 1) / BLOCK, fill_block, f);
        const double now = ty_wall_seconds();
        at = f->end;
        if (now - start < 0.5 * chunk_seconds) chunk *= 2;
        if (now - start > 2 * chunk_seconds && chunk > CHUNK_FIRST) chunk /= 2;
        cache->info.seconds = before + now - begun;
        const double fraction = from + (to - from) * (double)at / (double)count;
        if (!report(def, cache->info.seconds, fraction)) return TY_CANCELLED;
    }
    cache->info.paths += count * f->request.paths;
    cache->info.rays += (int64_t)f->rays;
    return TY_OK;
}

/* Assigns surfel indices to the cells in which paths hit surfaces. Moves these cells to the front of `cells` and
 * returns their count. */
static int64_t list_surfels(ty_bake_cache* cache, const _Atomic uint8_t* surface_axes, int32_t* cells) {
    int64_t count = 0;
    for (size_t i = 0; i < cache->cells; ++i) {
        cache->surfel_axes[i] = surface_axes[i];
        cache->first_surfel[i] = (int32_t)cache->surfels;
        cache->surfels += (size_t)__builtin_popcount(cache->surfel_axes[i]);
        if (cache->surfel_axes[i] != 0) cells[count++] = (int32_t)i;
    }
    return count;
}

/* Fills the surfels of all cells. */
static ty_result fill_surfels(ty_bake_cache* cache, const ty_bake_run* run, fill* f, int32_t* cells) {
    ty_bake_request bake = run->request;
    ty_cache_view* view = &cache->view;
    const int64_t count = list_surfels(cache, f->request.surface_axes, cells);
    if (count == 0) return TY_OK;
    const double bytes = (double)cache->surfels * (double)SURFEL_BYTES;
    const ty_result result = ty_check_memory(cache->context, bytes, "light in media");
    if (result != TY_OK) return result;
    view->surfels = ty_alloc_array(cache->context, cache->surfels, SURFEL_BYTES, true);
    if (view->surfels == NULL) return TY_ERROR_MEMORY;
    bake.cache = *view;
    bake.terms = TY_BAKE_SURFACE_TERMS;
    view->surfel_axes = cache->surfel_axes;
    view->first_surfel = cache->first_surfel;
    f->request.view = *view;
    f->request.bake = &bake;
    f->kernel = TY_BEST_KERNELS(ty_surfel_kernel);
    return fill_all_of(cache, run->def, f, count, cells_fraction, 1);
}

/* ---- cache lifetime ---- */

static ty_result allocate_cells(ty_bake_cache* cache) {
    ty_cache_view* view = &cache->view;
    const size_t floats = (size_t)(TY_CACHE_KINDS * view->floats);
    cache->cells = (size_t)view->size[0] * (size_t)view->size[1] * (size_t)view->size[2];
    ty_result result = ty_check_memory(cache->context, cache->info.bytes, "light in media");
    if (result != TY_OK) return result;
    view->light = ty_alloc_array(cache->context, cache->cells, floats * sizeof(float), true);
    view->second_light = ty_alloc_array(cache->context, cache->cells, floats * sizeof(float), true);
    view->anchor = ty_alloc_array(cache->context, cache->cells, 3 * TY_CACHE_SIDES * sizeof(float), true);
    view->flags = cache->flags = ty_alloc_array(cache->context, cache->cells, 1, true);
    cache->surfel_axes = ty_alloc_array(cache->context, cache->cells, 1, false);
    cache->first_surfel = ty_alloc_array(cache->context, cache->cells, sizeof *cache->first_surfel, false);
    const bool all = view->light != NULL && view->second_light != NULL && view->anchor != NULL &&
                     cache->flags != NULL && cache->surfel_axes != NULL && cache->first_surfel != NULL;
    return all ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result fill_both(ty_bake_cache* cache, const ty_bake_run* run, fill* f, int32_t* cells) {
    const int64_t count = list_cells(cache, &run->path.view, cells);
    f->request.cells = cells;
    ty_result result = fill_all_of(cache, run->def, f, count, 0, cells_fraction);
    cache->info.filled = count;
    if (result == TY_OK) result = ty_cache_find_visibility(cache, run->path.view.mesh);
    return result == TY_OK && run->path.view.mesh != NULL ? fill_surfels(cache, run, f, cells) : result;
}

static ty_result fill_all(ty_bake_cache* cache, const ty_bake_run* run) {
    fill f = {.kernel = TY_BEST_KERNELS(ty_cache_kernel), .flags = cache->flags};
    f.request = (ty_cache_request){.path = run->request.path, .view = cache->view};
    f.request.path.seed ^= seed_salt;
    f.request.path.enclosed = ty_enclosed_fields(cache->enclosed);
    f.request.paths = (uint32_t)run->def->cell_paths;
    f.request.surface_axes = ty_alloc_array(cache->context, cache->cells, sizeof *f.request.surface_axes, true);
    int32_t* cells = ty_alloc_array(cache->context, cache->cells, sizeof *cells, false);
    const ty_result result =
        cells != NULL && f.request.surface_axes != NULL ? fill_both(cache, run, &f, cells) : TY_ERROR_MEMORY;
    ty_free_array(cache->context, cells, cache->cells, sizeof *cells);
    ty_free_array(cache->context, f.request.surface_axes, cache->cells, sizeof *f.request.surface_axes);
    return result;
}

ty_result ty_bake_cache_make(const ty_bake_run* run, const ty_scene* scene, ty_bake_cache** out) {
    *out = NULL;
    ty_bake_cache* cache = ty_alloc_array(run->context, 1, sizeof *cache, true);
    if (cache == NULL) return TY_ERROR_MEMORY;
    cache->context = run->context;
    ty_result result = ty_bake_solve_enclosed(run, scene, &cache->enclosed);
    if (result == TY_OK && run->path.view.medium_count > 0) {
        lay_out(scene, run->def, &run->path.view, &cache->view, &cache->info);
        result = allocate_cells(cache);
        if (result == TY_OK) result = fill_all(cache, run);
    }
    if (result == TY_OK)
        *out = cache;
    else
        ty_bake_cache_destroy(cache);
    return result;
}

ty_result ty_bake_cache_estimate(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache_info* out) {
    ty_cache_view view;
    const ty_scene_view* media = ty_scene_get_view(scene);
    *out = (ty_bake_cache_info){.cell = 0};
    if (media == NULL) return TY_ERROR_ARGUMENT;
    ty_bake_def known;
    const ty_result result = ty_bake_take_def(ty_scene_context(scene), def, &known);
    if (result == TY_OK && media->medium_count > 0) lay_out(scene, &known, media, &view, out);
    return result;
}

void ty_bake_cache_destroy(ty_bake_cache* cache) {
    if (cache == NULL) return;
    ty_enclosed_destroy(cache->enclosed);
    const size_t floats = (size_t)(TY_CACHE_KINDS * cache->view.floats) * sizeof(float);
    ty_free_array(cache->context, cache->view.light, cache->cells, floats);
    ty_free_array(cache->context, cache->view.second_light, cache->cells, floats);
    ty_free_array(cache->context, cache->view.anchor, cache->cells, 3 * TY_CACHE_SIDES * sizeof(float));
    ty_free_array(cache->context, cache->flags, cache->cells, 1);
    ty_free_array(cache->context, cache->surfel_axes, cache->cells, 1);
    ty_free_array(cache->context, cache->first_surfel, cache->cells, sizeof *cache->first_surfel);
    if (cache->view.surfels != NULL) ty_free_array(cache->context, cache->view.surfels, cache->surfels, SURFEL_BYTES);
    ty_free_array(cache->context, cache, 1, sizeof *cache);
}

ty_bake_cache_info ty_bake_cache_get_info(const ty_bake_cache* cache) {
    return cache->info;
}
