/* Loops of the propagation between cells; compiled once per instruction set, named by TY_ISA. */
#include "method/pop/published/propagate_kernel.h"

#include "direct/media/attenuation.k.h"
#include "method/pop/grid/lobe.k.h"

static void fill_half(const ty_pop_slab* slab, float fraction, const float* loss, const float* absorption,
                      float* half_transmittance, float* half_retained) {
    const float* length = slab->length;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        const float half = 0.5f * fraction * length[i];
        half_transmittance[i] = ty_attenuation(absorption[i] * half);
        half_retained[i] = ty_attenuation(loss[i] * half);
    }
}

/* Absorption over half a step, and the anisotropy retained over it: g^(sigma_s dx), Eq. 4 (Elek 2014), or the exact
 * exp(-sigma_s (1 - g) dx). */
static void initial_slab(const ty_pop_slab* slab, ty_pop_initial_slab* s) {
    float loss[TY_POP_BLOCK], absorption[TY_POP_BLOCK];
    const float *extinction = slab->extinction[s->plane], *scattering = slab->scattering[s->plane];
    const float *g = slab->g[s->plane], *mean = s->mean, *length = slab->length;
    const float published = s->collided != 0 ? 0.0f : 1.0f;
    float *light = s->light, *next_g = s->next_g;
#pragma omp simd
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        /* Eq. 4 (Elek 2014): g^(sigma_s dx) = exp(-sigma_s dx (-ln g)); the exact mean cosine after a Poisson number
         * of scatterings is exp(-sigma_s dx (1 - g)) */
        const float eq4_loss = -ty_logf(ty_clampf(g[i], 1e-35f, 1.0f));
        const float mean_cosine_loss = 1.0f - g[i], sigma = scattering[i];
        absorption[i] = extinction[i] - sigma;
        loss[i] = sigma * (published * eq4_loss + (1.0f - published) * mean_cosine_loss);
        light[i] = mean[i] * (published + (1.0f - published) * sigma * length[i]);
        next_g[i] = published + (1.0f - published) * g[i];
    }
    fill_half(slab, 1.0f, loss, absorption, s->pass[0], s->anisotropy_retained[0]);
    fill_half(slab, s->across, loss, absorption, s->pass[1], s->anisotropy_retained[1]);
}

static void initial_cells(const ty_pop_initial_cells* b) {
    const float *uncollided = b->uncollided, *light = b->light, *next_g = b->next_g,
                *two_one_minus_mu = b->two_one_minus_mu, start = b->cosine;
    float *cosine = b->cosines, *fluence = b->fluence, *accumulated_radiance = b->accumulated_radiance;
    const float collided = b->collided != 0 ? 1.0f : 0.0f;
#pragma omp simd
    for (int32_t i = 0; i < b->count; ++i) {
        const float once = start * next_g[i], new = collided *light[i];
        cosine[i] = once;
        fluence[i] = uncollided[i] + new;
        accumulated_radiance[i] = collided * uncollided[i] * ty_pop_hg_fast(two_one_minus_mu[i], once) +
                                  new* ty_pop_hg_fast(two_one_minus_mu[i], once * next_g[i]);
    }
}

static float sum(const float* values, int32_t count) {
    float total = 0.0f;
#pragma omp simd reduction(+ : total)
    for (int32_t i = 0; i < count; ++i) total += values[i];
    return total;
}

/* dL and dL a that cells send to their neighbours: the terms of Eq. 5 and 6 (Elek 2014). */
static void scatter_to_neighbours(const ty_pop_scatter_slice* slice) {
    const float *light = slice->light, *cosine = slice->cosine;
    const float *transmittance_along = slice->half.pass[0], *transmittance_across = slice->half.pass[1];
    const float *retained_along = slice->half.anisotropy_retained[0],
                *retained_across = slice->half.anisotropy_retained[1];
    const ty_pop_outgoing out = slice->out;
#pragma omp simd
    for (int32_t i = 0; i < slice->count; ++i) {
        float front, side, back;
        /* Eq. 2-4 (Elek 2014): dL = L T F, a g^(sigma_s dx), the source cell's half of both factors */
        ty_pop_patch_fractions(cosine[i], &front, &side, &back);
        const float along = light[i] * transmittance_along[i], across = light[i] * transmittance_across[i];
        const float moment_along = along * cosine[i] * retained_along[i];
        const float moment_across = across * cosine[i] * retained_across[i];
        out.front[i] = along * front;
        out.back[i] = along * back;
        out.side[i] = across * side;
        out.front_moment[i] = moment_along * front;
        out.back_moment[i] = moment_along * back;
        out.side_moment[i] = moment_across * side;
    }
}

/* L = sum dL and a = sum dL a / sum dL over the neighbours: Eq. 5 and 6 (Elek 2014). */
static void gather_from_neighbours(const ty_pop_gather_slice* slice) {
    const int32_t row = slice->row;
    const float *transmittance_along = slice->half.pass[0], *transmittance_across = slice->half.pass[1];
    const float *retained_along = slice->half.anisotropy_retained[0],
                *retained_across = slice->half.anisotropy_retained[1];
    const float *front = slice->before.front, *front_moment = slice->before.front_moment;
    const float *back = slice->after.back, *back_moment = slice->after.back_moment;
    const float *side = slice->beside.side, *side_moment = slice->beside.side_moment;
    const float *two_one_minus_mu = slice->two_one_minus_mu, *next_g = slice->next_g;
    float *light = slice->light, *cosine = slice->cosine, *fluence = slice->fluence,
          *accumulated_radiance = slice->accumulated_radiance;
#pragma omp simd
    for (int32_t i = slice->begin; i < slice->end; ++i) {
        const float across = transmittance_across[i] * (side[i - 1] + side[i + 1] + side[i - row] + side[i + row]);
        const float moment_across =
            retained_across[i] * transmittance_across[i] *
            (side_moment[i - 1] + side_moment[i + 1] + side_moment[i - row] + side_moment[i + row]);
        const float along = transmittance_along[i] * (front[i] + back[i]);
        const float moment_along = retained_along[i] * transmittance_along[i] * (front_moment[i] + back_moment[i]);
        const float all = along + across;                                /* Eq. 5 (Elek 2014) */
        const float a = (moment_along + moment_across) / (all + 1e-30f); /* Eq. 6 (Elek 2014) */
        light[i] = all;
        cosine[i] = a;
        fluence[i] += all;
        accumulated_radiance[i] += all * ty_pop_hg_fast(two_one_minus_mu[i], a * next_g[i]); /* Eq. 7-8 (Elek 2014) */
    }
}

const ty_pop_propagation_kernels TY_KERNEL_NAME(ty_pop_propagation_kernels) = {
    .initial_slab = initial_slab,
    .initial_cells = initial_cells,
    .sum = sum,
    .scatter_to_neighbours = scatter_to_neighbours,
    .gather_from_neighbours = gather_from_neighbours,
};
