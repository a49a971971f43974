/* Bonnet's recurrence of the Legendre polynomials: (l + 1) P_l+1 = (2 l + 1) mu P_l - l P_l-1. */
#ifndef TY_BASE_LEGENDRE_K_H
#define TY_BASE_LEGENDRE_K_H

#include "base/kernel.h"

/* P_l+1(mu) from now = P_l and before = P_l-1; any number serves as P_-1. */
TY_FN float ty_legendre_next(int32_t l, float mu, float now, float before) {
    return ((float)(2 * l + 1) * mu * now - (float)l * before) / (float)(l + 1);
}

#if !defined(__OPENCL_C_VERSION__)
TY_FN double ty_legendre_next_f64(int32_t l, double mu, double now, double before) {
    return ((2 * l + 1) * mu * now - l * before) / (l + 1);
}
#endif

#endif
