/* Placement of an ordinate's grid around the medium's box. */
#include "method/pop/grid/grid.h"

#include <math.h>

static double diagonal_of(const ty_grid_box* box) {
    double square = 0;
    for (int a = 0; a < 3; ++a) square += pow(box->upper[a] - box->lower[a], 2);
    return sqrt(square);
}

/* ---- parallel ---- */

/* Normalises; components below rounding error become 0, so that axis-aligned directions stay exact. */
static void unit_of(const double direction[3], double unit[3]) {
    const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    for (int a = 0; a < 3; ++a) unit[a] = fabs(direction[a]) < 1e-6 * length ? 0 : direction[a] / length;
    const double norm = sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2]);
    for (int a = 0; a < 3; ++a) unit[a] /= norm;
}

/* Orthonormal axes: axis[2] along the direction, axis[0] the box axis most perpendicular to it, orthogonalised. */
static void axes_about(const double direction[3], double axis[3][3]) {
    unit_of(direction, axis[2]);
    const double* d = axis[2];
    int axis_index = 0;
    for (int a = 1; a < 3; ++a)
        if (fabs(d[a]) < fabs(d[axis_index])) axis_index = a;
    double first[3];
    for (int a = 0; a < 3; ++a) first[a] = (a == axis_index ? 1 : 0) - d[axis_index] * d[a];
    unit_of(first, axis[0]);
    for (int a = 0; a < 3; ++a)
        axis[1][a] = d[(a + 1) % 3] * axis[0][(a + 2) % 3] - d[(a + 2) % 3] * axis[0][(a + 1) % 3];
}

static void project(const ty_grid_box* box, const double axis[3], double range[2]) {
    range[0] = range[1] = 0;
    for (int a = 0; a < 3; ++a) {
        range[0] += axis[a] * (axis[a] > 0 ? box->lower[a] : box->upper[a]);
        range[1] += axis[a] * (axis[a] > 0 ? box->upper[a] : box->lower[a]);
    }
}

static void fit_parallel(const ty_grid_box* box, const double direction[3], int32_t resolution, ty_pop_grid* grid) {
    double axis[3][3], origin[3] = {0, 0, 0};
    float step[3];
    axes_about(direction, axis);
    for (int i = 0; i < 3; ++i) {
        double range[2];
        project(box, axis[i], range);
        for (int a = 0; a < 3; ++a) origin[a] += axis[i][a] * range[0];
        step[i] = (float)((range[1] - range[0]) / resolution);
        grid->axis[i] = ty_vec_make((float)axis[i][0], (float)axis[i][1], (float)axis[i][2]);
    }
    grid->kind = TY_DISCRETE_DIRECTIONAL;
    grid->origin = ty_vec_make((float)origin[0], (float)origin[1], (float)origin[2]);
    grid->step = ty_vec_load(step);
}

/* ---- radial ---- */

/* Distances from a point to the nearest and the farthest point of the box, m. */
static void distances(const ty_grid_box* box, const double point[3], double range[2]) {
    double near = 0, far = 0;
    for (int a = 0; a < 3; ++a) {
        const double below = box->lower[a] - point[a], above = point[a] - box->upper[a];
        near += pow(fmax(0, fmax(below, above)), 2);
        far += pow(fmax(-below, -above), 2);
    }
    range[0] = sqrt(near);
    range[1] = sqrt(far);
}

/* Shells as thick as columns are wide, or thicker if they would not reach inward to half a cell of the box. */
static void fit_radial(const ty_grid_box* box, const ty_discrete_light* ordinate, const double range[2],
                       int32_t resolution, ty_pop_grid* grid) {
    double longest_edge = 0;
    for (int a = 0; a < 3; ++a) longest_edge = fmax(longest_edge, box->upper[a] - box->lower[a]);
    const double matched = range[1] * exp(-sqrt(4 * (double)TY_PI));
    const double inner = fmax(range[0], fmin(matched, 0.5 * longest_edge / resolution));
    grid->kind = TY_DISCRETE_POINT;
    grid->origin = ordinate->position;
    grid->inner = (float)inner;
    grid->growth = (float)(log(range[1] / inner) / resolution);
}

/* Beyond this distance a parallel grid is used: the box covers few columns of a radial grid, and the light is nearly
 * parallel. At the threshold both errors measure equal, for cubes of optical thickness 4. */
static bool is_distant(const ty_grid_box* box, double distance, int32_t resolution) {
    return distance > 0.25 * sqrt(resolution) * diagonal_of(box);
}

/* Boxes along parallel light, and the shells of Sec. 6 (Elek 2014) about a point. */
void ty_pop_grid_fit(const ty_grid_box* box, const ty_discrete_light* ordinate, int32_t resolution, ty_pop_grid* out) {
    *out = (ty_pop_grid){.size = {resolution, resolution, resolution}};
    const double direction[3] = {(double)ordinate->direction.x, (double)ordinate->direction.y,
                                 (double)ordinate->direction.z};
    if (ordinate->kind == TY_DISCRETE_DIRECTIONAL) {
        fit_parallel(box, direction, resolution, out);
        return;
    }
    const double point[3] = {(double)ordinate->position.x, (double)ordinate->position.y, (double)ordinate->position.z};
    double range[2], to_center[3];
    distances(box, point, range);
    for (int a = 0; a < 3; ++a) to_center[a] = 0.5 * (box->lower[a] + box->upper[a]) - point[a];
    if (is_distant(box, sqrt(to_center[0] * to_center[0] + to_center[1] * to_center[1] + to_center[2] * to_center[2]),
                   resolution))
        fit_parallel(box, to_center, resolution, out);
    else
        fit_radial(box, ordinate, range, resolution, out);
}
