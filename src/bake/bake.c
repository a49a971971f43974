/* Entry points: light on surfaces, at probes and in media. */
#include "bake/cache/cache.h"

#include "base/context.h"
#include "base/check.h"

#include <string.h>

ty_result ty_bake_surfaces(const ty_scene* scene, const ty_bake_def* def, const ty_bake_receiver* receivers,
                           int64_t count, ty_bake_light* light, ty_bake_stats* stats) {
    ty_bake_run run;
    ty_bake_stats own;
    ty_result result = ty_take_stats(ty_scene_context(scene), stats, "ty_default_bake_stats", &own, sizeof own);
    if (result == TY_OK && count > 0 && light == NULL)
        result = ty_fail(ty_scene_context(scene), TY_ERROR_ARGUMENT, "ty_bake_surfaces: light is NULL");
    if (result != TY_OK) return result;
    result = ty_bake_run_begin(&run, scene, def, receivers, count, TY_BAKE_SURFACE_TERMS);
    if (result == TY_OK) {
        result = ty_bake_sample(&run);
        for (int64_t i = 0; i < count; ++i) {
            light[i].samples = run.sums[i].count;
            for (int c = 0; c < 3; ++c) {
                light[i].variance[c] = (float)ty_bake_variance(&run.sums[i], c);
                for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) {
                    light[i].irradiance[layer][c] = (float)ty_bake_mean(&run, i, layer, c, 0);
                    for (int a = 0; a < 3; ++a)
                        light[i].vector_irradiance[layer][c][a] = (float)ty_bake_mean(&run, i, layer, c, 1 + a);
                }
            }
        }
        ty_give_stats(&run.stats, sizeof run.stats, stats);
    }
    ty_bake_run_end(&run);
    return result;
}

static void write_probe(const ty_bake_run* run, int64_t i, ty_bake_probe* out) {
    out->samples = run->sums[i].count;
    out->blocked = out->samples > 0 ? (float)(run->sums[i].blocked / out->samples) : 0;
    for (int c = 0; c < 3; ++c) {
        out->variance[c] = (float)ty_bake_variance(&run->sums[i], c);
        for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer)
            for (int t = 0; t < TY_BAKE_SH_TERMS; ++t) out->sh[layer][c][t] = (float)ty_bake_mean(run, i, layer, c, t);
    }
}

ty_result ty_bake_probes(const ty_scene* scene, const ty_bake_def* def, const float* positions, int64_t count,
                         ty_bake_probe* probes, ty_bake_stats* stats) {
    ty_context* context = ty_scene_context(scene);
    ty_bake_stats own;
    ty_result result = ty_take_stats(context, stats, "ty_default_bake_stats", &own, sizeof own);
    if (result == TY_OK && count < 0)
        result = ty_fail(context, TY_ERROR_ARGUMENT, "bake: a count of %lld probes", (long long)count);
    if (result == TY_OK && count > 0 && (positions == NULL || probes == NULL))
        result = ty_fail(context, TY_ERROR_ARGUMENT, "ty_bake_probes: positions or probes is NULL");
    if (result != TY_OK) return result;
    ty_bake_receiver* receivers = ty_alloc_array(context, (size_t)count, sizeof *receivers, true);
    if (receivers == NULL) return TY_ERROR_MEMORY;
    for (int64_t i = 0; i < count; ++i) memcpy(receivers[i].position, positions + 3 * i, sizeof receivers[i].position);
    ty_bake_run run;
    result = ty_bake_run_begin(&run, scene, def, receivers, count, TY_BAKE_SH_TERMS);
    if (result == TY_OK) {
        result = ty_bake_sample(&run);
        for (int64_t i = 0; i < count; ++i) write_probe(&run, i, &probes[i]);
        ty_give_stats(&run.stats, sizeof run.stats, stats);
    }
    ty_bake_run_end(&run);
    ty_free_array(context, receivers, (size_t)count, sizeof *receivers);
    return result;
}

ty_result ty_bake_cache_create(const ty_scene* scene, const ty_bake_def* def, ty_bake_cache** out) {
    ty_bake_run run;
    *out = NULL;
    ty_result result = ty_bake_run_prepare(&run, scene, def);
    if (result == TY_OK) result = ty_bake_cache_make(&run, scene, out);
    ty_bake_run_end(&run);
    return result;
}
