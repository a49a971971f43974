/* Where integrands are looked at: Gauss-Legendre in panels that shrink towards what is singular, tanh-sinh where both
 * ends may be. */
#ifndef TY_METHOD_IMPULSE_NODES_H
#define TY_METHOD_IMPULSE_NODES_H

#include <stdint.h>

enum { TY_IMPULSE_GAUSS = 12, TY_IMPULSE_NODES_MAX = 1024 };

typedef struct ty_impulse_nodes {
    int32_t count;
    double x[TY_IMPULSE_NODES_MAX], weight[TY_IMPULSE_NODES_MAX];
} ty_impulse_nodes;

/* Adds the nodes of a smooth function of x, of a..b. Nodes beyond the most that there may be are left out; no caller
 * comes near. */
void ty_impulse_add_gauss(ty_impulse_nodes* nodes, double a, double b);
/* Of a function of ln x that falls as exp(-x) beyond 1: 0 < a < b. */
void ty_impulse_add_logarithmic(ty_impulse_nodes* nodes, double a, double b);
/* Of one with singular ends that can be integrated: count nodes. */
void ty_impulse_add_singular(ty_impulse_nodes* nodes, double a, double b, int32_t count);

#endif
