/* Directions at a vertex in a medium: of its phase function, of lobes about lights, and of the path's guide. */
#ifndef TY_METHOD_PATH_TRACE_SCATTER_K_H
#define TY_METHOD_PATH_TRACE_SCATTER_K_H

#include "method/path/trace/collision.k.h"
#include "method/path/trace/light_path.k.h"

/* Direction sampling at a vertex in a medium: a mixture over channels of their phase functions, weighted by throughput,
 * and of Henyey-Greenstein lobes about the directions of lights (guiding). */
typedef struct ty_scatter_vertex {
    ty_vec incoming;
    float g[3];
    float weight[3]; /* mixture weights of the channels; their sum is 1 */
    int32_t gray;
    const ty_phase_view* lobes; /* NULL: Henyey-Greenstein of g */
    float guided;               /* probability of sampling a lobe about a light */
    float guide_g[3];           /* g, g^2, g^4: light that scatters once, twice, four times more */
    int32_t guide_count;
    ty_vec axis[TY_GUIDES_MAX];
    const float* axis_share;
    int32_t point_light[TY_GUIDES_MAX]; /* nonzero if the guiding light is a lamp */
    ty_guide_vertex guide;              /* of the path's guide, beside all of this */
} ty_scatter_vertex;

TY_FN ty_vec ty_light_axis(const ty_light_view* light, ty_vec from) {
    if (light->kind == TY_KIND_DIRECTIONAL) return ty_scale(light->direction, -1.0f);
    ty_vec to = ty_sub(light->position, from);
    const float center = light->kind == TY_KIND_TRIANGLE ? 1.0f / 3.0f : 0.5f;
    if (light->kind == TY_KIND_AREA || light->kind == TY_KIND_TRIANGLE)
        to = ty_mad(ty_mad(to, light->u, center), light->v, center);
    const float d2 = ty_dot(to, to);
    return d2 > 1e-30f ? ty_scale(to, 1.0f / sqrtf(d2)) : ty_vec_make(0, 0, 1);
}

/* Probability of sampling a guiding lobe at a vertex of the given depth (1: the first). It is large only for g near 1
 * and falls with depth fast enough to bound the weight of a path without guided directions (by 14). Both factors
 * minimise the measured cost of noise (variance times time) in thin and in thick media. */
TY_FN float ty_guided_fraction(float g, int32_t depth) {
    const float g2 = ty_maxf(g, 0.0f) * ty_maxf(g, 0.0f), g4 = g2 * g2;
    const float fall = 1.0f / (1.0f + 0.25f * (float)(depth - 1));
    return 0.6f * g4 * g4 * fall * fall;
}

TY_FN void ty_scatter_vertex_begin(ty_scatter_vertex* s, ty_path* path, const ty_medium_view* medium) {
    const ty_path_request* request = path->request;
    const float sum = ty_sum3(path->beta);
    float g = 0.0f;
    s->incoming = path->direction;
    s->gray = medium->gray_g;
    s->lobes = medium->phase;
    ty_medium_g(medium, path->origin, s->g);
    for (int c = 0; c < 3; ++c) {
        s->weight[c] = path->beta[c] / sum;
        g += s->weight[c] * s->g[c];
    }
    if (TY_PATH_GUIDED != 0)
        ty_guide_vertex_scatter(&s->guide, request->guide, path->origin, path->direction, g, path->depth,
                                &path->random);
    s->guide_count = request->guide_count;
    s->axis_share = request->guide_weight;
    s->guided = s->guide_count > 0 ? ty_guided_fraction(g, path->depth) : 0.0f;
    if (s->guided <= 0.0f) return;
    s->guide_g[0] = g;
    s->guide_g[1] = g * g;
    s->guide_g[2] = g * g * g * g;
    for (int32_t i = 0; i < s->guide_count; ++i) {
        const ty_light_view* light = &request->scene->lights.lights[request->guide_light[i]];
        s->axis[i] = ty_light_axis(light, path->origin);
        s->point_light[i] = ty_light_is_point_or_spot(light->kind);
    }
}

/* The phase function per channel. */
TY_FN void ty_scatter_vertex_phase(const ty_scatter_vertex* s, ty_vec direction, float phase[3]) {
    const float mu = ty_clampf(ty_dot(s->incoming, direction), -1.0f, 1.0f);
    if (s->lobes != NULL) {
        ty_phase_evaluate(s->lobes, mu, phase);
        return;
    }
    phase[0] = ty_hg(mu, s->g[0]);
    phase[1] = s->gray != 0 ? phase[0] : ty_hg(mu, s->g[1]);
    phase[2] = s->gray != 0 ? phase[0] : ty_hg(mu, s->g[2]);
}

TY_FN float ty_scatter_vertex_pdf(const ty_scatter_vertex* s, ty_vec direction, const float phase[3]) {
    const float plain = s->weight[0] * phase[0] + s->weight[1] * phase[1] + s->weight[2] * phase[2];
    if (s->guided <= 0.0f) return ty_guide_vertex_pdf(&s->guide, direction, plain);
    float lobes = 0.0f;
    for (int32_t i = 0; i < s->guide_count; ++i) {
        const float mu = ty_clampf(ty_dot(s->axis[i], direction), -1.0f, 1.0f);
        lobes += s->axis_share[i] * (ty_hg(mu, s->guide_g[0]) + ty_hg(mu, s->guide_g[1]) + ty_hg(mu, s->guide_g[2]));
    }
    return ty_guide_vertex_pdf(&s->guide, direction, ty_lerpf(plain, lobes * (1.0f / 3.0f), s->guided));
}

TY_FN ty_vec ty_scatter_vertex_sample(const ty_scatter_vertex* s, ty_sampler* random) {
    const float v = ty_sobol_next(random);
    float u = ty_sobol_next(random);
    ty_vec axis = s->incoming;
    float g = s->g[0];
    if (ty_guide_vertex_takes(&s->guide, &u)) return ty_guide_vertex_sample(&s->guide, u, v);
    if (u < s->guided) {
        const float lobes[3] = {1.0f, 1.0f, 1.0f};
        u /= s->guided;
        const int32_t guide = ty_sample_discrete(s->axis_share, s->guide_count, 1.0f, &u);
        const int32_t lobe = ty_sample_discrete(lobes, 3, 3.0f, &u);
        axis = s->axis[guide];
        g = s->guide_g[lobe];
        /* Few bits of u are left, and the first of its values is the axis itself. A ray that meets a lamp would have
         * that probability, and not 0: the missing bits are drawn. */
        if (s->point_light[guide] != 0) {
            ty_sampler bits = ty_sampler_branch(random);
            u += ty_rng_uniform(&bits) * 3.0f * 0x1p-24f / (s->guided * s->axis_share[guide]);
            return ty_hg_sample_narrow(axis, g, ty_minf(u, 0x1.fffffep-1f), v);
        }
    } else {
        u = (u - s->guided) / (1.0f - s->guided);
        if (s->lobes != NULL)
            return ty_direction_about(axis, ty_phase_sample_cosine(s->lobes, s->weight, ty_minf(u, 0x1.fffffep-1f)), v);
        if (s->gray == 0) g = s->g[ty_sample_discrete(s->weight, 3, 1.0f, &u)];
    }
    return ty_hg_sample(axis, g, ty_minf(u, 0x1.fffffep-1f), v);
}

#endif
