/* Split mode: transmittances along an ordinate's columns, and the light's radiance towards the eye. */
#include "method/pop/grid/slab.h"

#include "base/float_mode.h"

typedef struct sweep {
    const ty_pop_grid_kernels* kernels;
    ty_pop_light* light;
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_transmittance through;
    ty_pop_eye_view view;
    float means[3][3][TY_POP_BLOCK]; /* storage if lobes are not stored */
} sweep;

/* Output arrays of slab k's means. */
static void set_means(sweep* s, int32_t k) {
    const ty_pop_grid* grid = &s->light->grid;
    const size_t cells = ty_pop_cells(grid), slice = cells / (size_t)grid->size[2];
    for (size_t p = 0; p < (size_t)s->light->planes; ++p)
        for (size_t order = 0; order < 3; ++order) {
            float* mean = s->means[p][order];
            if (s->light->lobes != NULL)
                mean = s->light->lobes + (3 * p + order) * cells + slice * (size_t)k + (size_t)s->columns.first;
            s->through.mean[p][order] = mean;
            s->view.mean[p][order] = mean;
        }
}

/* Adds the slab's power scattered out of the forward lobe. */
static void add_diffuse_power(sweep* s) {
    ty_pop_light* light = s->light;
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = light->planes == 3 ? c : 0;
        light->diffuse_power[c] +=
            (double)(s->kernels->diffuse_power(&s->slab, p, s->through.mean[p][1]) * light->ordinate.color[c]);
    }
}

static void begin(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light, sweep* s) {
    s->kernels = TY_BEST_KERNELS(ty_pop_grid_kernels);
    s->light = light;
    ty_pop_slab_setup(s->kernels, medium, &s->columns, &s->slab);
    ty_pop_eye_view_setup(medium, eye, light, &s->view);
}

static void sweep_columns(sweep* s) {
    ty_pop_transmittance_begin(s->kernels, 3, &s->slab, &s->through);
    for (int32_t k = 0; k < s->light->grid.size[2]; ++k) {
        ty_pop_slab_enter(s->kernels, k, &s->slab);
        s->kernels->incident_light(&s->slab);
        set_means(s, k);
        s->kernels->attenuate(&s->slab, &s->through);
        s->kernels->eye_cosines(&s->slab, &s->view);
        s->kernels->scatter(&s->slab, &s->view);
        ty_pop_write_accumulated(s->light, &s->slab, &s->view, k);
        add_diffuse_power(s);
    }
}

void ty_pop_sweep(const ty_scene* scene, const ty_grid_medium* medium, const float eye[3], ty_pop_light* light) {
    sweep s;
    const unsigned state = ty_flush_denormals();
    light->mode = TY_POP_MODE_SPLIT;
    light->planes = medium->planes;
    light->bands = 0;
    memset(light->diffuse_power, 0, sizeof light->diffuse_power);
    begin(medium, eye, light, &s);
    for (int32_t first = 0; first < light->grid.size[0] * light->grid.size[1]; first += s.columns.count) {
        ty_pop_columns_begin(scene, medium, light, first, &s.columns);
        sweep_columns(&s);
    }
    ty_pop_fill_ghost_cells(light);
    ty_restore_denormals(state);
}
