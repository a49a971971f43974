/* Media sampled onto cells. */
#include "direct/grid_medium.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/aligned.h"
#include "grid/grid.h"
#include "scene/check.h"
#include "scene/medium.h"
#include "scene/phase.k.h"
#include "scene/scene.h"

enum { COVERAGE_SAMPLES = 4, SAMPLES_MAX = 16 };

/* ---- the box ---- */

/* Widens density[3], voxels per metre along the axes, to those of a grid whose index space the world is mapped to. */
/* Cells along the longest side where none are asked for. */
enum { VOXELS_MAX = 256, SMOOTH_CELLS = 64 };

static void widen_density(const float to_index[12], double density[3]) {
    for (int a = 0; a < 3; ++a) {
        double square = 0;
        for (int row = 0; row < 3; ++row) square += pow((double)to_index[4 * row + a], 2);
        density[a] = fmax(density[a], sqrt(square));
    }
}

/* Voxels per metre along the axes, of the finest of a medium's grids; 0 without any. */
static void voxel_density(const ty_medium_view* medium, double density[3]) {
    for (int a = 0; a < 3; ++a) density[a] = 0;
    if (medium->has_grid != 0) widen_density(medium->to_index, density);
    for (int32_t i = 0; i < medium->albedo_fields; ++i) widen_density(medium->albedo[i].to_index, density);
    if (medium->has_g_field != 0) widen_density(medium->g_field.to_index, density);
    if (medium->has_temperature != 0) widen_density(medium->temperature.to_index, density);
}

static void media_extent(const ty_scene* scene, double lower[3], double upper[3]) {
    for (int a = 0; a < 3; ++a) {
        lower[a] = INFINITY;
        upper[a] = -INFINITY;
    }
    for (size_t m = 0; m < scene->medium_count; ++m) ty_medium_extent(&scene->media[m], lower, upper);
}

int32_t ty_grid_box_longest(const ty_scene* scene, int32_t asked) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (asked > 0) return asked;
    for (int32_t m = 0; m < view->medium_count; ++m)
        if (view->media[m].has_grid != 0) return VOXELS_MAX;
    return SMOOTH_CELLS;
}

void ty_grid_box_cut(const ty_grid_box* box, int32_t longest, int32_t size[3]) {
    double most = 0;
    for (int a = 0; a < 3; ++a) most = fmax(most, box->upper[a] - box->lower[a]);
    for (int a = 0; a < 3; ++a) size[a] = (int32_t)fmax(1, lround(longest * (box->upper[a] - box->lower[a]) / most));
}

ty_result ty_grid_box_fit(const ty_scene* scene, int32_t longest, ty_grid_box* out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (view->medium_count == 0) return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there are none");
    ty_result result = ty_check_number(scene->context, "cells: longest", longest, 1, TY_GRID_SIDE_MAX);
    if (result != TY_OK) return result;
    media_extent(scene, out->lower, out->upper);
    double extent = 0, density[3] = {0, 0, 0}, most = 0;
    for (int32_t m = 0; m < view->medium_count; ++m) {
        double of_medium[3];
        voxel_density(&view->media[m], of_medium);
        for (int a = 0; a < 3; ++a) density[a] = fmax(density[a], of_medium[a]);
    }
    for (int a = 0; a < 3; ++a) extent = fmax(extent, out->upper[a] - out->lower[a]);
    for (int a = 0; a < 3; ++a) {
        if (density[a] == 0) density[a] = longest / extent;
        most = fmax(most, density[a] * (out->upper[a] - out->lower[a]));
    }
    for (int a = 0; a < 3; ++a) {
        const double cells = density[a] * (out->upper[a] - out->lower[a]) * fmin(1, longest / most);
        out->size[a] = (int32_t)fmin(longest, fmax(1, ceil(cells * (1 - 1e-5))));
    }
    return TY_OK;
}

static ty_result check_box(ty_context* context, const ty_grid_box* box) {
    ty_result result = ty_check_point(context, "cells: lower", box->lower);
    if (result == TY_OK) result = ty_check_point(context, "cells: upper", box->upper);
    for (int a = 0; a < 3 && result == TY_OK; ++a)
        if (!(box->upper[a] > box->lower[a]) || box->size[a] < 1 || box->size[a] > TY_GRID_SIDE_MAX)
            result = ty_fail(context, TY_ERROR_ARGUMENT, "cells: %d from %g to %g along %c", (int)box->size[a],
                             box->lower[a], box->upper[a], "xyz"[a]);
    return result;
}

/* ---- storage ---- */

static bool alike(const float rgb[3]) {
    return rgb[0] == rgb[1] && rgb[1] == rgb[2];
}

static bool medium_is_gray(const ty_medium_view* medium) {
    if (medium->gray == 0 || !alike(medium->sigma_s) || medium->albedo_fields > 1) return false;
    if (medium->gray_g == 0 && medium->has_g_field == 0) return false;
    for (int32_t i = 0; i < medium->transfer_count && medium->transfer_albedo != 0; ++i)
        if (!alike(medium->transfer[i].albedo)) return false;
    return true;
}

static bool take_planes(ty_grid_medium* medium, float* planes[3], int32_t count) {
    for (int32_t c = 0; c < 3; ++c) {
        planes[c] =
            c < count ? ty_alloc_array(medium->context, medium->cells, sizeof **planes, true) : planes[count - 1];
        if (planes[c] == NULL) return false;
    }
    return true;
}

static void give_planes(const ty_grid_medium* medium, float* const planes[3], int32_t count) {
    for (int32_t c = 0; c < count; ++c) ty_free_array(medium->context, planes[c], medium->cells, sizeof **planes);
}

static ty_result new_medium(ty_context* context, const ty_grid_box* box, int32_t planes, bool emits,
                            ty_grid_medium** out) {
    const size_t cells = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    const double bytes = (double)cells * sizeof(float) * (3 * planes + (emits ? 3 : 0));
    const ty_result result = ty_check_memory(context, bytes, "media on a grid");
    if (result != TY_OK) return result;
    ty_grid_medium* medium = ty_alloc_array(context, 1, sizeof *medium, true);
    if (medium == NULL) return TY_ERROR_MEMORY;
    medium->context = context;
    medium->box = *box;
    medium->cells = cells;
    medium->planes = planes;
    for (int a = 0; a < 3; ++a) medium->cell[a] = (box->upper[a] - box->lower[a]) / box->size[a];
    if (!take_planes(medium, medium->extinction, planes) || !take_planes(medium, medium->scattering, planes) ||
        !take_planes(medium, medium->g, planes) || (emits && !take_planes(medium, medium->emission, 3))) {
        ty_grid_medium_destroy(medium);
        return TY_ERROR_MEMORY;
    }
    *out = medium;
    return TY_OK;
}

void ty_grid_medium_destroy(ty_grid_medium* medium) {
    if (medium == NULL) return;
    give_planes(medium, medium->extinction, medium->planes);
    give_planes(medium, medium->scattering, medium->planes);
    give_planes(medium, medium->g, medium->planes);
    give_planes(medium, medium->emission, 3);
    ty_free_array(medium->context, medium, 1, sizeof *medium);
}

/* ---- sampling ---- */

typedef struct sample_job {
    ty_grid_medium* out;
    const ty_medium_view* medium;
    const ty_grid* coverage; /* NULL: all of each cell */
    int32_t samples[3];      /* along a cell's sides */
    bool even;               /* only_density_varies */
    ty_aligned aligned;      /* where the density's means are had more quickly */
} sample_job;

/* Coefficients at a point, weighted by density and by g where they are for the mean cosine. */
typedef struct cell_sums {
    double extinction[3], scattering[3], turned[3], glow[3];
} cell_sums;

/* Density at a point that is within the bounds; 0 past the last voxels' reach. */
static float density_at(const ty_medium_view* medium, ty_vec point) {
    if (medium->has_grid == 0) return 1.0f;
    const ty_vec p = ty_map_point(medium->to_index, point);
    const int32_t* size = medium->grid.size;
    if (p.x < -1 || p.y < -1 || p.z < -1 || p.x > (float)size[0] || p.y > (float)size[1] || p.z > (float)size[2])
        return 0.0f;
    const float value = ty_grid_value(&medium->grid, p);
    return ty_maxf(
        0.0f, medium->transfer == NULL ? value : ty_transfer_density(medium->transfer, medium->transfer_count, value));
}

static void add_density(const ty_medium_view* medium, ty_vec point, double density, cell_sums* sums) {
    float sigma_s[3], g[3], glow[3] = {0, 0, 0};
    ty_medium_sigma_s(medium, point, sigma_s);
    ty_medium_g(medium, point, g);
    if (medium->emits != 0) ty_medium_emission_coefficient(medium, point, glow);
    for (int c = 0; c < 3; ++c) {
        sums->extinction[c] += density * (double)medium->sigma_t[c];
        sums->scattering[c] += density * (double)sigma_s[c];
        sums->turned[c] += density * (double)(sigma_s[c] * g[c]);
        sums->glow[c] += density * (double)glow[c];
    }
}

/* Whether coefficients at density 1 are the same everywhere. */
static bool only_density_varies(const ty_medium_view* medium) {
    return medium->albedo_fields == 0 && medium->transfer_albedo == 0 && medium->has_g_field == 0 &&
           medium->has_temperature == 0;
}

/* Sums over a cell's points. */
static cell_sums sample_cell(const sample_job* job, const int32_t cell[3]) {
    const ty_grid_medium* out = job->out;
    const int32_t* samples = job->samples;
    cell_sums sums = {0};
    double density = 0;
    ty_vec point = ty_vec_make(0, 0, 0);
    for (int32_t s = 0; s < samples[0] * samples[1] * samples[2]; ++s) {
        const int32_t sub[3] = {s % samples[0], s / samples[0] % samples[1], s / (samples[0] * samples[1])};
        float p[3];
        for (int a = 0; a < 3; ++a)
            p[a] = (float)(out->box.lower[a] + out->cell[a] * (cell[a] + (sub[a] + 0.5) / samples[a]));
        point = ty_vec_load(p);
        density += (double)density_at(job->medium, point);
        if (job->even || !(density > 0)) continue;
        add_density(job->medium, point, density, &sums);
        density = 0;
    }
    if (density > 0) add_density(job->medium, point, density, &sums);
    return sums;
}

/* The share of a cell within the medium's bounds. */
static float covered_share(const sample_job* job, int32_t x, int64_t row) {
    const int32_t* size = job->out->box.size;
    if (job->coverage == NULL) return 1.0f;
    return ty_grid_voxel(job->coverage, x, (int32_t)(row % size[1]), (int32_t)(row / size[1]));
}

/* Adds sums to a cell; g holds scattering times g until the end. */
static void add_sums(const sample_job* job, size_t at, double weight, const cell_sums* sums) {
    ty_grid_medium* out = job->out;
    for (int32_t c = 0; c < out->planes; ++c) {
        out->extinction[c][at] += (float)(weight * sums->extinction[c]);
        out->scattering[c][at] += (float)(weight * sums->scattering[c]);
        out->g[c][at] += (float)(weight * sums->turned[c]);
    }
    for (int32_t c = 0; c < 3 && job->medium->emits != 0; ++c)
        out->emission[c][at] += (float)(4 * (double)TY_PI * weight * sums->glow[c]);
}

/* Adds a medium to one row of cells. */
static void sample_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sample_job* job = user;
    const int32_t* size = job->out->box.size;
    int32_t cell[3] = {0, (int32_t)(index % size[1]), (int32_t)(index / size[1])};
    const double each = 1.0 / (job->samples[0] * job->samples[1] * job->samples[2]);
    const unsigned state = ty_flush_denormals();
    for (cell[0] = 0; cell[0] < size[0]; ++cell[0]) {
        const float covered = covered_share(job, cell[0], index);
        if (!(covered > 0.0f)) continue;
        const cell_sums sums = sample_cell(job, cell);
        add_sums(job, (size_t)index * (size_t)size[0] + (size_t)cell[0], (double)covered * each, &sums);
    }
    ty_restore_denormals(state);
}

/* The same where only density varies, along the axes of cells. */
static void mean_row(void* user, int64_t index, int32_t worker) {
    const sample_job* job = user;
    const int32_t* size = job->out->box.size;
    const unsigned state = ty_flush_denormals();
    const float* density = ty_aligned_row(&job->aligned, job->out, job->medium, (int32_t)(index % size[1]),
                                          (int32_t)(index / size[1]), worker);
    cell_sums sums = {0}; /* at density 1 */
    add_density(job->medium, ty_vec_make(0, 0, 0), 1, &sums);
    for (int32_t x = 0; x < size[0]; ++x)
        if (density[x] > 0.0f)
            add_sums(job, (size_t)index * (size_t)size[0] + (size_t)x,
                     (double)(density[x] * covered_share(job, x, index)), &sums);
    ty_restore_denormals(state);
}

/* Whether all of the cells are within a medium's bounds, by a box whose axes are theirs. */
static bool covers_all(const ty_scene* scene, int32_t index, const ty_grid_medium* out) {
    const ty_medium_view* medium = &ty_scene_get_view(scene)->media[index];
    if (medium->bounds == TY_BOUNDED_NOT) return true;
    if (medium->bounds != TY_BOUNDED_BOX) return false;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    ty_medium_extent(&scene->media[index], lower, upper);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            if (row != column && medium->to_bounds[4 * row + column] != 0) return false;
        const double slack = 1e-5 * out->cell[row];
        if (out->box.lower[row] < lower[row] - slack || out->box.upper[row] > upper[row] + slack) return false;
    }
    return true;
}

static ty_result add_medium(const ty_scene* scene, int32_t index, ty_grid_medium* out) {
    const ty_medium_view* medium = &ty_scene_get_view(scene)->media[index];
    sample_job job = {.out = out, .medium = medium, .even = only_density_varies(medium)};
    double density[3];
    ty_grid* coverage = NULL;
    if (!covers_all(scene, index, out)) {
        const ty_result covered = ty_medium_coverage(scene, index, out->box.lower, out->box.upper, out->box.size,
                                                     COVERAGE_SAMPLES, &coverage);
        if (covered != TY_OK) return covered;
    }
    job.coverage = coverage;
    voxel_density(medium, density);
    for (int a = 0; a < 3; ++a)
        job.samples[a] = (int32_t)fmin(SAMPLES_MAX, fmax(1, ceil(2 * density[a] * out->cell[a] * (1 - 1e-5))));
    const ty_result result = job.even ? ty_aligned_create(out, medium, job.samples, &job.aligned) : TY_OK;
    if (result == TY_OK)
        ty_parallel_for(out->context, (int64_t)out->box.size[1] * out->box.size[2],
                        job.aligned.cells[0] != NULL ? mean_row : sample_row, &job);
    ty_aligned_destroy(out, &job.aligned);
    ty_grid_destroy(coverage);
    return result;
}

/* From scattering times g to g. */
static void divide_g(ty_grid_medium* medium) {
    for (int32_t c = 0; c < medium->planes; ++c)
        for (size_t i = 0; i < medium->cells; ++i)
            medium->g[c][i] =
                medium->scattering[c][i] > 0 ? ty_clampf(medium->g[c][i] / medium->scattering[c][i], -1, 1) : 0;
}

ty_result ty_grid_medium_create(const ty_scene* scene, const ty_grid_box* box, ty_grid_medium** out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    ty_result result = check_box(scene->context, box);
    if (result != TY_OK) return result;
    bool gray = true, emits = false;
    for (int32_t m = 0; m < view->medium_count; ++m) {
        gray = gray && medium_is_gray(&view->media[m]);
        emits = emits || view->media[m].emits != 0;
    }
    ty_grid_medium* medium = NULL;
    result = new_medium(scene->context, box, gray ? 1 : 3, emits, &medium);
    for (int32_t m = 0; m < view->medium_count && result == TY_OK; ++m) result = add_medium(scene, m, medium);
    if (result != TY_OK) {
        ty_grid_medium_destroy(medium);
        return result;
    }
    divide_g(medium);
    *out = medium;
    return TY_OK;
}

/* ---- other cells ---- */

/* g goes through the mean of scattering times g. */
static ty_result resize_g(const ty_grid_medium* from, ty_grid_medium* to) {
    float* turned = ty_alloc_array(from->context, from->cells, sizeof *turned, false);
    if (turned == NULL) return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < from->planes; ++c) {
        for (size_t i = 0; i < from->cells; ++i) turned[i] = from->g[c][i] * from->scattering[c][i];
        ty_grid_average(from->context, turned, from->box.size, to->box.size, to->g[c]);
    }
    ty_free_array(from->context, turned, from->cells, sizeof *turned);
    divide_g(to);
    return TY_OK;
}

ty_result ty_grid_medium_resize(const ty_grid_medium* medium, const int32_t size[3], ty_grid_medium** out) {
    ty_grid_box box = medium->box;
    memcpy(box.size, size, sizeof box.size);
    ty_result result = check_box(medium->context, &box);
    if (result != TY_OK) return result;
    ty_grid_medium* to = NULL;
    result = new_medium(medium->context, &box, medium->planes, medium->emission[0] != NULL, &to);
    if (result != TY_OK) return result;
    for (int32_t c = 0; c < medium->planes; ++c) {
        ty_grid_average(medium->context, medium->extinction[c], medium->box.size, size, to->extinction[c]);
        ty_grid_average(medium->context, medium->scattering[c], medium->box.size, size, to->scattering[c]);
    }
    for (int32_t c = 0; c < 3 && to->emission[c] != NULL; ++c)
        ty_grid_average(medium->context, medium->emission[c], medium->box.size, size, to->emission[c]);
    result = resize_g(medium, to);
    if (result != TY_OK) {
        ty_grid_medium_destroy(to);
        return result;
    }
    *out = to;
    return TY_OK;
}

enum { REDUCED_AT_ONCE = 1 << 10 };

typedef struct reduction {
    const ty_grid_medium* medium;
    int32_t order;
    float share; /* times g^order */
    float* const* planes;
} reduction;

static void reduce_some(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const reduction* job = user;
    const ty_grid_medium* medium = job->medium;
    const size_t begin = (size_t)index * REDUCED_AT_ONCE, left = medium->cells - begin;
    const size_t count = left < REDUCED_AT_ONCE ? left : REDUCED_AT_ONCE;
    float forward[REDUCED_AT_ONCE];
    for (int32_t c = 0; c < medium->planes; ++c) {
        const float *g = medium->g[c] + begin, *scattering = medium->scattering[c] + begin;
        const float* extinction = medium->extinction[c] + begin;
        for (size_t i = 0; i < count; ++i) forward[i] = job->share * scattering[i];
        for (int32_t l = 0; l < job->order; ++l)
            for (size_t i = 0; i < count; ++i) forward[i] *= g[i];
        for (size_t i = 0; i < count; ++i) job->planes[c][begin + i] = ty_maxf(0, extinction[i] - forward[i]);
    }
}

static void reduce(reduction job) {
    const size_t chunks = (job.medium->cells + REDUCED_AT_ONCE - 1) / REDUCED_AT_ONCE;
    ty_parallel_for(job.medium->context, (int64_t)chunks, reduce_some, &job);
}

void ty_grid_medium_reduce(const ty_grid_medium* medium, int32_t order, float* const planes[3]) {
    reduce((reduction){medium, order, 1, planes});
}

void ty_grid_medium_reduce_by(const ty_grid_medium* medium, float share, float* const planes[3]) {
    reduce((reduction){medium, 0, share, planes});
}
