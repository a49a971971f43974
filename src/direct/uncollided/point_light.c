/* Uncollided light of a point: six pyramids around it, one per face of a cube, each divided into sections within which
 * the distance doubles. Each section has a lattice of rays with mean extinctions. */
#include "direct/uncollided/point_light.h"

#include "base/context.h"
#include "base/float_mode.h"
#include "direct/uncollided/cell_rows.h"

/* Means over the cells [begin, end) of the row. */
static void find_means(const ty_cell_row* row, int32_t begin, int32_t end) {
    const ty_point_light_job* point = row->l->job;
    ty_cell_row_means cells = ty_cell_row_means_of(row, begin, end);
    for (int32_t c = 0; c < point->medium->planes; ++c) {
        const ty_ray_row_blend rays = ty_cell_row_rays(row, c, begin, end);
        point->kernels->blend_rows(&rays);
        cells.extinction = point->extinction[c] + row->first;
        cells.transmittance = row->transmittance[c];
        point->kernels->cell_means(&cells);
    }
}

static void add_light(const ty_cell_row* row, int32_t begin, int32_t end) {
    const ty_ray_lattice* l = row->l;
    const ty_point_light_job* point = l->job;
    const ty_point_light_target* out = &point->out;
    ty_cell_row_find_directions(row, begin, end);
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

static void light_cells(const ty_cell_row* row, int32_t begin, int32_t end) {
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

/* Lights the rows v of all slabs. */
static void light_rows(void* user, int64_t v, int32_t worker) {
    const ty_ray_lattice* l = user;
    float* scratch = l->job->scratch + l->job->scratch_size * (size_t)worker;
    const unsigned state = ty_flush_denormals();
    for (int32_t slab = 0; slab < l->slabs; ++slab) {
        ty_cell_row row;
        int32_t ranges[2][2];
        ty_cell_row_place(l, slab, (int32_t)v, scratch, &row);
        const int32_t count = ty_cell_row_ranges(&row, l->job->out.transmittance != NULL, ranges);
        for (int32_t n = 0; n < count; ++n) light_cells(&row, ranges[n][0], ranges[n][1]);
    }
    ty_restore_denormals(state);
}

/* ---- pyramids ---- */

static ty_result light_pyramid(ty_point_light_job* point, int32_t w, bool backwards) {
    const ty_grid_medium* medium = point->medium;
    ty_ray_lattice l, before = {.job = point};
    ty_result result = TY_OK;
    int32_t begin = ty_ray_lattice_begin(point, w, backwards, &l);
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

void ty_point_light_place(ty_point_light_job* point) {
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
    ty_point_light_place(&point);
    point.scratch_size = ty_cell_row_scratch(&point);
    point.scratch = ty_alloc_array(medium->context, point.scratch_size * threads, sizeof *point.scratch, false);
    if (point.scratch == NULL) return TY_ERROR_MEMORY;
    ty_result result = TY_OK;
    for (int32_t face = 0; face < 6 && result == TY_OK; ++face) result = light_pyramid(&point, face / 2, face % 2 != 0);
    if (result == TY_OK && out->transmittance == NULL) result = ty_near_cells_add(&point);
    ty_free_array(medium->context, point.scratch, point.scratch_size * threads, sizeof *point.scratch);
    return result;
}
