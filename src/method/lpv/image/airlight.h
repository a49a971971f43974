/* Airlight: single scattering towards an eye with sharp shadows. Shadow maps give the lit segments of a ray; the
 * radiance scattered on a segment is integrated in closed form or by fast converging quadrature in homogeneous media,
 * and in steps in heterogeneous media.
 *
 * The shared marcher (image/march/march) with uncollided light on cells (direct/uncollided, direct/single/single.k.h)
 * computes the same quantity; docs/method/lpv.md compares both in accuracy and time. */
#ifndef TY_METHOD_LPV_IMAGE_AIRLIGHT_H
#define TY_METHOD_LPV_IMAGE_AIRLIGHT_H

#include "direct/shadow/shadow_hierarchy.h"
#include "method/lpv/lattice/reduced_media.h"

typedef struct ty_airlight_def {
    const ty_grid_medium* medium; /* the scene's media on cells, used if any of them is heterogeneous; not NULL */
    const ty_shadow_hierarchy* const* maps; /* one per light, at most 64 */
    int32_t count;
    const ty_reduced_media* reduced; /* between the lights and where their light scatters; NULL: the scene's media */
} ty_airlight_def;

typedef struct ty_airlight ty_airlight;

/* Precomputes the transmittance from the lights. Keeps pointers to the scene, the medium and the maps. Errors:
 * TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_airlight_create(const ty_scene* scene, const ty_airlight_def* def, ty_airlight** out);
void ty_airlight_destroy(ty_airlight* airlight);

/* A ray from an eye: its unit direction, its length, m, and the offset of its first step in heterogeneous media, (0,
 * 1]. */
typedef struct ty_eye_ray {
    ty_vec direction;
    float far, offset;
} ty_eye_ray;

/* Radiance, W m^-2 sr^-1, of the lights' light that scatters towards the eye, single scattering without reduced media,
 * that arrives at the origin from [0, far] of each ray, attenuated on both the
 * path from the light and the path to the eye, without the media's emission; and the transmittance of [0, far] (may be
 * NULL). Callable from any thread; a packet of coherent rays is faster than single rays. */
void ty_airlight_rays(const ty_airlight* airlight, ty_vec origin, const ty_eye_ray* rays, int32_t count,
                      float (*radiance)[3], float (*transmittance)[3]);
/* The same for one ray. */
void ty_airlight_ray(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                     float radiance[3], float transmittance[3]);

/* Transmittance of the media between a light and a point; surfaces are ignored. */
void ty_airlight_transmittance(const ty_airlight* airlight, int32_t light, ty_vec point, float transmittance[3]);

#endif
