/* Light cache of the media as kernels see it: cells with light from all directions, and surfels on the surfaces in
 * them. */
#ifndef TY_BAKE_GATHER_CACHE_VIEW_H
#define TY_BAKE_GATHER_CACHE_VIEW_H

#include <stdint.h>

enum { TY_CACHE_CELLS_MAX = 512 };

/* Light arriving in a cell, split into direct light and all other light. Each kind stores the mean radiance over all
 * directions in red, green and blue; for anisotropic media also the unit vector of its mean direction of incidence and
 * the length of the mean direction, 0..1, per channel where media are not gray. */
enum { TY_CACHE_ISOTROPIC = 3, TY_CACHE_GRAY = 7, TY_CACHE_COLORED = 9 };
enum { TY_CACHE_DIRECT = 0, TY_CACHE_INDIRECT = 1, TY_CACHE_KINDS = 2 };

/* A surfel: light scattered by media (once and otherwise untouched, and all other) on the surfaces in a cell, one
 * record per dominant normal axis, averaged over paths from surface points. Floats: mean position and normal;
 * irradiance and vector irradiance per kind and channel; variance of the total irradiance per channel; number of paths
 * in the mean. */
enum { TY_SURFEL_SINGLE = 0, TY_SURFEL_MULTIPLE = 1, TY_SURFEL_KINDS = 2, TY_SURFEL_TERMS = 4, TY_SURFEL_AXES = 6 };
enum { TY_SURFEL_POSITION = 0, TY_SURFEL_NORMAL = 3, TY_SURFEL_IRRADIANCE = 6 };
enum {
    TY_SURFEL_IRRADIANCE_FLOATS = TY_SURFEL_KINDS * 3 * TY_SURFEL_TERMS,
    TY_SURFEL_VARIANCE = TY_SURFEL_IRRADIANCE + TY_SURFEL_IRRADIANCE_FLOATS
};
enum { TY_SURFEL_PATHS = TY_SURFEL_VARIANCE + 3, TY_SURFEL_FLOATS = TY_SURFEL_PATHS + 1 };

/* A cell intersected by surfaces has two sides: the region visible from its center, and the rest, represented by one
 * anchor point. Flags of a cell: one bit per side with known light, and one bit that requires a visibility test to an
 * anchor before a lookup. */
enum { TY_CACHE_SIDES = 2, TY_CACHE_TEST_VISIBILITY = 1 << TY_CACHE_SIDES };

typedef struct ty_cache_view {
    float lower[3], per_metre;
    int32_t size[3];
    int32_t floats;              /* per kind of light: TY_CACHE_ISOTROPIC, _GRAY or _COLORED */
    float* light;                /* of the first side, cell by cell, both kinds */
    float* second_light;         /* of the second side */
    float* anchor;               /* per cell the anchor positions of both sides, 3 floats each */
    const uint8_t* flags;        /* per cell */
    const uint8_t* surfel_axes;  /* per cell, bits of the normal axes of its surfels; NULL: not known yet */
    const int32_t* first_surfel; /* per cell, the index of the first of its surfels, one per bit */
    float* surfels;              /* TY_SURFEL_FLOATS each */
} ty_cache_view;

#endif
