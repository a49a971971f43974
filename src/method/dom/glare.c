/* How much more or less of an environment phase functions see than of its parts: parts are so few that narrow lobes
 * about their directions leave gaps. Where media do not come in between, what all parts send along a way is made what
 * the environment, cut into many more, sends; media then dim that as they dim the parts. */
#include "base/context.h"
#include "method/dom/job.h"
#include "method/pop/environment.h"
#include "method/pop/frame.k.h"
#include "scene/scene.h"

/* Parts that the environment is cut into for that; ratios are held within bounds where parts send next to nothing. */
enum { FINE_PARTS = 1024 };
static const float most_ratio = 10;

typedef struct glare_job {
    ty_dom* light;
    const ty_pop_ordinate* fine;
    int32_t fine_count;
    float g[3];
} glare_job;

/* Mean cosine of all that scatters, per plane. */
static void find_mean_g(const ty_grid_medium* medium, float g[3]) {
    for (int32_t p = 0; p < medium->planes; ++p) {
        double sums[2] = {0, 0};
        for (size_t i = 0; i < medium->cells; ++i) {
            sums[0] += (double)medium->scattering[p][i];
            sums[1] += (double)(medium->scattering[p][i] * medium->g[p][i]);
        }
        g[p] = sums[0] > 0 ? (float)(sums[1] / sums[0]) : 0;
    }
}

/* Adds what light of a color sends along a way: one phase function where media are alike in all channels. */
static void add_sent(const glare_job* job, ty_vec direction, float cosine, const float color[3], ty_vec way,
                     float sent[3]) {
    const float mu = ty_dot(direction, way);
    float phase = 0;
    for (int32_t c = 0; c < 3; ++c) {
        if (c < job->light->part_planes) phase = ty_hg(mu, job->g[c] * cosine);
        sent[c] += color[c] * phase;
    }
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const glare_job* job = user;
    ty_dom* light = job->light;
    for (int32_t i = 0; i < TY_DOM_GLARE; ++i) {
        const ty_vec way = ty_octahedral_direction(((float)i + 0.5f) * (2.0f / TY_DOM_GLARE) - 1.0f,
                                                   ((float)row + 0.5f) * (2.0f / TY_DOM_GLARE) - 1.0f);
        float fine[3] = {0}, parts[3] = {0};
        for (int32_t n = 0; n < job->fine_count; ++n)
            add_sent(job, job->fine[n].direction, job->fine[n].cosine, job->fine[n].color, way, fine);
        for (int32_t n = 0; n < light->part_count; ++n) {
            const ty_dom_part* part = &light->parts[n];
            if (part->kind == TY_SINGLE_BEAM) add_sent(job, part->toward, part->cosine, part->color, way, parts);
        }
        for (int32_t c = 0; c < 3; ++c)
            light->glare[c][TY_DOM_GLARE * row + i] = parts[c] > 0 ? ty_minf(most_ratio, fine[c] / parts[c]) : 1;
    }
}

/* The same environments in many more parts. */
static ty_result cut_finely(const ty_dom_job* job, ty_pop_ordinate* parts, int32_t* count) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    ty_pop_def def = ty_default_pop_def();
    ty_result result = TY_OK;
    def.ordinates = FINE_PARTS;
    *count = 0;
    for (int32_t i = 0; i < lights->count && result == TY_OK; ++i) {
        int32_t own = 0;
        if (lights->lights[i].kind != TY_KIND_ENVIRONMENT) continue;
        result = ty_pop_environment_ordinates(job->scene, &def, i, NULL, parts + *count, &own);
        *count += own;
    }
    return result;
}

ty_result ty_dom_glare_find(ty_dom_job* job) {
    const ty_light_set* lights = &ty_scene_get_view(job->scene)->lights;
    glare_job glare = {.light = job->light};
    size_t capacity = 0;
    for (int32_t i = 0; i < lights->count; ++i)
        if (lights->lights[i].kind == TY_KIND_ENVIRONMENT) capacity += FINE_PARTS;
    for (int c = 0; c < 3; ++c)
        for (int32_t i = 0; i < TY_DOM_GLARE * TY_DOM_GLARE; ++i) job->light->glare[c][i] = 1;
    if (capacity == 0) return TY_OK;
    ty_pop_ordinate* parts = ty_alloc_array(job->context, capacity, sizeof *parts, false);
    if (parts == NULL) return TY_ERROR_MEMORY;
    find_mean_g(job->coarse, glare.g);
    const ty_result result = cut_finely(job, parts, &glare.fine_count);
    glare.fine = parts;
    if (result == TY_OK) ty_parallel_for(job->context, TY_DOM_GLARE, fill_row, &glare);
    ty_free_array(job->context, parts, capacity, sizeof *parts);
    return result;
}

float ty_dom_glare_at(const ty_dom* light, int32_t channel, ty_vec way) {
    float u, v;
    ty_octahedral_map(way, &u, &v);
    const float x = ty_clampf((u + 1) * 0.5f * TY_DOM_GLARE - 0.5f, 0, TY_DOM_GLARE - 1);
    const float y = ty_clampf((v + 1) * 0.5f * TY_DOM_GLARE - 0.5f, 0, TY_DOM_GLARE - 1);
    const int32_t i = (int32_t)x, j = (int32_t)y;
    const int32_t right = i + 1 < TY_DOM_GLARE ? 1 : 0, down = j + 1 < TY_DOM_GLARE ? TY_DOM_GLARE : 0;
    const float* at = light->glare[channel] + TY_DOM_GLARE * j + i;
    return ty_lerpf(ty_lerpf(at[0], at[right], x - (float)i), ty_lerpf(at[down], at[down + right], x - (float)i),
                    y - (float)j);
}
