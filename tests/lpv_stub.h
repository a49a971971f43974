/* Stand-ins for lattice.c's functions. */
#ifndef TY_TESTS_LPV_STUB_H
#define TY_TESTS_LPV_STUB_H

#include "base/context.h"
#include "method/lpv/lattice.h"

ty_result ty_lattice_create(ty_context* context, const ty_grid_box* box, int32_t bands, ty_lattice** out) {
    ty_lattice* l = ty_alloc_array(context, 1, sizeof *l, true);
    l->context = context;
    l->box = *box;
    l->cell = (float)((box->upper[0] - box->lower[0]) / box->size[0]);
    l->cells = (size_t)box->size[0] * (size_t)box->size[1] * (size_t)box->size[2];
    l->bands = bands;
    l->terms = bands * bands;
    for (int c = 0; c < 3; ++c) {
        l->albedo[c] = ty_alloc_array(context, l->cells, 4, true);
        for (int t = 0; t < l->terms; ++t) l->flow[c][t] = ty_alloc_array(context, l->cells, 4, true);
    }
    for (int k = 0; k < 26; ++k) {
        l->open[k] = ty_alloc_array(context, l->cells, 1, true);
        memset(l->open[k], 255, l->cells);
    }
    *out = l;
    return TY_OK;
}

void ty_lattice_destroy(ty_lattice* l) {
    if (l == NULL) return;
    for (int c = 0; c < 3; ++c) {
        ty_free_array(l->context, l->albedo[c], l->cells, 4);
        for (int t = 0; t < l->terms; ++t) ty_free_array(l->context, l->flow[c][t], l->cells, 4);
    }
    for (int k = 0; k < 26; ++k) ty_free_array(l->context, l->open[k], l->cells, 1);
    ty_grid_medium_destroy(l->medium);
    ty_free_array(l->context, l, 1, sizeof *l);
}

void ty_lpv_transfer_make(int32_t bands, bool keeps_momentum, ty_lpv_transfer* out) {
    (void)keeps_momentum;
    *out = (ty_lpv_transfer){.bands = bands, .terms = bands * bands};
    int k = 0;
    double sum = 0;
    for (int i = 0; i < 27; ++i) {
        const int e[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        if (!(e[2] > 0 || (e[2] == 0 && (e[1] > 0 || (e[1] == 0 && e[0] > 0))))) continue;
        for (int a = 0; a < 3; ++a) {
            out->step[k][a] = e[a];
            out->step[k + 13][a] = -e[a];
        }
        ++k;
    }
    for (k = 0; k < 26; ++k) {
        const int32_t* e = out->step[k];
        const ty_vec w = ty_normalize(ty_vec_make((float)e[0], (float)e[1], (float)e[2]));
        const float omega = 4 * TY_PI / 26;
        ty_sh_at(w, bands, out->shape[k]);
        for (int t = 0; t < 9; ++t) out->shape[k][t] *= sqrtf(omega);
        sum += (double)(out->shape[k][0] * out->shape[k][0]);
    }
    for (k = 0; k < 26; ++k)
        for (int t = 0; t < 9; ++t) out->shape[k][t] /= (float)sqrt(sum);
}

#endif
