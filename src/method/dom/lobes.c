/* Lights' lobes meet the moments of ordinates.
 *
 * Towards the eye, light that has scattered is the sum of ordinates' moments, l < L, and of lights' lobes, whose
 * moments from L on go on as light that never moves sideways would. In truth some does, and where the two meet, at l =
 * L, what is missing is a step that the eye sees as a ripple: L = 4, 6, 8 are too dark and too bright by turns. So the
 * lobes' moments from L on are scaled to what ordinates have at L - 1, cell by cell. */
#include "base/context.h"
#include "method/dom/view.h"
#include "solve/angular/harmonics.h"

#include <math.h>

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* What a lobe's moment falls off by from L to L + 1, at least; and the scale, at most. */
static const double least_cosine = 0.05, most_scale = 2;

typedef struct mend_job {
    const ty_dom* light;
    const double* eye;
    float* const* seen;
} mend_job;

/* One light's lobe in a cell. */
typedef struct lobe {
    double way[3]; /* that its light goes */
    double kept;   /* R - U */
    double cosine; /* b */
} lobe;

static double channel_factor(const ty_dom* light, const ty_light_field* field, int32_t channel) {
    if (field->planes == 3) return 1;
    if (!light->shared) return (double)field->color[channel];
    return (double)(field->color[0] + field->color[1] + field->color[2]) /
           (double)(light->color[0] + light->color[1] + light->color[2]);
}

static void find_way(const ty_dom* light, const ty_single_light* single, const int32_t cell[3], double way[3]) {
    const double toward[3] = {(double)single->toward.x, (double)single->toward.y, (double)single->toward.z};
    for (int a = 0; a < 3; ++a) way[a] = toward[a];
    if (single->kind == TY_SINGLE_BEAM) return;
    ty_dom_way(light, cell, toward, way);
    for (int a = 0; a < 3; ++a) way[a] = -way[a];
}

/* The lobes of a cell that are more than nothing. */
static int32_t find_lobes(const ty_dom* light, const int32_t cell[3], size_t at, int32_t channel,
                          lobe lobes[TY_DOM_OWN_MAX]) {
    int32_t count = 0;
    for (int32_t i = 0; i < light->light_count; ++i) {
        const ty_single_light* single = &light->lights[i];
        if (single->lobes == 0) continue;
        ty_light_field* const* fields = light->coarse[i];
        const int32_t plane = fields[0]->planes == 3 ? channel : 0;
        const float r = fields[TY_SINGLE_KEPT]->fluence[plane][at], u = fields[TY_SINGLE_STRAIGHT]->fluence[plane][at];
        if (!(r > u)) continue;
        lobe* out = &lobes[count++];
        find_way(light, single, cell, out->way);
        out->kept = channel_factor(light, fields[0], channel) * (double)(r - u);
        out->cosine = (double)ty_forward_cosine(u, r, fields[TY_SINGLE_BENT]->fluence[plane][at]);
    }
    return count;
}

/* The scale at which the lobes' moment L - 1, all of them together, is that of ordinates: nearest in the least squares.
 */
static double find_scale(const ty_dom* light, size_t at, int32_t channel, const lobe* lobes, int32_t count) {
    const int32_t first = (light->bands - 1) * (light->bands - 1), terms = light->bands * light->bands;
    double has[TERMS_MAX], expected[TERMS_MAX], y[TERMS_MAX], product = 0, square = 0;
    for (int32_t t = first; t < terms; ++t) {
        has[t] = (double)ty_dom_plane(light, light->moments[channel], t)[at];
        expected[t] = 0;
    }
    for (int32_t i = 0; i < count; ++i) {
        ty_harmonics_at(lobes[i].way, light->bands, y);
        for (int32_t t = first; t < terms; ++t) {
            has[t] += lobes[i].kept * y[t];
            expected[t] += lobes[i].kept / fmax(lobes[i].cosine, least_cosine) * y[t];
        }
    }
    for (int32_t t = first; t < terms; ++t) {
        product += has[t] * expected[t];
        square += expected[t] * expected[t];
    }
    return square > 0 ? fmin(most_scale, fmax(0, product / square)) : 1;
}

static void mend_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const mend_job* job = user;
    const ty_dom* light = job->light;
    const int32_t* size = light->box.size;
    for (int32_t i = 0; i < size[0]; ++i) {
        const int32_t cell[3] = {i, (int32_t)(row % size[1]), (int32_t)(row / size[1])};
        const size_t at = (size_t)row * (size_t)size[0] + (size_t)i;
        double way[3];
        ty_dom_way(light, cell, job->eye, way);
        for (int32_t c = 0; c < ty_dom_channels(light); ++c) {
            lobe lobes[TY_DOM_OWN_MAX];
            const int32_t count = find_lobes(light, cell, at, c, lobes);
            if (count == 0) continue;
            const double scale = find_scale(light, at, c, lobes, count);
            const float g = light->g[light->planes == 3 ? c : 0][at];
            for (int32_t n = 0; n < count; ++n) {
                const double* from = lobes[n].way;
                const double mu = from[0] * way[0] + from[1] * way[1] + from[2] * way[2];
                float below;
                const float tail = ty_forward_tail((float)lobes[n].cosine, (float)mu, g, light->bands, &below);
                job->seen[c][at] += (float)((scale - 1) * lobes[n].kept) * TY_INV_4PI * tail;
            }
        }
    }
}

void ty_dom_mend_lobes(const ty_dom* light, const double eye[3], float* const seen[3]) {
    mend_job job = {light, eye, seen};
    ty_parallel_for(light->context, (int64_t)light->box.size[1] * light->box.size[2], mend_row, &job);
}
