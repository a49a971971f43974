/* Quadrature nodes: Gauss-Legendre in panels that shrink towards a singularity, tanh-sinh for singular ends. */
#ifndef TY_METHOD_IMPULSE_NODES_H
#define TY_METHOD_IMPULSE_NODES_H

#include <stdint.h>

enum { TY_IMPULSE_GAUSS = 12, TY_IMPULSE_NODES_MAX = 1024 };

typedef struct ty_impulse_nodes {
    int32_t count;
    double x[TY_IMPULSE_NODES_MAX], weight[TY_IMPULSE_NODES_MAX];
} ty_impulse_nodes;

/* Adds nodes for a smooth function of x on a..b. Nodes beyond TY_IMPULSE_NODES_MAX are dropped; no caller comes close.
 */
void ty_impulse_add_gauss(ty_impulse_nodes* nodes, double a, double b);
/* Adds nodes for a function of ln x that decays as exp(-x) beyond 1: 0 < a < b. */
void ty_impulse_add_logarithmic(ty_impulse_nodes* nodes, double a, double b);
/* Adds `count` nodes for an integrand with integrable singularities at its ends. */
void ty_impulse_add_singular(ty_impulse_nodes* nodes, double a, double b, int32_t count);

#endif
