/* Fits of phase functions that are too narrow for the bands that the directions resolve. Truncated after L bands
 * (delta-M, Wiscombe 1977), the remainder oscillates between large and negative values at wide angles, which are what
 * views from the side see. So L bands are fitted to the phase function outside of the peak (delta-fit, Hu et al. 2000),
 * and the rest counts as unscattered. */
#include "base/legendre.k.h"
#include "method/dom/solve/solve.h"
#include "scene/media/phase.k.h"

#include <math.h>

/* Half angle of the peak that the fit ignores. Relative errors beyond it are weighted by solid angle plus min_weight,
 * which keeps backscattering in. Number of angles. */
static const double peak_angle = 0.7, min_weight = 0.02;
enum { ANGLES = 400 };

/* Number of exact low-order moments. With the third (l = 2) the lateral spread is exact. An odd number, as even ones
 * make images darker; more where enough free bands remain. */
static int32_t exact_bands(int32_t bands) {
    return bands < TY_DOM_BANDS_MAX ? 3 : 5;
}

/* Normal equations of the least-squares fit. */
typedef struct normal {
    double a[TY_DOM_BANDS_MAX][TY_DOM_BANDS_MAX], b[TY_DOM_BANDS_MAX];
    int32_t count;
} normal;

static void add_row(normal* n, const double* row, double target, double weight) {
    for (int32_t i = 0; i < n->count; ++i) {
        n->b[i] += weight * row[i] * target;
        for (int32_t j = 0; j < n->count; ++j) n->a[i][j] += weight * row[i] * row[j];
    }
}

/* Solves by Cholesky factors, in place. */
static void solve(normal* n, double* x) {
    for (int32_t i = 0; i < n->count; ++i)
        for (int32_t j = 0; j <= i; ++j) {
            double sum = n->a[i][j];
            for (int32_t k = 0; k < j; ++k) sum -= n->a[i][k] * n->a[j][k];
            n->a[i][j] = i == j ? sqrt(sum) : sum / n->a[j][j];
        }
    for (int32_t i = 0; i < n->count; ++i) {
        x[i] = n->b[i];
        for (int32_t k = 0; k < i; ++k) x[i] -= n->a[i][k] * x[k];
        x[i] /= n->a[i][i];
    }
    for (int32_t i = n->count - 1; i >= 0; --i) {
        for (int32_t k = i + 1; k < n->count; ++k) x[i] -= n->a[k][i] * x[k];
        x[i] /= n->a[i][i];
    }
}

/* Basis relative to the phase function: (2 l + 1) P_l(mu) / (4 pi p(mu)), l < bands. */
static void relative_terms(double mu, double g, int32_t bands, double* terms) {
    const double phase = 4 * (double)TY_PI * (double)ty_hg((float)mu, (float)g);
    double p_before = 0, p_l = 1;
    for (int32_t l = 0; l < bands; ++l) {
        terms[l] = (2 * l + 1) * p_l / phase;
        const double p_next = ty_legendre_next_f64(l, mu, p_l, p_before);
        p_before = p_l;
        p_l = p_next;
    }
}

void ty_dom_fit_phase(double g, int32_t bands, ty_forward_fit* out) {
    const int32_t exact = exact_bands(bands);
    normal n = {.count = bands - exact + 1};
    double terms[TY_DOM_BANDS_MAX], x[TY_DOM_BANDS_MAX];
    for (int32_t i = 0; i < ANGLES; ++i) {
        const double angle = peak_angle + ((double)TY_PI - peak_angle) * (i + 0.5) / ANGLES;
        relative_terms(cos(angle), g, bands, terms);
        /* For exact moments c_l = c_0 - (1 - g^l): the forward fraction does not contribute to 1 - g^l. */
        double target = 1;
        for (int32_t l = 1; l < exact; ++l) {
            target += (1 - pow(g, l)) * terms[l];
            terms[0] += terms[l];
        }
        for (int32_t l = exact; l < bands; ++l) terms[l - exact + 1] = terms[l];
        add_row(&n, terms, target, sin(angle) + min_weight);
    }
    solve(&n, x);
    out->bands = bands;
    out->forward_fraction = (float)(1 - x[0]);
    out->moments[0] = (float)x[0];
    for (int32_t l = 1; l < exact; ++l) out->moments[l] = (float)(x[0] - (1 - pow(g, l)));
    for (int32_t l = exact; l < bands; ++l) out->moments[l] = (float)x[l - exact + 1];
}
