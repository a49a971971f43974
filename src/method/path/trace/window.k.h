/* Russian roulette and splitting by the expected contribution of a path (Vorba and Krivanek 2016; the weight windows of
 * MCNP): throughput times the radiance that a guide expects along its ray, over the radiance that it expects of the
 * pixel. */
#ifndef TY_METHOD_PATH_TRACE_WINDOW_K_H
#define TY_METHOD_PATH_TRACE_WINDOW_K_H

#include "base/luminance.k.h"
#include "method/path/trace/collision.k.h"
#include "method/path/trace/light_path.k.h"

/* True if a window bounds the path, in place of Russian roulette by throughput. */
TY_FN bool ty_path_has_window(const ty_path* path) {
    return TY_PATH_GUIDED != 0 && path->request->guide->window > 0.0f && path->expected > 0.0f &&
           path->incident >= 0.0f;
}

/* Contributions of lights below this are traced by Russian roulette, W m^-2 sr^-1. Guided paths find many small ones.
 */
TY_FN float ty_path_min_contribution(const ty_path* path) {
    const float bound = path->request->min_contribution;
    return TY_PATH_GUIDED != 0 && path->expected > 0.0f
               ? ty_minf(bound, path->request->guide->light_window * path->expected)
               : bound;
}

/* The expected radiance of the camera's ray, which ends at a surface (NULL: at none). */
TY_FN_CALLED void ty_path_expect(ty_path* path, const ty_intersection* end) {
    const ty_guide* guide = path->request->guide;
    float passed;
    const float far = end != NULL ? end->hit.distance : TY_FLOAT_MAX;
    if (!(guide->window > 0.0f)) return;
    path->expected = ty_guide_media_radiance(guide, path->origin, path->direction, far, &passed);
    if (end == NULL) return;
    const float albedo = ty_luminance(end->point.albedo[0], end->point.albedo[1], end->point.albedo[2]);
    path->expected += passed * ty_guide_surface_radiance(guide, end->hit.position, end->point.ng, albedo);
}

/* After a vertex: false if roulette ends the path. Heavier paths are not split: that costs as much as it saves. */
TY_FN bool ty_path_passes_window(ty_path* path) {
    if (!ty_path_has_window(path)) return true;
    const float bound = path->request->guide->window;
    const float ratio = ty_luminance(path->beta[0], path->beta[1], path->beta[2]) * path->incident / path->expected;
    if (!(ratio < bound)) return true;
    const float chance = ty_maxf(ratio / bound, 0.25f);
    if (ty_rng_uniform(&path->random) >= chance) return false;
    for (int c = 0; c < 3; ++c) path->beta[c] /= chance;
    return true;
}

#endif
