/* Linear regression with few terms, whose signs may be known. */
#ifndef TY_FIGURES_REGRESSION_H
#define TY_FIGURES_REGRESSION_H

#include <stdint.h>

enum { REGRESSION_TERMS_MAX = 24 };

/* Knowledge of the sign of a coefficient. */
typedef enum regression_sign {
    REGRESSION_NONE,       /* it is 0 */
    REGRESSION_ANY,        /* nothing */
    REGRESSION_INCREASING, /* it is not negative */
    REGRESSION_DECREASING  /* it is not positive */
} regression_sign;

/* Fits the sum of coefficients times terms to values, by least squares with `ridge` times the squares of the
 * coefficients of terms scaled to a variance of 1. terms: count rows of term_count numbers, the first of which is 1.
 * Coefficients of a wrong sign are left out, the largest first. Rows whose weight is 0 do not count. */
void regression_fit(const double* terms, const double* values, const double* weights, int32_t count, int32_t term_count,
                    const regression_sign* signs, double ridge, double* out);

#endif
