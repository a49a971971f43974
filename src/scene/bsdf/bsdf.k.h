/* The BSDF of glTF's metallic-roughness model: GGX microfacets over a diffuse base, of metal, a dielectric or a
 * mixture, under sheen and a clear coat; thin walls let light through. docs/materials.md has the model and its sources.
 *
 * Energy compensation (Kulla and Conty 2017): light that single scattering at microfacets loses returns by the lobe
 * (1 - E(wi)) (1 - E(wo)) / (pi (1 - E_mean)), with E the directional albedo of white microfacets. The diffuse base has
 * the same form, with E the directional albedo of the dielectric above it (Kelemen and Szirmay-Kalos 2001). Both are
 * reciprocal, and a white material reflects all light; layers.k.h has the same for lobes below sheen and clear coat.
 * Without compensation the model is that of glTF 2.0, appendix B, with height-correlated masking. */
#ifndef TY_SCENE_BSDF_BSDF_K_H
#define TY_SCENE_BSDF_BSDF_K_H

#include "scene/bsdf/layers.k.h"

TY_FN ty_vec ty_frame_local(const ty_frame* frame, ty_vec v) {
    return ty_vec_make(ty_dot(frame->s, v), ty_dot(frame->t, v), ty_dot(frame->n, v));
}

TY_FN ty_vec ty_frame_world(const ty_frame* frame, ty_vec v) {
    return ty_mad(ty_mad(ty_scale(frame->s, v.x), frame->t, v.y), frame->n, v.z);
}

TY_FN ty_frame ty_frame_make(ty_vec n) {
    ty_frame frame;
    frame.n = n;
    ty_onb(n, &frame.s, &frame.t);
    return frame;
}

/* ---- albedos ---- */

/* Fraction of the light lost by single scattering that returns after two or more, for microfacets of Schlick's
 * reflectance, whose mean is (20 f0 + f90) / 21: the series of Kulla and Conty 2017 from its second term on.
 * mean_albedo: that of white microfacets, E_mean. */
TY_FN float ty_bsdf_multiple(float f0, float f90, float mean_albedo) {
    const float mean = (20.0f * f0 + f90) * (1.0f / 21.0f);
    return mean * mean * mean_albedo / (1.0f - mean * (1.0f - mean_albedo));
}

/* Directional albedo of the dielectric above the base. */
TY_FN float ty_bsdf_film_albedo(const ty_bsdf* b, float cosine) {
    const float white = ty_bsdf_albedo(b->tables->reflected[0], cosine, b->roughness);
    const float schlick = ty_bsdf_albedo(b->tables->schlick[0], cosine, b->roughness);
    return ty_bsdf_microfacet_albedo(b->film_f0, b->film_f90, b->film_multiple, white, schlick);
}

/* Directional albedo of the clear coat, whose F0 is 0.04. */
TY_FN float ty_bsdf_coat_albedo(const ty_bsdf* b, float cosine) {
    const float white = ty_bsdf_albedo(b->tables->reflected[0], cosine, b->coat_roughness);
    const float schlick = ty_bsdf_albedo(b->tables->schlick[0], cosine, b->coat_roughness);
    return b->coat * ty_bsdf_microfacet_albedo(0.04f, 1.0f, 0.0f, white, schlick);
}

TY_FN float ty_bsdf_sheen_albedo(const ty_bsdf* b, float cosine) {
    if (b->compensated != 0) return ty_bsdf_sheen_value(b->tables->sheen_kept[0], cosine, b->sheen_roughness);
    return ty_minf(ty_bsdf_sheen_value(b->tables->sheen[0], cosine, b->sheen_roughness), 1.0f);
}

/* Parts of light at a cosine to the base that sheen lets down, and to the coat that the coat does. */
TY_FN float ty_bsdf_below_sheen(const ty_bsdf* b, float cosine) {
    return b->sheen_scale > 0.0f ? 1.0f - b->sheen_scale * ty_bsdf_sheen_albedo(b, cosine) : 1.0f;
}

TY_FN float ty_bsdf_below_coat(const ty_bsdf* b, float cosine) {
    return b->coat > 0.0f ? 1.0f - ty_bsdf_coat_albedo(b, cosine) : 1.0f;
}

/* ---- preparation ---- */

/* The reflectances of dielectric and metal (KHR_materials_ior, KHR_materials_specular). */
TY_FN void ty_bsdf_set_fresnel(ty_bsdf* b, const ty_bsdf_parameters* p, float mean_albedo) {
    const float f0 = ty_dielectric_f0(p->ior), m = p->metallic;
    b->film_f0 = 0.0f;
    b->film_f90 = p->specular;
    for (int c = 0; c < 3; ++c) {
        const float dielectric = ty_minf(f0 * p->specular_color[c], 1.0f) * p->specular;
        b->film_f0 = ty_maxf(b->film_f0, dielectric);
        b->f0[c] = ty_lerpf(dielectric, p->base_color[c], m);
        b->multiple[c] = ty_lerpf(ty_bsdf_multiple(dielectric, p->specular, mean_albedo),
                                  ty_bsdf_multiple(p->base_color[c], 1.0f, mean_albedo), m);
    }
    b->film_multiple = ty_bsdf_multiple(b->film_f0, b->film_f90, mean_albedo);
    b->f90 = ty_lerpf(p->specular, 1.0f, m);
}

/* Albedos and the probabilities of the lobes, which are proportional to them. */
TY_FN void ty_bsdf_set_albedo(ty_bsdf* b, float white, float schlick) {
    float weight[TY_LOBE_COUNT] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f}, sum = 0.0f;
    const float coat = 1.0f - b->below_coat, base = b->below_sheen * b->below_coat;
    const float sheen = b->sheen_scale > 0.0f ? b->below_coat * (1.0f - b->below_sheen) / b->sheen_scale : 0.0f;
    const float film_once = ty_bsdf_microfacet_albedo(b->film_f0, b->film_f90, 0.0f, white, schlick);
    for (int c = 0; c < 3; ++c) {
        const float once = base * ty_bsdf_microfacet_albedo(b->f0[c], b->f90, 0.0f, white, schlick);
        const float residual = ty_bsdf_schlick_mix(b->f0[c], b->f90, b->residual_out);
        const float multiple = base * b->multiple[c] * b->lost;
        const float diffuse = base * b->diffuse[c] * (1.0f - b->film) + sheen * b->sheen[c];
        const float through = base * b->transmitted[c] * (white - film_once);
        const float through_residual =
            b->transmitted[c] * ty_bsdf_schlick_mix(1.0f - b->film_f0, 1.0f - b->film_f90, b->residual_out);
        const float through_multiple = base * b->transmitted[c] * (1.0f - b->film_multiple) * b->lost;
        weight[TY_LOBE_SPECULAR] += ty_maxf(once - residual, 0.0f);
        weight[TY_LOBE_MULTIPLE] += multiple + residual;
        weight[TY_LOBE_DIFFUSE] += diffuse;
        weight[TY_LOBE_COAT] += coat;
        weight[TY_LOBE_THROUGH] += ty_maxf(through - through_residual, 0.0f);
        weight[TY_LOBE_THROUGH_MULTIPLE] += through_multiple + through_residual;
        b->albedo[c] = ty_minf(once + multiple + diffuse + coat, 1.0f);
        b->total[c] = ty_minf(b->albedo[c] + through + through_multiple, 1.0f);
    }
    for (int i = 0; i < TY_LOBE_COUNT; ++i) sum += weight[i];
    for (int i = 0; i < TY_LOBE_COUNT; ++i) b->probability[i] = sum > 0.0f ? weight[i] / sum : 0.0f;
}

/* wo: unit, in world space, in front of both normals. normal: of the base; coat_normal: of the clear coat. */
TY_FN void ty_bsdf_prepare(ty_bsdf* b, const ty_bsdf_parameters* p, TY_GLOBAL const ty_bsdf_tables* tables,
                           ty_vec normal, ty_vec coat_normal, ty_vec wo) {
    b->tables = tables;
    b->compensated = 1;
    b->roughness = p->roughness;
    b->alpha = ty_ggx_alpha(p->roughness);
    b->frame = ty_frame_make(normal);
    b->wo = ty_frame_local(&b->frame, wo);
    const float white = ty_bsdf_albedo(tables->reflected[0], b->wo.z, b->roughness);
    const float schlick = ty_bsdf_albedo(tables->schlick[0], b->wo.z, b->roughness);
    const float mean_albedo = ty_bsdf_mean(tables->reflected_mean, b->roughness);
    b->lost = 1.0f - white;
    b->lost_mean = ty_maxf(1.0f - mean_albedo, 1e-6f);
    ty_bsdf_set_fresnel(b, p, mean_albedo);
    b->film = ty_bsdf_microfacet_albedo(b->film_f0, b->film_f90, b->film_multiple, white, schlick);
    b->below_mean = ty_maxf(1.0f - ty_bsdf_microfacet_albedo(b->film_f0, b->film_f90, b->film_multiple, mean_albedo,
                                                             ty_bsdf_mean(tables->schlick_mean, b->roughness)),
                            1e-6f);
    b->sheen_scale = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float base = p->base_color[c] * (1.0f - p->metallic);
        b->diffuse[c] = base * (1.0f - p->transmission);
        b->transmitted[c] = base * p->transmission;
        b->sheen[c] = p->sheen_color[c];
        b->sheen_scale = ty_maxf(b->sheen_scale, p->sheen_color[c]);
    }
    b->sheen_roughness = p->sheen_roughness;
    b->below_sheen = ty_bsdf_below_sheen(b, b->wo.z);
    b->coat = p->clearcoat;
    b->coat_roughness = p->clearcoat_roughness;
    b->below_coat = 1.0f;
    if (b->coat > 0.0f) {
        b->coat_frame = ty_frame_make(coat_normal);
        b->coat_wo = ty_frame_local(&b->coat_frame, wo);
        b->below_coat = ty_bsdf_below_coat(b, b->coat_wo.z);
    }
    b->layered = b->coat > 0.0f || b->sheen_scale > 0.0f;
    for (int i = 0; i < TY_BELOW_COUNT; ++i) b->residual_out[i] = 0.0f;
    if (b->layered != 0) ty_bsdf_set_layers(b);
    ty_bsdf_set_albedo(b, white, schlick);
}

/* Turns to the model without energy compensation. The albedos stay, as bounds. */
TY_FN void ty_bsdf_drop_compensation(ty_bsdf* b) {
    float sum = 0.0f;
    b->compensated = 0;
    b->below_sheen = ty_bsdf_below_sheen(b, b->wo.z);
    for (int c = 0; c < 3; ++c) b->multiple[c] = 0.0f;
    b->probability[TY_LOBE_MULTIPLE] = b->probability[TY_LOBE_THROUGH_MULTIPLE] = 0.0f;
    for (int i = 0; i < TY_LOBE_COUNT; ++i) sum += b->probability[i];
    for (int i = 0; i < TY_LOBE_COUNT && sum > 0.0f; ++i) b->probability[i] /= sum;
}

/* ---- evaluation ---- */

/* Density of a cosine in proportion to its power `roughness`, which is near the lobe below: smooth surfaces lose, and
 * return, light at small angles alone. */
TY_FN float ty_bsdf_power_pdf(float roughness, float cosine) {
    return (roughness + 1.0f) * ty_expf(roughness * ty_logf(ty_maxf(cosine, 1e-30f))) * (0.5f / TY_PI);
}

/* The lobe of light that microfacets scatter several times, for reflectance 1. */
TY_FN float ty_bsdf_multiple_lobe(const ty_bsdf* b, float cosine) {
    const float lost = 1.0f - ty_bsdf_albedo(b->tables->reflected[0], cosine, b->roughness);
    return lost * b->lost / (TY_PI * b->lost_mean);
}

/* Parts of the light from wi to wo that layers let down: of wide lobes of the base, of other ones, and of the sheen. */
typedef struct ty_bsdf_passage {
    float wide, lesser, sheen;
} ty_bsdf_passage;

/* coat_cosine: of wi to the normal of the coat. Without energy compensation each layer has the lesser of its two
 * transmittances, for wi and for wo (KHR_materials_sheen). */
TY_FN ty_bsdf_passage ty_bsdf_pass_layers(const ty_bsdf* b, float cosine, float coat_cosine) {
    ty_bsdf_passage down = {1.0f, 1.0f, 1.0f};
    if (b->layered == 0) return down;
    const float sheen = ty_bsdf_below_sheen(b, cosine), coat = ty_bsdf_below_coat(b, coat_cosine);
    const float in = sheen * coat, out = b->below_sheen * b->below_coat;
    down.sheen = ty_minf(coat, b->below_coat);
    down.lesser = b->compensated != 0 ? ty_minf(in, out) : ty_minf(sheen, b->below_sheen) * down.sheen;
    down.wide = b->compensated != 0 ? in * out : down.lesser;
    return down;
}

/* The BRDF of the base and the sheen, and the density of the lobes that sample it. */
TY_FN float ty_bsdf_evaluate_base(const ty_bsdf* b, ty_vec wi, const ty_bsdf_passage* down, float brdf[3]) {
    const ty_vec h = ty_normalize(ty_add(wi, b->wo));
    const float weight = ty_schlick_weight(ty_dot(h, wi));
    const float lobe = ty_ggx_ndf(h, b->alpha) * ty_ggx_visibility(wi.z, b->wo.z, b->alpha) * down->lesser;
    const float wide = b->compensated != 0 ? ty_bsdf_multiple_lobe(b, wi.z) * down->wide : 0.0f;
    const float passed =
        down->wide * (b->compensated != 0 ? (1.0f - ty_bsdf_film_albedo(b, wi.z)) * (1.0f - b->film) / b->below_mean
                                          : 1.0f - ty_lerpf(b->film_f0, b->film_f90, weight));
    for (int c = 0; c < 3; ++c)
        brdf[c] =
            ty_lerpf(b->f0[c], b->f90, weight) * lobe + b->multiple[c] * wide + b->diffuse[c] * passed * (1.0f / TY_PI);
    float pdf = b->probability[TY_LOBE_SPECULAR] * ty_ggx_pdf(b->wo, h, b->alpha) +
                b->probability[TY_LOBE_DIFFUSE] * wi.z * (1.0f / TY_PI);
    if (b->compensated != 0) pdf += b->probability[TY_LOBE_MULTIPLE] * ty_bsdf_power_pdf(b->roughness, wi.z);
    if (b->layered != 0) ty_bsdf_add_layers(b, wi, down->sheen, brdf);
    return pdf;
}

/* Transmission of thin walls: the reflection of microfacets, mirrored. wi: mirrored to the side of wo. */
TY_FN float ty_bsdf_evaluate_through(const ty_bsdf* b, ty_vec wi, const ty_bsdf_passage* down, float btdf[3]) {
    const ty_vec h = ty_normalize(ty_add(wi, b->wo));
    const float passed = 1.0f - ty_lerpf(b->film_f0, b->film_f90, ty_schlick_weight(ty_dot(h, wi)));
    const float lobe = ty_ggx_ndf(h, b->alpha) * ty_ggx_visibility(wi.z, b->wo.z, b->alpha) * down->lesser;
    float wide = 0.0f, pdf = b->probability[TY_LOBE_THROUGH] * ty_ggx_pdf(b->wo, h, b->alpha);
    if (b->compensated != 0) {
        wide = (1.0f - b->film_multiple) * ty_bsdf_multiple_lobe(b, wi.z) * down->wide;
        pdf += b->probability[TY_LOBE_THROUGH_MULTIPLE] * ty_bsdf_power_pdf(b->roughness, wi.z);
        if (b->layered != 0) {
            float residual[TY_BELOW_COUNT];
            ty_bsdf_residual_lobes(b, wi.z, residual);
            wide += ty_bsdf_schlick_mix(1.0f - b->film_f0, 1.0f - b->film_f90, residual);
        }
    }
    for (int c = 0; c < 3; ++c) btdf[c] = b->transmitted[c] * (passed * lobe + wide);
    return pdf;
}

/* BSDF times cosine for light from `direction`; returns the density of ty_bsdf_sample there, 1/sr, or 0 if no light
 * comes from there. */
TY_FN float ty_bsdf_evaluate(const ty_bsdf* b, ty_vec direction, float factor[3]) {
    ty_vec wi = ty_frame_local(&b->frame, direction), coat_wi = wi;
    const bool through = wi.z < 0.0f;
    float pdf, coat = 0.0f;
    for (int c = 0; c < 3; ++c) factor[c] = 0.0f;
    if (!(wi.z != 0.0f) || (through && !ty_bsdf_transmits(b)) || !(b->wo.z > 0.0f)) return 0.0f;
    wi.z = fabsf(wi.z);
    if (b->coat > 0.0f) coat_wi = ty_frame_local(&b->coat_frame, direction);
    const ty_bsdf_passage down = ty_bsdf_pass_layers(b, wi.z, fabsf(coat_wi.z));
    pdf = through ? ty_bsdf_evaluate_through(b, wi, &down, factor) : ty_bsdf_evaluate_base(b, wi, &down, factor);
    if (b->coat > 0.0f && !through && coat_wi.z > 0.0f) {
        const ty_vec h = ty_normalize(ty_add(coat_wi, b->coat_wo));
        const float alpha = ty_ggx_alpha(b->coat_roughness);
        coat = b->coat * ty_lerpf(0.04f, 1.0f, ty_schlick_weight(ty_dot(h, coat_wi))) * ty_ggx_ndf(h, alpha) *
               ty_ggx_visibility(coat_wi.z, b->coat_wo.z, alpha) * coat_wi.z;
        pdf += b->probability[TY_LOBE_COAT] * ty_ggx_pdf(b->coat_wo, h, alpha);
    }
    for (int c = 0; c < 3; ++c) factor[c] = factor[c] * wi.z + coat;
    return pdf;
}

/* ---- sampling ---- */

/* Samples a direction towards the light; its density is that of ty_bsdf_evaluate. u, v, pick: uniform in [0, 1). False:
 * the sample carries no light. */
TY_FN bool ty_bsdf_sample(const ty_bsdf* b, float pick, float u, float v, ty_vec* direction) {
    int32_t lobe = 0;
    while (lobe + 1 < TY_LOBE_COUNT && pick >= b->probability[lobe]) pick -= b->probability[lobe++];
    if (!(b->probability[lobe] > 0.0f) || !(b->wo.z > 0.0f)) return false;
    const bool coat = lobe == TY_LOBE_COAT, through = lobe >= TY_LOBE_THROUGH;
    ty_vec wi;
    if (lobe == TY_LOBE_DIFFUSE || lobe == TY_LOBE_MULTIPLE || lobe == TY_LOBE_THROUGH_MULTIPLE) {
        const float power = lobe == TY_LOBE_DIFFUSE ? 1.0f : b->roughness;
        wi = ty_direction_about(ty_vec_make(0.0f, 0.0f, 1.0f),
                                ty_expf(ty_logf(ty_maxf(1.0f - u, 1e-30f)) / (power + 1.0f)), v);
    } else {
        const ty_vec wo = coat ? b->coat_wo : b->wo;
        const ty_vec h = ty_ggx_sample(wo, coat ? ty_ggx_alpha(b->coat_roughness) : b->alpha, u, v);
        wi = ty_normalize(ty_mad(ty_scale(wo, -1.0f), h, 2.0f * ty_dot(wo, h)));
    }
    if (!(wi.z > 0.0f)) return false;
    if (through) wi.z = -wi.z;
    *direction = ty_frame_world(coat ? &b->coat_frame : &b->frame, wi);
    return true;
}

#endif
