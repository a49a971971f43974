/* Grids that span a box. */
#include "method/pop/grid.h"

#include <math.h>

static double diagonal_of(const ty_grid_box* box) {
    double square = 0;
    for (int a = 0; a < 3; ++a) square += pow(box->upper[a] - box->lower[a], 2);
    return sqrt(square);
}

/* ---- parallel ---- */

/* Unit; what is along an axis of the box but for rounding, is along it. */
static void unit_of(const double way[3], double unit[3]) {
    const double length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    for (int a = 0; a < 3; ++a) unit[a] = fabs(way[a]) < 1e-6 * length ? 0 : way[a] / length;
    const double rest = sqrt(unit[0] * unit[0] + unit[1] * unit[1] + unit[2] * unit[2]);
    for (int a = 0; a < 3; ++a) unit[a] /= rest;
}

/* The first axis is the box's that is most across the direction, turned to be at right angles to it. */
static void axes_about(const double way[3], double axis[3][3]) {
    unit_of(way, axis[2]);
    const double* d = axis[2];
    int across = 0;
    for (int a = 1; a < 3; ++a)
        if (fabs(d[a]) < fabs(d[across])) across = a;
    double first[3];
    for (int a = 0; a < 3; ++a) first[a] = (a == across ? 1 : 0) - d[across] * d[a];
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

static void fit_parallel(const ty_grid_box* box, const double way[3], int32_t resolution, ty_pop_frame* frame) {
    double axis[3][3], origin[3] = {0, 0, 0};
    float step[3];
    axes_about(way, axis);
    for (int i = 0; i < 3; ++i) {
        double range[2];
        project(box, axis[i], range);
        for (int a = 0; a < 3; ++a) origin[a] += axis[i][a] * range[0];
        step[i] = (float)((range[1] - range[0]) / resolution);
        frame->axis[i] = ty_vec_make((float)axis[i][0], (float)axis[i][1], (float)axis[i][2]);
    }
    frame->kind = TY_LIGHT_PART_PARALLEL;
    frame->origin = ty_vec_make((float)origin[0], (float)origin[1], (float)origin[2]);
    frame->step = ty_vec_load(step);
}

/* ---- radial ---- */

/* How far a point is from the nearest and the farthest point of the box, m. */
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

/* Shells as thick as columns are wide; thicker where they would not reach down to half a cell of the box. */
static void fit_radial(const ty_grid_box* box, const ty_light_part* ordinate, const double range[2], int32_t resolution,
                       ty_pop_frame* frame) {
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = fmax(longest, box->upper[a] - box->lower[a]);
    const double even = range[1] * exp(-sqrt(4 * (double)TY_PI));
    const double inner = fmax(range[0], fmin(even, 0.5 * longest / resolution));
    frame->kind = TY_LIGHT_PART_RADIAL;
    frame->origin = ordinate->position;
    frame->inner = (float)inner;
    frame->growth = (float)(log(range[1] / inner) / resolution);
}

/* From afar the box would be within few columns of a radial grid, while the light is nearly parallel: where errors of
 * both were measured to be alike, for cubes of optical thickness 4. */
static bool is_afar(const ty_grid_box* box, double distance, int32_t resolution) {
    return distance > 0.25 * sqrt(resolution) * diagonal_of(box);
}

/* Boxes along parallel light, and the shells of Sec. 6 (Elek 2014) about a point. */
void ty_pop_frame_fit(const ty_grid_box* box, const ty_light_part* ordinate, int32_t resolution, ty_pop_frame* out) {
    *out = (ty_pop_frame){.size = {resolution, resolution, resolution}};
    const double direction[3] = {(double)ordinate->direction.x, (double)ordinate->direction.y,
                                 (double)ordinate->direction.z};
    if (ordinate->kind == TY_LIGHT_PART_PARALLEL) {
        fit_parallel(box, direction, resolution, out);
        return;
    }
    const double point[3] = {(double)ordinate->position.x, (double)ordinate->position.y, (double)ordinate->position.z};
    double range[2], way[3];
    distances(box, point, range);
    for (int a = 0; a < 3; ++a) way[a] = 0.5 * (box->lower[a] + box->upper[a]) - point[a];
    if (is_afar(box, sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]), resolution))
        fit_parallel(box, way, resolution, out);
    else
        fit_radial(box, ordinate, range, resolution, out);
}
