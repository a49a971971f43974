/* Environment lights as clusters of directions. */
#ifndef TY_DIRECT_LIGHTS_ENVIRONMENT_CLUSTERS_H
#define TY_DIRECT_LIGHTS_ENVIRONMENT_CLUSTERS_H

#include "direct/lights/discrete_light.h"

#include <tyndall/scene.h>

typedef struct ty_environment_clusters_def {
    int32_t count;           /* maximum number of clusters */
    double prefilter;        /* exponent of the clusters' mean cosines; 1: unchanged, 0: all are lines */
    bool by_solid_angle;     /* mean cosine 1 - w / N from the cluster's solid angle, instead of the length of its mean
                                vector */
    uint64_t seed;           /* of the column at which the sphere is cut open */
    const float* importance; /* importance by direction: an equirectangular map of rotation 0; NULL: uniform */
    int32_t width, height;   /* of the importance map */
} ty_environment_clusters_def;

/* Appends clusters of an environment light to a set with room for def->count more. The clusters partition the sphere:
 * their irradiances add up to the environment's, channel by channel, and each direction is the mean over the cluster.
 * Splits minimise the loss of mean vector length, weighted by importance: a small sun is one cluster however bright it
 * is, and the rest of the clusters go to extended light.
 *
 * The length of a cluster's mean vector is its mean cosine, whatever its shape. Sec. 5.1 of principal-ordinates
 * propagation uses 1 - w / N, w / N being the cluster's fraction of the sphere, which equals it for uniform radiance.
 * Errors: TY_ERROR_MEMORY. */
ty_result ty_environment_clusters_add(const ty_scene* scene, const ty_environment_clusters_def* def, int32_t light,
                                      ty_discrete_light_set* out);

#endif
