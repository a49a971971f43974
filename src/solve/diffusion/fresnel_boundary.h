/* Boundary condition of diffusion within a smooth dielectric whose other side is of a lower index.
 *
 * Light of P1, psi = (phi + 3 mu J) / (4 pi), arrives at the interface with the partial current phi / 4 + J / 2, of
 * which Fresnel's reflectance R returns R_phi phi / 4 + R_J J / 2 with
 *
 *     R_phi = 2 C1 = 2 int_0^1 R(mu) mu dmu,   R_J = 3 C2 = 3 int_0^1 R(mu) mu^2 dmu
 *
 * (Haskell et al. 1994; Contini et al. 1997; the moments of d'Eon and Irving 2011). So phi = 2 A J there, with
 * A = (1 + 3 C2) / (1 - 2 C1) = (1 + R_eff) / (1 - R_eff). */
#ifndef TY_SOLVE_DIFFUSION_FRESNEL_BOUNDARY_H
#define TY_SOLVE_DIFFUSION_FRESNEL_BOUNDARY_H

typedef struct ty_fresnel_moments {
    double c1, c2; /* int R mu dmu, int R mu^2 dmu */
} ty_fresnel_moments;

/* Moments of the reflectance at an interface, for light from the side whose index relative to the other is n, above 0.
 */
ty_fresnel_moments ty_fresnel_moments_of(double n);
/* A of a relative index n; 1 without an interface (Marshak). */
double ty_fresnel_partial_current_factor(double n);
/* R_eff, the fraction of the partial current that an interface of relative index n returns, 0..1. staircase_factor: the
 * area of the faces of cells over that of the surface that they stand for, at least 1, by which A grows, so that as
 * much leaves through the faces as through the surface. */
double ty_fresnel_effective_reflectance(double n, double staircase_factor);

#endif
