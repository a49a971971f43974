#include "method/dom/solution.h"

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
