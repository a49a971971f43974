/* Similarity of rays that end on surfaces: which of those around a pixel it is interpolated from. */
#ifndef TY_IMAGE_SIMILARITY_K_H
#define TY_IMAGE_SIMILARITY_K_H

#include "base/vector.k.h"

/* Relative difference of distances at which the similarity is 0. */
#define TY_SIMILARITY_TOLERANCE 0.1f
/* Total weight of the rays around a pixel below which it gets a ray of its own. */
#define TY_SIMILARITY_WEIGHT_MIN (1.0f / 64.0f)

/* Similarity of two distances, 0..1; TY_FLOAT_MAX stands for an unbounded ray. */
TY_FN float ty_similarity(float a, float b) {
    const float apart = fabsf(a - b), within = TY_SIMILARITY_TOLERANCE * ty_minf(a, b);
    const float x = within > 0.0f ? apart / within : apart > 0.0f ? 1.0f : 0.0f;
    const float left = ty_maxf(0.0f, 1.0f - x * x);
    return left * left;
}

#endif
