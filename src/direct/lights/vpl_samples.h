/* Samples of the surfaces that a light reaches first, and the power that they reflect: the candidates for virtual point
 * lights (Keller 1997).
 *
 * The samples are stratified: one jittered ray per stratum. Directional lights have a square grid of strata across the
 * surfaces; spot lights have strata of equal solid angle in their cone, point lights in two hemispheres (about +z and
 * -z). All surfaces reflect diffusely on both sides, so all samples together reflect the power that the light sends to
 * surfaces, times their albedo. Strata of equal solid angle do not map straight lines to straight lines, so these
 * samples cannot serve as a shadow map: those are direct/shadow/rsm.h. */
#ifndef TY_DIRECT_LIGHTS_VPL_SAMPLES_H
#define TY_DIRECT_LIGHTS_VPL_SAMPLES_H

#include "base/vector.k.h"
#include "direct/media/grid_medium.h"

typedef struct ty_vpl_sample {
    ty_vec position; /* m, offset from the surface on the lit side against self-intersection */
    ty_vec normal;   /* shading normal on that side, unit */
    float flux[3];   /* reflected power, W; its intensity is flux / pi times the cosine about the normal */
    float area;      /* surface area of the stratum, m^2 */
    float distance;  /* along the ray, m; INFINITY: no surface, and all other fields are 0 */
} ty_vpl_sample;

typedef struct ty_vpl_samples {
    ty_context* context;
    int32_t light;        /* an index into ty_light_set.lights */
    int32_t side;         /* texels */
    int32_t faces;        /* 1; point lights: 2 */
    int32_t parallel;     /* whether the rays are parallel */
    ty_vec axis[3];       /* orthonormal; axis[2]: the direction of the light, or the center of the first face */
    ty_vec origin;        /* start of the ray of corner (0, 0) if parallel, else the light's position, m */
    float span[2];        /* size of the grid if parallel, m */
    float cap;            /* if not parallel: 1 - cosine of the half angle of a face */
    float measure;        /* of a stratum: area across the light, m^2, or solid angle, sr */
    uint64_t seed;        /* of the jitter */
    ty_vpl_sample* items; /* face by face, row by row */
    double flux[3];       /* sum over all samples, W */
} ty_vpl_samples;

typedef struct ty_vpl_samples_def {
    int32_t side;                 /* strata along a side, 1..4096 */
    const ty_grid_medium* medium; /* medium that attenuates the light; NULL: vacuum */
    float* const* extinction;     /* extinction in place of the medium's, as many planes; NULL: the medium's own */
    const double *lower, *upper;  /* directional lights: only surfaces in this box are sampled, m; NULL: all surfaces */
    uint64_t seed;
} ty_vpl_samples_def;

/* The samples of a directional, point or spot light of a committed scene. Errors: TY_ERROR_ARGUMENT (another kind of
 * light, def), TY_ERROR_MEMORY. *out is freed with ty_vpl_samples_destroy. */
ty_result ty_vpl_samples_create(const ty_scene* scene, const ty_vpl_samples_def* def, int32_t light,
                                ty_vpl_samples** out);
void ty_vpl_samples_destroy(ty_vpl_samples* samples);

size_t ty_vpl_samples_count(const ty_vpl_samples* samples);

/* The ray of a sample, from the light, or from the plane in front of all surfaces and the medium if parallel. */
void ty_vpl_samples_ray(const ty_vpl_samples* samples, size_t texel, ty_vec* origin, ty_vec* direction);

#endif
