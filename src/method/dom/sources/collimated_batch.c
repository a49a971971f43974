/* First-collision sources of directional samples without a dedicated field, several at a time. */
#include "base/context.h"
#include "base/mapping.h"
#include "method/dom/sources/sources.h"
#include "solve/angular/harmonics.h"

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* ---- memory ---- */

ty_result ty_dom_collimated_batch_create(const ty_dom_job* job, ty_dom_collimated_batch* batch) {
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        batch->scattered[p] = ty_alloc_large(job->context, job->coarse->cells, TY_DOM_BATCH * sizeof(float), false);
        if (batch->scattered[p] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

void ty_dom_collimated_batch_destroy(const ty_dom_job* job, ty_dom_collimated_batch* batch) {
    for (int32_t p = 0; p < 3; ++p)
        ty_free_large(job->context, batch->scattered[p], job->coarse->cells, TY_DOM_BATCH * sizeof(float));
}

/* ---- samples ---- */

bool ty_dom_collimated_batch_accepts(const ty_dom_scratch* scratch, const ty_light_field* field) {
    for (int32_t p = 0; p < field->planes; ++p)
        if (!scratch->uniform[p]) return false;
    return true;
}

void ty_dom_collimated_batch_take(ty_dom_job* job, ty_dom_collimated_batch* batch, const ty_discrete_light* source,
                                  const ty_light_field* field, const ty_dom_scratch* scratch, float* const fluence[3]) {
    const ty_dom* light = job->light;
    const size_t begin = light->cells * (size_t)batch->count;
    for (int32_t p = 0; p < field->planes; ++p)
        ty_grid_average_both(job->context, field->fluence[p], job->fine->scattering[p], job->fine->box.size,
                             job->coarse->box.size, batch->scattered[p] + begin, fluence[p]);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        batch->factor[batch->count][c] = ty_dom_channel_factor(light, field, field->planes == 3 ? c : 0, c);
    batch->sources[batch->count++] = source;
    if (batch->count == TY_DOM_BATCH) ty_dom_collimated_batch_flush(job, batch, scratch);
}

/* ---- moments ---- */

typedef struct add_job {
    ty_dom_job* job;
    const ty_dom_collimated_batch* batch;
    int32_t channel, plane;
    float weight[TERMS_MAX]
                [TY_DOM_BATCH]; /* per harmonic: (g^l - g^L) b^l Y_lm with delta-M, or c_l b^l Y_lm of given moments */
} add_job;

/* g: of the medium. */
static void find_weights(add_job* add, float g) {
    const ty_dom_collimated_batch* batch = add->batch;
    const int32_t bands = add->job->light->bands;
    const ty_dom* light = add->job->light;
    const float* moments = light->fit.bands > 0             ? light->fit.moments
                           : ty_dom_legendre(light) != NULL ? light->scattered
                                                            : NULL;
    float forward = 1;
    for (int32_t l = 0; l < bands; ++l) forward *= g;
    for (int32_t i = 0; i < batch->count; ++i) {
        const ty_discrete_light* source = batch->sources[i];
        const double omega[3] = {(double)source->direction.x, (double)source->direction.y, (double)source->direction.z};
        double y[TERMS_MAX];
        float power = 1, b_l = batch->factor[i][add->channel];
        ty_harmonics_at(omega, bands, y);
        for (int32_t l = 0; l < bands; ++l, power *= g, b_l *= source->mean_cosine)
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                add->weight[t][i] = (moments != NULL ? moments[l] : power - forward) * b_l * (float)y[t];
    }
}

static void add_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const ty_dom_collimated_batch* batch = add->batch;
    const ty_dom* light = add->job->light;
    const int32_t width = light->box.size[0];
    const size_t at = (size_t)row * (size_t)width;
    for (int32_t t = 0; t < light->bands * light->bands; ++t) {
        float* out = ty_dom_plane(light, add->job->source[add->channel], t) + at;
        for (int32_t i = 0; i < batch->count; ++i) {
            const float* from = batch->scattered[add->plane] + light->cells * (size_t)i + at;
            const float weight = add->weight[t][i];
#pragma omp simd
            for (int32_t x = 0; x < width; ++x) out[x] += weight * from[x];
        }
    }
}

void ty_dom_collimated_batch_flush(ty_dom_job* job, ty_dom_collimated_batch* batch, const ty_dom_scratch* scratch) {
    const ty_dom* light = job->light;
    add_job add = {.job = job, .batch = batch};
    for (int32_t c = 0; c < ty_dom_channels(light) && batch->count > 0; ++c) {
        add.channel = c;
        add.plane = job->fine->planes == 3 ? c : 0;
        find_weights(&add, scratch->g[add.plane]);
        ty_parallel_for(job->context, (int64_t)light->box.size[1] * light->box.size[2], add_row, &add);
    }
    batch->count = 0;
}
