/* Fraction of each grid cell inside a medium's bounds. */
#include "base/float_mode.h"
#include "base/context.h"
#include "grid/grid.h"
#include "base/check.h"
#include "scene/scene.h"
#include "scene/media/spans.k.h"

enum { SIZE_MAX_AXIS = 16384, SAMPLES_MAX = 64 };

typedef struct coverage_job {
    ty_medium_view medium; /* bounds only */
    double lower[3], cell[3];
    int32_t size[3];
    int32_t samples;
    float* values;
} coverage_job;

/* Adds `weight` times the overlap of [enter, leave], in cells, to each cell of a row. */
static void add_overlap(float* row, int32_t count, double enter, double leave, float weight) {
    const double from = fmax(enter, 0), to = fmin(leave, count);
    for (int32_t i = (int32_t)floor(from); i < count && i < to; ++i)
        row[i] += weight * (float)(fmin(to, i + 1) - fmax(from, i));
}

/* A row of cells along x: exact along x, sampled across. */
static void coverage_row(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const coverage_job* job = user;
    const int64_t j = index % job->size[1], k = index / job->size[1];
    float* row = job->values + index * job->size[0];
    const float weight = 1 / (float)(job->samples * job->samples);
    const unsigned state = ty_flush_denormals();
    for (int32_t s = 0; s < job->samples * job->samples; ++s) {
        const double y = (double)j + (s % job->samples + 0.5) / job->samples;
        const double z = (double)k + (s / job->samples + 0.5) / job->samples;
        const ty_vec origin = ty_vec_make((float)job->lower[0], (float)(job->lower[1] + y * job->cell[1]),
                                          (float)(job->lower[2] + z * job->cell[2]));
        ty_spans spans;
        ty_spans_find(&job->medium, 1, origin, ty_vec_make(1, 0, 0), (float)(job->cell[0] * job->size[0]), &spans);
        for (int32_t i = 0; i < spans.count; ++i)
            add_overlap(row, job->size[0], (double)spans.enter[i] / job->cell[0], (double)spans.leave[i] / job->cell[0],
                        weight);
    }
    ty_restore_denormals(state);
}

static ty_result check_box(ty_context* context, const double lower[3], const double upper[3], const int32_t size[3]) {
    ty_result result = ty_check_point(context, "coverage: lower", lower);
    if (result == TY_OK) result = ty_check_point(context, "coverage: upper", upper);
    for (int a = 0; a < 3 && result == TY_OK; ++a)
        if (!(upper[a] > lower[a]) || size[a] < 1 || size[a] > SIZE_MAX_AXIS)
            result = ty_fail(context, TY_ERROR_ARGUMENT, "coverage: %d cells from %g to %g along %c", size[a], lower[a],
                             upper[a], "xyz"[a]);
    return result;
}

ty_result ty_medium_create_coverage(const ty_scene* scene, int32_t medium, const double lower[3], const double upper[3],
                                    const int32_t size[3], int32_t samples, ty_grid** out) {
    ty_context* context = ty_scene_context(scene);
    const ty_scene_view* view = ty_scene_get_view(scene);
    if (view == NULL) return TY_ERROR_ARGUMENT;
    if (medium < 0 || medium >= view->medium_count)
        return ty_fail(context, TY_ERROR_ARGUMENT, "media: there is no medium %d", (int)medium);
    ty_result result = check_box(context, lower, upper, size);
    if (result == TY_OK) result = ty_check_number(context, "coverage: samples", samples, 1, SAMPLES_MAX);
    if (result != TY_OK) return result;
    coverage_job job = {.medium = view->media[medium], .samples = samples};
    ty_grid_def def = ty_default_grid_def();
    job.medium.has_grid = 0;
    for (int a = 0; a < 3; ++a) {
        job.lower[a] = lower[a];
        job.cell[a] = (upper[a] - lower[a]) / size[a];
        job.size[a] = def.size[a] = size[a];
    }
    const size_t cells = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    job.values = ty_alloc_array(context, cells, sizeof *job.values, true);
    if (job.values == NULL) return TY_ERROR_MEMORY;
    ty_parallel_for(context, (int64_t)size[1] * size[2], coverage_row, &job);
    for (size_t i = 0; i < cells; ++i) job.values[i] = ty_minf(job.values[i], 1.0f);
    return ty_grid_adopt(context, &def, job.values, out);
}
