/* What scatters of beams that have no field of their own, several at a time. */
#include "base/context.h"
#include "method/dom/sources/sources.h"
#include "solve/harmonics.h"

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* ---- memory ---- */

ty_result ty_dom_collimated_batch_create(const ty_dom_job* job, ty_dom_collimated_batch* beams) {
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        beams->scattered[p] = ty_alloc_array(job->context, job->coarse->cells, TY_DOM_BATCH * sizeof(float), false);
        if (beams->scattered[p] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

void ty_dom_collimated_batch_destroy(const ty_dom_job* job, ty_dom_collimated_batch* beams) {
    for (int32_t p = 0; p < 3; ++p)
        ty_free_array(job->context, beams->scattered[p], job->coarse->cells, TY_DOM_BATCH * sizeof(float));
}

/* ---- beams ---- */

bool ty_dom_collimated_batch_accepts(const ty_dom_scratch* scratch, const ty_light_field* field) {
    for (int32_t p = 0; p < field->planes; ++p)
        if (!scratch->uniform[p]) return false;
    return true;
}

void ty_dom_collimated_batch_take(ty_dom_job* job, ty_dom_collimated_batch* beams, const ty_discrete_light* source,
                                  const ty_light_field* field, const ty_dom_scratch* scratch, float* const fluence[3]) {
    const ty_dom* light = job->light;
    const size_t begin = light->cells * (size_t)beams->count;
    for (int32_t p = 0; p < field->planes; ++p)
        ty_grid_average_both(job->context, field->fluence[p], job->fine->scattering[p], job->fine->box.size,
                             job->coarse->box.size, beams->scattered[p] + begin, fluence[p]);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        beams->factor[beams->count][c] = ty_dom_channel_factor(light, field, field->planes == 3 ? c : 0, c);
    beams->sources[beams->count++] = source;
    if (beams->count == TY_DOM_BATCH) ty_dom_collimated_batch_flush(job, beams, scratch);
}

/* ---- moments ---- */

typedef struct add_job {
    ty_dom_job* job;
    const ty_dom_collimated_batch* beams;
    int32_t channel, plane;
    float weight[TERMS_MAX][TY_DOM_BATCH]; /* of what scatters, for each term: (g^l - g^L) b^l Y_lm, or c_l b^l Y_lm */
} add_job;

/* g: of the medium, of which the light that goes straight on is left out. */
static void find_weights(add_job* add, float g) {
    const ty_dom_collimated_batch* beams = add->beams;
    const int32_t bands = add->job->light->bands;
    const ty_forward_fit* fit = &add->job->light->fit;
    float forward = 1;
    for (int32_t l = 0; l < bands; ++l) forward *= g;
    for (int32_t i = 0; i < beams->count; ++i) {
        const ty_discrete_light* source = beams->sources[i];
        const double omega[3] = {(double)source->direction.x, (double)source->direction.y, (double)source->direction.z};
        double y[TERMS_MAX];
        float power = 1, b_l = beams->factor[i][add->channel];
        ty_harmonics_at(omega, bands, y);
        for (int32_t l = 0; l < bands; ++l, power *= g, b_l *= source->mean_cosine)
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                add->weight[t][i] = (fit->bands > 0 ? fit->moments[l] : power - forward) * b_l * (float)y[t];
    }
}

static void add_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const ty_dom_collimated_batch* beams = add->beams;
    const ty_dom* light = add->job->light;
    const int32_t width = light->box.size[0];
    const size_t at = (size_t)row * (size_t)width;
    for (int32_t t = 0; t < light->bands * light->bands; ++t) {
        float* out = ty_dom_plane(light, add->job->source[add->channel], t) + at;
        for (int32_t i = 0; i < beams->count; ++i) {
            const float* from = beams->scattered[add->plane] + light->cells * (size_t)i + at;
            const float weight = add->weight[t][i];
#pragma omp simd
            for (int32_t x = 0; x < width; ++x) out[x] += weight * from[x];
        }
    }
}

void ty_dom_collimated_batch_flush(ty_dom_job* job, ty_dom_collimated_batch* beams, const ty_dom_scratch* scratch) {
    const ty_dom* light = job->light;
    add_job add = {.job = job, .beams = beams};
    for (int32_t c = 0; c < ty_dom_channels(light) && beams->count > 0; ++c) {
        add.channel = c;
        add.plane = job->fine->planes == 3 ? c : 0;
        find_weights(&add, scratch->g[add.plane]);
        ty_parallel_for(job->context, (int64_t)light->box.size[1] * light->box.size[2], add_row, &add);
    }
    beams->count = 0;
}
