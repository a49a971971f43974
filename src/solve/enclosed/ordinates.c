/* Scattered light of an interior by discrete ordinates, whose boundary reflects angle by angle. */
#include "base/constants.h"
#include "base/context.h"
#include "solve/angular/quadrature.h"
#include "solve/enclosed/body.h"

#include <string.h>

enum { TERMS_MAX = TY_SH_TERMS_MAX };

typedef struct channel {
    ty_enclosed_body* body;
    int c;
    double tolerance;
    float scattered[TY_SH_BANDS_MAX]; /* s_l / sigma_s */
    float *source, *g;                /* `terms` planes; one plane of zeros */
} channel;

/* q_lm = s_l Phi_lm of uncollided light. */
static void find_source(const channel* ch) {
    const ty_enclosed_body* body = ch->body;
    const float *lights = body->of_lights[ch->c], *surfaces = body->of_surfaces[ch->c];
    for (int32_t l = 0, t = 0; l < body->bands; ++l)
        for (; t < (l + 1) * (l + 1); ++t)
            for (size_t i = 0; i < body->cells; ++i) {
                const size_t at = i * (size_t)body->terms + (size_t)t;
                ch->source[(size_t)t * body->cells + i] =
                    ch->scattered[l] * body->scattering[ch->c][i] * (lights[at] + surfaces[at]);
            }
}

/* Power that uncollided light loses to absorption, W. */
static double absorbed_uncollided(const channel* ch) {
    const ty_enclosed_body* body = ch->body;
    double sum = 0;
    for (size_t i = 0; i < body->cells; ++i) {
        const double absorption = (double)(body->extinction[ch->c][i] - body->scattering[ch->c][i]);
        const size_t at = i * (size_t)body->terms;
        sum += absorption * (double)(body->of_lights[ch->c][at] + body->of_surfaces[ch->c][at]);
    }
    return sum * TY_SQRT_4PI_F64 * body->cell[0] * body->cell[1] * body->cell[2];
}

static ty_result solve_channel(channel* ch, const ty_angular_quadrature* set, bool again, ty_enclosed_stats* stats) {
    ty_enclosed_body* body = ch->body;
    const float *sources[TERMS_MAX], *start[TERMS_MAX];
    float* moments[TERMS_MAX];
    ty_ordinates_def def = ty_default_ordinates_def();
    ty_ordinates_stats solved;
    for (int32_t l = 0; l < body->bands; ++l) ch->scattered[l] = body->legendre[ch->c][l] - body->forward[ch->c];
    find_source(ch);
    for (int32_t t = 0; t < body->terms; ++t) {
        sources[t] = ch->source + (size_t)t * body->cells;
        start[t] = moments[t] = body->solved[ch->c] + (size_t)t * body->cells;
    }
    memcpy(def.size, body->size, sizeof def.size);
    memcpy(def.cell, body->cell, sizeof def.cell);
    def.set = set;
    def.bands = def.output_order = body->bands;
    def.extinction = body->extinction[ch->c];
    def.scattering = body->scattering[ch->c];
    def.g = ch->g;
    def.scattered = ch->scattered;
    def.source = sources;
    def.source_terms = body->terms;
    def.start = again ? start : NULL;
    def.tolerance = ch->tolerance;
    def.walls = (ty_ordinates_faces){.count = body->side_count,
                                     .first = body->first,
                                     .x = body->x,
                                     .face = body->face,
                                     .albedo = body->albedo,
                                     .emission = body->emission,
                                     .ior = body->ior,
                                     .normal = body->normal,
                                     .absorbed = body->exitance[ch->c]};
    const ty_result result = ty_ordinates_solve(body->context, &def, moments, NULL, 0, &solved);
    if (result != TY_OK) return result;
    stats->converged = stats->converged && solved.converged;
    stats->sweeps += solved.sweeps;
    stats->absorbed[ch->c] += solved.absorbed + absorbed_uncollided(ch);
    stats->leaving[ch->c] += solved.walls_absorbed + solved.leaving + body->leaving[0][ch->c] + body->leaving[1][ch->c];
    return TY_OK;
}

ty_result ty_enclosed_solve_ordinates(ty_enclosed_body* body, bool again, double tolerance, ty_enclosed_stats* stats) {
    const size_t planes = (size_t)body->terms + 1;
    ty_angular_quadrature* set = ty_alloc_array(body->context, 1, sizeof *set, true);
    float* memory = ty_alloc_array(body->context, body->cells, planes * sizeof(float), true);
    channel ch = {.body = body, .tolerance = tolerance, .source = memory};
    ty_result result = TY_ERROR_MEMORY;
    if (set != NULL && memory != NULL) {
        ch.g = memory + body->cells * (size_t)body->terms;
        result = ty_angular_quadrature_create(body->context, body->def->directions, set, NULL);
    }
    for (ch.c = 0; ch.c < 3 && result == TY_OK; ++ch.c) result = solve_channel(&ch, set, again, stats);
    ty_free_array(body->context, set, 1, sizeof *set);
    ty_free_array(body->context, memory, body->cells, planes * sizeof(float));
    return result;
}
