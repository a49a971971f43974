/* Sweeps: diamond differences, radiance kept from falling below 0 with every cell's balance. */
#include "base/context.h"
#include "base/float_mode.h"
#include "solve/harmonics.h"
#include "solve/sweep.h"

#include <string.h>

enum { TERMS_MAX = TY_ORDINATE_BANDS_MAX * TY_ORDINATE_BANDS_MAX };

struct ty_sweep {
    ty_context* context;
    int32_t size[3];
    double cell[3];
    const ty_ordinate_set* set;
    int32_t terms;
    const float* extinction;
    const float* inflow; /* radiance of each direction that comes in through the faces; NULL: none */
    float* harmonics;    /* of each direction, `terms` after one another */
    float* faces;        /* radiance below the next cell along z, y and x: a plane, a row, one; of one direction */
};

static size_t face_count(const ty_sweep* sweep) {
    return (size_t)sweep->size[0] * (size_t)sweep->size[1] + (size_t)sweep->size[0];
}

static size_t harmonic_count(const ty_sweep* sweep) {
    return (size_t)sweep->set->count * (size_t)sweep->terms;
}

ty_result ty_sweep_create(ty_context* context, const int32_t size[3], const double cell[3], const ty_ordinate_set* set,
                          int32_t bands, const float* extinction, ty_sweep** out) {
    *out = NULL;
    ty_sweep* sweep = ty_alloc_array(context, 1, sizeof *sweep, true);
    if (sweep == NULL) return TY_ERROR_MEMORY;
    sweep->context = context;
    memcpy(sweep->size, size, sizeof sweep->size);
    memcpy(sweep->cell, cell, sizeof sweep->cell);
    sweep->set = set;
    sweep->terms = bands * bands;
    sweep->extinction = extinction;
    sweep->harmonics = ty_alloc_array(context, harmonic_count(sweep), sizeof(float), false);
    sweep->faces = ty_alloc_array(context, face_count(sweep), sizeof(float), false);
    if (sweep->harmonics == NULL || sweep->faces == NULL) {
        ty_sweep_destroy(sweep);
        return TY_ERROR_MEMORY;
    }
    for (int32_t d = 0; d < set->count; ++d) {
        const double w[3] = {(double)set->direction[0][d], (double)set->direction[1][d], (double)set->direction[2][d]};
        double y[TERMS_MAX];
        ty_harmonics_at(w, bands, y);
        for (int32_t i = 0; i < sweep->terms; ++i) sweep->harmonics[d * sweep->terms + i] = (float)y[i];
    }
    *out = sweep;
    return TY_OK;
}

void ty_sweep_let_in(ty_sweep* sweep, const float* radiance) {
    sweep->inflow = radiance;
}

void ty_sweep_destroy(ty_sweep* sweep) {
    if (sweep == NULL) return;
    if (sweep->harmonics != NULL) ty_free_array(sweep->context, sweep->harmonics, harmonic_count(sweep), sizeof(float));
    if (sweep->faces != NULL) ty_free_array(sweep->context, sweep->faces, face_count(sweep), sizeof(float));
    ty_free_array(sweep->context, sweep, 1, sizeof *sweep);
}

size_t ty_sweep_bytes(const ty_sweep* sweep) {
    return sizeof *sweep + (harmonic_count(sweep) + face_count(sweep)) * sizeof(float);
}

/* Radiance in the middle of a cell, from that of its three faces upwind; those downwind replace them. twice: of each
 * axis, 2 |cosine| / edge. Faces that would fall below 0 are 0, and the cell balances without them. */
static float cross_cell(const float twice[3], float extinction, float source, float* const face[3], bool* fixed) {
    float share[3] = {1, 1, 1}; /* of an outgoing face that the middle decides */
    for (;;) {
        float above = source, below = extinction;
        for (int a = 0; a < 3; ++a) {
            above += 0.5f * (1 + share[a]) * twice[a] * *face[a];
            below += share[a] * twice[a];
        }
        const float middle = below > 0 ? above / below : 0;
        bool again = false;
        for (int a = 0; a < 3; ++a)
            if (share[a] > 0 && 2 * middle < *face[a]) {
                share[a] = 0;
                again = true;
            }
        if (again) {
            *fixed = true;
            continue;
        }
        for (int a = 0; a < 3; ++a) *face[a] = share[a] > 0 ? 2 * middle - *face[a] : 0;
        return middle;
    }
}

typedef struct totals {
    double leaving, fixed;
} totals;

static void sweep_direction(ty_sweep* sweep, int32_t d, const float* emission, float* moments, totals* sums) {
    const int32_t *n = sweep->size, terms = sweep->terms;
    const ty_ordinate_set* set = sweep->set;
    const float* y = sweep->harmonics + d * terms;
    float twice[3];
    double through[3]; /* W per radiance that leaves a face */
    bool back[3];
    for (int a = 0; a < 3; ++a) {
        const double cosine = (double)set->direction[a][d];
        back[a] = cosine < 0;
        twice[a] = (float)(2 * (back[a] ? -cosine : cosine) / sweep->cell[a]);
        through[a] = (double)set->weight[d] * 0.5 * (double)twice[a] * sweep->cell[0] * sweep->cell[1] * sweep->cell[2];
    }
    float *plane = sweep->faces, *row = plane + (size_t)n[0] * (size_t)n[1];
    const float inflow = sweep->inflow != NULL ? sweep->inflow[d] : 0;
    for (int32_t i = 0; i < n[0] * n[1]; ++i) plane[i] = inflow;
    for (int32_t k = 0; k < n[2]; ++k) {
        for (int32_t i = 0; i < n[0]; ++i) row[i] = inflow;
        for (int32_t j = 0; j < n[1]; ++j) {
            float along = inflow;
            for (int32_t i = 0; i < n[0]; ++i) {
                const int32_t x = back[0] ? n[0] - 1 - i : i, at_y = back[1] ? n[1] - 1 - j : j;
                const ptrdiff_t at = ((ptrdiff_t)(back[2] ? n[2] - 1 - k : k) * n[1] + at_y) * n[0] + x;
                float source = 0;
                for (int32_t t = 0; t < terms; ++t) source += emission[at * terms + t] * y[t];
                float* const face[3] = {&along, &row[x], &plane[at_y * n[0] + x]};
                bool fixed = false;
                const float middle = set->weight[d] * cross_cell(twice, sweep->extinction[at], source, face, &fixed);
                for (int32_t t = 0; t < terms; ++t) moments[at * terms + t] += middle * y[t];
                sums->fixed += fixed;
            }
            sums->leaving += through[0] * (double)along;
        }
        for (int32_t i = 0; i < n[0]; ++i) sums->leaving += through[1] * (double)row[i];
    }
    for (int32_t i = 0; i < n[0] * n[1]; ++i) sums->leaving += through[2] * (double)plane[i];
}

ty_result ty_sweep_run(ty_sweep* sweep, const float* emission, float* moments, double* leaving, double* fixed) {
    const unsigned state = ty_flush_denormals();
    const size_t cells = (size_t)sweep->size[0] * (size_t)sweep->size[1] * (size_t)sweep->size[2];
    memset(moments, 0, sizeof(float) * cells * (size_t)sweep->terms);
    totals sums = {0};
    for (int32_t d = 0; d < sweep->set->count; ++d) sweep_direction(sweep, d, emission, moments, &sums);
    if (leaving != NULL) *leaving = sums.leaving;
    if (fixed != NULL) *fixed = sums.fixed;
    ty_restore_denormals(state);
    return TY_OK;
}
