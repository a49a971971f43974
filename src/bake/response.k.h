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
    ty_vec wi;         /* unit, towards it */
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
} ty_response;

TY_FN ty_vec ty_response_axis(const ty_emitter* emitter, float shift) {
    if (emitter->kind != TY_IMPULSE_AREA || shift == 0.0f) return emitter->wi;
    const ty_vec aside = ty_mad(emitter->normal, emitter->wi, -ty_dot(emitter->normal, emitter->wi));
    const float length2 = ty_dot(aside, aside);
    if (!(length2 > 1e-12f)) return emitter->wi;
    const ty_vec axis = ty_scale(emitter->wi, sqrtf(ty_maxf(0.0f, 1.0f - shift * shift)));
    return ty_mad(axis, aside, shift / sqrtf(length2));
}

/* False where nothing scatters. */
TY_FN bool ty_response_find(const ty_bake_request* request, const ty_segment* segment, const ty_emitter* emitter,
                            ty_response* out) {
    const float any = ty_maxf(segment->scattered[0], ty_maxf(segment->scattered[1], segment->scattered[2]));
    if (!(any > 0.0f) || !(emitter->distance > 0.0f) || !(emitter->distance < TY_FLOAT_MAX)) return false;
    const float per_metre = 1.0f / emitter->distance;
    out->channels = request->gray != 0 ? 1 : 3;
    for (int c = 0; c < out->channels; ++c) {
        const float s = segment->scattered[c];
        ty_impulse_medium* medium = &out->medium[c];
        *medium = (ty_impulse_medium){.sigma_t = segment->depth[c] * per_metre,
                                      .sigma_s = s * per_metre,
                                      .g = s > 0.0f ? segment->turned[c] / s : 0.0f};
        if (request->merged[c].rows != NULL)
            ty_impulse_look_merged(&request->merged[c], emitter->kind, medium->sigma_t, emitter->distance,
                                   emitter->cosine, &out->channel[c]);
        else
            ty_impulse_look_within(request->tables, (ty_impulse_emitter)emitter->kind, medium, emitter->distance,
                                   emitter->cosine, request->scatterings, request->most[c], &out->channel[c]);
        out->axis[c] = ty_response_axis(emitter, out->channel[c].shift);
    }
    return true;
}

/* Radiance along a ray that is scattered once, behind `far`, per unit of the emitter's strength: what a medium that
 * ends there does not send. */
TY_FN float ty_response_beyond(const ty_emitter* emitter, const ty_impulse_medium* medium, ty_vec direction,
                               float far) {
    const float mu = ty_clampf(ty_dot(emitter->wi, direction), -1.0f, 1.0f), d = emitter->distance;
    const float sigma = medium->sigma_t, g = ty_clampf(medium->g, -0.5f, 0.5f);
    if (emitter->kind == TY_IMPULSE_DIRECTIONAL) {
        const float end = mu * far < d ? (mu > 0.0f ? d / mu : TY_FLOAT_MAX) : far;
        const float rate = sigma * ty_maxf(1.0f - mu, 1e-6f);
        const float stretch = ty_expf(-rate * far) - ty_expf(-ty_minf(rate * end, 80.0f));
        return medium->sigma_s * ty_hg(mu, g) * ty_expf(-sigma * d) * stretch / rate;
    }
    /* By the angle under which the emitter sees the ray, with Gauss-Legendre's two nodes. */
    static const float node[2] = {0.2113248654f, 0.7886751346f};
    const float nearest = d * mu, aside2 = d * d * ty_maxf(1e-6f, 1.0f - mu * mu);
    const float off = sqrtf(aside2 + emitter->area * (0.25f / TY_PI));
    const float begin = atanf((far - nearest) / off), range = 0.5f * TY_PI - begin;
    float sum = 0.0f;
    for (int i = 0; i < 2; ++i) {
        const float along = off * tanf(begin + range * node[i]), t = nearest + along;
        const float r = sqrtf(off * off + along * along);
        /* From the emitter to where it scatters. */
        const ty_vec way = ty_scale(ty_mad(ty_scale(direction, t), emitter->wi, -d), 1.0f / r);
        const float sends = emitter->kind == TY_IMPULSE_AREA ? ty_maxf(0.0f, ty_dot(emitter->normal, way)) : 1.0f;
        sum += 0.5f * sends * ty_hg(ty_clampf(-ty_dot(way, direction), -1.0f, 1.0f), g) * ty_expf(-sigma * (t + r));
    }
    return medium->sigma_s * sum * range / off;
}

#endif
