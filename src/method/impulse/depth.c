/* Light of a direction, from above into a half space. Everything depends on depth alone. With mu the cosine between
 * where light comes from and the emitter's direction,
 *
 *     once scattered    L(z, mu) = p(mu) exp(-z) (1 - exp(-z (1 - mu) / mu)) / (1 - mu),  for mu < 0 without the exp,
 *     harmonics of more 1/2 integral over z' of fluence(z') integral over mu of exp(-|z - z'| / |mu|) y_l(mu) / |mu|.
 */
#include "method/impulse/build.h"

enum { COSINES = 64 };

/* Over the phase function. */
static double radiance_once(double z, double mu) {
    const double off = 1 - mu;
    if (mu <= 0) return exp(-z) / off;
    return off > 0 ? -exp(-z) * expm1(-z * off / mu) / off : exp(-z) * z;
}

void ty_impulse_sink_once(void* user, int64_t place, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    double sums[TY_IMPULSE_PHASES][TY_IMPULSE_TERMS] = {0}, zonal[TY_IMPULSE_TERMS];
    ty_impulse_nodes nodes = {0};
    ty_impulse_add_singular(&nodes, -1, 0, COSINES);
    ty_impulse_add_singular(&nodes, 0, 1, COSINES);
    for (int32_t i = 0; i < nodes.count; ++i) {
        const double mu = nodes.x[i];
        const double light = 2 * TY_PI_F64 * nodes.weight[i] * radiance_once(work->distances[place], mu);
        ty_impulse_zonal(mu, zonal);
        for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
            for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
                sums[g][l] += light * ty_hg_f64(mu, TY_IMPULSE_PHASE_G * (g - 1)) * zonal[l];
    }
    ty_impulse_depth(work, 1)[place] = sqrt(4 * TY_PI_F64) * sums[1][0];
    if (place >= TY_IMPULSE_DISTANCES) return;
    for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
        ty_impulse_keep(work, TY_IMPULSE_DIRECTIONAL, 0, (int32_t)place, g, sums[g]);
}

/* Of one layer at a distance above or below, per unit of its fluence and thickness. */
static void layer(double away, bool above, double out[TY_IMPULSE_TERMS]) {
    const double reach = 30;
    ty_impulse_nodes ways = {0};
    double zonal[TY_IMPULSE_TERMS];
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] = 0;
    if (away > 0) ty_impulse_add_logarithmic(&ways, away, away + reach);
    for (int32_t i = 0; i < ways.count; ++i) {
        const double t = ways.x[i], share = 0.5 * ways.weight[i] * exp(-t) / t;
        ty_impulse_zonal(above ? away / t : -away / t, zonal);
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] += share * zonal[l];
    }
}

/* A place's rows: [term][place], the response of all layers. */
void ty_impulse_make_sink(void* user, int64_t place, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double z = work->distances[place];
    double* rows = work->sink + (size_t)place * TY_IMPULSE_TERMS * (size_t)work->places;
    ty_impulse_nodes depths = {0};
    ty_impulse_add_radii(work, z, &depths);
    for (int32_t i = 0; i < depths.count; ++i) {
        int32_t first;
        double weight[4], response[TY_IMPULSE_TERMS];
        if (!ty_impulse_around(work, depths.x[i], &first, weight)) continue;
        layer(fabs(z - depths.x[i]), depths.x[i] < z, response);
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
            for (int32_t j = 0; j < 4; ++j)
                rows[l * work->places + first + j] += depths.weight[i] * weight[j] * response[l];
    }
}

void ty_impulse_sink_again(void* user, int64_t bin, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double* rows = work->sink + (size_t)bin * TY_IMPULSE_TERMS * (size_t)work->places;
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce) {
        const double* fluence = ty_impulse_depth(work, bounce - 1);
        double zonal[TY_IMPULSE_TERMS];
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
            zonal[l] = 0;
            for (int32_t j = 0; j < work->places; ++j) zonal[l] += rows[l * work->places + j] * fluence[j];
        }
        ty_impulse_keep(work, TY_IMPULSE_DIRECTIONAL, 0, (int32_t)bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
}
