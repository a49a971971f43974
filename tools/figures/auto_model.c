/* The model that method auto chooses by: fitted to the stored measurements of the matrix, and tried on scenes that were
 * left out of the fit. */
#include "figures/auto_model.h"
#include "figures/regression.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char* const auto_methods[AUTO_METHODS] = {"path", "dom", "fld", "cda", "pop", "lpv"};

/* Of the squares of coefficients. */
static const double ridge = 1;

/* ---- terms of each quantity ---- */

#define UP REGRESSION_INCREASING
#define DOWN REGRESSION_DECREASING
#define ANY REGRESSION_ANY

/* Signs that physics knows: errors of methods grow with the part of the light that scattered several times, with
 * forward scattering, and with thick cells; times with the numbers of interactions and of lights. */
static const regression_sign path_signs[TY_FITS][TY_TERMS] = {
    [TY_FIT_ERROR] = {[TY_TERM_NOISE] = UP, [TY_TERM_FORWARD] = UP, [TY_TERM_PLACED_LIGHT] = UP},
    [TY_FIT_VIEW] =
        {[TY_TERM_VERTICES] = UP, [TY_TERM_HETEROGENEOUS] = UP, [TY_TERM_SURFACES] = UP, [TY_TERM_ENVIRONMENT] = ANY},
    [TY_FIT_SURFACE] = {[TY_TERM_SURFACE_VERTICES] = UP, [TY_TERM_HETEROGENEOUS] = UP, [TY_TERM_ENVIRONMENT] = ANY},
};
static const regression_sign method_signs[TY_FITS][TY_TERMS] = {
    [TY_FIT_ERROR] = {[TY_TERM_MULTIPLE] = UP,
                      [TY_TERM_FORWARD] = UP,
                      [TY_TERM_CELL] = UP,
                      [TY_TERM_PLACED_LIGHT] = UP,
                      [TY_TERM_NOISE] = UP,
                      [TY_TERM_ENCLOSED] = ANY,
                      [TY_TERM_ENVIRONMENT] = DOWN,
                      [TY_TERM_TRIAL] = UP,
                      [TY_TERM_TRIAL_NOISE] = DOWN},
    [TY_FIT_FINE] = {[TY_TERM_SURFACES] = UP, [TY_TERM_NOISE] = UP},
    [TY_FIT_UNTRIED] = {[TY_TERM_MULTIPLE] = UP,
                        [TY_TERM_FORWARD] = UP,
                        [TY_TERM_CELL] = UP,
                        [TY_TERM_PLACED_LIGHT] = UP,
                        [TY_TERM_NOISE] = UP,
                        [TY_TERM_ENCLOSED] = ANY,
                        [TY_TERM_ENVIRONMENT] = DOWN},
    [TY_FIT_SOLVE] = {[TY_TERM_VOXELS] = UP,
                      [TY_TERM_LIGHTS] = UP,
                      [TY_TERM_ENVIRONMENT] = ANY,
                      [TY_TERM_SURFACES] = ANY,
                      [TY_TERM_ENCLOSED] = ANY,
                      [TY_TERM_HETEROGENEOUS] = ANY,
                      [TY_TERM_FORWARD] = ANY,
                      [TY_TERM_SPAN] = ANY},
    [TY_FIT_VIEW] = {[TY_TERM_LIGHTS] = UP,
                     [TY_TERM_ENVIRONMENT] = ANY,
                     [TY_TERM_SURFACES] = ANY,
                     [TY_TERM_HETEROGENEOUS] = UP,
                     [TY_TERM_CELL] = ANY},
};

/* ---- fitting ---- */

static void fit_one(const auto_row* rows, int32_t count, int32_t left_out, int32_t method, ty_fit which,
                    const regression_sign* signs, double out[TY_TERMS]) {
    double *terms = calloc((size_t)count * TY_TERMS, sizeof *terms), *values = calloc((size_t)count, sizeof *values),
           *weights = calloc((size_t)count, sizeof *weights);
    for (int32_t i = 0; terms != NULL && values != NULL && weights != NULL && i < count; ++i) {
        const auto_measured* measured = &rows[i].methods[method];
        const double quantities[TY_FITS] = {measured->error,   measured->solve, measured->view,
                                            measured->surface, measured->fine,  measured->error};
        memcpy(terms + (size_t)i * TY_TERMS, rows[i].terms[method], sizeof rows[i].terms[method]);
        weights[i] = i != left_out && quantities[which] > 0 ? 1 : 0;
        values[i] = weights[i] > 0 ? log(quantities[which]) : 0;
    }
    if (terms != NULL && values != NULL && weights != NULL)
        regression_fit(terms, values, weights, count, TY_TERMS, signs, ridge, out);
    free(terms);
    free(values);
    free(weights);
}

void auto_model_fit(const auto_row* rows, int32_t count, int32_t left_out, ty_method_model out[AUTO_METHODS]) {
    for (int32_t m = 0; m < AUTO_METHODS; ++m) {
        out[m] = (ty_method_model){.name = auto_methods[m]};
        for (int f = 0; f < TY_FITS; ++f) {
            const bool surfaces = f == TY_FIT_SURFACE;
            if (surfaces || (m == 0 && (f == TY_FIT_SOLVE || f == TY_FIT_FINE || f == TY_FIT_UNTRIED))) continue;
            fit_one(rows, count, left_out, m, f, m == 0 ? path_signs[f] : method_signs[f], out[m].terms[f]);
        }
    }
    /* Paths of surfaces are alike in all methods that trace them: those of the first that does stand for all. */
    double surfaces[TY_TERMS];
    fit_one(rows, count, left_out, AUTO_SURFACES, TY_FIT_SURFACE, path_signs[TY_FIT_SURFACE], surfaces);
    for (int32_t m = 1; m < AUTO_METHODS; ++m) memcpy(out[m].terms[TY_FIT_SURFACE], surfaces, sizeof surfaces);
}

/* ---- judging ---- */

ty_expectation auto_measured_at(const auto_row* row, int32_t method, const ty_picture_size* size) {
    const auto_measured* of = &row->methods[method];
    const double root = 4 * sqrt(size->samples), paths = size->pixels * size->samples;
    const bool large = size->pixels == AUTO_LARGE_PIXELS && size->samples == MATRIX_SAMPLES;
    if (large && of->large.seconds > 0) return of->large;
    if (method == 0) return (ty_expectation){of->error / root, paths * of->view};
    return (ty_expectation){hypot(hypot(of->error, of->fine_fitted), of->noise / root),
                            of->solve + size->pixels * of->view + paths * of->surface};
}

auto_judged auto_model_judge(const auto_row* row, const ty_scene_features* features, const ty_choice_model* model,
                             const ty_picture_size* size) {
    auto_judged out = {.best = -1, .chosen = -1};
    for (int32_t m = 0; m < AUTO_METHODS; ++m) {
        if (!row->methods[m].rendered) continue;
        const ty_expectation expected =
            m < model->count ? ty_expect(model, m, features, size) : (ty_expectation){INFINITY, INFINITY};
        const ty_expectation measured = auto_measured_at(row, m, size);
        if (m < model->count && (out.chosen < 0 || ty_cost_of(&expected) < ty_cost_of(&out.expected))) {
            out.chosen = m;
            out.expected = expected;
            out.measured = measured;
        }
        if (out.best < 0 || ty_cost_of(&measured) < ty_cost_of(&out.best_measured)) {
            out.best = m;
            out.best_measured = measured;
        }
    }
    out.loss = ty_cost_of(&out.measured) / ty_cost_of(&out.best_measured);
    return out;
}
