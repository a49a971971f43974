/* Quadrature nodes. */
#include "method/impulse/nodes.h"

#include "base/constants.h"

#include <math.h>

/* Positive nodes of the 12-point Gauss-Legendre rule, and their weights. */
static const double gauss_x[TY_IMPULSE_GAUSS / 2] = {0.1252334085114689, 0.3678314989981802, 0.5873179542866175,
                                                     0.7699026741943047, 0.9041172563704749, 0.9815606342467193};
static const double gauss_weight[TY_IMPULSE_GAUSS / 2] = {0.2491470458134028, 0.2334925365383548, 0.2031674267230659,
                                                          0.1600783285433462, 0.1069393259953184, 0.0471753363865118};

static void add(ty_impulse_nodes* nodes, double x, double weight) {
    if (nodes->count >= TY_IMPULSE_NODES_MAX) return;
    nodes->x[nodes->count] = x;
    nodes->weight[nodes->count++] = weight;
}

void ty_impulse_add_gauss(ty_impulse_nodes* nodes, double a, double b) {
    const double center = 0.5 * (a + b), half = 0.5 * (b - a);
    for (int i = 0; i < TY_IMPULSE_GAUSS / 2; ++i) {
        add(nodes, center - half * gauss_x[i], half * gauss_weight[i]);
        add(nodes, center + half * gauss_x[i], half * gauss_weight[i]);
    }
}

void ty_impulse_add_logarithmic(ty_impulse_nodes* nodes, double a, double b) {
    while (a < b) {
        double next = fmin(6 * a, a + 6);
        if (next > 0.8 * b) next = b;
        const int32_t first = nodes->count;
        ty_impulse_add_gauss(nodes, log(a), log(next));
        for (int32_t i = first; i < nodes->count; ++i) {
            nodes->x[i] = exp(nodes->x[i]);
            nodes->weight[i] *= nodes->x[i];
        }
        a = next;
    }
}

/* Tanh-sinh rule. x - a and b - x are computed from the nearer end, so that nodes there do not coincide. */
void ty_impulse_add_singular(ty_impulse_nodes* nodes, double a, double b, int32_t count) {
    const double half_pi = 0.5 * TY_PI_F64, reach = 3, step = 2 * reach / (count - 1);
    for (int32_t i = 0; i < count; ++i) {
        const double t = -reach + step * i, u = half_pi * sinh(t);
        const double near = 1 / (exp(2 * fabs(u)) + 1); /* fraction of the interval, from the nearer end */
        const double weight = (b - a) * step * half_pi * cosh(t) * 2 * near * (1 - near);
        add(nodes, u < 0 ? a + (b - a) * near : b - (b - a) * near, weight);
    }
}
