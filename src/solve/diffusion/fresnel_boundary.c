#include "solve/diffusion/fresnel_boundary.h"

#include "base/quadrature.h"
#include "scene/bsdf/fresnel.k.h"

/* Intervals of quadrature on each side of the critical angle. */
enum { PANELS = 16 };

typedef struct integrand {
    double n;
    int power;
} integrand;

/* The substitution mu = c + (1 - c) x^2 resolves the root at the critical cosine c. */
static double at(const void* user, double x) {
    const integrand* f = user;
    const double critical = f->n > 1 ? sqrt(1 - 1 / (f->n * f->n)) : 0;
    const double mu = critical + (1 - critical) * x * x;
    const double reflectance = (double)ty_fresnel_dielectric((float)mu, (float)(1 / f->n));
    return reflectance * (f->power == 1 ? mu : mu * mu) * 2 * (1 - critical) * x;
}

/* Light at cosines below the critical one is reflected totally. */
static double moment(double n, int power) {
    const integrand f = {n, power};
    const double critical = n > 1 ? sqrt(1 - 1 / (n * n)) : 0;
    return ty_integrate(at, &f, 0, 1, PANELS) + (power == 1 ? critical * critical / 2 : pow(critical, 3) / 3);
}

ty_fresnel_moments ty_fresnel_moments_of(double n) {
    return (ty_fresnel_moments){moment(n, 1), moment(n, 2)};
}

double ty_fresnel_partial_current_factor(double n) {
    const ty_fresnel_moments m = ty_fresnel_moments_of(n);
    return (1 + 3 * m.c2) / (1 - 2 * m.c1);
}

double ty_fresnel_effective_reflectance(double n, double staircase_factor) {
    const ty_fresnel_moments m = ty_fresnel_moments_of(n);
    const double above = staircase_factor * (1 + 3 * m.c2), below = fmax(1 - 2 * m.c1, 0);
    return (above - below) / (above + below);
}
