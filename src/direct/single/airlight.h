/* Light that media scatter once towards an eye, with sharp shadows: shadow maps say which stretches of a ray are lit;
 * over these, what homogeneous media scatter is integrated in closed form or by quadrature that converges fast, and
 * other media are taken in steps. */
#ifndef TY_DIRECT_AIRLIGHT_H
#define TY_DIRECT_AIRLIGHT_H

#include "direct/media/grid_medium.h"
#include "direct/shadow/lit.h"

typedef struct ty_airlight_def {
    const ty_grid_medium* medium; /* the scene's media on cells: where they are not homogeneous these count. Not NULL */
    const ty_lit_map* const* maps; /* of lights, one each, at most 64 */
    int32_t count;
} ty_airlight_def;

typedef struct ty_airlight ty_airlight;

/* What rays need: transmittance from lights, and so on. Keeps pointers to the scene, the medium and the maps.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
ty_result ty_airlight_create(const ty_scene* scene, const ty_airlight_def* def, ty_airlight** out);
void ty_airlight_destroy(ty_airlight* airlight);

/* A ray from an eye: where it goes (unit), how far, m, and where steps begin in media that are not homogeneous, (0, 1].
 */
typedef struct ty_air_ray {
    ty_vec direction;
    float far, offset;
} ty_air_ray;

/* Radiance, W m^-2 sr^-1, that arrives at the origin of each ray from [0, far], scattered once, extinction up to there
 * and from the light included, but not what media send by themselves; and the transmittance of the same stretch (may be
 * NULL). May be called from any thread; rays that are near one another together are faster than each by itself. */
void ty_airlight_rays(const ty_airlight* airlight, ty_vec origin, const ty_air_ray* rays, int32_t count,
                      float (*radiance)[3], float (*transmittance)[3]);
/* The same of one ray. */
void ty_airlight_ray(const ty_airlight* airlight, ty_vec origin, ty_vec direction, float far, float offset,
                     float radiance[3], float transmittance[3]);

/* Transmittance of the media between a light and a point, which surfaces do not take part in. */
void ty_airlight_reach(const ty_airlight* airlight, int32_t light, ty_vec point, float transmittance[3]);

#endif
