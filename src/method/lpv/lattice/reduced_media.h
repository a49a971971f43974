/* Media as two or three bands of spherical harmonics can hold them: a fraction f of the scattering, the forward peak of
 * the phase function, counts as unscattered, so that sigma_t' = sigma_t - f sigma_s, sigma_s' = (1 - f) sigma_s and
 * g' = (g - f) / (1 - f), and sigma_t' - g' sigma_s' is as before (delta scaling; Joseph, Wiscombe and Weinman 1976).
 * Here f is the least for which g' is at most 1/2: 2 g - 1, near the g^2 of delta-Eddington for g near 1, and 0 for
 * phase functions that two bands hold as they are. */
#ifndef TY_METHOD_LPV_LATTICE_REDUCED_MEDIA_H
#define TY_METHOD_LPV_LATTICE_REDUCED_MEDIA_H

#include "direct/media/grid_medium.h"
#include "scene/scene.h"

/* Mean cosine up to which phase functions are kept. */
#define TY_REDUCED_G_MAX 0.5f

static inline float ty_reduced_forward_fraction(float g) {
    return g > TY_REDUCED_G_MAX ? (g - TY_REDUCED_G_MAX) / (1.0f - TY_REDUCED_G_MAX) : 0.0f;
}

static inline float ty_reduced_g(float g) {
    return g > TY_REDUCED_G_MAX ? TY_REDUCED_G_MAX : g;
}

/* The scene's media, reduced; NULL each where no medium changes. */
typedef struct ty_reduced_media {
    ty_grid_medium* medium; /* on cells */
    ty_medium_view* views;  /* as many as the scene's, of which homogeneous ones alone are reduced */
    int32_t view_count;
} ty_reduced_media;

/* medium: the scene's media on cells. Errors: TY_ERROR_MEMORY. */
ty_result ty_reduced_media_create(const ty_scene* scene, const ty_grid_medium* medium, ty_reduced_media* out);
void ty_reduced_media_destroy(ty_context* context, ty_reduced_media* media);

#endif
