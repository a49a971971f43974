/* Reflective shadow maps (Dachsbacher and Stamminger 2005): what a light meets first of a scene's surfaces, texel by
 * texel, and the light that they send back.
 *
 * Each texel is one ray, somewhere in it. Directional lights have a square map across the surfaces; spot lights one of
 * their cone, point lights two of a hemisphere each (about +z and -z), in a map in which all texels are of the same
 * solid angle. All surfaces reflect diffusely and on both sides, so texels together send back what the light sends
 * them, times albedo. */
#ifndef TY_DIRECT_SHADOW_MAP_H
#define TY_DIRECT_SHADOW_MAP_H

#include "base/vector.k.h"
#include "direct/media/grid_medium.h"

typedef struct ty_shadow_texel {
    ty_vec position; /* m, off the surface by as much as rounding needs, on the side that is lit */
    ty_vec normal;   /* unit, smoothed, on that side */
    float flux[3];   /* reflected, W: as intensity flux / pi times the cosine about the normal */
    float area;      /* of the surface that the texel stands for, m^2 */
    float distance;  /* along the texel's ray, m; INFINITY: it meets nothing, and all else is 0 */
} ty_shadow_texel;

typedef struct ty_shadow_map {
    ty_context* context;
    int32_t light;           /* an index into ty_light_set.lights */
    int32_t side;            /* texels */
    int32_t faces;           /* 1; point lights: 2 */
    int32_t parallel;        /* whether rays are */
    ty_vec axis[3];          /* unit; axis[2]: the way light travels, or the middle of the first face */
    ty_vec origin;           /* parallel: where the ray of the corner 0, 0 starts; else the light; m */
    float span[2];           /* parallel: of the map, m */
    float cap;               /* else: 1 - cosine of the cone's half angle, of a face */
    float share;             /* of a texel: m^2 across the light, or sr */
    uint64_t seed;           /* of where in texels rays go */
    ty_shadow_texel* texels; /* face by face, row by row */
    double flux[3];          /* of all texels, W */
} ty_shadow_map;

typedef struct ty_shadow_map_def {
    int32_t side;                 /* texels, 1..4096 */
    const ty_grid_medium* medium; /* light is attenuated by it on its way; NULL: it is not */
    float* const* extinction;     /* as many planes as the medium has, in place of its own; NULL: its own */
    const double *lower, *upper;  /* directional lights: the map is of surfaces in this box alone, m; NULL: of all */
    uint64_t seed;
} ty_shadow_map_def;

/* The map of a directional, point or spot light of a committed scene; without surfaces nothing is met.
 * Errors: TY_ERROR_ARGUMENT (another light, def), TY_ERROR_MEMORY. *out is freed with ty_shadow_map_destroy. */
ty_result ty_shadow_map_create(const ty_scene* scene, const ty_shadow_map_def* def, int32_t light, ty_shadow_map** out);
void ty_shadow_map_destroy(ty_shadow_map* map);

size_t ty_shadow_map_count(const ty_shadow_map* map);

/* The ray of a texel, from where light starts (parallel: a plane before all surfaces and the medium). */
void ty_shadow_map_ray(const ty_shadow_map* map, size_t texel, ty_vec* origin, ty_vec* direction);

#endif
