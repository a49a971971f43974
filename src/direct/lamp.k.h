/* Light from a point on cells: what a cell gets on the mean, and how far a lamp's light is dimmed on a lattice of rays.
 */
#ifndef TY_DIRECT_LAMP_K_H
#define TY_DIRECT_LAMP_K_H

#include "direct/beam.k.h"
#include "scene/light.k.h"

/* ln(sinh x / x) for x >= 0: what an exponential's mean over [-x, x] is above its middle. */
TY_FN float ty_log_sinhc(float x) {
    const float square = x * x;
    if (x < 0.3f) return square * (1.0f / 6.0f - square * (1.0f / 180.0f));
    return x + ty_logf((1.0f - ty_decay(2.0f * x)) / (2.0f * x));
}

/* The optical depth around a cell's middle. */
typedef struct ty_lamp_depth {
    float depth;      /* in the middle */
    float extinction; /* of the cell, 1/m */
    ty_vec slope;     /* gradient of the depth over extinction */
} ty_lamp_depth;

/* The mean of the transmittance over a cell: exact where the depth is linear. */
TY_FN float ty_lamp_mean_transmittance(ty_lamp_depth d, const float cell[3]) {
    const float slope[3] = {d.slope.x, d.slope.y, d.slope.z};
    float log_mean = -d.depth;
    for (int32_t a = 0; a < 3; ++a) log_mean += ty_log_sinhc(0.5f * d.extinction * fabsf(slope[a]) * cell[a]);
    return ty_decay(ty_maxf(0.0f, -log_mean));
}

/* The mean of transmittance / r^2 over a cell, relative to 1 / r^2 in its middle, to second order in the cell's size
 * over r. to: unit, from the lamp. */
TY_FN float ty_lamp_mean(ty_lamp_depth d, ty_vec to, float distance, const float cell[3]) {
    const float way[3] = {to.x, to.y, to.z}, slope[3] = {d.slope.x, d.slope.y, d.slope.z};
    const float inverse = 1.0f / distance;
    float spread = 1.0f;
    for (int32_t a = 0; a < 3; ++a) {
        const float square = way[a] * way[a];
        const float bent = d.extinction * (4.0f * way[a] * slope[a] - (1.0f - square));
        spread += cell[a] * cell[a] * (1.0f / 24.0f) * inverse * ((8.0f * square - 2.0f) * inverse + bent);
    }
    return ty_lamp_mean_transmittance(d, cell) * spread;
}

#endif
