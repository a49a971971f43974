/* Evaluation of stored lobes: for another eye, and at any point. */
#include "method/pop/grid/slab.h"

#include "base/float_mode.h"
#include "method/pop/grid/lobe.k.h"

/* ---- sizes ---- */

int32_t ty_pop_band_index(int32_t m) {
    int32_t band = 0;
    while (band < TY_POP_BANDS - 1 && (1 << band) < m) ++band;
    return band;
}

size_t ty_pop_lobe_floats(const ty_pop_grid* grid, const ty_pop_def* def, int32_t planes, int32_t iterations) {
    const size_t bands = (size_t)ty_pop_band_index(iterations) + 1;
    const size_t arrays = def->mode == TY_POP_MODE_SPLIT ? 3 : 1 + 2 * bands;
    return (size_t)planes * arrays * ty_pop_cells(grid);
}

/* ---- another eye ---- */

typedef struct evaluation {
    ty_pop_light* light;
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_eye_view view;
} evaluation;

/* A lobe array at slab k, from the block's first column on. */
static const float* lobe_array(const evaluation* e, size_t array, int32_t k) {
    const size_t cells = ty_pop_cells(&e->light->grid), slice = cells / (size_t)e->light->grid.size[2];
    return e->light->lobes + array * cells + slice * (size_t)k + (size_t)e->columns.first;
}

/* Published: Eq. 8 (Elek 2014). Collided: one more scattering, and the uncollided light's. */
static void scatter_bands(evaluation* e, int32_t plane, int32_t k) {
    const bool collided = e->light->mode == TY_POP_MODE_COLLIDED;
    const size_t first = (size_t)plane * (1 + 2 * (size_t)e->light->bands);
    const float *uncollided = lobe_array(e, first, k), *g_of = e->slab.g[plane], *mu = e->view.mu;
    float* radiance = e->view.radiance[plane];
    for (int32_t i = 0; i < e->columns.count; ++i)
        radiance[i] = collided ? uncollided[i] * ty_pop_hg(mu[i], e->view.cosine * g_of[i]) : 0;
    for (size_t band = 0; band < (size_t)e->light->bands; ++band) {
        const float* fluence = lobe_array(e, first + 1 + 2 * band, k);
        const float* first_moment = lobe_array(e, first + 2 + 2 * band, k);
        for (int32_t i = 0; i < e->columns.count; ++i) {
            const float a = ty_clampf(first_moment[i] / ty_maxf(fluence[i], 1e-30f), -1.0f, 1.0f);
            radiance[i] += fluence[i] * ty_pop_hg(mu[i], collided ? a * g_of[i] : a);
        }
    }
}

static void write_radiance(const evaluation* e, int32_t k) {
    float* slab = ty_pop_accumulated_slab(e->light, k);
    for (int32_t i = 0; i < e->columns.count; ++i) {
        float* cell = slab + (size_t)e->light->floats * (size_t)e->columns.cell[i];
        for (int32_t c = 0; c < 3; ++c)
            cell[c] = e->light->ordinate.color[c] * e->view.radiance[e->light->planes == 3 ? c : 0][i];
    }
}

static void evaluate_slab(const ty_pop_grid_kernels* kernels, evaluation* e, int32_t k) {
    ty_pop_slab_enter(kernels, k, &e->slab);
    kernels->eye_cosines(&e->slab, &e->view);
    for (int32_t p = 0; p < e->light->planes && e->light->mode != TY_POP_MODE_SPLIT; ++p) scatter_bands(e, p, k);
    if (e->light->mode == TY_POP_MODE_SPLIT) {
        for (size_t p = 0; p < (size_t)e->light->planes; ++p)
            for (size_t order = 0; order < 3; ++order) e->view.mean[p][order] = lobe_array(e, 3 * p + order, k);
        kernels->scatter(&e->slab, &e->view);
    }
    if (e->light->mode == TY_POP_MODE_SPLIT)
        ty_pop_write_accumulated(e->light, &e->slab, &e->view, k);
    else
        write_radiance(e, k);
}

/* L_acc of Eq. 7 and 8 (Elek 2014). */
void ty_pop_evaluate_lobes(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light) {
    evaluation g = {.light = light};
    const ty_pop_grid_kernels* kernels = TY_BEST_KERNELS(ty_pop_grid_kernels);
    const unsigned state = ty_flush_denormals();
    ty_pop_slab_setup(kernels, medium, &g.columns, &g.slab);
    ty_pop_eye_view_setup(medium, eye, light, &g.view);
    memset(light->accumulated, 0, ty_pop_accumulated_floats(&light->grid, light->floats) * sizeof *light->accumulated);
    for (int32_t first = 0; first < light->grid.size[0] * light->grid.size[1]; first += g.columns.count) {
        ty_pop_columns_begin(NULL, medium, light, first, &g.columns);
        for (int32_t k = 0; k < light->grid.size[2]; ++k) evaluate_slab(kernels, &g, k);
    }
    ty_pop_fill_ghost_cells(light);
    ty_restore_denormals(state);
}

/* ---- radiance at a point ---- */

/* Eight cells without ghosts, and their trilinear weights. */
typedef struct corner_cells {
    size_t cell[8];
    float fraction[8];
    float inverse_square;
} corner_cells;

static size_t cell_without_ghosts(const ty_pop_grid* grid, size_t with_ghosts) {
    const int32_t ghosts = ty_pop_ghost_width(grid), n = grid->size[0];
    const size_t row = (size_t)(n + 2 * ghosts), slice = row * (size_t)(grid->size[1] + 2 * ghosts);
    int32_t i = (int32_t)(with_ghosts % row) - ghosts, j = (int32_t)(with_ghosts % slice / row) - ghosts;
    if (ghosts != 0) ty_octahedral_wrap(n, &i, &j);
    return (size_t)i + (size_t)n * ((size_t)j + (size_t)grid->size[1] * (with_ghosts / slice));
}

static corner_cells find_corners(const ty_pop_light* light, ty_vec point) {
    const ty_pop_cell_position position = ty_pop_locate(&light->grid, light->ordinate.min_distance, point);
    corner_cells corners = {.inverse_square = position.inverse_square};
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t cell = position.base;
        float fraction = 1;
        for (size_t a = 0; a < 3; ++a) {
            const bool next = (corner >> a & 1) != 0;
            cell += next ? position.step[a] : 0;
            fraction *= next ? position.fraction[a] : 1 - position.fraction[a];
        }
        corners.cell[corner] = cell_without_ghosts(&light->grid, cell);
        corners.fraction[corner] = fraction;
    }
    return corners;
}

static float interpolate(const ty_pop_light* light, const corner_cells* corners, size_t array) {
    const float* values = light->lobes + array * ty_pop_cells(&light->grid);
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) sum += corners->fraction[corner] * values[corners->cell[corner]];
    return sum * corners->inverse_square;
}

static float radiance_split(const ty_pop_light* light, const corner_cells* corners, size_t plane, float mu,
                            float* uncollided) {
    const float u = interpolate(light, corners, 3 * plane), r = interpolate(light, corners, 3 * plane + 1);
    const float s = interpolate(light, corners, 3 * plane + 2);
    *uncollided = u;
    const float disc = light->ordinate.mean_cosine, width = ty_pop_disc_width(disc);
    return ty_pop_disc_forward(mu, u, r, s, 1, disc, width, ty_pop_disc_lobe(1, disc, width));
}

static float radiance_bands(const ty_pop_light* light, const corner_cells* corners, size_t plane, float mu,
                            float* uncollided) {
    const size_t first = plane * (1 + 2 * (size_t)light->bands);
    float radiance = 0;
    *uncollided = interpolate(light, corners, first);
    for (size_t band = 0; band < (size_t)light->bands; ++band) {
        const float fluence = interpolate(light, corners, first + 1 + 2 * band);
        const float a = interpolate(light, corners, first + 2 + 2 * band) / ty_maxf(fluence, 1e-30f);
        radiance += fluence * ty_pop_hg(mu, ty_clampf(a, -1.0f, 1.0f));
    }
    return radiance;
}

void ty_pop_light_radiance(const ty_grid_medium* medium, const ty_pop_light* light, ty_vec point, ty_vec direction,
                           float* radiance, float* uncollided) {
    (void)medium;
    const corner_cells corners = find_corners(light, point);
    ty_vec along = light->grid.axis[2];
    if (light->grid.kind == TY_DISCRETE_POINT) {
        const ty_vec off = ty_sub(point, light->grid.origin);
        along = ty_scale(off, 1 / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f)));
    }
    const float mu = ty_clampf(ty_dot(along, direction), -1.0f, 1.0f);
    float scattered = 0, direct = 0;
    for (int32_t c = 0; c < 3; ++c) {
        if (c < light->planes)
            scattered = light->mode == TY_POP_MODE_SPLIT ? radiance_split(light, &corners, (size_t)c, mu, &direct)
                                                         : radiance_bands(light, &corners, (size_t)c, mu, &direct);
        radiance[c] += light->ordinate.color[c] * scattered;
        if (uncollided != NULL) uncollided[c] += light->ordinate.color[c] * direct;
    }
}
