/* Importance from the camera: a column of cells along a ray of it, and what light that comes along some direction adds
 * to what the camera sees there. */
#ifndef TY_METHOD_POP_IMPORTANCE_K_H
#define TY_METHOD_POP_IMPORTANCE_K_H

#include "direct/media/attenuation.k.h"
#include "direct/single/single.k.h"
#include "scene/phase.k.h"

/* The medium where importance goes, means of the channels. */
typedef struct ty_pop_murk {
    float extinction, scattering; /* 1/m */
    float g;
} ty_pop_murk;

typedef struct ty_pop_murk_view {
    TY_GLOBAL const float* extinction[3];
    TY_GLOBAL const float* scattering[3];
    TY_GLOBAL const float* g[3];
    int32_t planes, size[3];
    ty_vec lower, upper, per_cell; /* m, cells per m */
} ty_pop_murk_view;

TY_FN ty_pop_murk ty_pop_murk_at(const ty_pop_murk_view* view, ty_vec point) {
    ty_pop_murk murk;
    const ty_vec from = ty_sub(point, view->lower), to = ty_sub(view->upper, point);
    const float share = 1.0f / (float)view->planes;
    murk.extinction = murk.scattering = murk.g = 0.0f;
    if (ty_minf(ty_minf(from.x, from.y), from.z) < 0.0f || ty_minf(ty_minf(to.x, to.y), to.z) < 0.0f) return murk;
    const ty_cell_point at = ty_cell_locate(
        view->size, ty_vec_make(from.x * view->per_cell.x, from.y * view->per_cell.y, from.z * view->per_cell.z));
    for (int32_t c = 0; c < view->planes; ++c) {
        murk.extinction += share * ty_cell_value(view->extinction[c], &at);
        murk.scattering += share * ty_cell_value(view->scattering[c], &at);
        murk.g += share * ty_cell_value(view->g[c], &at);
    }
    return murk;
}

/* Extinction of the l-th moment of what scattering sends on; negative g sends nothing on. */
TY_FN float ty_pop_murk_reduced(const ty_pop_murk* murk, int32_t order) {
    const float g = ty_maxf(0.0f, murk->g);
    return ty_maxf(0.0f, murk->extinction - (order == 2 ? g * g : g) * murk->scattering);
}

/* What importance has become on its way: transmittances of its moments 0, 1 and 2 (U, R and S of ty_pop_sweep). */
typedef struct ty_pop_gaze {
    float straight, first, second;
} ty_pop_gaze;

/* Sums over a stretch of a column, each times scattering coefficient and length. */
typedef struct ty_pop_glance {
    float straight;  /* of U */
    float forward;   /* of R - U */
    float forward_b; /* of S - U */
    float g;         /* of R times g */
    float aside;     /* of (1 - g) R: what no longer has a direction */
    ty_vec place;    /* of R times the place, m */
} ty_pop_glance;

/* Passes a stretch of some length with its middle at `point`. */
TY_FN void ty_pop_glance_add(ty_pop_glance* sum, ty_pop_gaze* gaze, const ty_pop_murk* murk, ty_vec point,
                             float length) {
    const float tau[3] = {murk->extinction * length, ty_pop_murk_reduced(murk, 1) * length,
                          ty_pop_murk_reduced(murk, 2) * length};
    const float decay[3] = {ty_decay(tau[0]), ty_decay(tau[1]), ty_decay(tau[2])};
    const float weight = murk->scattering * length;
    const float straight = weight * gaze->straight * ty_mean_decay(tau[0], decay[0]);
    const float first = weight * gaze->first * ty_mean_decay(tau[1], decay[1]);
    const float second = weight * gaze->second * ty_mean_decay(tau[2], decay[2]);
    sum->straight += straight;
    sum->forward += ty_maxf(0.0f, first - straight);
    sum->forward_b += ty_maxf(0.0f, second - straight);
    sum->g += first * murk->g;
    sum->aside += first * (1.0f - ty_maxf(0.0f, murk->g));
    sum->place = ty_mad(sum->place, point, first);
    gaze->straight *= decay[0];
    gaze->first *= decay[1];
    gaze->second *= decay[2];
}

/* How a stretch of importance scatters: J of grid.h, between light from where one looks along `look` and the eye. */
typedef struct ty_pop_lobe {
    float straight, g;
    float forward, forward_g, per_b; /* forward part: mean cosine b g, and 1 / b */
} ty_pop_lobe;

TY_FN ty_pop_lobe ty_pop_lobe_of(const ty_pop_glance* sum) {
    const float all = sum->straight + sum->forward;
    const float b = ty_clampf(sum->forward_b / ty_maxf(sum->forward, 1e-30f), 1e-3f, 1.0f);
    ty_pop_lobe lobe;
    lobe.straight = sum->straight;
    lobe.forward = sum->forward;
    lobe.g = ty_clampf(sum->g / ty_maxf(all, 1e-30f), -0.99f, 0.99f);
    lobe.forward_g = b * lobe.g;
    lobe.per_b = 1.0f / b;
    return lobe;
}

/* mu: cosine between the eye's ray and the direction one looks along for the light. */
TY_FN float ty_pop_lobe_at(const ty_pop_lobe* lobe, float mu) {
    const float forward = (ty_hg(mu, lobe->forward_g) - TY_INV_4PI) * lobe->per_b + TY_INV_4PI;
    return ty_maxf(0.0f, lobe->straight * ty_hg(mu, lobe->g) + lobe->forward * forward);
}

#endif
