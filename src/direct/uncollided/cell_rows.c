#include "direct/uncollided/cell_rows.h"

/* A cell's center along an axis, m from the light. */
double ty_point_light_center(const ty_point_light_job* point, int32_t axis, int32_t cell) {
    return point->lower[axis] + point->medium->cell[axis] * (cell + 0.5);
}

/* Floats of scratch for a row: rays, then cells. */
size_t ty_cell_row_scratch(const ty_point_light_job* point) {
    int32_t max = 0;
    for (int a = 0; a < 3; ++a) max = point->medium->box.size[a] > max ? point->medium->box.size[a] : max;
    return ty_ray_lattice_scratch(point) + 7 * (size_t)max;
}

void ty_cell_row_place(const ty_ray_lattice* l, int32_t slab, int32_t v, float* scratch, ty_cell_row* row) {
    const ty_point_light_job* point = l->job;
    const int32_t* size = point->medium->box.size;
    const size_t stride[3] = {1, (size_t)size[0], (size_t)size[0] * (size_t)size[1]};
    const size_t rays = (size_t)l->count[0], cells = (size_t)size[l->axis[0]];
    *row = (ty_cell_row){.l = l, .slab = slab, .cell = {0, v, ty_ray_lattice_cell(l, slab)}};
    row->stride = stride[l->axis[0]];
    row->first = stride[l->axis[1]] * (size_t)row->cell[1] + stride[l->axis[2]] * (size_t)row->cell[2];
    row->v = ty_point_light_center(point, l->axis[1], row->cell[1]);
    row->w = fabs(ty_point_light_center(point, l->axis[2], row->cell[2]));
    row->mean = scratch;
    row->visible = scratch + rays;
    float* const next = scratch + 2 * rays;
    for (int i = 0; i < 3; ++i) {
        row->transmittance[i] = next + (size_t)i * cells;
        row->omega[i] = next + (size_t)(3 + i) * cells;
    }
    row->falloff = next + 6 * cells;
}

/* True if a cell's center lies in this lattice's pyramid; exactly one of the six has it. */
static bool is_owned(const ty_cell_row* row, int32_t u) {
    const ty_ray_lattice* l = row->l;
    double off[3];
    off[l->axis[0]] = fabs(ty_point_light_center(l->job, l->axis[0], u));
    off[l->axis[1]] = fabs(row->v);
    off[l->axis[2]] = row->w;
    const int32_t w = off[0] >= off[1] && off[0] >= off[2] ? 0 : off[1] >= off[2] ? 1 : 2;
    return w == l->axis[2];
}

/* The range of the row's cells within the pyramid. */
static void find_owned(const ty_cell_row* row, int32_t* begin, int32_t* end) {
    const ty_point_light_job* point = row->l->job;
    const int32_t u = row->l->axis[0], size = point->medium->box.size[u];
    const double lower = point->lower[u], per_cell = 1 / point->medium->cell[u];
    *begin = (int32_t)fmax(0, fmin(size, floor((-row->w - lower) * per_cell) - 1));
    *end = (int32_t)fmax(0, fmin(size, ceil((row->w - lower) * per_cell) + 1));
    while (*begin < *end && !is_owned(row, *begin)) ++*begin;
    while (*begin < *end && !is_owned(row, *end - 1)) --*end;
}

/* Distance along w between the cells and the entry of rays into the box, through its end or across v. */
static double inside_of(const ty_cell_row* row, bool* across_v) {
    const ty_ray_lattice* l = row->l;
    const int32_t v = l->axis[1], w = l->axis[2];
    const ty_grid_medium* medium = l->job->medium;
    const double lower = l->job->lower[v], upper = l->job->upper[v], cell = row->cell[1] + 0.5;
    const double by_w = l->entry > 0 ? medium->cell[w] * (l->begin + row->slab + 0.5) : row->w;
    double by_v = INFINITY;
    if (lower > 0) by_v = row->w * medium->cell[v] * cell / row->v;
    if (upper < 0) by_v = row->w * medium->cell[v] * (cell - medium->box.size[v]) / row->v;
    *across_v = by_v < by_w;
    return fmin(by_v, by_w);
}

ty_ray_row_blend ty_cell_row_rays(const ty_cell_row* row, int32_t plane, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const double near = ty_ray_lattice_plane(l, row->slab), far = fmin(l->far, ty_ray_lattice_plane(l, row->slab + 1));
    const size_t count = (size_t)l->count[0], rays = ty_ray_lattice_rays(l);
    int32_t at, first, last;
    const float row_t = ty_ray_lattice_locate(l, 1, row->v / row->w, &at);
    ty_ray_lattice_locate(l, 0, ty_point_light_center(l->job, l->axis[0], begin) / row->w, &first);
    ty_ray_lattice_locate(l, 0, ty_point_light_center(l->job, l->axis[0], end - 1) / row->w, &last);
    ty_ray_row_blend blend = {
        .begin = first > 0 ? first - 1 : 0,
        .end = last + 3 < l->count[0] ? last + 3 : l->count[0],
        .row_t = row_t,
        .far_t = (float)fmin(fmax((row->w - near) / (far - near), 0), 1),
        .along = (float)row->w,
        .out = row->mean,
        .visible = row->visible,
    };
    for (size_t i = 0; i < 4; ++i)
        blend.mean[i] = l->mean[plane] + rays * ((size_t)row->slab + i / 2) + count * ((size_t)at + i % 2);
    for (size_t i = 0; i < 2 && l->hit != NULL; ++i) blend.hit[i] = l->hit + count * ((size_t)at + i);
    return blend;
}

ty_cell_row_means ty_cell_row_means_of(const ty_cell_row* row, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const ty_point_light_job* point = l->job;
    const ty_grid_medium* medium = point->medium;
    const int32_t u = l->axis[0];
    const double size = medium->cell[u], center = ty_point_light_center(point, u, 0);
    bool across_v;
    ty_cell_row_means cells = {
        .begin = begin,
        .end = end,
        .rays = l->count[0],
        .column = {(float)((center / row->w - l->low[0]) / l->step[0]), (float)(size / row->w / l->step[0])},
        .off = {(float)center, (float)size},
        .v = (float)row->v,
        .w = (float)row->w,
        .side = {(float)(size * (point->lower[u] > 0 ? 0.5 : 0.5 - medium->box.size[u])), (float)size},
        .outside = point->lower[u] > 0 || point->upper[u] < 0,
        .inside = (float)inside_of(row, &across_v),
        .stride = row->stride,
        .mean = row->mean,
        .visible = l->hit != NULL ? row->visible : NULL,
        .spread = point->out.transmittance == NULL,
    };
    cells.across_v = across_v;
    for (int i = 0; i < 3; ++i) cells.cell[i] = (float)medium->cell[l->axis[i]];
    return cells;
}

int32_t ty_cell_row_ranges(const ty_cell_row* row, bool near_too, int32_t ranges[2][2]) {
    const ty_point_light_job* point = row->l->job;
    const int32_t* axis = row->l->axis;
    int32_t begin, end, near[2], cell[3], count = 0;
    if (!(fabs(row->v) <= row->w)) return 0;
    find_owned(row, &begin, &end);
    cell[axis[0]] = point->home[axis[0]];
    cell[axis[1]] = row->cell[1];
    cell[axis[2]] = row->cell[2];
    ty_near_cells_range(point, axis[0], near);
    if (near_too || !ty_near_cells_contain(point, cell)) near[0] = near[1] = end;
    const int32_t parts[2][2] = {{begin, near[0] < end ? near[0] : end}, {near[1] > begin ? near[1] : begin, end}};
    for (int i = 0; i < 2; ++i) {
        if (parts[i][0] >= parts[i][1]) continue;
        memcpy(ranges[count++], parts[i], sizeof parts[i]);
    }
    return count;
}

void ty_cell_row_find_directions(const ty_cell_row* row, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const ty_point_light_job* point = l->job;
    const ty_vec direction = point->source->direction;
    const float axis_direction[3] = {direction.x, direction.y, direction.z};
    const float center = (float)ty_point_light_center(point, l->axis[0], 0),
                size = (float)point->medium->cell[l->axis[0]];
    ty_cell_row_directions directions = {.begin = begin, .end = end, .off = {center, size}, .v = (float)row->v};
    directions.w = (float)(l->backwards ? -row->w : row->w);
    directions.profile = point->source->profile;
    directions.light = point->light;
    directions.falloff = row->falloff;
    for (int i = 0; i < 3; ++i) {
        directions.axis_direction[i] = axis_direction[l->axis[i]];
        directions.omega[i] = row->omega[i];
    }
    point->kernels->directions(&directions);
}
