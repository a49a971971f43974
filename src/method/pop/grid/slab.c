/* Slabs of an ordinate's grid. */
#include "method/pop/grid/slab.h"

#include "method/pop/grid/lobe.k.h"

size_t ty_pop_cells(const ty_pop_grid* grid) {
    return (size_t)grid->size[0] * (size_t)grid->size[1] * (size_t)grid->size[2];
}

float* ty_pop_accumulated_slab(const ty_pop_light* light, int32_t k) {
    const size_t slab = ty_pop_cells_with_ghosts(&light->grid) / (size_t)light->grid.size[2];
    return light->accumulated + (size_t)light->floats * slab * (size_t)k;
}

size_t ty_pop_accumulated_floats(const ty_pop_grid* grid, int32_t floats) {
    return ty_pop_cells_with_ghosts(grid) * (size_t)floats;
}

static float mean_g(const ty_grid_medium* medium, int32_t plane) {
    double sigma_s_g = 0, scattering = 0;
    for (size_t i = 0; i < medium->cells; ++i) {
        scattering += (double)medium->scattering[plane][i];
        sigma_s_g += (double)(medium->scattering[plane][i] * medium->g[plane][i]);
    }
    return scattering > 0 ? (float)(sigma_s_g / scattering) : 0;
}

/* A medium with one density and one g per channel, the common case, needs one interpolation per cell. */
static bool find_proportional(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, ty_pop_slab* slab) {
    const float* density = medium->extinction[0];
    const int32_t cells = (int32_t)medium->cells;
    size_t densest = 0;
    for (size_t i = 0; i < medium->cells; ++i)
        if (density[i] > density[densest]) densest = i;
    if (!(density[densest] > 0)) return false;
    for (int32_t p = 0; p < medium->planes; ++p) {
        const float* const planes[2] = {medium->extinction[p], medium->scattering[p]};
        for (int i = 0; i < 2; ++i) {
            slab->multiple[i][p] = planes[i][densest] / density[densest];
            if (kernels->proportionality_error(planes[i], density, slab->multiple[i][p], 1e-6f * planes[i][densest],
                                               cells) > 0)
                return false;
        }
        slab->default_g[p] = medium->g[p][densest];
        if (kernels->g_variation(medium->g[p], medium->scattering[p], slab->default_g[p], 1e-6f, cells) > 0)
            return false;
    }
    return true;
}

void ty_pop_slab_setup(const ty_pop_grid_kernels* kernels, const ty_grid_medium* medium, const ty_pop_columns* columns,
                       ty_pop_slab* slab) {
    slab->columns = columns;
    slab->medium = medium;
    for (int a = 0; a < 3; ++a) slab->per_metre[a] = (float)(1 / medium->cell[a]);
    slab->proportional = find_proportional(kernels, medium, slab);
    for (int32_t p = 0; p < medium->planes && slab->proportional == 0; ++p) slab->default_g[p] = mean_g(medium, p);
}

void ty_pop_slab_enter(const ty_pop_grid_kernels* kernels, int32_t k, ty_pop_slab* slab) {
    const ty_pop_grid* grid = slab->columns->grid;
    slab->ends[0] = ty_pop_slab_begin(grid, k);
    slab->ends[1] = ty_pop_slab_begin(grid, k + 1);
    slab->center = grid->kind == TY_DISCRETE_DIRECTIONAL ? 0.5f * (slab->ends[0] + slab->ends[1])
                                                         : ty_pop_radius(grid, (float)k + 0.5f);
    kernels->sample(slab);
}

void ty_pop_transmittance_begin(const ty_pop_grid_kernels* kernels, int32_t orders, ty_pop_slab* slab,
                                ty_pop_transmittance* t) {
    float unused[TY_POP_BLOCK];
    t->orders = orders;
    for (int32_t p = 0; p < slab->medium->planes; ++p)
        for (int32_t order = 0; order < orders; ++order) {
            t->mean[p][order] = unused;
            for (int32_t i = 0; i < slab->columns->count; ++i) t->along[p][order][i] = 1;
        }
    if (slab->columns->grid->kind == TY_DISCRETE_DIRECTIONAL) return;
    ty_pop_slab_enter(kernels, -1, slab);
    kernels->incident_light(slab);
    kernels->attenuate(slab, t);
}

void ty_pop_eye_view_setup(const ty_grid_medium* medium, const float eye[3], const ty_pop_light* light,
                           ty_pop_eye_view* view) {
    for (int a = 0; a < 3; ++a) view->eye[a] = (float)((double)eye[a] - medium->box.lower[a]);
    view->cosine = light->ordinate.mean_cosine;
    view->width = ty_pop_disc_width(view->cosine);
}

/* Weights of merging: cells count by optical depth, so that vacuum beside a medium does not dilute its light; below
 * this depth they count equally. */
static const float min_weight = 0.05f;

static void find_weights(const ty_pop_slab* slab, float weight[TY_POP_BLOCK]) {
    const int32_t count = slab->columns->count, planes = slab->medium->planes;
    const float per_plane = 1 / (float)planes;
    for (int32_t i = 0; i < count; ++i) weight[i] = 0;
    for (int32_t p = 0; p < planes; ++p)
        for (int32_t i = 0; i < count; ++i) weight[i] += slab->extinction[p][i] * slab->length[i];
    for (int32_t i = 0; i < count; ++i) weight[i] = min_weight + weight[i] * per_plane;
}

void ty_pop_write_accumulated(const ty_pop_light* light, const ty_pop_slab* slab, const ty_pop_eye_view* view,
                              int32_t k) {
    float weight[TY_POP_BLOCK], *cells = ty_pop_accumulated_slab(light, k);
    const float *radiance[3], *fluence[3], *color = light->ordinate.color;
    find_weights(slab, weight);
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = light->planes == 3 ? c : 0;
        radiance[c] = view->radiance[p];
        fluence[c] = view->mean[p][1];
    }
    for (int32_t i = 0; i < slab->columns->count; ++i) {
        float* cell = cells + (size_t)light->floats * (size_t)slab->columns->cell[i];
        const float weighted_color[3] = {weight[i] * color[0], weight[i] * color[1], weight[i] * color[2]};
        for (int32_t c = 0; c < 3; ++c) {
            cell[c] = weighted_color[c] * radiance[c][i];
            cell[3 + c] = weighted_color[c] * fluence[c][i];
        }
        cell[TY_POP_CELL_WEIGHT] = weight[i];
        cell[TY_POP_CELL_WEIGHT + 1] = 0;
    }
}
