/* Fluence and flux on a caller's cells. */
#include "method/fld/job.h"

#include "base/constants.h"
#include "base/context.h"
#include "direct/media/coverage.h"

#include <math.h>

typedef struct fluence_job {
    const ty_fld* light;
    ty_coverage_box cells;
    double *fluence, *uncollided, *flux;
} fluence_job;

/* Fluence of uncollided light, and its flux where the direction is known. */
static void add_beams(const fluence_job* job, const int32_t cell[3], int c, double* fluence, double flux[3]) {
    const ty_fld* light = job->light;
    ty_coverage axes[3];
    ty_coverage_of_cell(&light->direct_box, &job->cells, cell, axes);
    for (int32_t l = 0; l < light->light_count; ++l) {
        const ty_light_fluence* single = &light->lights[l];
        float factor;
        const float* plane = ty_light_fluence_plane(single, c, &factor);
        double source_fluence = 0;
        ty_coverage_add(&light->direct_box, axes, &plane, 1, (double)factor, &source_fluence);
        *fluence += source_fluence;
        double direction[3] = {(double)single->anchor.x, (double)single->anchor.y, (double)single->anchor.z};
        if (single->kind == TY_FLUENCE_P1) {
            ty_coverage_add(&light->direct_box, axes, single->flux[single->shared != 0 ? 0 : c], 3, (double)factor,
                            flux);
            continue;
        }
        if (single->kind == TY_FLUENCE_POINT) {
            double length = 0;
            for (int a = 0; a < 3; ++a) {
                direction[a] = job->cells.lower[a] +
                               (job->cells.upper[a] - job->cells.lower[a]) * (cell[a] + 0.5) / job->cells.size[a] -
                               direction[a];
                length += direction[a] * direction[a];
            }
            for (int a = 0; a < 3; ++a) direction[a] = length > 0 ? direction[a] / sqrt(length) : 0;
        }
        for (int a = 0; a < 3; ++a) flux[a] += source_fluence * direction[a];
    }
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const fluence_job* job = user;
    const ty_fld* light = job->light;
    for (int32_t i = 0; i < job->cells.size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % job->cells.size[1]), (int32_t)(row / job->cells.size[1])};
        const size_t at = (size_t)row * (size_t)job->cells.size[0] + (size_t)i;
        ty_coverage axes[3];
        ty_coverage_of_cell(&light->diffuse->box, &job->cells, cell, axes);
        for (int c = 0; c < 3; ++c) {
            double beam = 0, diffuse = 0, flux[3] = {0, 0, 0};
            const float* const* terms = (const float* const*)light->diffuse->terms[c];
            ty_coverage_add(&light->diffuse->box, axes, terms, 1, 4 * TY_PI_F64, &diffuse);
            ty_coverage_add(&light->diffuse->box, axes, terms + 1, 3, 4 * TY_PI_F64 / 3, flux);
            add_beams(job, cell, c, &beam, flux);
            job->fluence[3 * at + (size_t)c] = diffuse + beam;
            if (job->uncollided != NULL) job->uncollided[3 * at + (size_t)c] = beam;
            for (int a = 0; a < 3 && job->flux != NULL; ++a) job->flux[9 * at + 3 * (size_t)c + (size_t)a] = flux[a];
        }
    }
}

ty_result ty_fld_fluence(const ty_fld* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence, double* uncollided, double* flux) {
    const ty_coverage_box cells = {lower, upper, size};
    const ty_result result = ty_coverage_check(light->context, &cells);
    if (result != TY_OK) return result;
    fluence_job job = {light, cells, fluence, uncollided, flux};
    ty_parallel_for(light->context, (int64_t)size[1] * size[2], fill_row, &job);
    return TY_OK;
}
