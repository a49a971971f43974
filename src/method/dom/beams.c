/* What scatters of beams that have no field of their own, several at a time. */
#include "base/context.h"
#include "method/dom/job.h"
#include "solve/angular/harmonics.h"

enum { TERMS_MAX = TY_DOM_BANDS_MAX * TY_DOM_BANDS_MAX };

/* ---- memory ---- */

ty_result ty_dom_beams_create(const ty_dom_job* job, ty_dom_beams* beams) {
    for (int32_t p = 0; p < job->fine->planes; ++p) {
        beams->scattered[p] = ty_alloc_array(job->context, job->coarse->cells, TY_DOM_TOGETHER * sizeof(float), false);
        if (beams->scattered[p] == NULL) return TY_ERROR_MEMORY;
    }
    return TY_OK;
}

void ty_dom_beams_destroy(const ty_dom_job* job, ty_dom_beams* beams) {
    for (int32_t p = 0; p < 3; ++p)
        ty_free_array(job->context, beams->scattered[p], job->coarse->cells, TY_DOM_TOGETHER * sizeof(float));
}

/* ---- beams ---- */

bool ty_dom_beams_can(const ty_dom_scratch* scratch, const ty_light_field* field) {
    for (int32_t p = 0; p < field->planes; ++p)
        if (!scratch->uniform[p]) return false;
    return true;
}

void ty_dom_beams_take(ty_dom_job* job, ty_dom_beams* beams, const ty_source* source, const ty_light_field* field,
                       const ty_dom_scratch* scratch, float* const fluence[3]) {
    const ty_dom* light = job->light;
    const size_t begin = light->cells * (size_t)beams->count;
    for (int32_t p = 0; p < field->planes; ++p)
        ty_grid_average_both(job->context, field->fluence[p], job->fine->scattering[p], job->fine->box.size,
                             job->coarse->box.size, beams->scattered[p] + begin, fluence[p]);
    for (int32_t c = 0; c < ty_dom_channels(light); ++c)
        beams->factor[beams->count][c] = ty_dom_channel_factor(light, field, field->planes == 3 ? c : 0, c);
    beams->sources[beams->count++] = source;
    if (beams->count == TY_DOM_TOGETHER) ty_dom_beams_add(job, beams, scratch);
}

/* ---- moments ---- */

typedef struct add_job {
    ty_dom_job* job;
    const ty_dom_beams* beams;
    int32_t channel, plane;
    float share[TERMS_MAX]
               [TY_DOM_TOGETHER]; /* of what scatters, for each term: (g^l - g^L) b^l Y_lm, or c_l b^l Y_lm */
} add_job;

/* g: of the medium, of which the light that goes straight on is left out. */
static void find_shares(add_job* add, float g) {
    const ty_dom_beams* beams = add->beams;
    const int32_t bands = add->job->light->bands;
    const ty_forward_fit* fit = &add->job->light->fit;
    float straight = 1;
    for (int32_t l = 0; l < bands; ++l) straight *= g;
    for (int32_t i = 0; i < beams->count; ++i) {
        const ty_source* source = beams->sources[i];
        const double way[3] = {(double)source->direction.x, (double)source->direction.y, (double)source->direction.z};
        double y[TERMS_MAX];
        float power = 1, spread = beams->factor[i][add->channel];
        ty_harmonics_at(way, bands, y);
        for (int32_t l = 0; l < bands; ++l, power *= g, spread *= source->cosine)
            for (int32_t t = l * l; t < (l + 1) * (l + 1); ++t)
                add->share[t][i] = (fit->bands > 0 ? fit->moments[l] : power - straight) * spread * (float)y[t];
    }
}

static void add_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const add_job* add = user;
    const ty_dom_beams* beams = add->beams;
    const ty_dom* light = add->job->light;
    const int32_t width = light->box.size[0];
    const size_t at = (size_t)row * (size_t)width;
    for (int32_t t = 0; t < light->bands * light->bands; ++t) {
        float* out = ty_dom_plane(light, add->job->source[add->channel], t) + at;
        for (int32_t i = 0; i < beams->count; ++i) {
            const float* from = beams->scattered[add->plane] + light->cells * (size_t)i + at;
            const float share = add->share[t][i];
#pragma omp simd
            for (int32_t x = 0; x < width; ++x) out[x] += share * from[x];
        }
    }
}

void ty_dom_beams_add(ty_dom_job* job, ty_dom_beams* beams, const ty_dom_scratch* scratch) {
    const ty_dom* light = job->light;
    add_job add = {.job = job, .beams = beams};
    for (int32_t c = 0; c < ty_dom_channels(light) && beams->count > 0; ++c) {
        add.channel = c;
        add.plane = job->fine->planes == 3 ? c : 0;
        find_shares(&add, scratch->g[add.plane]);
        ty_parallel_for(job->context, (int64_t)light->box.size[1] * light->box.size[2], add_row, &add);
    }
    beams->count = 0;
}
