#include "direct/lights/interior_light.h"

#include "base/constants.h"

#include <math.h>

/* Measured for a point light at the center of a ball with a radius of 2 to 3.3 mean free paths (docs/method/fld.md). */
static const double interior_max_flux = 0.8;

static double mean_color(const float rgb[3]) {
    return (double)(rgb[0] + rgb[1] + rgb[2]) / 3;
}

/* Half of the box's surface area, an upper bound of its projected area. */
static double half_surface_area(const ty_grid_box* box) {
    double edge[3];
    for (int a = 0; a < 3; ++a) edge[a] = box->upper[a] - box->lower[a];
    return edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0];
}

void ty_interior_light_add_directional(ty_interior_light* sum, const ty_grid_box* box, ty_vec direction,
                                       const float irradiance[3]) {
    const double omega[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
    double projected_area = 0;
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        projected_area += fabs(omega[a]) * (box->upper[b] - box->lower[b]) * (box->upper[c] - box->lower[c]);
    }
    sum->from_outside += projected_area * mean_color(irradiance);
}

void ty_interior_light_add_point(ty_interior_light* sum, const ty_grid_box* box, ty_vec position,
                                 const float intensity[3]) {
    const double at[3] = {(double)position.x, (double)position.y, (double)position.z};
    double square = 0;
    for (int a = 0; a < 3; ++a) {
        const double offset = at[a] - fmin(fmax(at[a], box->lower[a]), box->upper[a]);
        square += offset * offset;
    }
    const double sphere = 4 * TY_PI_F64;
    if (square > 0)
        sum->from_outside += mean_color(intensity) * fmin(0.5 * sphere, 0.5 * half_surface_area(box) / square);
    else
        sum->from_inside += mean_color(intensity) * sphere;
}

double ty_interior_light_max_flux(const ty_interior_light* sum, double exterior_max) {
    const double all = sum->from_outside + sum->from_inside;
    return all > 0 ? exterior_max + (interior_max_flux - exterior_max) * (sum->from_inside / all) : exterior_max;
}

double ty_interior_light_max_flux_slope(const ty_interior_light* sum, const ty_interior_light* part,
                                        double exterior_max) {
    const double all = sum->from_outside + sum->from_inside;
    if (!(all > 0)) return 0;
    const double change = part->from_inside * sum->from_outside - sum->from_inside * part->from_outside;
    return (interior_max_flux - exterior_max) * change / (all * all);
}
