/* Environment light, cut into parts. */
#ifndef TY_DIRECT_LIGHTS_ENVIRONMENT_CLUSTERS_H
#define TY_DIRECT_LIGHTS_ENVIRONMENT_CLUSTERS_H

#include "direct/lights/discrete_light.h"

#include <tyndall/scene.h>

typedef struct ty_environment_clusters_def {
    int32_t count;    /* at most */
    double prefilter; /* what parts' mean cosines are raised to; 1: as they are, 0: all are lines */
    bool
        by_solid_angle; /* whether a part's mean cosine is 1 less its share of the sphere, instead of its light's own */
    uint64_t seed;      /* of where the sphere is cut open */
    const float* importance; /* of light by direction: an equirectangular map of rotation 0, or NULL: all alike */
    int32_t width, height;   /* of it */
} ty_environment_clusters_def;

/* Cuts an environment light into parts: a part's irradiance is that of its stretch of the sphere, so that all together
 * are the environment, channel by channel; its direction is the mean of its light. Parts are cut where the most light
 * changes direction, weighted by importance: a small sun is one part however bright it is, and what is left over goes
 * to where light comes from all over.
 *
 * The length of the mean vector of a part's light is its mean cosine, whatever the part's shape: what Sec. 5.1 of
 * principal-ordinates propagation has 1 - w / N for (w / N being the part's share of the sphere, in a sphere of even
 * radiance). out: room for def->parts. Errors: TY_ERROR_MEMORY. */
ty_result ty_environment_clusters_add(const ty_scene* scene, const ty_environment_clusters_def* def, int32_t light,
                                      ty_discrete_light_set* out);

#endif
