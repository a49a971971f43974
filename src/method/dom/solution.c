#include "method/dom/solution.h"
#include "base/constants.h"
#include "solve/angular/harmonics.h"

#include <math.h>

void ty_dom_direction_to_eye(const ty_dom* light, const int32_t cell[3], const double eye[3], double omega[3]) {
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double side = (light->box.upper[a] - light->box.lower[a]) / light->box.size[a];
        omega[a] = eye[a] - (light->box.lower[a] + (cell[a] + 0.5) * side);
        square += omega[a] * omega[a];
    }
    for (int a = 0; a < 3; ++a) omega[a] = square > 0 ? omega[a] / sqrt(square) : a == 2;
}

/* Staircase factor up to which the irradiance of the face is that of the surface. */
static const float min_slant = 1.03f;

float ty_dom_side_irradiance(const ty_dom* light, const ty_boundary_side* side, float of_face, const float* moments,
                             int32_t bands, size_t cell) {
    static const double cosine[] = {TY_PI, TY_PI * 2 / 3, TY_PI / 4, 0, -TY_PI / 24, 0};
    const double omega[3] = {-(double)side->normal.x, -(double)side->normal.y, -(double)side->normal.z};
    double y[TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX], sum = 0;
    if (!(side->staircase_factor > min_slant)) return of_face;
    if (bands > 6) bands = 6;
    ty_harmonics_at(omega, bands, y);
    for (int32_t l = 0; l < bands; ++l)
        for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
            sum += cosine[l] * y[t] * (double)moments[light->cells * (size_t)t + cell];
    return ty_maxf(0, (float)sum);
}
