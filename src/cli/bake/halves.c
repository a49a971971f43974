/* tyndall bake --denoise: light of two independent halves of the paths, and their mean. */
#include "cli/bake/bake.h"

#include <math.h>

/* Seed of the odd half, over that of the even one. */
static const uint64_t odd_seed = 0xb5ad4eceda1ce2a9u;

ty_bake_def bake_half_def(const ty_bake_def* def, int half) {
    ty_bake_def own = *def;
    own.spp = half == 0 ? (def->spp + 1) / 2 : def->spp / 2;
    own.error = def->error * sqrt(2);
    if (half == 1) own.seed ^= odd_seed;
    return own;
}

void bake_join_halves(const ty_bake_light* even, const ty_bake_light* odd, int64_t count, ty_bake_light* out) {
    for (int64_t i = 0; i < count; ++i) {
        const ty_bake_light *a = &even[i], *b = &odd[i];
        out[i] = a->samples > 0 ? *a : *b;
        if (a->samples == 0 || b->samples == 0) continue;
        const float n = (float)(a->samples + b->samples), p = (float)a->samples / n, q = (float)b->samples / n;
        out[i].samples = a->samples + b->samples;
        out[i].blocked = p * a->blocked + q * b->blocked;
        for (int c = 0; c < 3; ++c) {
            out[i].fluence[c] = p * a->fluence[c] + q * b->fluence[c];
            out[i].variance[c] = p * p * a->variance[c] + q * q * b->variance[c];
            for (int layer = 0; layer < TY_BAKE_LAYERS; ++layer) {
                out[i].irradiance[layer][c] = p * a->irradiance[layer][c] + q * b->irradiance[layer][c];
                for (int axis = 0; axis < 3; ++axis)
                    out[i].vector_irradiance[layer][c][axis] =
                        p * a->vector_irradiance[layer][c][axis] + q * b->vector_irradiance[layer][c][axis];
            }
        }
    }
}
