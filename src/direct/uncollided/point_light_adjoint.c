/* Forward, the sections of a pyramid are traced outwards one after another. On the way back, from the last one to the
 * first, cells give their derivatives by mean extinction to the rays around them, and rays to cells and to the rays of
 * the section before. With the depth tau at its center and the extinction e a cell has
 *
 *     T = M(tau, e) ratio(e),   M = exp(-tau) prod_a exp(x_a / 2) m(x_a),   x_a = e |slope_a| side_a
 *
 * (point_light.k.h), so that dM/dtau = -M and dM/de = M sum_a (1 / 2 + m'(x_a) / m(x_a)) x_a / e. */
#include "direct/uncollided/point_light_adjoint.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/cell_rows.h"
#include "direct/uncollided/point_rows.k.h"

#include <string.h>

/* Sections, each at least four slabs and twice as far as the one before. */
enum { SECTIONS_MAX = 32 };

typedef struct return_job {
    ty_point_light_job point;
    const ty_uncollided_loss* loss;
    float* gradient;
    double parts[3];                       /* of the loss, per channel */
    ty_ray_lattice sections[SECTIONS_MAX]; /* of the pyramid at hand */
    float* by_mean[SECTIONS_MAX];          /* derivatives by their mean[0] */
    int32_t count;
    float* by_ray; /* by the mean extinction of a row of rays, at a row of cells */
    /* Of cells next to the light: the loss by the light in it, and that light. */
    float *weight, *light;
} return_job;

/* ---- cells ---- */

/* T of a cell, and its derivatives by optical depth and extinction. */
typedef struct cell_slope {
    float value, by_depth, by_extinction;
} cell_slope;

static cell_slope differentiate_cell(const ty_cell_depth* d, const ty_cell_place* p, const float cell[3]) {
    const float mean = ty_cell_mean_transmittance(d, cell);
    ty_cell_depth bare = *d, full = *d;
    float relative = 0;
    for (int a = 0; a < 3; ++a) {
        const float side = fabsf(d->slope[a]) * cell[a], x = d->extinction * side, decay = ty_attenuation(x);
        const float m = ty_mean_attenuation(x, decay);
        relative += side * (0.5f + ty_mean_attenuation_slope(x, decay, m) / m);
    }
    bare.extinction = 0;
    full.extinction = 1;
    const float ratio = ty_cell_falloff_ratio(d, p->to, p->per_distance, cell);
    const float by_ratio = ty_cell_falloff_ratio(&full, p->to, p->per_distance, cell) -
                           ty_cell_falloff_ratio(&bare, p->to, p->per_distance, cell);
    const float factor = ty_clampf(ratio, 0, TY_MAX_FALLOFF_RATIO);
    const bool is_limited = mean >= 1 && d->extinction > 0;
    cell_slope out = {.value = mean * factor};
    if (!is_limited) {
        out.by_depth = -mean * factor;
        out.by_extinction = mean * relative * factor;
    }
    if (ratio > 0 && ratio < TY_MAX_FALLOFF_RATIO) out.by_extinction += mean * by_ratio;
    return out;
}

/* Adds the cell's part of the loss and returns its derivative by T. */
static float weigh_cell(return_job* job, size_t at, float falloff, float value) {
    float sum = 0;
    for (int32_t c = 0; c < job->loss->channels; ++c) {
        const float weight = ty_uncollided_loss_color(job->loss, job->point.source, c) * job->loss->weight[c][at];
        job->parts[c] += (double)weight * (double)(value * falloff);
        sum += weight;
    }
    return sum * falloff;
}

/* From the rays around a row of cells to the lattice. */
static void return_rays(const return_job* job, const ty_ray_row_blend* rays, int32_t section) {
    const ty_ray_lattice* l = &job->sections[section];
    const float across[2] = {1 - rays->row_t, rays->row_t}, along[2] = {1 - rays->far_t, rays->far_t};
    for (int n = 0; n < 4; ++n) {
        float* to = job->by_mean[section] + (rays->mean[n] - l->mean[0]);
        const float weight = across[n % 2] * along[n / 2];
        for (int32_t i = rays->begin; i < rays->end; ++i) to[i] += weight * job->by_ray[i];
    }
}

static void return_cells(return_job* job, int32_t section, const ty_cell_row* row, int32_t begin, int32_t end) {
    const ty_point_light_job* point = &job->point;
    const ty_ray_row_blend rays = ty_cell_row_rays(row, 0, begin, end);
    const ty_cell_row_means cells = ty_cell_row_means_of(row, begin, end);
    point->kernels->blend_rows(&rays);
    ty_cell_row_find_directions(row, begin, end);
    memset(job->by_ray, 0, sizeof(float) * (size_t)job->sections[section].count[0]);
    for (int32_t i = begin; i < end; ++i) {
        const size_t at = row->first + row->stride * (size_t)i;
        const ty_cell_place p = ty_cell_row_place_at(&cells, i);
        float t;
        const int32_t ray = ty_cell_row_column(&cells, i, &t);
        ty_cell_depth d = {.depth = ty_lerp_exact(row->mean[ray], row->mean[ray + 1], t) * p.in_media,
                           .extinction = point->extinction[0][at]};
        memcpy(d.slope, p.slope, sizeof d.slope);
        const cell_slope slope = differentiate_cell(&d, &p, cells.cell);
        const float by_value = weigh_cell(job, at, row->falloff[i], slope.value);
        const float by_mean = by_value * slope.by_depth * p.in_media;
        job->gradient[at] += by_value * slope.by_extinction;
        job->by_ray[ray] += by_mean * (1 - t);
        job->by_ray[ray + 1] += by_mean * t;
    }
    return_rays(job, &rays, section);
}

static void return_section(return_job* job, int32_t section) {
    const ty_ray_lattice* l = &job->sections[section];
    const int32_t rows = job->point.medium->box.size[l->axis[1]];
    for (int32_t slab = 0; slab < l->slabs; ++slab)
        for (int32_t v = 0; v < rows; ++v) {
            ty_cell_row row;
            int32_t ranges[2][2];
            ty_cell_row_place(l, slab, v, job->point.scratch, &row);
            const int32_t count = ty_cell_row_ranges(&row, false, ranges);
            for (int32_t n = 0; n < count; ++n) return_cells(job, section, &row, ranges[n][0], ranges[n][1]);
        }
}

/* ---- pyramids ---- */

static ty_result trace_section(return_job* job, const ty_ray_lattice* placed, const ty_ray_lattice* none) {
    const int32_t n = job->count;
    ty_ray_lattice* l = &job->sections[n];
    *l = *placed;
    ++job->count;
    job->by_mean[n] = ty_alloc_array(job->point.medium->context, ty_ray_lattice_values(l), sizeof(float), true);
    if (job->by_mean[n] == NULL) return TY_ERROR_MEMORY;
    return ty_ray_lattice_trace(l, n > 0 ? &job->sections[n - 1] : none);
}

static void end_pyramid(return_job* job) {
    for (int32_t i = 0; i < job->count; ++i) {
        ty_ray_lattice* l = &job->sections[i];
        ty_free_array(job->point.medium->context, job->by_mean[i], ty_ray_lattice_values(l), sizeof(float));
        ty_ray_lattice_end(l);
    }
    job->count = 0;
}

static ty_result return_pyramid(return_job* job, int32_t w, bool backwards) {
    const ty_grid_medium* medium = job->point.medium;
    const ty_ray_lattice none = {.job = &job->point};
    ty_ray_lattice l;
    ty_result result = TY_OK;
    int32_t begin = ty_ray_lattice_begin(&job->point, w, backwards, &l);
    for (; begin < medium->box.size[w] && result == TY_OK && job->count < SECTIONS_MAX; begin += l.slabs)
        if (ty_ray_lattice_place(&l, begin)) result = trace_section(job, &l, &none);
    for (int32_t i = job->count - 1; i >= 0 && result == TY_OK; --i) {
        const ty_ray_lattice* before = i > 0 ? &job->sections[i - 1] : &none;
        return_section(job, i);
        ty_ray_lattice_return(&job->sections[i], before, job->by_mean[i], i > 0 ? job->by_mean[i - 1] : NULL,
                              job->gradient);
    }
    end_pyramid(job);
    return result;
}

/* ---- cells next to the light ---- */

static void return_near(return_job* job) {
    const ty_grid_medium* medium = job->point.medium;
    const ty_uncollided_loss* loss = job->loss;
    const double volume = medium->cell[0] * medium->cell[1] * medium->cell[2];
    double color[3];
    memset(job->weight, 0, sizeof(float) * medium->cells);
    memset(job->light, 0, sizeof(float) * medium->cells);
    for (int32_t c = 0; c < loss->channels; ++c) {
        color[c] = (double)ty_uncollided_loss_color(loss, job->point.source, c) / volume;
        for (size_t i = 0; i < medium->cells; ++i) job->weight[i] += (float)(color[c] * (double)loss->weight[c][i]);
    }
    ty_near_cells_return(&job->point, job->weight, job->gradient, job->light);
    for (int32_t c = 0; c < loss->channels; ++c)
        for (size_t i = 0; i < medium->cells; ++i)
            job->parts[c] += color[c] * (double)(loss->weight[c][i] * job->light[i]);
}

/* ---- all points ---- */

static ty_result return_point(return_job* job, const ty_scene_view* scene, const ty_discrete_light* source) {
    job->point.source = source;
    job->point.light = &scene->lights.lights[source->light];
    memset(job->parts, 0, sizeof job->parts);
    ty_point_light_place(&job->point);
    ty_result result = TY_OK;
    for (int32_t face = 0; face < 6 && result == TY_OK; ++face) result = return_pyramid(job, face / 2, face % 2 != 0);
    if (result == TY_OK) return_near(job);
    return result;
}

ty_result ty_point_light_adjoint(const ty_scene_view* scene, const ty_grid_medium* medium,
                                 const ty_uncollided_loss* loss, float* gradient, double (*strength)[3]) {
    ty_context* context = medium->context;
    ty_grid_medium plane = *medium;
    float* const extinction[1] = {(float*)loss->extinction};
    plane.planes = 1;
    return_job job = {
        .point = {.scene = scene, .medium = &plane, .extinction = extinction}, .loss = loss, .gradient = gradient};
    job.point.kernels = TY_BEST_KERNELS(ty_direct_kernels);
    job.point.scratch_size = ty_cell_row_scratch(&job.point);
    const size_t scratch = job.point.scratch_size * (size_t)ty_context_threads(context);
    job.point.scratch = ty_alloc_array(context, scratch, sizeof(float), false);
    job.by_ray = ty_alloc_array(context, job.point.scratch_size, sizeof(float), false);
    job.weight = ty_alloc_array(context, medium->cells, sizeof(float), false);
    job.light = ty_alloc_array(context, medium->cells, sizeof(float), false);
    ty_result result = job.point.scratch != NULL && job.by_ray != NULL && job.weight != NULL && job.light != NULL
                           ? TY_OK
                           : TY_ERROR_MEMORY;
    const unsigned state = ty_flush_denormals();
    for (int32_t i = 0; i < loss->count && result == TY_OK; ++i) {
        const ty_discrete_light* source = &loss->sources[i];
        if (source->kind != TY_DISCRETE_POINT) continue;
        result = ty_part_show(loss->progress, "adjoint", (double)i / loss->count);
        if (result == TY_OK) result = return_point(&job, scene, source);
        for (int32_t c = 0; c < loss->channels && result == TY_OK; ++c)
            ty_uncollided_loss_add(loss, source, c, job.parts[c], strength[source->light]);
    }
    ty_restore_denormals(state);
    ty_free_array(context, job.point.scratch, scratch, sizeof(float));
    ty_free_array(context, job.by_ray, job.point.scratch_size, sizeof(float));
    ty_free_array(context, job.weight, medium->cells, sizeof(float));
    ty_free_array(context, job.light, medium->cells, sizeof(float));
    return result;
}
