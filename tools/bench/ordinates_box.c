/* Test problems of the discrete ordinates solver. */
#include "bench/ordinates_box.h"

#include <math.h>
#include <stdlib.h>

const char* const ordinates_box_names[ORDINATES_BOX_KINDS] = {"even", "cloud"};

/* Coefficients at a point, for an optical thickness of 1. */
typedef struct coefficients {
    double extinction, scattering, source;
} coefficients;

static coefficients uniform_at(void) {
    return (coefficients){1, 1, 1};
}

static coefficients cloud_at(const double at[3]) {
    static const double radius = 0.35, diameter = 0.7;
    const double x = at[0] - 0.5, y = at[1] - 0.5, z = at[2] - 0.5, r = sqrt(x * x + y * y + z * z);
    const double lumps = sin(23 * at[0]) * sin(19 * at[1] + 1) * sin(21 * at[2] + 2);
    if (r > radius + 0.05 * lumps) return (coefficients){0, 0, 0};
    const double extinction = (1 + 0.8 * lumps) / diameter;
    return (coefficients){extinction, 0.999 * extinction, fmax(0, 1 + lumps - 2 * r)};
}

static void fill(ordinates_box* box, ordinates_box_kind kind, int32_t edge, double thickness) {
    size_t i = 0;
    for (int32_t z = 0; z < edge; ++z)
        for (int32_t y = 0; y < edge; ++y)
            for (int32_t x = 0; x < edge; ++x, ++i) {
                const double at[3] = {(x + 0.5) / edge, (y + 0.5) / edge, (z + 0.5) / edge};
                const coefficients here = kind == ORDINATES_BOX_EVEN ? uniform_at() : cloud_at(at);
                box->extinction[i] = (float)(thickness * here.extinction);
                box->scattering[i] = (float)(thickness * here.scattering);
                box->source[i] = (float)here.source;
            }
}

ty_result ordinates_box_open(ty_context* context, ordinates_box_kind kind, int32_t edge, int32_t directions,
                             double thickness, ordinates_box* out) {
    *out = (ordinates_box){.def = ty_default_ordinates_def(), .cells = (size_t)edge * (size_t)edge * (size_t)edge};
    float** const planes[] = {&out->extinction, &out->scattering, &out->g, &out->source, &out->fluence};
    bool allocated = true;
    for (size_t i = 0; i < sizeof planes / sizeof *planes; ++i) {
        *planes[i] = calloc(out->cells, sizeof(float));
        allocated = allocated && *planes[i] != NULL;
    }
    ty_result result = allocated ? ty_angular_quadrature_create(context, directions, &out->set, NULL) : TY_ERROR_MEMORY;
    if (result != TY_OK) {
        ordinates_box_close(out);
        return result;
    }
    fill(out, kind, edge, thickness);
    for (int a = 0; a < 3; ++a) {
        out->def.size[a] = edge;
        out->def.cell[a] = 1.0 / edge;
    }
    out->sources[0] = out->source;
    out->def.set = &out->set;
    out->def.bands = out->def.output_order = 1;
    out->def.extinction = out->extinction;
    out->def.scattering = out->scattering;
    out->def.g = out->g;
    out->def.source = out->sources;
    out->def.source_terms = 1;
    return TY_OK;
}

void ordinates_box_close(ordinates_box* box) {
    free(box->extinction);
    free(box->scattering);
    free(box->g);
    free(box->source);
    free(box->fluence);
}

ty_result ordinates_box_solve(ty_context* context, ordinates_box* box, double* history, int32_t history_capacity,
                              ty_ordinates_stats* stats) {
    float* const moments[1] = {box->fluence};
    return ty_ordinates_solve(context, &box->def, moments, history, history_capacity, stats);
}
