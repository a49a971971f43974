/* Uncollided light of a point: six pyramids around it, one per face of a cube, each divided into sections within which
 * the distance doubles. Each section has a lattice of rays with mean extinctions. */
#include "direct/uncollided/point_light.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/ray_lattice.h"
#include "direct/uncollided/near_cells.h"

/* ---- rows of cells ---- */

/* A row of cells along u within a pyramid. */
typedef struct cell_row {
    const ty_ray_lattice* l;
    int32_t slab;
    int32_t cell[3]; /* along u, v, w; of u: 0 */
    size_t first;    /* offset of the row, and between cells, in planes */
    size_t stride;
    double v, w; /* cell centers, m from the light; w > 0 */
    float *mean, *visible, *transmittance[3], *falloff, *omega[3];
} cell_row;

/* A cell's center along an axis, m from the light. */
static double center_of(const ty_point_light_job* point, int32_t axis, int32_t cell) {
    return point->lower[axis] + point->medium->cell[axis] * (cell + 0.5);
}

/* Floats of scratch for a row: rays, then cells. */
static size_t cell_scratch(const ty_point_light_job* point) {
    int32_t max = 0;
    for (int a = 0; a < 3; ++a) max = point->medium->box.size[a] > max ? point->medium->box.size[a] : max;
    return ty_ray_lattice_scratch(point) + 7 * (size_t)max;
}

static void place_row(const ty_ray_lattice* l, int32_t slab, int32_t v, float* scratch, cell_row* row) {
    const ty_point_light_job* point = l->job;
    const int32_t* size = point->medium->box.size;
    const size_t stride[3] = {1, (size_t)size[0], (size_t)size[0] * (size_t)size[1]};
    const size_t rays = (size_t)l->count[0], cells = (size_t)size[l->axis[0]];
    *row = (cell_row){.l = l, .slab = slab, .cell = {0, v, ty_ray_lattice_cell(l, slab)}};
    row->stride = stride[l->axis[0]];
    row->first = stride[l->axis[1]] * (size_t)row->cell[1] + stride[l->axis[2]] * (size_t)row->cell[2];
    row->v = center_of(point, l->axis[1], row->cell[1]);
    row->w = fabs(center_of(point, l->axis[2], row->cell[2]));
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
static bool is_owned(const cell_row* row, int32_t u) {
    const ty_ray_lattice* l = row->l;
    double off[3];
    off[l->axis[0]] = fabs(center_of(l->job, l->axis[0], u));
    off[l->axis[1]] = fabs(row->v);
    off[l->axis[2]] = row->w;
    const int32_t w = off[0] >= off[1] && off[0] >= off[2] ? 0 : off[1] >= off[2] ? 1 : 2;
    return w == l->axis[2];
}

/* The range of the row's cells within the pyramid. */
static void find_owned(const cell_row* row, int32_t* begin, int32_t* end) {
    const ty_point_light_job* point = row->l->job;
    const int32_t u = row->l->axis[0], size = point->medium->box.size[u];
    const double lower = point->lower[u], per_cell = 1 / point->medium->cell[u];
    *begin = (int32_t)fmax(0, fmin(size, floor((-row->w - lower) * per_cell) - 1));
    *end = (int32_t)fmax(0, fmin(size, ceil((row->w - lower) * per_cell) + 1));
    while (*begin < *end && !is_owned(row, *begin)) ++*begin;
    while (*begin < *end && !is_owned(row, *end - 1)) --*end;
}

/* Interpolates mean extinction and visibility of the rays around the cells [begin, end). */
static void blend_rays(const cell_row* row, int32_t plane, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const double near = ty_ray_lattice_plane(l, row->slab), far = fmin(l->far, ty_ray_lattice_plane(l, row->slab + 1));
    const size_t count = (size_t)l->count[0], rays = ty_ray_lattice_rays(l);
    int32_t at, first, last;
    const float row_t = ty_ray_lattice_locate(l, 1, row->v / row->w, &at);
    ty_ray_lattice_locate(l, 0, center_of(l->job, l->axis[0], begin) / row->w, &first);
    ty_ray_lattice_locate(l, 0, center_of(l->job, l->axis[0], end - 1) / row->w, &last);
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
    l->job->kernels->blend_rows(&blend);
}

/* Distance along w between the cells and the entry of rays into the box, through its end or across v. */
static double inside_of(const cell_row* row, bool* across_v) {
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

/* Means over the cells [begin, end) of the row. */
static void find_means(const cell_row* row, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const ty_point_light_job* point = l->job;
    const ty_grid_medium* medium = point->medium;
    const int32_t u = l->axis[0];
    const double size = medium->cell[u], center = center_of(point, u, 0);
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
    for (int32_t c = 0; c < medium->planes; ++c) {
        blend_rays(row, c, begin, end);
        cells.extinction = point->extinction[c] + row->first;
        cells.transmittance = row->transmittance[c];
        point->kernels->cell_means(&cells);
    }
}

static void add_light(const cell_row* row, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const ty_point_light_job* point = l->job;
    const ty_point_light_target* out = &point->out;
    const ty_vec direction = point->source->direction;
    const float axis_direction[3] = {direction.x, direction.y, direction.z};
    const float center = (float)center_of(point, l->axis[0], 0), size = (float)point->medium->cell[l->axis[0]];
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
    for (int32_t c = 0; c < out->planes; ++c) {
        ty_cell_row_sum sum = {.begin = begin, .end = end, .stride = row->stride, .falloff = row->falloff};
        sum.color = out->color[c];
        sum.transmittance = row->transmittance[c < point->medium->planes ? c : 0];
        sum.fluence = out->fluence[c] + row->first;
        for (int i = 0; i < 3 && out->flux != NULL; ++i) {
            sum.omega[i] = row->omega[i];
            sum.flux[i] = out->flux[c][l->axis[i]] + row->first;
        }
        point->kernels->add_light(&sum);
    }
}

static void light_cells(const cell_row* row, int32_t begin, int32_t end) {
    if (begin >= end) return;
    float* const* transmittance = row->l->job->out.transmittance;
    find_means(row, begin, end);
    if (transmittance == NULL) {
        add_light(row, begin, end);
        return;
    }
    for (int32_t c = 0; c < row->l->job->medium->planes; ++c)
        for (int32_t u = begin; u < end; ++u)
            transmittance[c][row->first + row->stride * (size_t)u] = row->transmittance[c][u];
}

/* Lights all cells of a row but the near ones. */
static void light_row(const cell_row* row) {
    const ty_point_light_job* point = row->l->job;
    const int32_t* axis = row->l->axis;
    int32_t begin, end, near[2], cell[3];
    find_owned(row, &begin, &end);
    cell[axis[0]] = point->home[axis[0]];
    cell[axis[1]] = row->cell[1];
    cell[axis[2]] = row->cell[2];
    if (point->out.transmittance != NULL || !ty_near_cells_contain(point, cell)) {
        light_cells(row, begin, end);
        return;
    }
    ty_near_cells_range(point, axis[0], near);
    light_cells(row, begin, near[0] < end ? near[0] : end);
    light_cells(row, near[1] > begin ? near[1] : begin, end);
}

/* Lights the rows v of all slabs. */
static void light_rows(void* user, int64_t v, int32_t worker) {
    const ty_ray_lattice* l = user;
    float* scratch = l->job->scratch + l->job->scratch_size * (size_t)worker;
    const unsigned state = ty_flush_denormals();
    for (int32_t slab = 0; slab < l->slabs; ++slab) {
        cell_row row;
        place_row(l, slab, (int32_t)v, scratch, &row);
        if (fabs(row.v) <= row.w) light_row(&row);
    }
    ty_restore_denormals(state);
}

/* ---- pyramids ---- */

static ty_result light_pyramid(ty_point_light_job* point, int32_t w, bool backwards) {
    const ty_grid_medium* medium = point->medium;
    const double from = backwards ? -point->upper[w] : point->lower[w];
    ty_ray_lattice before = {.job = point},
                   l = {.job = point, .axis = {w == 0 ? 1 : 0, w == 2 ? 1 : 2, w}, .backwards = backwards};
    l.entry = fmax(0, from);
    ty_result result = TY_OK;
    int32_t begin = (int32_t)fmin(medium->box.size[w], fmax(0, floor(-from / medium->cell[w])));
    for (; begin < medium->box.size[w] && result == TY_OK; begin += l.slabs) {
        if (!ty_ray_lattice_place(&l, begin)) continue;
        result = ty_ray_lattice_trace(&l, &before);
        if (result == TY_OK) ty_parallel_for(medium->context, medium->box.size[l.axis[1]], light_rows, &l);
        ty_ray_lattice_end(&before);
        before = l;
        l.hit = l.mean[0] = l.mean[1] = l.mean[2] = NULL;
        point->finished += 1.0 / 6 * before.slabs / medium->box.size[w];
        if (result == TY_OK) result = ty_part_show(point->progress, "direct light", fmin(point->finished, 1));
    }
    ty_ray_lattice_end(&before);
    return result;
}

static void place_point(ty_point_light_job* point) {
    const ty_discrete_light* source = point->source;
    const ty_grid_medium* medium = point->medium;
    const double position[3] = {(double)source->position.x, (double)source->position.y, (double)source->position.z};
    double min_side = INFINITY;
    for (int a = 0; a < 3; ++a) {
        point->lower[a] = medium->box.lower[a] - position[a];
        point->upper[a] = medium->box.upper[a] - position[a];
        point->home[a] = (int32_t)fmin(fmax(floor(-point->lower[a] / medium->cell[a]), -1e6), 1e6);
        min_side = fmin(min_side, medium->cell[a]);
    }
    if (source->is_point == 0) point->lift = (float)(1e-3 * min_side);
}

ty_result ty_point_light_add(const ty_scene_view* scene, const ty_grid_medium* medium, float* const extinction[3],
                             const ty_discrete_light* source, const ty_point_light_target* out,
                             ty_part_progress* progress) {
    ty_point_light_job point = {
        .scene = scene, .medium = medium, .source = source, .extinction = extinction, .out = *out};
    const size_t threads = (size_t)ty_context_threads(medium->context);
    point.light = &scene->lights.lights[source->light];
    point.kernels = TY_BEST_KERNELS(ty_direct_kernels);
    point.progress = progress;
    place_point(&point);
    point.scratch_size = cell_scratch(&point);
    point.scratch = ty_alloc_array(medium->context, point.scratch_size * threads, sizeof *point.scratch, false);
    if (point.scratch == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t face = 0; face < 6 && result == TY_OK; ++face) result = light_pyramid(&point, face / 2, face % 2 != 0);
    if (result == TY_OK && out->transmittance == NULL) result = ty_near_cells_add(&point);
    ty_free_array(medium->context, point.scratch, point.scratch_size * threads, sizeof *point.scratch);
    return result;
}
