/* Response of a half space to collimated light from above. Everything depends on depth alone. With mu the cosine
 * between the direction of incidence at the receiver and the direction to the emitter, single scattering gives
 *
 *     L(z, mu) = p(mu) exp(-z) (1 - exp(-z (1 - mu) / mu)) / (1 - mu),  for mu < 0 without the second exp,
 *
 * and multiple scattering the harmonics
 *
 *     1/2 integral over z' of fluence(z') integral over mu of exp(-|z - z'| / |mu|) y_l(mu) / |mu|.
 */
#include "method/impulse/build.h"

enum { COSINES = 64 };

/* Once-scattered radiance divided by the phase function. */
static double single_radiance(double z, double mu) {
    const double one_minus_mu = 1 - mu;
    if (mu <= 0) return exp(-z) / one_minus_mu;
    return one_minus_mu > 0 ? -exp(-z) * expm1(-z * one_minus_mu / mu) / one_minus_mu : exp(-z) * z;
}

void ty_impulse_half_space_single(void* user, int64_t index, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    double sums[TY_IMPULSE_PHASES][TY_IMPULSE_TERMS] = {0}, zonal[TY_IMPULSE_TERMS];
    ty_impulse_nodes nodes = {0};
    ty_impulse_add_singular(&nodes, -1, 0, COSINES);
    ty_impulse_add_singular(&nodes, 0, 1, COSINES);
    for (int32_t i = 0; i < nodes.count; ++i) {
        const double mu = nodes.x[i];
        const double light = 2 * TY_PI_F64 * nodes.weight[i] * single_radiance(work->distances[index], mu);
        ty_impulse_zonal(mu, zonal);
        for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
            for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
                sums[g][l] += light * ty_hg_f64(mu, TY_IMPULSE_PHASE_G * (g - 1)) * zonal[l];
    }
    ty_impulse_half_space_fluence(work, 1)[index] = ty_impulse_zonal_norm(0) * sums[1][0];
    if (index >= TY_IMPULSE_DISTANCES) return;
    for (int32_t g = 0; g < TY_IMPULSE_PHASES; ++g)
        ty_impulse_store(work, TY_IMPULSE_DIRECTIONAL, 0, (int32_t)index, g, sums[g]);
}

/* Zonal harmonics of one layer at a distance above or below, per unit of its fluence and thickness. */
static void layer_response(double distance, bool above, double out[TY_IMPULSE_TERMS]) {
    const double reach = 30;
    ty_impulse_nodes path_lengths = {0};
    double zonal[TY_IMPULSE_TERMS];
    for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] = 0;
    if (distance > 0) ty_impulse_add_logarithmic(&path_lengths, distance, distance + reach);
    for (int32_t i = 0; i < path_lengths.count; ++i) {
        const double t = path_lengths.x[i], direction_weight = 0.5 * path_lengths.weight[i] * exp(-t) / t;
        ty_impulse_zonal(above ? distance / t : -distance / t, zonal);
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) out[l] += direction_weight * zonal[l];
    }
}

/* Rows of the operator for one distance: [term][distance], the response to all layers. */
void ty_impulse_make_half_space_operator(void* user, int64_t index, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double z = work->distances[index];
    double* rows = work->half_space_operator + (size_t)index * TY_IMPULSE_TERMS * (size_t)work->distance_count;
    ty_impulse_nodes depths = {0};
    ty_impulse_add_radii(work, z, &depths);
    for (int32_t i = 0; i < depths.count; ++i) {
        int32_t first;
        double weight[4], response[TY_IMPULSE_TERMS];
        if (!ty_impulse_cubic_weights(work, depths.x[i], &first, weight)) continue;
        layer_response(fabs(z - depths.x[i]), depths.x[i] < z, response);
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l)
            for (int32_t j = 0; j < 4; ++j)
                rows[l * work->distance_count + first + j] += depths.weight[i] * weight[j] * response[l];
    }
}

void ty_impulse_half_space_multiple(void* user, int64_t bin, int32_t worker) {
    ty_impulse_work* work = user;
    (void)worker;
    const double* rows = work->half_space_operator + (size_t)bin * TY_IMPULSE_TERMS * (size_t)work->distance_count;
    for (int32_t bounce = 2; bounce <= work->tables->bounces; ++bounce) {
        const double* fluence = ty_impulse_half_space_fluence(work, bounce - 1);
        double zonal[TY_IMPULSE_TERMS];
        for (int32_t l = 0; l < TY_IMPULSE_TERMS; ++l) {
            zonal[l] = 0;
            for (int32_t j = 0; j < work->distance_count; ++j)
                zonal[l] += rows[l * work->distance_count + j] * fluence[j];
        }
        ty_impulse_store(work, TY_IMPULSE_DIRECTIONAL, 0, (int32_t)bin, TY_IMPULSE_PHASES + bounce - 2, zonal);
    }
}
