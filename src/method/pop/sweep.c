/* Split mode: transmittances along an ordinate's columns, and what is seen of the light. */
#include "method/pop/slab.h"

#include "base/float_mode.h"

typedef struct sweep {
    const ty_pop_grid_kernels* kernels;
    ty_pop_light* light;
    ty_pop_columns columns;
    ty_pop_slab slab;
    ty_pop_transmittance through;
    ty_pop_look look;
    float means[3][3][TY_POP_BLOCK]; /* where lobes are not kept */
} sweep;

/* Where slab k's means go. */
static void place_means(sweep* s, int32_t k) {
    const ty_pop_frame* frame = &s->light->frame;
    const size_t cells = ty_pop_cells(frame), slice = cells / (size_t)frame->size[2];
    for (size_t p = 0; p < (size_t)s->light->planes; ++p)
        for (size_t order = 0; order < 3; ++order) {
            float* mean = s->means[p][order];
            if (s->light->lobes != NULL)
                mean = s->light->lobes + (3 * p + order) * cells + slice * (size_t)k + (size_t)s->columns.first;
            s->through.mean[p][order] = mean;
            s->look.mean[p][order] = mean;
        }
}

/* What the slab turns aside of the light. */
static void add_turned(sweep* s) {
    ty_pop_light* light = s->light;
    for (int32_t c = 0; c < 3; ++c) {
        const int32_t p = light->planes == 3 ? c : 0;
        light->turned[c] += (double)(s->kernels->turned(&s->slab, p, s->through.mean[p][1]) * light->ordinate.color[c]);
    }
}

static void begin(const ty_grid_medium* medium, const float eye[3], ty_pop_light* light, sweep* s) {
    s->kernels = TY_BEST_KERNELS(ty_pop_grid_kernels);
    s->light = light;
    ty_pop_slab_setup(s->kernels, medium, &s->columns, &s->slab);
    ty_pop_look_setup(medium, eye, light, &s->look);
}

static void sweep_columns(sweep* s) {
    ty_pop_transmittance_begin(s->kernels, 3, &s->slab, &s->through);
    for (int32_t k = 0; k < s->light->frame.size[2]; ++k) {
        ty_pop_slab_enter(s->kernels, k, &s->slab);
        s->kernels->light(&s->slab);
        place_means(s, k);
        s->kernels->pass(&s->slab, &s->through);
        s->kernels->look(&s->slab, &s->look);
        s->kernels->scatter(&s->slab, &s->look);
        ty_pop_write_seen(s->light, &s->slab, &s->look, k);
        add_turned(s);
    }
}

void ty_pop_sweep(const ty_scene* scene, const ty_grid_medium* medium, const float eye[3], ty_pop_light* light) {
    sweep s;
    const unsigned state = ty_flush_denormals();
    light->mode = TY_POP_MODE_SPLIT;
    light->planes = medium->planes;
    light->bands = 0;
    memset(light->turned, 0, sizeof light->turned);
    begin(medium, eye, light, &s);
    for (int32_t first = 0; first < light->frame.size[0] * light->frame.size[1]; first += s.columns.count) {
        ty_pop_columns_begin(scene, medium, light, first, &s.columns);
        sweep_columns(&s);
    }
    ty_pop_fill_ring(light);
    ty_restore_denormals(state);
}
