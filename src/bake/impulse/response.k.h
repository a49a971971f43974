/* Response of a medium to an emitter at the end of a ray. */
#ifndef TY_BAKE_IMPULSE_RESPONSE_K_H
#define TY_BAKE_IMPULSE_RESPONSE_K_H

#include "bake/gather/request.h"
#include "bake/gather/segment.k.h"
#include "method/impulse/lookup.h"
#include "scene/media/phase.k.h"

/* An emitter relative to a receiver. */
typedef struct ty_emitter {
    int32_t kind;      /* ty_impulse_emitter */
    ty_vec position;   /* unless it is directional */
    ty_vec wi;         /* unit direction towards it */
    ty_vec normal;     /* areas: unit normal on the emitting side */
    float area;        /* of the disc it represents, m^2 */
    float distance;    /* m */
    float cosine;      /* areas: cosine at the emitter, between its normal and the direction to the receiver */
    float strength[3]; /* ty_impulse_emitter: color */
} ty_emitter;

/* Effective distance of a disc for scattered light, which falls off as 1 / distance: the mean of that over the disc. */
TY_FN float ty_disc_distance(float distance, float area) {
    return sqrtf(distance * distance + area * (0.25f / TY_PI));
}

typedef struct ty_response {
    ty_impulse_response channel[3];
    int32_t channels; /* 1: all channels are identical */
    ty_vec axis[3];
    ty_impulse_medium medium[3];
} ty_response;

TY_FN ty_vec ty_response_axis(const ty_emitter* emitter, float shift) {
    if (emitter->kind != TY_IMPULSE_AREA || shift == 0.0f) return emitter->wi;
    const ty_vec tangent = ty_mad(emitter->normal, emitter->wi, -ty_dot(emitter->normal, emitter->wi));
    const float length2 = ty_dot(tangent, tangent);
    if (!(length2 > 1e-12f)) return emitter->wi;
    const ty_vec axis = ty_scale(emitter->wi, sqrtf(ty_maxf(0.0f, 1.0f - shift * shift)));
    return ty_mad(axis, tangent, shift / sqrtf(length2));
}

/* Looks up the response of a segment to an emitter; false: the segment does not scatter. */
TY_FN bool ty_response_find(const ty_bake_request* request, const ty_segment* segment, const ty_emitter* emitter,
                            ty_response* out) {
    const float max_scattering =
        ty_maxf(segment->scattering_depth[0], ty_maxf(segment->scattering_depth[1], segment->scattering_depth[2]));
    if (!(max_scattering > 0.0f) || !(emitter->distance > 0.0f) || !(emitter->distance < TY_FLOAT_MAX)) return false;
    const float per_metre = 1.0f / emitter->distance;
    out->channels = request->gray != 0 ? 1 : 3;
    for (int c = 0; c < out->channels; ++c) {
        const float s = segment->scattering_depth[c];
        ty_impulse_medium* medium = &out->medium[c];
        *medium = (ty_impulse_medium){.sigma_t = segment->depth[c] * per_metre,
                                      .sigma_s = s * per_metre,
                                      .g = s > 0.0f ? segment->g_scattering_depth[c] / s : 0.0f};
        if (request->impulse.merged[c].rows != NULL)
            ty_impulse_lookup_merged(&request->impulse.merged[c], emitter->kind, medium->sigma_t, emitter->distance,
                                     emitter->cosine, &out->channel[c]);
        else
            ty_impulse_lookup_bounded(request->impulse.tables, (ty_impulse_emitter)emitter->kind, medium,
                                      emitter->distance, emitter->cosine, request->scatterings,
                                      request->impulse.max_bounce_ratio[c], &out->channel[c]);
        out->axis[c] = ty_response_axis(emitter, out->channel[c].shift);
    }
    return true;
}

/* Once-scattered radiance along a ray from beyond `max_distance`, per unit strength of the emitter: the part of the
 * response that a medium ending there lacks. */
TY_FN float ty_response_occluded(const ty_emitter* emitter, const ty_impulse_medium* medium, ty_vec direction,
                                 float max_distance) {
    const float mu = ty_clampf(ty_dot(emitter->wi, direction), -1.0f, 1.0f), d = emitter->distance;
    const float sigma = medium->sigma_t, g = ty_clampf(medium->g, -0.5f, 0.5f);
    if (emitter->kind == TY_IMPULSE_DIRECTIONAL) {
        const float end = mu * max_distance < d ? (mu > 0.0f ? d / mu : TY_FLOAT_MAX) : max_distance;
        const float rate = sigma * ty_maxf(1.0f - mu, 1e-6f);
        const float path_integral = ty_expf(-rate * max_distance) - ty_expf(-ty_minf(rate * end, 80.0f));
        return medium->sigma_s * ty_hg(mu, g) * ty_expf(-sigma * d) * path_integral / rate;
    }
    /* Equiangular quadrature (Kulla and Fajardo 2012) with the two nodes of Gauss-Legendre. */
    static const float node[2] = {0.2113248654f, 0.7886751346f};
    const float nearest = d * mu, height2 = d * d * ty_maxf(1e-6f, 1.0f - mu * mu);
    const float height = sqrtf(height2 + emitter->area * (0.25f / TY_PI));
    const float begin = atanf((max_distance - nearest) / height), range = 0.5f * TY_PI - begin;
    float sum = 0.0f;
    for (int i = 0; i < 2; ++i) {
        const float along = height * tanf(begin + range * node[i]), t = nearest + along;
        const float r = sqrtf(height * height + along * along);
        /* Direction from the emitter to the scattering point. */
        const ty_vec omega = ty_scale(ty_mad(ty_scale(direction, t), emitter->wi, -d), 1.0f / r);
        const float cosine = emitter->kind == TY_IMPULSE_AREA ? ty_maxf(0.0f, ty_dot(emitter->normal, omega)) : 1.0f;
        sum += 0.5f * cosine * ty_hg(ty_clampf(-ty_dot(omega, direction), -1.0f, 1.0f), g) * ty_expf(-sigma * (t + r));
    }
    return medium->sigma_s * sum * range / height;
}

#endif
