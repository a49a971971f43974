/* Continuity between the lights' lobes and the moments of ordinates.
 *
 * The collided radiance towards the eye is the sum of the ordinates' moments l < L and of the lights' lobes, whose
 * moments from L on neglect lateral spread. The step between both at l = L shows as ripples: L = 4, 6, 8 are too dark
 * and too bright by turns. So the lobes' moments from L on are scaled, cell by cell, by the ratio of both at L - 1. */
#include "base/context.h"
#include "method/dom/view/view.h"
#include "solve/angular/harmonics.h"

#include <math.h>

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* Minimum ratio of a lobe's moments L + 1 and L, and maximum scale. */
static const double min_cosine = 0.05, max_scale = 2;

typedef struct correct_job {
    const ty_dom* light;
    const double* eye;
    float* const* radiance;
} correct_job;

/* The forward lobe of one light in a cell. */
typedef struct lobe {
    double omega[3]; /* direction of travel */
    double order_l;  /* R - U */
    double cosine;   /* b */
} lobe;

static double channel_factor(const ty_dom* light, const ty_light_field* field, int32_t channel) {
    if (field->planes == 3) return 1;
    if (!light->shared) return (double)field->color[channel];
    return (double)(field->color[0] + field->color[1] + field->color[2]) /
           (double)(light->color[0] + light->color[1] + light->color[2]);
}

static void find_direction(const ty_dom* light, const ty_light_fluence* uncollided, const int32_t cell[3],
                           double omega[3]) {
    const ty_vec anchor = uncollided->anchor;
    const double position[3] = {(double)anchor.x, (double)anchor.y, (double)anchor.z};
    for (int a = 0; a < 3; ++a) omega[a] = position[a];
    if (uncollided->kind == TY_FLUENCE_DIRECTIONAL) return;
    ty_dom_direction_to_eye(light, cell, position, omega);
    for (int a = 0; a < 3; ++a) omega[a] = -omega[a];
}

/* The nonzero lobes of a cell. */
static int32_t find_lobes(const ty_dom* light, const int32_t cell[3], size_t at, int32_t channel,
                          lobe lobes[TY_DOM_DEDICATED_MAX]) {
    int32_t count = 0;
    for (int32_t i = 0; i < light->fluence_count; ++i) {
        const ty_light_fluence* uncollided = &light->fluences[i];
        if (uncollided->lobe_order == 0) continue;
        ty_light_field* const* fields = light->coarse_fields[i];
        const int32_t plane = fields[0]->planes == 3 ? channel : 0;
        const float r = fields[TY_FLUENCE_ORDER_L]->fluence[plane][at],
                    u = fields[TY_FLUENCE_UNSCATTERED]->fluence[plane][at];
        if (!(r > u)) continue;
        lobe* out = &lobes[count++];
        find_direction(light, uncollided, cell, out->omega);
        out->order_l = channel_factor(light, fields[0], channel) * (double)(r - u);
        out->cosine = (double)ty_forward_lobe_cosine(u, r, fields[TY_FLUENCE_NEXT_ORDER]->fluence[plane][at]);
    }
    return count;
}

/* The least-squares scale from the lobes' moments of order L - 1 to those of ordinates. */
static double find_scale(const ty_dom* light, size_t at, int32_t channel, const lobe* lobes, int32_t count) {
    const int32_t first = (light->bands - 1) * (light->bands - 1), terms = light->bands * light->bands;
    double moments[TERMS_MAX], expected[TERMS_MAX], y[TERMS_MAX], product = 0, square = 0;
    for (int32_t t = first; t < terms; ++t) {
        moments[t] = (double)ty_dom_plane(light, light->moments[channel], t)[at];
        expected[t] = 0;
    }
    for (int32_t i = 0; i < count; ++i) {
        ty_harmonics_at(lobes[i].omega, light->bands, y);
        for (int32_t t = first; t < terms; ++t) {
            moments[t] += lobes[i].order_l * y[t];
            expected[t] += lobes[i].order_l / fmax(lobes[i].cosine, min_cosine) * y[t];
        }
    }
    for (int32_t t = first; t < terms; ++t) {
        product += moments[t] * expected[t];
        square += expected[t] * expected[t];
    }
    return square > 0 ? fmin(max_scale, fmax(0, product / square)) : 1;
}

static void correct_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const correct_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double omega[3];
        ty_dom_direction_to_eye(light, cell, job->eye, omega);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
            lobe lobes[TY_DOM_DEDICATED_MAX];
            const int32_t count = find_lobes(light, cell, at, c, lobes);
            if (count == 0) continue;
            const double scale = find_scale(light, at, c, lobes, count);
            const float *legendre = ty_dom_legendre(light), g = light->g[light->planes == 3 ? c : 0][at];
            for (int32_t n = 0; n < count; ++n) {
                const double* from = lobes[n].omega;
                const double mu = from[0] * omega[0] + from[1] * omega[1] + from[2] * omega[2];
                const float b = (float)lobes[n].cosine;
                float below;
                const float tail = legendre != NULL ? ty_forward_tail_of(b, (float)mu, legendre, light->bands, &below)
                                                    : ty_forward_tail(b, (float)mu, g, light->bands, &below);
                job->radiance[c][at] += (float)((scale - 1) * lobes[n].order_l) * TY_INV_4PI * tail;
            }
        }
    }
}

void ty_dom_correct_lobes(const ty_dom* light, const double eye[3], float* const radiance[3]) {
    correct_job job = {light, eye, radiance};
    ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], correct_row, &job);
}
