/* Tyndall: dense scalar grids. Apache-2.0.
 *
 * A voxel's centre is at its integer index; values between centres are trilinear. Storage is x fastest:
 * value(i, j, k) = values[i + nx * (j + ny * k)]. */
#ifndef TYNDALL_GRID_H
#define TYNDALL_GRID_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A 3x4 affine map, row-major: y[r] = m[4 r] x[0] + m[4 r + 1] x[1] + m[4 r + 2] x[2] + m[4 r + 3]. */
typedef struct ty_affine {
    double m[12]; /* three rows of four */
} ty_affine;

/* x -> x. */
TY_API ty_affine ty_affine_identity(void);
/* a after b: x -> a(b(x)). */
TY_API ty_affine ty_affine_multiply(const ty_affine* a, const ty_affine* b);
/* Returns false, with *out untouched, when the map cannot be inverted. */
TY_API bool ty_affine_invert(const ty_affine* a, ty_affine* out);
/* The map of a point. */
TY_API void ty_affine_point(const ty_affine* a, const double point[3], double out[3]);
/* Scale, then rotate about x, then y, then z (degrees, counter-clockwise seen from the axis' tip), then translate. */
TY_API ty_affine ty_affine_compose(const double translate[3], const double rotate_deg[3], const double scale[3]);

/* Scalar values on a regular grid of voxels. Immutable, and shared by counting owners. */
typedef struct ty_grid ty_grid;

/* How values are stored: 32 or 16 bit. */
typedef enum ty_grid_type { TY_GRID_F32 = 0, TY_GRID_F16 = 1 } ty_grid_type;

/* What a grid is made of; made by ty_default_grid_def. */
typedef struct ty_grid_def {
    uint32_t cookie;          /* set by ty_default_grid_def; checked */
    uint32_t bytes;           /* set by ty_default_grid_def: size of the def */
    int32_t size[3];          /* voxels along x, y, z; each 1..16384, default 0 (must be set) */
    ty_grid_type type;        /* of values; default TY_GRID_F32 */
    const void* values;       /* size[0]*size[1]*size[2] values, copied; NULL (default) fills with 0 */
    ty_affine index_to_local; /* places voxel centres; metres, or units of bounds; default identity */
    bool placed;              /* true: index_to_local places the grid (VDB); false (default): the grid fills
                                 the bounds of the medium that uses it, cell i being [i, i+1]/n of the box */
    float background;         /* value outside, for placed grids; default 0 */
} ty_grid_def;

/* Fills in a ty_grid_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_grid_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_grid_def ty_default_grid_def(void) {
    ty_grid_def def;
    ty_init_grid_def(&def, sizeof def);
    return def;
}

/* Non-finite values become 0 with a warning that counts them.
 * Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY (also when the size overflows). The result has one owner. */
TY_API ty_result ty_grid_create(ty_context* context, const ty_grid_def* def, ty_grid** out);
/* Adds an owner, and returns the grid. NULL is allowed. */
TY_API ty_grid* ty_grid_retain(ty_grid* grid);
/* Removes an owner; the last one frees the grid. NULL is allowed. */
TY_API void ty_grid_destroy(ty_grid* grid);

/* What a grid is; as in ty_grid_def where nothing else is said. */
typedef struct ty_grid_info {
    int32_t size[3];          /* voxels along x, y, z */
    ty_grid_type type;        /* of values */
    bool placed;              /* whether it has a place of its own */
    float background;         /* value outside, of placed grids */
    float min, max;           /* over all voxels */
    double mean;              /* over all voxels */
    size_t bytes;             /* memory taken, tables included */
    ty_affine index_to_local; /* units as given */
} ty_grid_info;

/* Size, place, extremes and memory of a grid. */
TY_API ty_grid_info ty_grid_get_info(const ty_grid* grid);

/* The trilinear value at a point in index space; outside: background if placed, else the nearest edge value. */
TY_API float ty_grid_sample(const ty_grid* grid, const double index[3]);
/* The stored value at a voxel, which must exist. */
TY_API float ty_grid_voxel(const ty_grid* grid, int32_t i, int32_t j, int32_t k);

/* Procedural density: fractal gradient noise in the unit cube, values 0..1, as an unplaced half grid.
 * TY_NOISE_CONSTANT is 1 everywhere; TY_NOISE_FBM is noise thresholded by coverage; TY_NOISE_CLOUD is the same
 * inside a cumulus-like body (flat base, billowing top) that vanishes at the faces of the box, TY_NOISE_NEBULA inside
 * an arch with a ball alone under it, whose surfaces noise displaces and towards which the density falls off. */
typedef enum ty_noise_kind {
    TY_NOISE_CONSTANT = 0,
    TY_NOISE_FBM = 1,
    TY_NOISE_CLOUD = 2,
    TY_NOISE_NEBULA = 3
} ty_noise_kind;

/* What noise is made of; made by ty_default_noise_def. */
typedef struct ty_noise_def {
    uint32_t cookie;    /* set by ty_default_noise_def; checked */
    uint32_t bytes;     /* set by ty_default_noise_def: size of the def */
    ty_noise_kind kind; /* default TY_NOISE_CLOUD */
    int32_t size[3];    /* voxels, each 1..4096; default 96 */
    uint32_t seed;      /* default 1 */
    int32_t up_axis;    /* 1: y (default), 2: z: which way clouds and nebulae rise */
    float frequency;    /* lattice cells along the longest side at the first octave, (0, 4096]; default 4 */
    int32_t octaves;    /* 1..12; default 5. Those finer than two voxels a cell are left out */
    float gain;         /* amplitude of each octave relative to the one before, (0, 1]; default 0.5 */
    float lacunarity;   /* frequency of each octave relative to the one before, 1..4096; default 2 */
    float coverage;     /* fraction-like threshold, 0 (empty) .. 1 (full); default 0.5 */
    float sharpness;    /* slope of the edge from 0 to 1, (0, 1e6]; default 4 */
} ty_noise_def;

/* Fills in a ty_noise_def of `bytes` bytes, as ty_init_context_def does. */
TY_API void ty_init_noise_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_noise_def ty_default_noise_def(void) {
    ty_noise_def def;
    ty_init_noise_def(&def, sizeof def);
    return def;
}
/* Makes the grid, which has one owner. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY. */
TY_API ty_result ty_grid_noise(ty_context* context, const ty_noise_def* def, ty_grid** out);

#ifdef __cplusplus
}
#endif
#endif
