/* What a medium makes of an emitter that a ray leads to. */
#ifndef TY_BAKE_RESPONSE_K_H
#define TY_BAKE_RESPONSE_K_H

#include "bake/kernel.h"
#include "bake/segment.k.h"
#include "method/impulse/look.h"
#include "scene/phase.k.h"

/* An emitter as seen from a receiver. */
typedef struct ty_emitter {
    int32_t kind;      /* ty_impulse_emitter */
    ty_vec position;   /* unless it is far */
    ty_vec look;       /* unit, towards it */
    ty_vec normal;     /* areas: unit, on the side that sends */
    float area;        /* of the disc that it stands for, m^2 */
    float distance;    /* m */
    float cosine;      /* areas: between normal and the way from it */
    float strength[3]; /* ty_impulse_emitter: color */
} ty_emitter;

/* The distance to a disc as what scatters beside it goes by: light falls with distance there, which has this mean over
 * the disc. */
TY_FN float ty_disc_distance(float distance, float area) {
    return sqrtf(distance * distance + area * (0.25f / TY_PI));
}

typedef struct ty_response {
    ty_impulse_response channel[3];
    int32_t channels; /* 1: all alike */
    ty_vec axis[3];
    ty_impulse_medium medium[3];
    float folded; /* areas: how much of what seems to come from behind their plane comes from before it */
    ty_vec plane; /* the area's normal */
} ty_response;

/* Irradiance of a zonal function of a response on a surface. A small area sends nothing behind its plane, and a
 * receiver in that plane gets nothing from there; but about one axis a zonal function cannot say so. What it has there
 * is folded up. */
TY_FN float ty_response_on(const ty_response* response, const float zonal[TY_IMPULSE_TERMS], ty_vec axis,
                           ty_vec normal) {
    const float straight = ty_impulse_irradiance(zonal, ty_dot(axis, normal));
    const float folded = response->folded * ty_dot(response->plane, normal);
    if (!(folded > 0.0f)) return ty_maxf(0.0f, straight);
    const ty_vec mirrored = ty_mad(axis, response->plane, -2.0f * ty_dot(axis, response->plane));
    return ty_maxf(0.0f, straight + folded * ty_impulse_irradiance(zonal, ty_dot(mirrored, normal)));
}

TY_FN ty_vec ty_response_axis(const ty_emitter* emitter, float shift) {
    if (emitter->kind != TY_IMPULSE_AREA || shift == 0.0f) return emitter->look;
    const ty_vec aside = ty_mad(emitter->normal, emitter->look, -ty_dot(emitter->normal, emitter->look));
    const float length2 = ty_dot(aside, aside);
    if (!(length2 > 1e-12f)) return emitter->look;
    const ty_vec axis = ty_scale(emitter->look, sqrtf(ty_maxf(0.0f, 1.0f - shift * shift)));
    return ty_mad(axis, aside, shift / sqrtf(length2));
}

/* How many times as bright as one bounce the next is at most, per channel, where light that scattered does so again
 * with a mean probability p before it leaves the medium or meets a surface. In the long run it is p; the first bounces
 * fall off less, more of their light being deep in the medium. */
TY_FN float ty_response_most(double depth, double stopped) {
    const double p = depth > 0 ? 1 - stopped / depth : 1;
    return p < 1 ? (float)(p / (1 - p * p)) : TY_FLOAT_MAX;
}

/* False where nothing scatters. most: per channel, see above. */
TY_FN bool ty_response_find(const ty_bake_request* request, const ty_segment* segment, const ty_emitter* emitter,
                            const float most[3], ty_response* out) {
    const float any = ty_maxf(segment->scattered[0], ty_maxf(segment->scattered[1], segment->scattered[2]));
    if (!(any > 0.0f) || !(emitter->distance > 0.0f) || !(emitter->distance < TY_FLOAT_MAX)) return false;
    const float per_metre = 1.0f / emitter->distance;
    out->channels = request->gray != 0 ? 1 : 3;
    out->folded = 0.0f;
    if (emitter->kind == TY_IMPULSE_AREA) {
        out->folded = (1.0f - emitter->cosine) * (1.0f - emitter->cosine);
        out->plane = emitter->normal;
    }
    for (int c = 0; c < out->channels; ++c) {
        const float s = segment->scattered[c];
        out->medium[c] = (ty_impulse_medium){.sigma_t = segment->depth[c] * per_metre,
                                             .sigma_s = s * per_metre,
                                             .g = s > 0.0f ? segment->turned[c] / s : 0.0f};
        ty_impulse_look_within(request->tables, (ty_impulse_emitter)emitter->kind, &out->medium[c], emitter->distance,
                               emitter->cosine, request->scatterings, most[c], &out->channel[c]);
        out->axis[c] = ty_response_axis(emitter, out->channel[c].shift);
    }
    return true;
}

/* Radiance along a ray that is scattered once, behind `far`, per unit of the emitter's strength: what a medium that
 * ends there does not send. */
TY_FN float ty_response_beyond(const ty_emitter* emitter, const ty_impulse_medium* medium, ty_vec direction,
                               float far) {
    const float mu = ty_clampf(ty_dot(emitter->look, direction), -1.0f, 1.0f), d = emitter->distance;
    const float sigma = medium->sigma_t, g = ty_clampf(medium->g, -0.5f, 0.5f);
    if (emitter->kind == TY_IMPULSE_DIRECTIONAL) {
        const float end = mu * far < d ? (mu > 0.0f ? d / mu : TY_FLOAT_MAX) : far;
        const float rate = sigma * ty_maxf(1.0f - mu, 1e-6f);
        const float stretch = ty_expf(-rate * far) - ty_expf(-ty_minf(rate * end, 80.0f));
        return medium->sigma_s * ty_hg(mu, g) * ty_expf(-sigma * d) * stretch / rate;
    }
    /* By the angle under which the emitter sees the ray, with Gauss-Legendre's four nodes. */
    static const float node[4] = {0.0694318442f, 0.3300094782f, 0.6699905218f, 0.9305681558f};
    static const float weight[4] = {0.1739274226f, 0.3260725774f, 0.3260725774f, 0.1739274226f};
    const float nearest = d * mu, off = ty_maxf(d * sqrtf(ty_maxf(0.0f, 1.0f - mu * mu)), 1e-3f * d);
    const float begin = atanf((far - nearest) / off), range = 0.5f * TY_PI - begin;
    float sum = 0.0f;
    for (int i = 0; i < 4; ++i) {
        const float along = off * tanf(begin + range * node[i]), t = nearest + along;
        const float r = sqrtf(off * off + along * along);
        /* From the emitter to where it scatters. */
        const ty_vec way = ty_scale(ty_mad(ty_scale(direction, t), emitter->look, -d), 1.0f / r);
        const float sends = emitter->kind == TY_IMPULSE_AREA ? ty_maxf(0.0f, ty_dot(emitter->normal, way)) : 1.0f;
        sum +=
            weight[i] * sends * ty_hg(ty_clampf(-ty_dot(way, direction), -1.0f, 1.0f), g) * ty_expf(-sigma * (t + r));
    }
    return medium->sigma_s * sum * range / off;
}

#endif
