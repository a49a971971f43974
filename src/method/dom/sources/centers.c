/* Where first collisions of uncollided light happen within thick cells, from its fluence on fine cells. */
#include "base/context.h"
#include "base/mapping.h"
#include "base/sh.k.h"
#include "direct/media/coverage.h"
#include "method/dom/sources/sources.h"

#include <math.h>
#include <string.h>

/* Mean cosine of the collisions of even light with the normal of a half-space, by the flux: 2 / 3; and least cosine. */
static const double even_cosine = 0.6666666666666667, min_cosine = 0.1;
/* Optical thickness of a cell above which positions follow from directions, and the part of the expected fall-off from
 * cell to cell that tells that light enters along an axis. */
static const double thick = 1.5, steep = 0.25;

typedef struct center_job {
    const ty_dom_job* job;
    int32_t channel;
    int64_t steps[3]; /* between fine cells */
    float* planes[4];
} center_job;

/* sigma_s phi of a fine cell for a light. */
static double collisions_of(const center_job* centers, int32_t index, size_t fine) {
    const ty_dom_job* job = centers->job;
    const ty_dom* light = job->light;
    const bool aggregate = light->aggregate != NULL && index + 1 == light->fluence_count;
    const ty_light_field* field = aggregate ? light->aggregate : light->fields[index][TY_FLUENCE_ORDER_L];
    double sum = 0;
    for (int32_t p = 0; p < field->planes; ++p)
        sum += (double)ty_dom_channel_factor(light, field, p, centers->channel) * (double)field->fluence[p][fine];
    return sum * (double)job->fine->scattering[job->fine->planes == 3 ? centers->channel : 0][fine];
}

/* Cosine of a light's direction with an axis at a fine cell, at least min_cosine; of light without a direction the mean
 * over the collisions of even light. */
static double cosine_along(const center_job* centers, int32_t index, const int32_t cell[3], int axis) {
    const ty_light_fluence* light = &centers->job->light->fluences[index];
    const ty_grid_medium* medium = centers->job->fine;
    double at[3], off[3] = {(double)light->anchor.x, (double)light->anchor.y, (double)light->anchor.z}, square = 0;
    if (light->kind >= TY_FLUENCE_P1) return even_cosine;
    for (int a = 0; a < 3; ++a) {
        at[a] = medium->box.lower[a] + (cell[a] + 0.5) * medium->cell[a];
        if (light->kind == TY_FLUENCE_POINT) off[a] = at[a] - off[a];
        square += off[a] * off[a];
    }
    return fmax(min_cosine, square > 0 ? fabs(off[axis]) / sqrt(square) : 0);
}

/* Center of a light's collisions within a fine cell along an axis, -1..1: that of an exponential through it and its
 * neighbours. In thick cells these are too far off: there it falls off with the depth along the light's direction. */
static double center_in(const center_job* centers, int32_t light, const int32_t index[3], size_t fine, int axis,
                        double here) {
    const ty_grid_medium* medium = centers->job->fine;
    const double thickness =
        (double)medium->extinction[medium->planes == 3 ? centers->channel : 0][fine] * medium->cell[axis];
    double lower = here, upper = here;
    int neighbours = 0;
    if (index[axis] > 0) lower = collisions_of(centers, light, fine - (size_t)centers->steps[axis]), ++neighbours;
    if (index[axis] + 1 < medium->box.size[axis])
        upper = collisions_of(centers, light, fine + (size_t)centers->steps[axis]), ++neighbours;
    if (neighbours == 0) return 0;
    const double max_growth = thickness / cosine_along(centers, light, index, axis);
    double growth = lower > 0 && upper > 0 ? log(upper / lower) / neighbours : upper > 0 ? max_growth : -max_growth;
    if (thickness > thick && fabs(growth) > steep * max_growth) growth = copysign(max_growth, growth);
    const double half = fmax(fmin(growth, max_growth), -max_growth) / 2;
    return fabs(half) < 1e-2 ? half / 3 : 1 / tanh(half) - 1 / half;
}

/* Adds the collisions of all lights in a fine cell, and their positions within the coarse cell, times a weight. */
static void add_fine_cell(const center_job* centers, const ty_coverage axes[3], const int32_t index[3], double weight,
                          double sums[4]) {
    const size_t fine =
        (size_t)index[0] + (size_t)centers->steps[1] * (size_t)index[1] + (size_t)centers->steps[2] * (size_t)index[2];
    for (int32_t i = 0; i < centers->job->light->fluence_count; ++i) {
        const double here = collisions_of(centers, i, fine);
        if (!(here > 0)) continue;
        sums[0] += weight * here;
        for (int a = 0; a < 3; ++a) {
            const double center = index[a] + 0.5 + 0.5 * center_in(centers, i, index, fine, a, here);
            const double within = 2 * (center - axes[a].lower) / (axes[a].upper - axes[a].lower) - 1;
            sums[1 + a] += weight * here * fmax(-1, fmin(within, 1));
        }
    }
}

/* q_00 that uncollided light makes in a cell, and that times its center. */
static void find_center(const center_job* centers, const int32_t cell[3], size_t at) {
    const ty_dom_job* job = centers->job;
    const ty_grid_box* box = &job->coarse->box;
    const ty_coverage_box cells = {box->lower, box->upper, box->size};
    double sums[4] = {0, 0, 0, 0};
    ty_coverage axes[3];
    ty_coverage_of_cell(&job->fine->box, &cells, cell, axes);
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j)
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i) {
                const int32_t index[3] = {i, j, k};
                double weight = 1;
                for (int a = 0; a < 3; ++a) weight *= ty_coverage_fraction(&axes[a], index[a]);
                if (weight > 0) add_fine_cell(centers, axes, index, weight, sums);
            }
    for (int n = 0; n < 4; ++n) centers->planes[n][at] = (float)sums[n] * TY_SH_0;
}

/* The longest edge of a cell in mean free paths of sigma*. */
static double reduced_thickness(const ty_dom_job* job, int32_t plane, size_t cell) {
    const ty_dom* light = job->light;
    const float sigma_t = job->coarse->extinction[plane][cell], sigma_s = job->coarse->scattering[plane][cell];
    const float forward = light->fit.bands > 0             ? light->fit.forward_fraction
                          : ty_dom_legendre(light) != NULL ? ty_grid_medium_forward(job->coarse, light->bands)
                                                           : powf(job->coarse->g[plane][cell], (float)light->bands);
    return sigma_t > 0 ? ty_dom_cell_thickness(job, plane, cell) * (double)(1 - forward * sigma_s / sigma_t) : 0;
}

/* True for cells that may be diffusive, and for thick ones with first moments of their sources. */
static bool is_thick(const center_job* centers, size_t cell) {
    const ty_dom_job* job = centers->job;
    const int32_t plane = job->coarse->planes == 3 ? centers->channel : 0;
    return ty_dom_cell_thickness(job, plane, cell) > job->diffusive_paths ||
           (job->tells_positions && reduced_thickness(job, plane, cell) > TY_DOM_DISPLACED_PATHS);
}

static void center_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const center_job* centers = user;
    const int32_t* size = centers->job->coarse->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        if (is_thick(centers, at)) find_center(centers, cell, at);
    }
}

ty_result ty_dom_find_centers(ty_dom_job* job) {
    const int32_t* size = job->fine->box.size;
    const size_t cells = job->coarse->cells;
    center_job centers = {.job = job, .steps = {1, size[0], (int64_t)size[0] * size[1]}};
    for (int32_t c = 0; c < ty_dom_channels(job->light); ++c) {
        size_t first = 0;
        centers.channel = c;
        while (first < cells && !is_thick(&centers, first)) ++first;
        if (first == cells) continue;
        job->centers[c] = ty_alloc_large(job->context, cells, 4 * sizeof(float), true);
        if (job->centers[c] == NULL) return TY_ERROR_MEMORY;
        for (size_t n = 0; n < 4; ++n) centers.planes[n] = job->centers[c] + cells * n;
        ty_parallel_for(job->context, (int64_t)job->coarse->box.size[1] * job->coarse->box.size[2], center_row,
                        &centers);
    }
    return TY_OK;
}
