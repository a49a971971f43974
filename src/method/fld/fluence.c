/* Fluence and flux on a caller's cells. */
#include "method/fld/job.h"

#include "base/context.h"
#include "scene/check.h"

#include <math.h>
#include <string.h>

static const double four_pi = 12.566370614359172;

/* The cells of the method that a cell of the caller's covers along one axis, and the share that each has of it. */
typedef struct cover {
    int32_t first, count;
    double lower, upper; /* in cells */
} cover;

/* Cell `index` of `count` from lower to upper; a cell without extent is a point, and the upper face is part of the box.
 */
static cover cover_of(const ty_grid_box* box, int axis, double lower, double upper, int32_t index, int32_t count) {
    const double per_metre = box->size[axis] / (box->upper[axis] - box->lower[axis]);
    const double width = (upper - lower) / count;
    cover c = {.lower = (lower + width * index - box->lower[axis]) * per_metre,
               .upper = (lower + width * (index + 1) - box->lower[axis]) * per_metre};
    if (upper == lower && upper == box->upper[axis]) c.lower = c.upper = box->size[axis] - 1;
    const double first = fmin(fmax(floor(c.lower), 0), box->size[axis]);
    const double end = fmin(fmax(fmax(ceil(c.upper), floor(c.lower) + 1), 0), box->size[axis]);
    c.first = (int32_t)first;
    c.count = (int32_t)(end - first);
    return c;
}

static double share_of(const cover* c, int32_t cell) {
    if (!(c->upper > c->lower)) return 1;
    return fmax(0, fmin(c->upper, cell + 1) - fmax(c->lower, cell)) / (c->upper - c->lower);
}

/* Adds the mean over what three covers span, of planes of a box's cells, times scale, to out[]. */
static void add_means(const ty_grid_box* box, const cover axes[3], const float* const* planes, int32_t plane_count,
                      double scale, double* out) {
    for (int32_t k = axes[2].first; k < axes[2].first + axes[2].count; ++k)
        for (int32_t j = axes[1].first; j < axes[1].first + axes[1].count; ++j) {
            const double row = scale * share_of(&axes[2], k) * share_of(&axes[1], j);
            const size_t base = (size_t)box->size[0] * ((size_t)j + (size_t)box->size[1] * (size_t)k);
            for (int32_t i = axes[0].first; i < axes[0].first + axes[0].count; ++i) {
                const double share = row * share_of(&axes[0], i);
                for (int32_t p = 0; p < plane_count; ++p) out[p] += share * (double)planes[p][base + (size_t)i];
            }
        }
}

typedef struct fluence_job {
    const ty_fld* light;
    const double *lower, *upper;
    const int32_t* size;
    double *fluence, *beam, *flux;
} fluence_job;

static void cover_cell(const fluence_job* job, const ty_grid_box* box, const int32_t cell[3], cover axes[3]) {
    for (int a = 0; a < 3; ++a) axes[a] = cover_of(box, a, job->lower[a], job->upper[a], cell[a], job->size[a]);
}

/* What beams bring: fluence, and flux where lights know it. */
static void add_beams(const fluence_job* job, const int32_t cell[3], int c, double* fluence, double flux[3]) {
    const ty_fld* light = job->light;
    cover axes[3];
    cover_cell(job, &light->direct_box, cell, axes);
    for (int32_t l = 0; l < light->light_count; ++l) {
        const ty_single_light* single = &light->lights[l];
        float factor;
        const float* plane = ty_fld_beam_plane(single, c, &factor);
        double own = 0;
        add_means(&light->direct_box, axes, &plane, 1, (double)factor, &own);
        *fluence += own;
        double along[3] = {(double)single->toward.x, (double)single->toward.y, (double)single->toward.z};
        if (single->kind == TY_SINGLE_MANY) {
            add_means(&light->direct_box, axes, single->flux[single->shared != 0 ? 0 : c], 3, (double)factor, flux);
            continue;
        }
        if (single->kind == TY_SINGLE_LAMP) {
            double length = 0;
            for (int a = 0; a < 3; ++a) {
                along[a] = job->lower[a] + (job->upper[a] - job->lower[a]) * (cell[a] + 0.5) / job->size[a] - along[a];
                length += along[a] * along[a];
            }
            for (int a = 0; a < 3; ++a) along[a] = length > 0 ? along[a] / sqrt(length) : 0;
        }
        for (int a = 0; a < 3; ++a) flux[a] += own * along[a];
    }
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const fluence_job* job = user;
    const ty_fld* light = job->light;
    for (int32_t i = 0; i < job->size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % job->size[1]), (int32_t)(row / job->size[1])};
        const size_t at = (size_t)row * (size_t)job->size[0] + (size_t)i;
        cover axes[3];
        cover_cell(job, &light->box, cell, axes);
        for (int c = 0; c < 3; ++c) {
            double beam = 0, diffuse = 0, flux[3] = {0, 0, 0};
            const float* const* terms = (const float* const*)light->terms[c];
            add_means(&light->box, axes, terms, 1, four_pi, &diffuse);
            add_means(&light->box, axes, terms + 1, 3, four_pi / 3, flux);
            add_beams(job, cell, c, &beam, flux);
            job->fluence[3 * at + (size_t)c] = diffuse + beam;
            if (job->beam != NULL) job->beam[3 * at + (size_t)c] = beam;
            for (int a = 0; a < 3 && job->flux != NULL; ++a) job->flux[9 * at + 3 * (size_t)c + (size_t)a] = flux[a];
        }
    }
}

ty_result ty_fld_fluence(const ty_fld* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence, double* beam, double* flux) {
    ty_result result = ty_check_point(light->context, "fluence: lower", lower);
    if (result == TY_OK) result = ty_check_point(light->context, "fluence: upper", upper);
    for (int a = 0; a < 3 && result == TY_OK; ++a)
        if (lower[a] > upper[a] || size[a] < 1 || size[a] > 65536)
            result = ty_fail(light->context, TY_ERROR_ARGUMENT,
                             "fluence: %d cells from %g to %g m are no cut of a box along axis %d", size[a], lower[a],
                             upper[a], a);
    if (result != TY_OK) return result;
    fluence_job job = {light, lower, upper, size, fluence, beam, flux};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}
