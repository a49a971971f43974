/* Directions for discrete ordinates, with weights. */
#ifndef TY_SOLVE_ANGULAR_QUADRATURE_H
#define TY_SOLVE_ANGULAR_QUADRATURE_H

#include <tyndall/base.h>

enum { TY_ORDINATES_MAX = 1024 };

/* Directions with weights that sum to 4 pi, octant by octant: first[o] is the first direction of octant o (bit a of o:
 * negative component along axis a), first[8] the count. */
typedef struct ty_angular_quadrature {
    int32_t count;
    int32_t first[9];
    float direction[3][TY_ORDINATES_MAX];
    float weight[TY_ORDINATES_MAX];
} ty_angular_quadrature;

/* About `count` directions (8..1024), equally many in each octant, mirrored along the axes, without zero components.
 * The weighted sums of spherical harmonics vanish at least up to order *exactness_order (except l = 0), which may be
 * NULL. docs/method/dom.md describes the set. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_angular_quadrature_create(ty_context* context, int32_t count, ty_angular_quadrature* out,
                                       int32_t* exactness_order);

#endif
