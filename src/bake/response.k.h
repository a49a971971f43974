/* What a medium makes of an emitter that a ray leads to. */
#ifndef TY_BAKE_RESPONSE_K_H
#define TY_BAKE_RESPONSE_K_H

#include "bake/kernel.h"
#include "bake/segment.k.h"

/* An emitter as seen from a receiver. */
typedef struct ty_emitter {
    int32_t kind;      /* ty_impulse_emitter */
    ty_vec look;       /* unit, towards it */
    ty_vec normal;     /* areas: unit, on the side that sends */
    float distance;    /* m */
    float cosine;      /* areas: between normal and the way from it */
    float strength[3]; /* ty_impulse_emitter: color */
} ty_emitter;

typedef struct ty_response {
    ty_impulse_response channel[3];
    int32_t channels; /* 1: all alike */
    ty_vec axis[3];
} ty_response;

TY_FN ty_vec ty_response_axis(const ty_emitter* emitter, float shift) {
    if (emitter->kind != TY_IMPULSE_AREA || shift == 0.0f) return emitter->look;
    const ty_vec aside = ty_mad(emitter->normal, emitter->look, -ty_dot(emitter->normal, emitter->look));
    const float length2 = ty_dot(aside, aside);
    if (!(length2 > 1e-12f)) return emitter->look;
    const ty_vec axis = ty_scale(emitter->look, sqrtf(ty_maxf(0.0f, 1.0f - shift * shift)));
    return ty_mad(axis, aside, shift / sqrtf(length2));
}

/* False where nothing scatters. */
TY_FN bool ty_response_find(const ty_bake_request* request, const ty_segment* segment, const ty_emitter* emitter,
                            ty_response* out) {
    const float most = ty_maxf(segment->scattered[0], ty_maxf(segment->scattered[1], segment->scattered[2]));
    if (!(most > 0.0f) || !(emitter->distance > 0.0f) || !(emitter->distance < TY_FLOAT_MAX)) return false;
    const float per_metre = 1.0f / emitter->distance;
    out->channels = request->gray != 0 ? 1 : 3;
    for (int c = 0; c < out->channels; ++c) {
        const float s = segment->scattered[c];
        const ty_impulse_medium medium = {.sigma_t = segment->depth[c] * per_metre,
                                          .sigma_s = s * per_metre,
                                          .g = s > 0.0f ? segment->turned[c] / s : 0.0f};
        ty_impulse_look(request->tables, (ty_impulse_emitter)emitter->kind, &medium, emitter->distance, emitter->cosine,
                        request->scatterings, &out->channel[c]);
        out->axis[c] = ty_response_axis(emitter, out->channel[c].shift);
    }
    return true;
}

/* Irradiance on a surface from all that scattered, per channel. */
TY_FN void ty_response_irradiance(const ty_response* response, ty_vec normal, float out[3]) {
    float zonal[TY_IMPULSE_TERMS];
    for (int c = 0; c < response->channels; ++c) {
        const ty_impulse_response* r = &response->channel[c];
        for (int l = 0; l < TY_IMPULSE_TERMS; ++l) zonal[l] = r->single[l] + r->multiple[l];
        out[c] = ty_maxf(0.0f, ty_impulse_irradiance(zonal, ty_dot(response->axis[c], normal)));
    }
    for (int c = response->channels; c < 3; ++c) out[c] = out[0];
}

#endif
