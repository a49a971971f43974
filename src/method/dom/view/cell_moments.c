/* Light on a caller's cells for shaders: unscattered light of lamps, and all other light with its moments. */
#include "base/constants.h"
#include "base/context.h"
#include "base/luminance.k.h"
#include "direct/media/coverage.h"
#include "direct/single/source_field.h"
#include "method/cell_light.h"
#include "method/dom/solution.h"
#include "solve/angular/harmonics.h"

#include <math.h>

enum { BANDS = TY_CELL_BANDS, TERMS = TY_CELL_TERMS };

typedef struct moments_job {
    const ty_dom* light;
    ty_coverage_box cells;
    ty_cell_moments* out;
} moments_job;

/* One cell: its coverage, its center, and sums. */
typedef struct moments_cell {
    ty_coverage fine[3], coarse[3];
    double center[3];
    double unscattered[3], rest[3];
    double moments[TERMS]; /* of the luminance of `rest`, phi_lm */
    double flux[3][3];     /* of the channels of `rest` */
} moments_cell;

static double mean_of(const ty_light_fluence* light, const float* const planes[3], int c, const ty_grid_box* box,
                      const ty_coverage axes[3]) {
    const float* plane = planes[light->shared != 0 ? 0 : c];
    double sum = 0;
    if (plane != NULL) ty_coverage_add(box, axes, &plane, 1, light->shared != 0 ? (double)light->color[c] : 1, &sum);
    return sum;
}

/* Adds light about a direction (any length) whose Legendre moments are 1 below `order`, and from there on a geometric
 * sequence; bands: those that are added, from `first` on. */
static void add_lobe(moments_cell* cell, double luminance, const double along[3], int order, double ratio, int first) {
    const double length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    const double omega[3] = {along[0] / length, along[1] / length, along[2] / length};
    double y[TERMS], moment = luminance;
    if (!(length > 0)) {
        if (first == 0) cell->moments[0] += luminance / TY_SQRT_4PI_F64;
        return;
    }
    ty_harmonics_at(omega, BANDS, y);
    for (int l = 0; l < BANDS; ++l) {
        moment *= l < order ? 1 : ratio;
        for (int t = l * l; l >= first && t < (l + 1) * (l + 1); ++t) cell->moments[t] += moment * y[t];
    }
}

/* Light of a lamp: unscattered, and that in its forward lobe (R - U of forward.k.h). */
static void add_lamp(const moments_job* job, const ty_light_fluence* light, moments_cell* cell) {
    double lobe[3], next[3], along[3];
    const double anchor[3] = {(double)light->anchor.x, (double)light->anchor.y, (double)light->anchor.z};
    for (int c = 0; c < 3; ++c) {
        const double all = mean_of(light, light->fluence, c, &job->light->fine_box, cell->fine);
        const bool whole = light->lobe_order == 0;
        const double u = whole ? all : mean_of(light, light->unscattered, c, &job->light->fine_box, cell->fine);
        const double s = whole ? all : mean_of(light, light->next_order, c, &job->light->fine_box, cell->fine);
        lobe[c] = fmax(all - u, 0);
        next[c] = fmax(s - u, 0);
        cell->unscattered[c] += u;
        cell->rest[c] += lobe[c];
    }
    const double luminance = ty_luminance_f64(lobe);
    if (!(luminance > 0)) return;
    for (int a = 0; a < 3; ++a) along[a] = light->kind == TY_FLUENCE_POINT ? cell->center[a] - anchor[a] : anchor[a];
    const double length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    for (int c = 0; c < 3 && length > 0; ++c)
        for (int a = 0; a < 3; ++a)
            cell->flux[c][a] += (light->lobe_order > 0 ? lobe[c] : fmin(next[c], lobe[c])) * along[a] / length;
    add_lobe(cell, luminance, along, light->lobe_order + 1, fmin(ty_luminance_f64(next) / luminance, 1), 0);
}

/* Uncollided light of all others, of which the flux is known: moments are powers of the mean cosine. */
static void add_aggregate(const moments_job* job, const ty_light_fluence* light, moments_cell* cell) {
    double fluence[3], flux[3], rgb[3];
    for (int c = 0; c < 3; ++c) {
        fluence[c] = mean_of(light, light->fluence, c, &job->light->fine_box, cell->fine);
        cell->rest[c] += fluence[c];
    }
    const double luminance = ty_luminance_f64(fluence);
    if (!(luminance > 0)) return;
    for (int a = 0; a < 3; ++a) {
        const float* const planes[3] = {light->flux[0][a], light->flux[1][a], light->flux[2][a]};
        for (int c = 0; c < 3; ++c) {
            rgb[c] = mean_of(light, planes, c, &job->light->fine_box, cell->fine);
            cell->flux[c][a] += rgb[c];
        }
        flux[a] = ty_luminance_f64(rgb);
    }
    const double cosine = fmin(sqrt(flux[0] * flux[0] + flux[1] * flux[1] + flux[2] * flux[2]) / luminance, 1);
    add_lobe(cell, luminance, flux, 1, cosine, 0);
}

/* Collided light, or light from surfaces. Bands that were not kept are powers of the mean cosine. */
static void add_moments(const ty_dom* light, float* const moments[3], moments_cell* cell) {
    const int32_t bands = light->output_bands < BANDS ? light->output_bands : BANDS;
    static const int band_1[3] = {3, 1, 2}; /* x, y, z */
    double sums[3][TERMS] = {{0}}, found[TERMS];
    if (moments[0] == NULL) return;
    for (int c = 0; c < 3; ++c) {
        const float* planes[TERMS];
        for (int32_t t = 0; t < bands * bands; ++t) planes[t] = ty_dom_plane(light, moments[light->shared ? 0 : c], t);
        ty_coverage_add(&light->box, cell->coarse, planes, bands * bands, (double)light->color[c], sums[c]);
        cell->rest[c] += TY_SQRT_4PI_F64 * sums[c][0];
        for (int a = 0; a < 3; ++a) cell->flux[c][a] += TY_SQRT_4PI_F64 / sqrt(3) * sums[c][band_1[a]];
    }
    for (int32_t t = 0; t < bands * bands; ++t) {
        const double rgb[3] = {sums[0][t], sums[1][t], sums[2][t]};
        found[t] = ty_luminance_f64(rgb);
        cell->moments[t] += found[t];
    }
    if (bands == BANDS || !(found[0] > 0)) return;
    const double along[3] = {found[3], found[1], found[2]};
    const double flux = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]) / sqrt(3);
    add_lobe(cell, TY_SQRT_4PI_F64 * found[0], along, 1, fmin(flux / found[0], 1), bands);
}

/* Mean cosines of the channels with the flux of their luminance, which bands of index 1 have. */
static void find_cosines(const moments_cell* cell, float out[3]) {
    const double along[3] = {cell->moments[3], cell->moments[1], cell->moments[2]};
    const double length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    for (int c = 0; c < 3; ++c) {
        double flux = 0;
        for (int a = 0; a < 3; ++a) flux += cell->flux[c][a] * along[a];
        out[c] = length > 0 && cell->rest[c] > 0 ? (float)(flux / (length * cell->rest[c])) : 0;
    }
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const moments_job* job = user;
    const ty_dom* light = job->light;
    const ty_coverage_box* box = &job->cells;
    for (int32_t i = 0; i < box->size[0]; ++i) {
        const int32_t at[3] = {i, (int32_t)(row % box->size[1]), (int32_t)(row / box->size[1])};
        const size_t index = (size_t)row * (size_t)box->size[0] + (size_t)i;
        moments_cell cell = {.center = {0}};
        ty_coverage_of_cell(&light->fine_box, box, at, cell.fine);
        ty_coverage_of_cell(&light->box, box, at, cell.coarse);
        for (int a = 0; a < 3; ++a)
            cell.center[a] = box->lower[a] + (at[a] + 0.5) * (box->upper[a] - box->lower[a]) / box->size[a];
        for (int32_t l = 0; l < light->fluence_count; ++l)
            (light->fluences[l].kind <= TY_FLUENCE_POINT ? add_lamp : add_aggregate)(job, &light->fluences[l], &cell);
        add_moments(light, light->moments, &cell);
        add_moments(light, light->wall_moments, &cell);
        for (size_t c = 0; c < 3; ++c) {
            job->out->unscattered[3 * index + c] = cell.unscattered[c];
            job->out->rest[3 * index + c] = cell.rest[c];
        }
        find_cosines(&cell, &job->out->cosines[3 * index]);
        for (size_t t = 0; t < TERMS; ++t) job->out->moments[TERMS * index + t] = (float)cell.moments[t];
    }
}

ty_result ty_dom_cell_moments(const ty_dom* light, const double lower[3], const double upper[3], const int32_t size[3],
                              ty_cell_moments* out) {
    const ty_coverage_box cells = {lower, upper, size};
    const ty_result result = ty_coverage_check(light->context, &cells);
    if (result != TY_OK) return result;
    moments_job job = {light, cells, out};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}
