/* Estimates without a camera: radiance along given rays, fluence in cells, transmittance between points. */
#include "base/context.h"
#include "direct/media/transmittance.k.h"
#include "method/path/driver.h"
#include "base/check.h"

/* Allocates the run's items, samples them and copies the results out. */
static ty_result sample_items(ty_path_run* run, const ty_scene* scene, double* mean, double* uncollided,
                              double* variance) {
    ty_result result = ty_path_run_begin(run, scene, uncollided != NULL);
    if (result != TY_OK) return result;
    result = ty_path_sample(run);
    for (int64_t i = 0; i < run->item_count; ++i)
        for (int c = 0; c < 3; ++c) {
            mean[3 * i + c] = ty_path_item_mean(&run->items[i], c);
            if (uncollided != NULL)
                uncollided[3 * i + c] = run->aov_sums[i].uncollided[c] / fmax(run->items[i].count, 1);
            if (variance != NULL) variance[3 * i + c] = ty_path_item_variance(&run->items[i], c);
        }
    ty_path_run_end(run);
    return result;
}

ty_result ty_path_radiance(const ty_scene* scene, const ty_path_def* def, const double* rays, int64_t count,
                           double* radiance, double* variance) {
    ty_path_run run;
    ty_result result = ty_path_prepare(scene, def, &run);
    if (result == TY_OK) result = ty_check_rays(run.context, rays, count, radiance);
    if (result != TY_OK) return result;
    run.stage = "radiance";
    run.request.kind = TY_PATH_RAYS;
    run.request.rays = rays;
    run.item_count = count;
    return sample_items(&run, scene, radiance, NULL, variance);
}

ty_result ty_path_fluence(const ty_scene* scene, const ty_path_def* def, const double lower[3], const double upper[3],
                          const int32_t size[3], double* fluence, double* uncollided, double* variance) {
    ty_path_run run;
    ty_result result = ty_path_prepare(scene, def, &run);
    if (result == TY_OK) result = ty_check_point(run.context, "fluence: lower", lower);
    if (result == TY_OK) result = ty_check_point(run.context, "fluence: upper", upper);
    if (result != TY_OK) return result;
    run.item_count = 1;
    for (int a = 0; a < 3; ++a) {
        if (size[a] < 1 || size[a] > 65536 || upper[a] < lower[a])
            return ty_fail(run.context, TY_ERROR_ARGUMENT, "fluence: %d cells from %g to %g along %c", size[a],
                           lower[a], upper[a], "xyz"[a]);
        run.request.lower[a] = lower[a];
        run.request.cell[a] = (upper[a] - lower[a]) / size[a];
        run.request.size[a] = size[a];
        run.item_count *= size[a];
    }
    run.stage = "fluence";
    run.request.kind = TY_PATH_CELLS;
    return sample_items(&run, scene, fluence, uncollided, variance);
}

ty_result ty_path_transmittance(const ty_scene* scene, const ty_path_def* def, const double from[3], const double to[3],
                                double transmittance[3]) {
    ty_path_run run;
    ty_result result = ty_path_prepare(scene, def, &run);
    if (result == TY_OK) result = ty_check_point(run.context, "transmittance: from", from);
    if (result == TY_OK) result = ty_check_point(run.context, "transmittance: to", to);
    if (result != TY_OK) return result;
    const ty_vec origin = ty_vec_make((float)from[0], (float)from[1], (float)from[2]);
    const ty_vec offset = ty_vec_make((float)(to[0] - from[0]), (float)(to[1] - from[1]), (float)(to[2] - from[2]));
    const float length = sqrtf(ty_dot(offset, offset));
    for (int c = 0; c < 3; ++c) transmittance[c] = length > 0 ? 0 : 1;
    for (int32_t sample = 0; sample < def->spp && length > 0; ++sample) {
        ty_sampler random = ty_sampler_begin(&run.sobol, def->seed, 0, (uint32_t)sample);
        float estimate[3];
        ty_transmittance(run.request.scene->media, run.request.scene->medium_count, origin,
                         ty_scale(offset, 1.0f / length), length, &random, estimate);
        for (int c = 0; c < 3; ++c) transmittance[c] += (double)estimate[c] / def->spp;
    }
    return TY_OK;
}
