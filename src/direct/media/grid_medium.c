/* Media sampled onto cells. */
#include "direct/media/grid_medium.h"

#include "base/context.h"
#include "base/mapping.h"
#include "base/float_mode.h"
#include "direct/media/aligned.h"
#include "grid/grid.h"
#include "base/check.h"
#include "scene/media/medium.h"
#include "scene/media/phase.k.h"
#include "scene/scene.h"

enum { COVERAGE_SAMPLES = 4, SAMPLES_MAX = 16 };

/* ---- the box ---- */

/* Cells along the longest side by default, with and without voxels. */
enum { VOXELS_MAX = 256, SMOOTH_CELLS = 64 };

/* Raises density[3], voxels per metre along the world's axes, to at least that of a grid with this transform. */
static void raise_density(const float to_index[12], double density[3]) {
    for (int a = 0; a < 3; ++a) {
        double square = 0;
        for (int row = 0; row < 3; ++row) square += pow((double)to_index[4 * row + a], 2);
        density[a] = fmax(density[a], sqrt(square));
    }
}

/* Voxels per metre along the axes of the finest of a medium's grids; 0 without grids. */
static void voxel_density(const ty_medium_view* medium, double density[3]) {
    for (int a = 0; a < 3; ++a) density[a] = 0;
    if (medium->has_grid != 0) raise_density(medium->to_index, density);
    for (int32_t i = 0; i < medium->albedo_fields; ++i) raise_density(medium->albedo[i].to_index, density);
    if (medium->has_g_field != 0) raise_density(medium->g_field.to_index, density);
    if (medium->has_temperature != 0) raise_density(medium->temperature.to_index, density);
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
    double max_extent = 0;
    for (int a = 0; a < 3; ++a) max_extent = fmax(max_extent, box->upper[a] - box->lower[a]);
    for (int a = 0; a < 3; ++a)
        size[a] = (int32_t)fmax(1, lround(longest * (box->upper[a] - box->lower[a]) / max_extent));
}

ty_result ty_grid_box_fit(const ty_scene* scene, int32_t longest, ty_grid_box* out) {
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (view->medium_count == 0) return ty_fail(scene->context, TY_ERROR_ARGUMENT, "media: there are none");
    ty_result result = ty_check_number(scene->context, "cells: longest", longest, 1, TY_GRID_SIDE_MAX);
    if (result != TY_OK) return result;
    media_extent(scene, out->lower, out->upper);
    for (int a = 0; a < 3; ++a) {
        if ((view->periodic.axes >> a & 1) == 0) continue;
        out->lower[a] = (double)view->periodic.lower[a];
        out->upper[a] = (double)view->periodic.upper[a];
    }
    double extent = 0, density[3] = {0, 0, 0}, max_extent = 0;
    for (int32_t m = 0; m < view->medium_count; ++m) {
        double of_medium[3];
        voxel_density(&view->media[m], of_medium);
        for (int a = 0; a < 3; ++a) density[a] = fmax(density[a], of_medium[a]);
    }
    for (int a = 0; a < 3; ++a) extent = fmax(extent, out->upper[a] - out->lower[a]);
    for (int a = 0; a < 3; ++a) {
        if (density[a] == 0) density[a] = longest / extent;
        max_extent = fmax(max_extent, density[a] * (out->upper[a] - out->lower[a]));
    }
    for (int a = 0; a < 3; ++a) {
        const double cells = density[a] * (out->upper[a] - out->lower[a]) * fmin(1, longest / max_extent);
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

static bool is_gray_color(const float rgb[3]) {
    return rgb[0] == rgb[1] && rgb[1] == rgb[2];
}

static bool medium_is_gray(const ty_medium_view* medium) {
    if (medium->gray == 0 || !is_gray_color(medium->sigma_s) || medium->albedo_fields > 1) return false;
    if (medium->gray_g == 0 && medium->has_g_field == 0) return false;
    for (int32_t i = 0; i < medium->transfer_count && medium->transfer_albedo != 0; ++i)
        if (!is_gray_color(medium->transfer[i].albedo)) return false;
    return true;
}

static bool allocate_planes(ty_grid_medium* medium, float* planes[3], int32_t count) {
    for (int32_t c = 0; c < 3; ++c) {
        planes[c] =
            c < count ? ty_alloc_large(medium->context, medium->cells, sizeof **planes, true) : planes[count - 1];
        if (planes[c] == NULL) return false;
    }
    return true;
}

static void free_planes(const ty_grid_medium* medium, float* const planes[3], int32_t count) {
    for (int32_t c = 0; c < count; ++c) ty_free_large(medium->context, planes[c], medium->cells, sizeof **planes);
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
    if (!allocate_planes(medium, medium->extinction, planes) || !allocate_planes(medium, medium->scattering, planes) ||
        !allocate_planes(medium, medium->g, planes) || (emits && !allocate_planes(medium, medium->emission, 3))) {
        ty_grid_medium_destroy(medium);
        return TY_ERROR_MEMORY;
    }
    *out = medium;
    return TY_OK;
}

void ty_grid_medium_destroy(ty_grid_medium* medium) {
    if (medium == NULL) return;
    free_planes(medium, medium->extinction, medium->planes);
    free_planes(medium, medium->scattering, medium->planes);
    free_planes(medium, medium->g, medium->planes);
    free_planes(medium, medium->emission, 3);
    ty_free_array(medium->context, medium, 1, sizeof *medium);
}

/* ---- sampling ---- */

typedef struct sample_job {
    ty_grid_medium* out;
    const ty_medium_view* medium;
    const ty_grid* coverage; /* fraction of each cell within the bounds; NULL: 1 */
    int32_t samples[3];      /* points along a cell's sides */
    bool only_density;       /* coefficients vary by density alone */
    ty_aligned aligned;      /* separable means of the density where its cells are not NULL */
} sample_job;

/* Coefficients at a point, weighted by density; scattering_g is sigma_s g. */
typedef struct cell_sums {
    double extinction[3], scattering[3], scattering_g[3], emission[3];
} cell_sums;

/* Density at a point within the bounds; 0 beyond the reach of the outer voxels. */
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
    float sigma_s[3], g[3], emission[3] = {0, 0, 0};
    ty_medium_sigma_s(medium, point, sigma_s);
    ty_medium_g(medium, point, g);
    if (medium->emits != 0) ty_medium_emission_coefficient(medium, point, emission);
    for (int c = 0; c < 3; ++c) {
        sums->extinction[c] += density * (double)medium->sigma_t[c];
        sums->scattering[c] += density * (double)sigma_s[c];
        sums->scattering_g[c] += density * (double)(sigma_s[c] * g[c]);
        sums->emission[c] += density * (double)emission[c];
    }
}

/* True if coefficients at density 1 are constant in space. */
static bool only_density_varies(const ty_medium_view* medium) {
    return medium->albedo_fields == 0 && medium->transfer_albedo == 0 && medium->has_g_field == 0 &&
           medium->has_temperature == 0;
}

/* Sums over a cell's sample points. */
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
        if (job->only_density || !(density > 0)) continue;
        add_density(job->medium, point, density, &sums);
        density = 0;
    }
    if (density > 0) add_density(job->medium, point, density, &sums);
    return sums;
}

/* The fraction of a cell within the medium's bounds. */
static float covered_fraction(const sample_job* job, int32_t x, int64_t row) {
    const int32_t* size = job->out->box.size;
    if (job->coverage == NULL) return 1.0f;
    return ty_grid_voxel(job->coverage, x, (int32_t)(row % size[1]), (int32_t)(row / size[1]));
}

/* Adds sums to a cell; g holds sigma_s g until divide_g. */
static void add_sums(const sample_job* job, size_t at, double weight, const cell_sums* sums) {
    ty_grid_medium* out = job->out;
    for (int32_t c = 0; c < out->planes; ++c) {
        out->extinction[c][at] += (float)(weight * sums->extinction[c]);
        out->scattering[c][at] += (float)(weight * sums->scattering[c]);
        out->g[c][at] += (float)(weight * sums->scattering_g[c]);
    }
    for (int32_t c = 0; c < 3 && job->medium->emits != 0; ++c)
        out->emission[c][at] += (float)(4 * (double)TY_PI * weight * sums->emission[c]);
}

/* Adds a medium to one row of cells by point samples. */
static void sample_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const sample_job* job = user;
    const int32_t* size = job->out->box.size;
    int32_t cell[3] = {0, (int32_t)(index % size[1]), (int32_t)(index / size[1])};
    const double each = 1.0 / (job->samples[0] * job->samples[1] * job->samples[2]);
    const unsigned state = ty_flush_denormals();
    for (cell[0] = 0; cell[0] < size[0]; ++cell[0]) {
        const float covered = covered_fraction(job, cell[0], index);
        if (!(covered > 0.0f)) continue;
        const cell_sums sums = sample_cell(job, cell);
        add_sums(job, (size_t)index * (size_t)size[0] + (size_t)cell[0], (double)covered * each, &sums);
    }
    ty_restore_denormals(state);
}

/* Adds a medium of which only the density varies to one row of cells, by separable means. */
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
                     (double)(density[x] * covered_fraction(job, x, index)), &sums);
    ty_restore_denormals(state);
}

/* True if all cells lie within a medium's bounds, for boxes with the axes of the cells. */
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

/* The fraction of each cell within a medium's bounds, and how its cells are sampled. The caller releases the coverage
 * and destroys job->aligned, also after an error. medium: its view, or one with other coefficients. */
static ty_result begin_medium(const ty_scene* scene, int32_t index, const ty_medium_view* medium, ty_grid_medium* out,
                              sample_job* job, ty_grid** coverage) {
    *job = (sample_job){.out = out, .medium = medium, .only_density = only_density_varies(medium)};
    *coverage = NULL;
    if (!covers_all(scene, index, out)) {
        const ty_result covered = ty_medium_create_coverage(scene, index, out->box.lower, out->box.upper, out->box.size,
                                                            COVERAGE_SAMPLES, coverage);
        if (covered != TY_OK) return covered;
    }
    double density[3];
    job->coverage = *coverage;
    voxel_density(medium, density);
    for (int a = 0; a < 3; ++a)
        job->samples[a] = (int32_t)fmin(SAMPLES_MAX, fmax(1, ceil(2 * density[a] * out->cell[a] * (1 - 1e-5))));
    return job->only_density ? ty_aligned_create(out, medium, job->samples, &job->aligned) : TY_OK;
}

static ty_result add_medium(const ty_scene* scene, int32_t index, const ty_medium_view* medium, ty_grid_medium* out) {
    sample_job job;
    ty_grid* coverage;
    const ty_result result = begin_medium(scene, index, medium, out, &job, &coverage);
    if (result == TY_OK)
        ty_parallel_for(out->context, (int64_t)out->box.size[1] * out->box.size[2],
                        job.aligned.cells[0] != NULL ? mean_row : sample_row, &job);
    ty_aligned_destroy(out, &job.aligned);
    ty_grid_release(coverage);
    return result;
}

/* Replaces sigma_s g by g. */
static void divide_g(ty_grid_medium* medium) {
    for (int32_t c = 0; c < medium->planes; ++c)
        for (size_t i = 0; i < medium->cells; ++i)
            medium->g[c][i] =
                medium->scattering[c][i] > 0 ? ty_clampf(medium->g[c][i] / medium->scattering[c][i], -1, 1) : 0;
}

/* Largest difference of equal moments. */
static const float legendre_tolerance = 1e-6f;

/* The moments that all media have in common, in all channels; the first is 0 if there are none such. */
static void find_common_legendre(const ty_scene_view* view, float legendre[TY_PHASE_MOMENTS]) {
    const ty_phase_view* common = NULL;
    for (int32_t m = 0; m < view->medium_count; ++m) {
        const ty_phase_view* phase = view->media[m].phase;
        if (phase == NULL) return;
        if (common == NULL) common = phase;
        for (int32_t i = 0; i < 3 * TY_PHASE_MOMENTS; ++i)
            if (fabsf(phase->moments[i / TY_PHASE_MOMENTS][i % TY_PHASE_MOMENTS] -
                      common->moments[0][i % TY_PHASE_MOMENTS]) > legendre_tolerance)
                return;
    }
    if (common != NULL) memcpy(legendre, common->moments[0], sizeof common->moments[0]);
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
    for (int32_t m = 0; m < view->medium_count && result == TY_OK; ++m)
        result = add_medium(scene, m, &view->media[m], medium);
    if (result != TY_OK) {
        ty_grid_medium_destroy(medium);
        return result;
    }
    divide_g(medium);
    find_common_legendre(view, medium->legendre);
    medium->periodic = (uint32_t)view->periodic.axes;
    *out = medium;
    return TY_OK;
}

/* ---- the density of one medium ---- */

/* A medium of extinction 1 at density 1. Only its density varies. */
static ty_medium_view of_density(const ty_scene* scene, int32_t index) {
    ty_medium_view medium = ty_scene_get_view(scene)->media[index];
    for (int c = 0; c < 3; ++c) {
        medium.sigma_t[c] = 1;
        medium.sigma_s[c] = 0;
    }
    medium.albedo_fields = medium.transfer_albedo = medium.has_g_field = medium.has_temperature = medium.emits = 0;
    return medium;
}

ty_result ty_grid_medium_density(const ty_scene* scene, int32_t index, const ty_grid_box* box, ty_grid_medium** out) {
    const ty_medium_view view = of_density(scene, index);
    ty_grid_medium* medium = NULL;
    ty_result result = new_medium(scene->context, box, 1, false, &medium);
    if (result == TY_OK) result = add_medium(scene, index, &view, medium);
    if (result != TY_OK) {
        ty_grid_medium_destroy(medium);
        return result;
    }
    *out = medium;
    return TY_OK;
}

ty_result ty_grid_medium_spread_density(const ty_scene* scene, int32_t index, ty_grid_medium* medium,
                                        const double* by_density, double* voxels) {
    const ty_medium_view view = of_density(scene, index);
    const int32_t* size = medium->box.size;
    sample_job job;
    ty_grid* coverage;
    ty_result result = begin_medium(scene, index, &view, medium, &job, &coverage);
    if (result == TY_OK && job.aligned.cells[0] == NULL)
        result =
            ty_fail(scene->context, TY_ERROR_ARGUMENT,
                    "gradient: media[%d].density: there are derivatives of voxels along the axes of the scene alone, "
                    "without a transfer function and of at least 0",
                    (int)index);
    double* row = result == TY_OK ? ty_alloc_array(scene->context, (size_t)size[0], sizeof *row, false) : NULL;
    if (result == TY_OK && row == NULL) result = TY_ERROR_MEMORY;
    for (int64_t r = 0; r < (int64_t)size[1] * size[2] && result == TY_OK; ++r) {
        for (int32_t x = 0; x < size[0]; ++x)
            row[x] = by_density[r * size[0] + x] * (double)covered_fraction(&job, x, r);
        ty_aligned_spread_row(&job.aligned, medium, &view, (int32_t)(r % size[1]), (int32_t)(r / size[1]), row, voxels);
    }
    ty_free_array(scene->context, row, (size_t)size[0], sizeof *row);
    ty_aligned_destroy(medium, &job.aligned);
    ty_grid_release(coverage);
    return result;
}

/* ---- other cells ---- */

/* Averages g with the weight sigma_s. */
static ty_result resize_g(const ty_grid_medium* from, ty_grid_medium* to) {
    float* scattering_g = ty_alloc_array(from->context, from->cells, sizeof *scattering_g, false);
    if (scattering_g == NULL) return TY_ERROR_MEMORY;
    for (int32_t c = 0; c < from->planes; ++c) {
        for (size_t i = 0; i < from->cells; ++i) scattering_g[i] = from->g[c][i] * from->scattering[c][i];
        ty_grid_average(from->context, scattering_g, from->box.size, to->box.size, to->g[c]);
    }
    ty_free_array(from->context, scattering_g, from->cells, sizeof *scattering_g);
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
    memcpy(to->legendre, medium->legendre, sizeof to->legendre);
    to->periodic = medium->periodic;
    result = resize_g(medium, to);
    if (result != TY_OK) {
        ty_grid_medium_destroy(to);
        return result;
    }
    *out = to;
    return TY_OK;
}

enum { REDUCTION_CHUNK = 1 << 10 };

typedef struct reduction {
    const ty_grid_medium* medium;
    int32_t order;
    float fraction; /* factor of g^order */
    float* const* planes;
} reduction;

static void reduce_chunk(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const reduction* job = user;
    const ty_grid_medium* medium = job->medium;
    const size_t begin = (size_t)index * REDUCTION_CHUNK, left = medium->cells - begin;
    const size_t count = left < REDUCTION_CHUNK ? left : REDUCTION_CHUNK;
    float forward[REDUCTION_CHUNK];
    for (int32_t c = 0; c < medium->planes; ++c) {
        const float *g = medium->g[c] + begin, *scattering = medium->scattering[c] + begin;
        const float* extinction = medium->extinction[c] + begin;
        for (size_t i = 0; i < count; ++i) forward[i] = job->fraction * scattering[i];
        for (int32_t l = 0; l < job->order; ++l)
            for (size_t i = 0; i < count; ++i) forward[i] *= g[i];
        for (size_t i = 0; i < count; ++i) job->planes[c][begin + i] = ty_maxf(0, extinction[i] - forward[i]);
    }
}

static void reduce(reduction job) {
    const size_t chunks = (job.medium->cells + REDUCTION_CHUNK - 1) / REDUCTION_CHUNK;
    ty_parallel_for(job.medium->context, (int64_t)chunks, reduce_chunk, &job);
}

float ty_grid_medium_forward(const ty_grid_medium* medium, int32_t order) {
    return ty_maxf(0, medium->legendre[order]);
}

void ty_grid_medium_reduce(const ty_grid_medium* medium, int32_t order, float* const planes[3]) {
    if (medium->legendre[0] > 0 && order > 1)
        reduce((reduction){medium, 0, ty_grid_medium_forward(medium, order), planes});
    else
        reduce((reduction){medium, order, 1, planes});
}

void ty_grid_medium_reduce_by(const ty_grid_medium* medium, float fraction, float* const planes[3]) {
    reduce((reduction){medium, 0, fraction, planes});
}
