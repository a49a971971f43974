/* Kept lobes: seen from elsewhere, and at any point. */
#include "method/pop/slab.h"

#include "base/float_mode.h"
#include "method/pop/lobe.k.h"

/* ---- another eye ---- */

typedef struct glance {
    ty_pop_light* light;
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_look look;
} glance;

/* Arrays of the cells of a slab, from the block's first column on. */
static const float* array_of(const glance* g, size_t number, int32_t k) {
    const size_t cells = ty_pop_cells(&g->light->frame), slice = cells / (size_t)g->light->frame.size[2];
    return g->light->lobes + number * cells + slice * (size_t)k + (size_t)g->columns.first;
}

/* Published: Eq. 8. Collided: scattered once more, and the light that has not scattered. */
static void scatter_bands(glance* g, int32_t plane, int32_t k) {
    const bool again = g->light->mode == TY_POP_MODE_COLLIDED;
    const size_t first = (size_t)plane * (1 + 2 * (size_t)g->light->bands);
    const float *uncollided = array_of(g, first, k), *own = g->slab.g[plane], *mu = g->look.mu;
    float* radiance = g->look.radiance[plane];
    for (int32_t i = 0; i < g->columns.count; ++i)
        radiance[i] = again ? uncollided[i] * ty_pop_hg(mu[i], g->look.cosine * own[i]) : 0;
    for (size_t band = 0; band < (size_t)g->light->bands; ++band) {
        const float* passed = array_of(g, first + 1 + 2 * band, k);
        const float* forward = array_of(g, first + 2 + 2 * band, k);
        for (int32_t i = 0; i < g->columns.count; ++i) {
            const float a = ty_clampf(forward[i] / ty_maxf(passed[i], 1e-30f), -1.0f, 1.0f);
            radiance[i] += passed[i] * ty_pop_hg(mu[i], again ? a * own[i] : a);
        }
    }
}

static void write_radiance(const glance* g, int32_t k) {
    float* slab = ty_pop_seen_slab(g->light, k);
    for (int32_t i = 0; i < g->columns.count; ++i) {
        float* seen = slab + (size_t)g->light->floats * (size_t)g->columns.cell[i];
        for (int32_t c = 0; c < 3; ++c)
            seen[c] = g->light->ordinate.color[c] * g->look.radiance[g->light->planes == 3 ? c : 0][i];
    }
}

static void see_slab(const ty_pop_grid_kernels* kernels, glance* g, int32_t k) {
    ty_pop_slab_enter(kernels, k, &g->slab);
    kernels->look(&g->slab, &g->look);
    for (int32_t p = 0; p < g->light->planes && g->light->mode != TY_POP_MODE_SPLIT; ++p) scatter_bands(g, p, k);
    if (g->light->mode == TY_POP_MODE_SPLIT) {
        for (size_t p = 0; p < (size_t)g->light->planes; ++p)
            for (size_t order = 0; order < 3; ++order) g->look.mean[p][order] = array_of(g, 3 * p + order, k);
        kernels->scatter(&g->slab, &g->look);
    }
    if (g->light->mode == TY_POP_MODE_SPLIT)
        ty_pop_write_seen(g->light, &g->slab, &g->look, k);
    else
        write_radiance(g, k);
}

/* L_acc of Eq. 7 and 8 (Elek 2014). */
void ty_pop_see(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light) {
    glance g = {.light = light};
    const ty_pop_grid_kernels* kernels = ty_pop_grid_kernels_best();
    const unsigned state = ty_flush_denormals();
    ty_pop_slab_setup(kernels, medium, &g.columns, &g.slab);
    ty_pop_look_setup(medium, eye, light, &g.look);
    memset(light->seen, 0, ty_pop_seen_floats(&light->frame, light->floats) * sizeof *light->seen);
    for (int32_t first = 0; first < light->frame.size[0] * light->frame.size[1]; first += g.columns.count) {
        ty_pop_columns_begin(NULL, medium, light, first, &g.columns);
        for (int32_t k = 0; k < light->frame.size[2]; ++k) see_slab(kernels, &g, k);
    }
    ty_pop_fill_ring(light);
    ty_restore_denormals(state);
}

/* ---- a point ---- */

/* Eight cells without a ring, and their shares. */
typedef struct neighbours {
    size_t cell[8];
    float share[8];
    float spread;
} neighbours;

static size_t cell_without_ring(const ty_pop_frame* frame, size_t ringed) {
    const int32_t ring = ty_pop_ring(frame), n = frame->size[0];
    const size_t row = (size_t)(n + 2 * ring), slice = row * (size_t)(frame->size[1] + 2 * ring);
    int32_t i = (int32_t)(ringed % row) - ring, j = (int32_t)(ringed % slice / row) - ring;
    if (ring != 0) ty_octahedral_wrap(n, &i, &j);
    return (size_t)i + (size_t)n * ((size_t)j + (size_t)frame->size[1] * (ringed / slice));
}

static neighbours find_neighbours(const ty_pop_light* light, ty_vec point) {
    const ty_pop_place place = ty_pop_locate(&light->frame, light->ordinate.least, point);
    neighbours near = {.spread = place.spread};
    for (size_t corner = 0; corner < 8; ++corner) {
        size_t cell = place.base;
        float share = 1;
        for (size_t a = 0; a < 3; ++a) {
            const bool next = (corner >> a & 1) != 0;
            cell += next ? place.step[a] : 0;
            share *= next ? place.share[a] : 1 - place.share[a];
        }
        near.cell[corner] = cell_without_ring(&light->frame, cell);
        near.share[corner] = share;
    }
    return near;
}

static float between(const ty_pop_light* light, const neighbours* near, size_t number) {
    const float* array = light->lobes + number * ty_pop_cells(&light->frame);
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) sum += near->share[corner] * array[near->cell[corner]];
    return sum * near->spread;
}

static float radiance_split(const ty_pop_light* light, const neighbours* near, size_t plane, float mu,
                            float* uncollided) {
    const float u = between(light, near, 3 * plane), r = between(light, near, 3 * plane + 1);
    const float s = between(light, near, 3 * plane + 2);
    *uncollided = u;
    const float disc = light->ordinate.cosine, width = ty_pop_disc_width(disc);
    return ty_pop_disc_forward(mu, u, r, s, 1, disc, width, ty_pop_disc_lobe(1, disc, width));
}

static float radiance_bands(const ty_pop_light* light, const neighbours* near, size_t plane, float mu,
                            float* uncollided) {
    const size_t first = plane * (1 + 2 * (size_t)light->bands);
    float radiance = 0;
    *uncollided = between(light, near, first);
    for (size_t band = 0; band < (size_t)light->bands; ++band) {
        const float passed = between(light, near, first + 1 + 2 * band);
        const float a = between(light, near, first + 2 + 2 * band) / ty_maxf(passed, 1e-30f);
        radiance += passed * ty_pop_hg(mu, ty_clampf(a, -1.0f, 1.0f));
    }
    return radiance;
}

void ty_pop_light_radiance(const ty_grid_medium* medium, const ty_pop_light* light, ty_vec point, ty_vec way,
                           float* radiance, float* uncollided) {
    (void)medium;
    const neighbours near = find_neighbours(light, point);
    ty_vec along = light->frame.axis[2];
    if (light->frame.kind == TY_LIGHT_PART_RADIAL) {
        const ty_vec off = ty_sub(point, light->frame.origin);
        along = ty_scale(off, 1 / sqrtf(ty_maxf(ty_dot(off, off), 1e-30f)));
    }
    const float mu = ty_clampf(ty_dot(along, way), -1.0f, 1.0f);
    float found = 0, direct = 0;
    for (int32_t c = 0; c < 3; ++c) {
        if (c < light->planes)
            found = light->mode == TY_POP_MODE_SPLIT ? radiance_split(light, &near, (size_t)c, mu, &direct)
                                                     : radiance_bands(light, &near, (size_t)c, mu, &direct);
        radiance[c] += light->ordinate.color[c] * found;
        if (uncollided != NULL) uncollided[c] += light->ordinate.color[c] * direct;
    }
}
