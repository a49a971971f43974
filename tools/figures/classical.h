/* The classical solver that methods were compared with: discrete ordinates on one grid along the scene's axes, into
 * which an environment comes through the faces, radiance and scattering cut off after a few bands of spherical
 * harmonics. */
#ifndef TY_FIGURES_CLASSICAL_H
#define TY_FIGURES_CLASSICAL_H

#include "figures/view.h"

typedef struct classical_setting {
    int32_t bands;      /* of radiance and phase functions, 1..12 */
    int32_t resolution; /* cells along the longest side */
    int32_t directions; /* ordinates */
} classical_setting;

/* A figure_variant's render with a classical_setting, which user is. Of lights only environments are seen. Notes the
 * time, that before the march and iterations. */
ty_result classical_render(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                           figure_picture* out);

#endif
