#include "choose/predict.h"

#include "method/method.h"

#include <math.h>

const double ty_error_unseen = 0.02, ty_seconds_unfelt = 1;

/* Pixels along the sides of the blocks whose means are compared. */
static const double block = 4;

/* Features are cut to where the logarithms of the regression are of use. */
static double log_above(double bound, double value) {
    return log(fmax(bound, value));
}

/* Estimated number of scatterings before absorption or escape. */
static double scatterings(const ty_scene_features* features) {
    return 1 / (1 / (1 + features->thickness) + 1 - fmin(features->albedo, 1));
}

void ty_terms_of(const ty_scene_features* features, int32_t method, double out[TY_TERMS]) {
    const uint32_t placed = 1u << TY_LIGHT_POINT | 1u << TY_LIGHT_SPOT | 1u << TY_LIGHT_AREA;
    out[TY_TERM_ONE] = 1;
    out[TY_TERM_NOISE] = log_above(1e-3, features->noise);
    out[TY_TERM_VERTICES] = log(1 + features->vertices);
    out[TY_TERM_SURFACE_NOISE] = log_above(1e-3, features->surface_noise);
    out[TY_TERM_SURFACE_VERTICES] = log(1 + features->surface_vertices);
    out[TY_TERM_MULTIPLE] = log(0.02 + features->multiple);
    out[TY_TERM_FORWARD] = -log_above(0.01, 1 - features->g);
    out[TY_TERM_CELL] = log(1 + features->cell);
    out[TY_TERM_SCATTERINGS] = log(scatterings(features));
    out[TY_TERM_ENCLOSED] = features->enclosed;
    out[TY_TERM_SURFACES] = features->surfaces > 0 ? 1 : 0;
    out[TY_TERM_PLACED_LIGHT] = (features->lights & placed) != 0 ? 1 : 0;
    out[TY_TERM_ENVIRONMENT] = (features->lights & 1u << TY_LIGHT_ENVIRONMENT) != 0 ? 1 : 0;
    out[TY_TERM_HETEROGENEOUS] = features->heterogeneous ? 1 : 0;
    out[TY_TERM_SPAN] = log(1 + features->span);
    out[TY_TERM_LIGHTS] = log(1.0 + features->light_count);
    out[TY_TERM_VOXELS] = log_above(1e-3, features->voxels / (64.0 * 64 * 64));
    out[TY_TERM_TRIAL] = log_above(4e-3, features->trials[method]);
    out[TY_TERM_TRIAL_NOISE] = log_above(4e-3, features->trial_noise);
}

static double fitted(const ty_method_model* method, ty_fit fit, const double terms[TY_TERMS]) {
    double sum = 0;
    for (int t = 0; t < TY_TERMS; ++t) sum += method->terms[fit][t] * terms[t];
    return exp(sum);
}

ty_expectation ty_expect(const ty_choice_model* model, int32_t method, const ty_scene_features* features,
                         const ty_picture_size* size) {
    const ty_method_model* of = &model->methods[method];
    const double paths = size->pixels * size->samples, root = block * sqrt(size->samples);
    double terms[TY_TERMS];
    ty_terms_of(features, method, terms);
    if (method == 0)
        return (ty_expectation){fitted(of, TY_FIT_ERROR, terms) / root, paths * fitted(of, TY_FIT_VIEW, terms)};
    const bool tried = features->trials[method] > 0;
    const double error = fitted(of, tried ? TY_FIT_ERROR : TY_FIT_UNTRIED, terms);
    const double fine = fitted(of, TY_FIT_FINE, terms);
    const bool takes_surfaces = ty_method_find(of->name)->takes_surfaces;
    const bool traces = features->surface_vertices > 0 && takes_surfaces;
    const double noise = traces ? features->surface_noise / root : 0;
    return (ty_expectation){hypot(hypot(error, fine), noise),
                            fitted(of, TY_FIT_SOLVE, terms) + size->pixels * fitted(of, TY_FIT_VIEW, terms) +
                                (traces ? paths * fitted(of, TY_FIT_SURFACE, terms) : 0)};
}

double ty_expect_fine(const ty_choice_model* model, int32_t method, const ty_scene_features* features) {
    double terms[TY_TERMS];
    ty_terms_of(features, method, terms);
    return fitted(&model->methods[method], TY_FIT_FINE, terms);
}

double ty_cost_of(const ty_expectation* of) {
    return hypot(of->error, ty_error_unseen) * sqrt(of->seconds + ty_seconds_unfelt);
}
