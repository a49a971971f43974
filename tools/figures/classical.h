/* The classical solver of comparisons in the literature: discrete ordinates on one axis-aligned grid with the
 * environment as boundary source, radiance and scattering truncated to a few bands of spherical harmonics. */
#ifndef TY_FIGURES_CLASSICAL_H
#define TY_FIGURES_CLASSICAL_H

#include "figures/view.h"

typedef struct classical_setting {
    int32_t bands;      /* spherical harmonic bands of radiance and phase functions, 1..12 */
    int32_t resolution; /* cells along the longest side */
    int32_t directions; /* ordinates */
} classical_setting;

/* A figure_variant's render; user is a classical_setting. Only environment lights are supported. Records the time, the
 * time before the march, and iterations. */
ty_result classical_render(figure_run* run, const char* item, ty_scene* scene, const int32_t size[2], const void* user,
                           figure_picture* out);

#endif
