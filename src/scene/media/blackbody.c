/* Blackbody radiation: Planck's law for the CIE 1931 standard observer. */
#include "scene/media/blackbody.h"
#include "scene/media/observer.h"

#include <tyndall/scene.h>

/* Spectral radiance, W m^-2 sr^-1 per metre of wavelength. */
static double planck(double wavelength, double kelvin) {
    static const double h = 6.62607015e-34, c = 299792458, k = 1.380649e-23;
    return 2 * h * c * c / (pow(wavelength, 5) * expm1(h * c / (wavelength * k * kelvin)));
}

/* X, Y and Z, W m^-2 sr^-1, by the trapezoidal rule: the functions are nearly 0 at the ends of the table. */
static void blackbody_xyz(double kelvin, double xyz[3]) {
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (int i = 0; i < TY_OBSERVER_COUNT; ++i) {
        const double radiance =
            planck((TY_OBSERVER_FIRST + TY_OBSERVER_STEP * i) * 1e-9, kelvin) * TY_OBSERVER_STEP * 1e-9;
        for (int c = 0; c < 3; ++c) xyz[c] += radiance * ty_observer[i][c];
    }
}

void ty_blackbody(double kelvin, float radiance[3]) {
    double xyz[3] = {0, 0, 0};
    if (kelvin >= (double)TY_BLACKBODY_COLDEST) blackbody_xyz(fmin(kelvin, (double)TY_BLACKBODY_HOTTEST), xyz);
    const float narrow[3] = {(float)xyz[0], (float)xyz[1], (float)xyz[2]};
    ty_rgb_from_xyz(narrow, radiance);
}

void ty_blackbody_fill(ty_blackbody_table* table) {
    const int steps = 1 << TY_BLACKBODY_STEPS_LOG2;
    for (int i = 0; i < TY_BLACKBODY_KNOTS; ++i) {
        double xyz[3];
        const double knot = ldexp(1 + (double)(i % steps) / steps, i / steps);
        blackbody_xyz((double)TY_BLACKBODY_COLDEST * knot, xyz);
        for (int c = 0; c < 3; ++c) table->log_xyz[i][c] = (float)log(xyz[c]);
    }
}
