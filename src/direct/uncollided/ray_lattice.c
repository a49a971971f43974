/* Lattices of rays from a point light, slab by slab. */
#include "direct/uncollided/ray_lattice.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/occlusion.h"
#include "direct/uncollided/point_rows.k.h"

/* MARGIN: cells beside the box within which rays are still traced. */
enum { FIRST_SLABS = 4, MARGIN = 4 };

size_t ty_ray_lattice_rays(const ty_ray_lattice* l) {
    return (size_t)l->count[0] * (size_t)l->count[1];
}

size_t ty_ray_lattice_values(const ty_ray_lattice* l) {
    return ty_ray_lattice_rays(l) * (size_t)(l->slabs + 1);
}

/* Maximum number of rays along one axis: twice the cells, and as many again for boxes seen askew. */
static int32_t rays_max(const ty_point_light_job* point, int32_t axis) {
    return 4 * point->medium->box.size[axis] + 64;
}

size_t ty_ray_lattice_scratch(const ty_point_light_job* point) {
    size_t max_count = 0;
    for (int32_t a = 0; a < 3; ++a)
        max_count = rays_max(point, a) > (int32_t)max_count ? (size_t)rays_max(point, a) : max_count;
    return max_count * (size_t)(1 + point->medium->planes);
}

void ty_ray_lattice_end(ty_ray_lattice* l) {
    ty_context* context = l->job->medium->context;
    for (int32_t c = 0; c < l->job->medium->planes; ++c)
        ty_free_array(context, l->mean[c], ty_ray_lattice_values(l), sizeof *l->mean[c]);
    ty_free_array(context, l->hit, ty_ray_lattice_rays(l), sizeof *l->hit);
    l->slabs = 0;
    l->hit = l->mean[0] = l->mean[1] = l->mean[2] = NULL;
}

static ty_result allocate_lattice(ty_ray_lattice* l) {
    const ty_grid_medium* medium = l->job->medium;
    for (int32_t c = 0; c < medium->planes; ++c) {
        l->mean[c] = ty_alloc_array(medium->context, ty_ray_lattice_values(l), sizeof *l->mean[c], true);
        if (l->mean[c] == NULL) return TY_ERROR_MEMORY;
    }
    if (l->job->scene->mesh == NULL) return TY_OK;
    l->hit = ty_alloc_array(medium->context, ty_ray_lattice_rays(l), sizeof *l->hit, false);
    return l->hit != NULL ? TY_OK : TY_ERROR_MEMORY;
}

/* ---- placement ---- */

double ty_ray_lattice_plane(const ty_ray_lattice* l, int32_t slab) {
    const int32_t w = l->axis[2];
    const double cell = l->job->medium->cell[w];
    const double from = l->backwards ? -l->job->upper[w] : l->job->lower[w];
    return fmax(l->near, from + cell * (l->begin + slab));
}

int32_t ty_ray_lattice_cell(const ty_ray_lattice* l, int32_t slab) {
    const int32_t at = l->begin + slab;
    return l->backwards ? l->job->medium->box.size[l->axis[2]] - 1 - at : at;
}

float ty_ray_lattice_locate(const ty_ray_lattice* l, int32_t along, double tangent, int32_t* i) {
    const double at = fmin(fmax((tangent - l->low[along]) / l->step[along], 0), l->count[along] - 1);
    *i = (int32_t)fmin(at, l->count[along] - 2);
    return (float)(at - *i);
}

/* Tangents under which the box appears between the lattice's near and far side; false: the pyramid misses it. */
static bool place_rays(ty_ray_lattice* l) {
    for (int i = 0; i < 2; ++i) {
        const int32_t a = l->axis[i];
        const double low = l->job->lower[a], high = l->job->upper[a];
        const double at_low = low < 0 ? l->near : l->far, at_high = high > 0 ? l->near : l->far;
        l->low[i] = at_low > 0 ? fmax(-1, low / at_low) : -1;
        const double end = at_high > 0 ? fmin(1, high / at_high) : 1;
        if (!(end > l->low[i])) return false;
        const double rays = ceil((end - l->low[i]) * l->far / l->job->medium->cell[a]) + 1;
        l->count[i] = (int32_t)fmin(fmax(2, rays), rays_max(l->job, a));
        l->step[i] = (end - l->low[i]) / (l->count[i] - 1);
    }
    return true;
}

int32_t ty_ray_lattice_begin(const ty_point_light_job* point, int32_t w, bool backwards, ty_ray_lattice* l) {
    const double from = backwards ? -point->upper[w] : point->lower[w], cell = point->medium->cell[w];
    *l = (ty_ray_lattice){.job = point, .axis = {w == 0 ? 1 : 0, w == 2 ? 1 : 2, w}, .backwards = backwards};
    l->entry = fmax(0, from);
    return (int32_t)fmin(point->medium->box.size[w], fmax(0, floor(-from / cell)));
}

bool ty_ray_lattice_place(ty_ray_lattice* l, int32_t begin) {
    const int32_t size = l->job->medium->box.size[l->axis[2]];
    const double cell = l->job->medium->cell[l->axis[2]];
    l->begin = begin;
    l->near = 0;
    l->near = ty_ray_lattice_plane(l, 0);
    l->slabs = (int32_t)fmin(size - begin, fmax(FIRST_SLABS, ceil(l->near / cell)));
    l->far = INFINITY;
    l->far = ty_ray_lattice_plane(l, l->slabs);
    return l->far > l->near && place_rays(l);
}

/* The distance along w at which a ray enters the range [low, high], m; INFINITY: never. */
static double entry_of(double p, double low, double high) {
    if (low <= 0 && high >= 0) return 0;
    const double at = p != 0 ? (low > 0 ? low : high) / p : -1;
    return at > 0 ? at : INFINITY;
}

/* ---- rays ---- */

typedef struct trace_job {
    ty_ray_lattice* l;
    const ty_ray_lattice* before;
    ty_occlusion_box box;
} trace_job;

static float interpolate_rays(const ty_ray_lattice* l, const float* plane, const int32_t at[2], const float t[2]) {
    const float* row = plane + (size_t)at[1] * (size_t)l->count[0] + (size_t)at[0];
    const float* next = row + l->count[0];
    return ty_lerp_exact(ty_lerp_exact(row[0], row[1], t[0]), ty_lerp_exact(next[0], next[1], t[0]), t[1]);
}

/* Entries into the box of a row of rays, m along w from the box's near end, and their depths at the lattice's near
 * side, from the previous section. Rays do not leave the box again: beyond its sides they see the outer cells'
 * extinction. No cell there is lit, and interpolation with a ray inside stays correct. */
static void begin_row(const trace_job* job, double q, float* entry, float* const depth[3]) {
    const ty_ray_lattice *l = job->l, *before = job->before;
    const ty_point_light_job* point = l->job;
    const int32_t u = l->axis[0], v = l->axis[1], planes = point->medium->planes;
    const double from = fmax(l->entry, entry_of(q, point->lower[v], point->upper[v]));
    int32_t at[2] = {0, 0};
    float t[2] = {0, 0};
    if (before->slabs > 0) t[1] = ty_ray_lattice_locate(before, 1, q, &at[1]);
    for (int32_t i = 0; i < l->count[0]; ++i) {
        const double p = l->low[0] + l->step[0] * i, enters = fmax(from, entry_of(p, point->lower[u], point->upper[u]));
        entry[i] = (float)(enters - l->entry);
        for (int32_t c = 0; c < planes; ++c) depth[c][i] = 0;
        if (before->slabs == 0 || !(l->near > enters)) continue;
        t[0] = ty_ray_lattice_locate(before, 0, p, &at[0]);
        const size_t last = ty_ray_lattice_rays(before) * (size_t)before->slabs;
        for (int32_t c = 0; c < planes; ++c)
            depth[c][i] = interpolate_rays(before, before->mean[c] + last, at, t) * (float)(l->near - enters);
    }
}

/* For positions first + i * step along `size` cells, the range of i in [0, count) that can affect cells: a ray farther
 * outside has left the box for good or not entered it yet. */
static void find_beside(double first, double step, int32_t size, int32_t count, int32_t range[2]) {
    range[0] = (int32_t)fmin(fmax(floor((-MARGIN - first) / step), 0), count);
    range[1] = (int32_t)fmin(fmax(ceil((size + MARGIN - first) / step) + 1, 0), count);
}

/* The row of rays of tangent q through a slab; past the last slab only the far side is left. */
static ty_ray_row rays_through(const ty_ray_lattice* l, int32_t slab, double q) {
    const ty_point_light_job* point = l->job;
    const ty_grid_medium* medium = point->medium;
    const int32_t u = l->axis[0], v = l->axis[1];
    const double near = ty_ray_lattice_plane(l, slab);
    const double far = slab < l->slabs ? fmin(l->far, ty_ray_lattice_plane(l, slab + 1)) : near;
    const size_t row = (size_t)medium->box.size[0];
    const size_t stride[3] = {1, row, row * (size_t)medium->box.size[1]};
    const double per_u = 1 / medium->cell[u], per_v = 1 / medium->cell[v];
    ty_ray_row rays = {
        .near = (float)(near - l->entry),
        .far = (float)(far - l->entry),
        .at = {(float)((l->low[0] * far - point->lower[u]) * per_u - 0.5), (float)(l->step[0] * far * per_u)},
        .slope = {(float)(l->low[0] * per_u), (float)(l->step[0] * per_u)},
        .row = (float)((q * far - point->lower[v]) * per_v - 0.5),
        .row_slope = (float)(q * per_v),
        .size = {medium->box.size[u], medium->box.size[v]},
        .stride = {(int32_t)stride[u], (int32_t)stride[v]},
    };
    int32_t range[2];
    find_beside((double)rays.at[0], (double)rays.at[1], rays.size[0], l->count[0], range);
    rays.begin = range[0];
    rays.end = rays.row < -MARGIN || rays.row > (float)(rays.size[1] + MARGIN) ? range[0] : range[1];
    return rays;
}

/* Occlusion distance of a ray, along w. */
static float occlusion_along(const trace_job* job, double p, double q) {
    const ty_ray_lattice* l = job->l;
    const ty_vec point = l->job->source->position;
    const double length = sqrt(1 + p * p + q * q), position[3] = {(double)point.x, (double)point.y, (double)point.z};
    double omega[3];
    ty_occlusion_span span = {0, INFINITY};
    omega[l->axis[0]] = p / length;
    omega[l->axis[1]] = q / length;
    omega[l->axis[2]] = (l->backwards ? -1 : 1) / length;
    for (int a = 0; a < 3; ++a)
        span = ty_occlusion_clip(span, &job->box, a, position[a], ty_occlusion_inverse(omega[a]));
    if (!(span.enter < span.leave)) return TY_OCCLUSION_UNDEFINED;
    const ty_vec direction = ty_vec_make((float)omega[0], (float)omega[1], (float)omega[2]);
    const float leave = (float)span.leave, reach = ty_point_light_visible_distance(l->job, direction, leave);
    if (!(reach < leave)) return TY_FLOAT_MAX;
    return (double)reach > span.enter ? reach / (float)length : 0;
}

static void trace_row(void* user, int64_t row, int32_t worker) {
    const trace_job* job = user;
    ty_ray_lattice* l = job->l;
    const ty_point_light_job* point = l->job;
    const ty_grid_medium* medium = point->medium;
    const double q = l->low[1] + l->step[1] * (double)row;
    const size_t size = (size_t)medium->box.size[0], count = (size_t)l->count[0], first = (size_t)row * count;
    const size_t per_slab[3] = {1, size, size * (size_t)medium->box.size[1]};
    float* entry = point->scratch + point->scratch_size * (size_t)worker;
    float* const depth[3] = {entry + count, entry + 2 * count, entry + 3 * count};
    const unsigned state = ty_flush_denormals();
    begin_row(job, q, entry, depth);
    for (int32_t slab = 0; slab <= l->slabs; ++slab) {
        ty_ray_row rays = rays_through(l, slab, q);
        const int32_t cell = ty_ray_lattice_cell(l, slab < l->slabs ? slab : l->slabs - 1);
        rays.entry = entry;
        for (int32_t c = 0; c < medium->planes; ++c) {
            rays.cells = point->extinction[c] + per_slab[l->axis[2]] * (size_t)cell;
            rays.depth = depth[c];
            rays.mean = l->mean[c] + ty_ray_lattice_rays(l) * (size_t)slab + first;
            point->kernels->trace_row(&rays);
        }
    }
    for (size_t i = 0; i < count && l->hit != NULL; ++i)
        l->hit[first + i] = occlusion_along(job, l->low[0] + l->step[0] * (double)i, q);
    ty_restore_denormals(state);
}

ty_result ty_ray_lattice_trace(ty_ray_lattice* l, const ty_ray_lattice* before) {
    const ty_result result = allocate_lattice(l);
    if (result != TY_OK) return result;
    trace_job job = {.l = l, .before = before, .box = ty_occlusion_box_of(l->job->medium)};
    ty_parallel_for(l->job->medium->context, l->count[1], trace_row, &job);
    if (l->hit != NULL) ty_occlusion_fill(l->hit, l->count[0], l->count[1]);
    return TY_OK;
}

/* ---- the adjoint ---- */

/* A row of rays on the way back. */
typedef struct return_row_job {
    const ty_ray_lattice *l, *before;
    double q;
    float *entry, *by_depth;
    float* by_mean_before; /* of the previous lattice */
    float* gradient;       /* of cells */
} return_row_job;

/* Back through a slab: from the derivatives by mean extinction and by depth behind it. */
static void return_slab(const return_row_job* job, int32_t slab, const float* by_mean) {
    const ty_ray_lattice* l = job->l;
    const ty_grid_medium* medium = l->job->medium;
    const size_t size = (size_t)medium->box.size[0];
    const size_t per_slab[3] = {1, size, size * (size_t)medium->box.size[1]};
    const int32_t cell = ty_ray_lattice_cell(l, slab < l->slabs ? slab : l->slabs - 1);
    float* cells = job->gradient + per_slab[l->axis[2]] * (size_t)cell;
    const ty_ray_row rays = rays_through(l, slab, job->q);
    for (int32_t i = rays.begin; i < rays.end; ++i) {
        const ty_ray_place p = ty_ray_row_place(&rays, i, job->entry[i]);
        float by_sigma = job->by_depth[i] * (rays.far - p.from);
        if (p.passed > 0)
            job->by_depth[i] += by_mean[i] / p.passed;
        else
            by_sigma += by_mean[i];
        const float before = by_sigma * (1 - p.row_t), after = by_sigma * p.row_t;
        cells[p.base] += before * (1 - p.t);
        cells[p.base + p.next_u] += before * p.t;
        cells[p.base + p.next_v] += after * (1 - p.t);
        cells[p.base + p.next_v + p.next_u] += after * p.t;
    }
}

/* From depths at the near side to the means of the previous section (begin_row). */
static void return_begin(const return_row_job* job) {
    const ty_ray_lattice *l = job->l, *before = job->before;
    int32_t at[2];
    const float row_t = ty_ray_lattice_locate(before, 1, job->q, &at[1]);
    float* last = job->by_mean_before + ty_ray_lattice_rays(before) * (size_t)before->slabs;
    for (int32_t i = 0; i < l->count[0]; ++i) {
        const float inside = (float)(l->near - l->entry) - job->entry[i];
        if (!(inside > 0)) continue;
        const float t = ty_ray_lattice_locate(before, 0, l->low[0] + l->step[0] * i, &at[0]);
        float* row = last + (size_t)at[1] * (size_t)before->count[0] + (size_t)at[0];
        const float by_first = job->by_depth[i] * inside * (1 - row_t), by_next = job->by_depth[i] * inside * row_t;
        row[0] += by_first * (1 - t);
        row[1] += by_first * t;
        row[before->count[0]] += by_next * (1 - t);
        row[before->count[0] + 1] += by_next * t;
    }
}

void ty_ray_lattice_return(const ty_ray_lattice* l, const ty_ray_lattice* before, float* by_mean, float* by_mean_before,
                           float* gradient) {
    const trace_job trace = {.l = (ty_ray_lattice*)l, .before = before};
    const size_t count = (size_t)l->count[0];
    float* entry = l->job->scratch;
    float* const depth[3] = {entry + count};
    for (int32_t row = 0; row < l->count[1]; ++row) {
        return_row_job job = {.l = l,
                              .before = before,
                              .q = l->low[1] + l->step[1] * row,
                              .entry = entry,
                              .by_depth = depth[0],
                              .by_mean_before = by_mean_before,
                              .gradient = gradient};
        begin_row(&trace, job.q, entry, depth);
        memset(job.by_depth, 0, count * sizeof *job.by_depth);
        for (int32_t slab = l->slabs; slab >= 0; --slab)
            return_slab(&job, slab, by_mean + ty_ray_lattice_rays(l) * (size_t)slab + count * (size_t)row);
        if (before->slabs > 0) return_begin(&job);
    }
}
