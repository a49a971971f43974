/* Phase functions other than Henyey-Greenstein: sums of lobes, each Henyey-Greenstein times 1 + alpha mu^2 (Draine
 * 2003) or a table. */
#ifndef TY_SCENE_MEDIA_PHASE_LOBES_K_H
#define TY_SCENE_MEDIA_PHASE_LOBES_K_H

#include "scene/media/phase.k.h"

/* Terms of a phase function, and Legendre moments 0..13. */
enum { TY_PHASE_TERMS_MAX = 16, TY_PHASE_MOMENTS = 14 };

/* A node of a table that is linear in the cosine mu, from forward to backward. */
typedef struct ty_phase_node {
    float one_minus_mu;
    float value; /* 1/sr */
    float cdf;   /* integral of the function up to the node */
} ty_phase_node;

typedef struct ty_phase_term {
    float weight[3]; /* fraction per channel; the sum over all terms is 1 */
    float g, alpha;
    float scale;                          /* 3 / (3 + alpha (1 + 2 g^2)) */
    int32_t node_count;                   /* 0: no table */
    TY_GLOBAL const ty_phase_node* nodes; /* instead of g, alpha and scale */
} ty_phase_term;

typedef struct ty_phase_view {
    int32_t count;
    int32_t gray; /* equal weights in all channels */
    ty_phase_term terms[TY_PHASE_TERMS_MAX];
    float moments[3][TY_PHASE_MOMENTS]; /* Legendre moments per channel */
} ty_phase_view;

/* ---- tables ---- */

/* The last node at or before 1 - mu, and the last one whose integral is at most `cdf`. */
TY_FN int32_t ty_phase_find_node(TY_GLOBAL const ty_phase_term* term, float one_minus_mu) {
    int32_t low = 0, high = term->node_count - 1;
    while (high - low > 1) {
        const int32_t center = (low + high) / 2;
        if (term->nodes[center].one_minus_mu <= one_minus_mu)
            low = center;
        else
            high = center;
    }
    return low;
}

TY_FN int32_t ty_phase_find_cdf(TY_GLOBAL const ty_phase_term* term, float cdf) {
    int32_t low = 0, high = term->node_count - 1;
    while (high - low > 1) {
        const int32_t center = (low + high) / 2;
        if (term->nodes[center].cdf <= cdf)
            low = center;
        else
            high = center;
    }
    return low;
}

TY_FN float ty_phase_table_value(TY_GLOBAL const ty_phase_term* term, float one_minus_mu) {
    TY_GLOBAL const ty_phase_node* node = &term->nodes[ty_phase_find_node(term, one_minus_mu)];
    return ty_lerpf(node[0].value, node[1].value,
                    (one_minus_mu - node[0].one_minus_mu) /
                        ty_maxf(node[1].one_minus_mu - node[0].one_minus_mu, 1e-9f));
}

/* 1 - mu at which the integral is u; the integral is quadratic between nodes. */
TY_FN float ty_phase_table_sample(TY_GLOBAL const ty_phase_term* term, float u) {
    TY_GLOBAL const ty_phase_node* node = &term->nodes[ty_phase_find_cdf(term, u)];
    const float width = ty_maxf(node[1].one_minus_mu - node[0].one_minus_mu, 1e-9f);
    const float slope = (node[1].value - node[0].value) / width;
    const float rest = ty_maxf(0.0f, u - node[0].cdf) * (1.0f / (2.0f * TY_PI));
    const float root = sqrtf(ty_maxf(0.0f, node[0].value * node[0].value + 2.0f * slope * rest));
    return node[0].one_minus_mu + ty_minf(width, 2.0f * rest / ty_maxf(node[0].value + root, 1e-30f));
}

/* ---- Draine ---- */

/* The fraction u of light that a Draine lobe scatters into cosines above one, as the fraction H of the same for
 * Henyey-Greenstein. With r = sqrt(1 + g^2 - 2 g mu) = 1 - g + 2 g q, q = 0 .. 1, (own derivation)
 * mu = 1 - 2 (1 - g) q - 2 g q^2,   H = (1 + g) q / r,
 * u = H (1 + alpha ((1 - (1 - g) q)^2 + r (1 - g) q^2 / 3)) scale,   du/dH = (1 + alpha mu^2) scale,
 * none of which cancels at g = 0 or 1. Solved for H by Newton's iteration within a bracket. */
TY_FN float ty_draine_solve(float g, float alpha, float scale, float u) {
    float low = 0.0f, high = 1.0f, fraction = u;
    for (int32_t i = 0; i < 24; ++i) {
        const float less = 1.0f - g;
        const float q = fraction * less / ty_maxf(1.0f + g - 2.0f * g * fraction, 1e-30f), r = less + 2.0f * g * q;
        const float mu = 1.0f - 2.0f * q * (less + g * q), near = 1.0f - less * q;
        const float excess = fraction * (1.0f + alpha * (near * near + r * less * q * q * (1.0f / 3.0f))) * scale - u;
        if (excess > 0.0f)
            high = fraction;
        else
            low = fraction;
        const float newton = fraction - excess / ((1.0f + alpha * mu * mu) * scale);
        const float next = newton > low && newton < high ? newton : 0.5f * (low + high);
        const bool done = fabsf(next - fraction) <= 1e-6f * next;
        fraction = next;
        if (done) break;
    }
    return fraction;
}

/* ---- all ---- */

/* The term's value at cosine mu, 1/sr. */
TY_FN float ty_phase_term_value(TY_GLOBAL const ty_phase_term* term, float mu) {
    if (term->node_count > 0) return ty_phase_table_value(term, 1.0f - mu);
    return ty_hg(mu, term->g) * (1.0f + term->alpha * mu * mu) * term->scale;
}

/* Inverse CDF of a term's cosine, u in [0, 1). */
TY_FN float ty_phase_term_sample(TY_GLOBAL const ty_phase_term* term, float u) {
    if (term->node_count > 0) return 1.0f - ty_phase_table_sample(term, u);
    if (term->alpha > 0.0f) u = ty_draine_solve(term->g, term->alpha, term->scale, u);
    return ty_hg_sample_cosine(term->g, u);
}

/* The phase function per channel at cosine mu in [-1, 1], 1/sr. */
TY_FN_CALLED void ty_phase_evaluate(TY_GLOBAL const ty_phase_view* phase, float mu, float values[3]) {
    values[0] = values[1] = values[2] = 0.0f;
    for (int32_t i = 0; i < phase->count; ++i) {
        TY_GLOBAL const ty_phase_term* term = &phase->terms[i];
        const float value = ty_phase_term_value(term, mu);
        for (int32_t c = 0; c < 3; ++c) values[c] += term->weight[c] * value;
    }
}

/* A cosine of the mixture of the channels' phase functions by weights whose sum is 1; u in [0, 1). */
TY_FN_CALLED float ty_phase_sample_cosine(TY_GLOBAL const ty_phase_view* phase, const float weight[3], float u) {
    int32_t i = 0;
    float fraction;
    for (;; ++i) {
        TY_GLOBAL const float* of_term = phase->terms[i].weight;
        fraction = weight[0] * of_term[0] + weight[1] * of_term[1] + weight[2] * of_term[2];
        if (u < fraction || i + 1 >= phase->count) break;
        u -= fraction;
    }
    return ty_phase_term_sample(&phase->terms[i], ty_clampf(u / ty_maxf(fraction, 1e-30f), 0.0f, 0x1.fffffep-1f));
}

#endif
