#include "figures/regression.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { N = REGRESSION_TERMS_MAX };

/* The terms that take part, with their means and standard deviations. */
typedef struct design {
    int32_t used[N], count; /* used[0] is the constant */
    double mean[N], deviation[N];
} design;

static double weighted_mean(const double* values, const double* weights, int32_t count, int32_t stride) {
    double sum = 0, all = 0;
    for (int32_t i = 0; i < count; ++i) {
        sum += weights[i] * values[(int64_t)i * stride];
        all += weights[i];
    }
    return all > 0 ? sum / all : 0;
}

static void scale(design* of, const double* terms, const double* weights, int32_t count, int32_t stride) {
    of->mean[0] = 0;
    of->deviation[0] = 1;
    for (int32_t k = 1; k < of->count; ++k) {
        double squares = 0, all = 0;
        of->mean[k] = weighted_mean(terms + of->used[k], weights, count, stride);
        for (int32_t i = 0; i < count; ++i) {
            const double difference = terms[(int64_t)i * stride + of->used[k]] - of->mean[k];
            squares += weights[i] * difference * difference;
            all += weights[i];
        }
        of->deviation[k] = fmax(sqrt(squares / fmax(all, 1e-9)), 1e-3);
    }
}

/* Gauss's elimination of a positive definite system, whose right side becomes the solution. */
static void solve(double matrix[N][N], double right[N], int32_t count) {
    for (int32_t k = 0; k < count; ++k)
        for (int32_t i = k + 1; i < count; ++i) {
            const double factor = matrix[i][k] / matrix[k][k];
            for (int32_t j = k; j < count; ++j) matrix[i][j] -= factor * matrix[k][j];
            right[i] -= factor * right[k];
        }
    for (int32_t k = count - 1; k >= 0; --k) {
        for (int32_t j = k + 1; j < count; ++j) right[k] -= matrix[k][j] * right[j];
        right[k] /= matrix[k][k];
    }
}

static void fit(const design* of, const double* terms, const double* values, const double* weights, int32_t count,
                int32_t stride, double ridge, double out[N]) {
    double matrix[N][N] = {{0}}, row[N];
    memset(out, 0, N * sizeof *out);
    for (int32_t i = 0; i < count; ++i) {
        for (int32_t k = 0; k < of->count; ++k)
            row[k] = (terms[(int64_t)i * stride + of->used[k]] - of->mean[k]) / of->deviation[k];
        for (int32_t k = 0; k < of->count; ++k) {
            out[k] += weights[i] * row[k] * values[i];
            for (int32_t j = 0; j < of->count; ++j) matrix[k][j] += weights[i] * row[k] * row[j];
        }
    }
    for (int32_t k = 1; k < of->count; ++k) matrix[k][k] += ridge;
    solve(matrix, out, of->count);
}

/* The number of the term whose coefficient is of the wrong sign and largest; 0: none is. */
static int32_t find_wrong(const design* of, const regression_sign* signs, const double scaled[N]) {
    int32_t worst = 0;
    double largest = 0;
    for (int32_t k = 1; k < of->count; ++k) {
        const regression_sign sign = signs[of->used[k]];
        const bool wrong =
            sign == REGRESSION_INCREASING ? scaled[k] < 0 : sign == REGRESSION_DECREASING && scaled[k] > 0;
        if (!wrong || fabs(scaled[k]) <= largest) continue;
        worst = k;
        largest = fabs(scaled[k]);
    }
    return worst;
}

void regression_fit(const double* terms, const double* values, const double* weights, int32_t count, int32_t term_count,
                    const regression_sign* signs, double ridge, double* out) {
    design of = {.count = 1};
    double scaled[N];
    for (int32_t t = 1; t < term_count; ++t)
        if (signs[t] != REGRESSION_NONE) of.used[of.count++] = t;
    for (;;) {
        scale(&of, terms, weights, count, term_count);
        fit(&of, terms, values, weights, count, term_count, ridge, scaled);
        const int32_t wrong = find_wrong(&of, signs, scaled);
        if (wrong == 0) break;
        memmove(of.used + wrong, of.used + wrong + 1, (size_t)(of.count - wrong - 1) * sizeof *of.used);
        --of.count;
    }
    for (int32_t t = 0; t < term_count; ++t) out[t] = 0;
    out[0] = scaled[0];
    for (int32_t k = 1; k < of.count; ++k) {
        out[of.used[k]] = scaled[k] / of.deviation[k];
        out[0] -= out[of.used[k]] * of.mean[k];
    }
}
