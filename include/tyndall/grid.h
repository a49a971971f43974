/// @file grid.h
/// Scalar grids, affine maps and procedural density.
///
/// The centre of a voxel is at its integer index, and values between centres are trilinear. Dense storage is x fastest:
/// value(i, j, k) = values[i + nx * (j + ny * k)]. Sparse grids store blocks of 8^3 voxels, one for all blocks of the
/// most common value, and paged ones have these blocks in a file; images do not depend on the storage. Apache-2.0.
#ifndef TYNDALL_GRID_H
#define TYNDALL_GRID_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A 3 x 4 affine map, row-major: y[r] = m[4 r] x[0] + m[4 r + 1] x[1] + m[4 r + 2] x[2] + m[4 r + 3].
typedef struct ty_affine {
    double m[12]; ///< Three rows of four.
} ty_affine;

/// The map x -> x.
TY_API ty_affine ty_affine_identity(void);
/// The composition x -> a(b(x)).
TY_API ty_affine ty_affine_multiply(const ty_affine* a, const ty_affine* b);
/// Stores the inverse map. Returns false, and leaves `*out` as it is, when the map is singular.
TY_API bool ty_affine_invert(const ty_affine* a, ty_affine* out);
/// Maps a point.
TY_API void ty_affine_point(const ty_affine* a, const double point[3], double out[3]);
/// The map that scales, then rotates about x, then y, then z (degrees, counter-clockwise seen from the tip of the
/// axis), then translates.
TY_API ty_affine ty_affine_compose(const double translate[3], const double rotate_deg[3], const double scale[3]);

/// Scalar values on a regular grid of voxels. A grid is immutable and reference counted.
typedef struct ty_grid ty_grid;

/// The storage of grid values.
typedef enum ty_grid_type {
    TY_GRID_F32 = 0, ///< 32-bit floats.
    TY_GRID_F16 = 1  ///< 16-bit floats.
} ty_grid_type;

/// Storage of a grid in memory.
typedef enum ty_grid_storage {
    TY_GRID_AUTO = 0,   ///< Sparse where that halves the memory and saves 16 MiB or more, else dense.
    TY_GRID_DENSE = 1,  ///< Every voxel.
    TY_GRID_SPARSE = 2, ///< Blocks of 8^3 voxels that are not all of one value, and 4 bytes for each other block.
    TY_GRID_PAGED = 3 ///< The same blocks in a file, which the operating system pages in where they are read: for grids
                      ///< larger than memory. In memory stay 12 bytes for each block. The file has no name and lies
                      ///< in the folder that the environment variable TMPDIR names, else in /tmp, or is one of bricks
                      ///< (.bricks) that was read.
} ty_grid_storage;

/// Receives the end of a loan: the library does not read the values of a grid any more. It is called once, from any
/// thread.
typedef void (*ty_grid_release_fn)(void* user);

/// The content and placement of a grid. Create it with ty_default_grid_def().
typedef struct ty_grid_def {
    uint32_t cookie;          ///< Set by ty_default_grid_def() and checked.
    uint32_t bytes;           ///< Set by ty_default_grid_def() to the size of the structure, and checked.
    int32_t size[3];          ///< Voxels along x, y, z, each 1..16384; must be set.
    ty_grid_type type;        ///< Storage of `values` and of the grid; default TY_GRID_F32.
    const void* values;       ///< size[0] * size[1] * size[2] values, copied; NULL (default): all 0.
    ty_affine index_to_local; ///< Map from voxel indices to metres, or to units of bounds; default identity.
    bool placed;              ///< True: `index_to_local` places the grid, as in VDB files. False (default): the grid
                              ///< fills the bounds of the medium that uses it, voxel i being [i, i + 1] / n of the box.
    float background;         ///< Value outside of a placed grid; default 0.
    ty_grid_release_fn release; ///< Not NULL: `values`, aligned to their size, are borrowed, not copied. They must not
                                ///< change until `release` is called: when the last reference to the grid is dropped,
                                ///< or by ty_grid_create() itself where it copies values that are not all finite.
                                ///< It is not called if ty_grid_create() fails. Default NULL.
    void* release_user;         ///< Passed on to `release`; default NULL.
} ty_grid_def;

/// Sets the `bytes` bytes of a ty_grid_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_grid_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_grid_def ty_default_grid_def(void) {
    ty_grid_def def;
    ty_init_grid_def(&def, sizeof def);
    return def;
}

/// Creates a grid with one reference. Values that are not finite become 0, with a warning that counts them. The arrays
/// of `def` may be freed after the call, unless they are lent by def->release.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY (also when the size overflows).
TY_API ty_result ty_grid_create(ty_context* context, const ty_grid_def* def, ty_grid** out);
/// Adds a reference and returns the grid; NULL is allowed.
TY_API ty_grid* ty_grid_retain(ty_grid* grid);
/// Drops a reference; the last one frees the grid. NULL is allowed. A scene holds references to its grids, so the
/// caller's own may be released as soon as the medium was added.
TY_API void ty_grid_release(ty_grid* grid);

/// The properties of a grid.
typedef struct ty_grid_info {
    int32_t size[3];          ///< Voxels along x, y, z.
    ty_grid_type type;        ///< Storage of values.
    bool placed;              ///< True: the grid has a placement of its own.
    float background;         ///< Value outside of a placed grid.
    float min;                ///< Minimum over all voxels.
    float max;                ///< Maximum over all voxels.
    double mean;              ///< Mean over all voxels.
    size_t bytes;             ///< Memory of the grid with its tables; of a paged one, of its tables.
    ty_affine index_to_local; ///< Map from voxel indices to the units that were given.
    ty_grid_storage storage;  ///< TY_GRID_DENSE, TY_GRID_SPARSE or TY_GRID_PAGED.
    int64_t active;           ///< Voxels that differ from the background.
    int64_t stored;           ///< Stored values: all voxels of a dense grid, 512 per block of a sparse or paged one.
} ty_grid_info;

/// Size, placement, range and memory of a grid.
TY_API ty_grid_info ty_grid_get_info(const ty_grid* grid);

/// The same values in another storage: the grid itself, with one more reference, where it is stored so, and by
/// TY_GRID_AUTO where it is sparse or paged. Values, extremes and images are the same to the last bit.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY, TY_ERROR_FILE (no space on the disk for a paged grid).
TY_API ty_result ty_grid_store(ty_context* context, ty_grid* grid, ty_grid_storage storage, ty_grid** out);

/// The values of a dense grid, of its type, x fastest, valid as long as the grid; NULL of a sparse or paged one, which
/// ty_grid_store() makes dense.
TY_API const void* ty_grid_values(const ty_grid* grid);
/// The trilinear value at a point in index space. Outside, the value is the background of a placed grid, or that of the
/// nearest edge.
TY_API float ty_grid_sample(const ty_grid* grid, const double index[3]);
/// The stored value at a voxel, which must exist.
TY_API float ty_grid_voxel(const ty_grid* grid, int32_t i, int32_t j, int32_t k);

/// The shape of procedural density: fractal gradient noise in the unit cube with values 0..1.
typedef enum ty_noise_kind {
    TY_NOISE_CONSTANT = 0, ///< 1 everywhere.
    TY_NOISE_FBM = 1,      ///< Noise above a threshold that `coverage` sets.
    TY_NOISE_CLOUD = 2, ///< The same inside a cumulus with a flat base and a billowing top, 0 at the faces of the box.
    TY_NOISE_NEBULA = 3 ///< The same inside an arch with a separate ball under it; noise displaces their surfaces, and
                        ///< the density falls off towards these.
} ty_noise_kind;

/// The options of procedural density. Create it with ty_default_noise_def().
typedef struct ty_noise_def {
    uint32_t cookie;    ///< Set by ty_default_noise_def() and checked.
    uint32_t bytes;     ///< Set by ty_default_noise_def() to the size of the structure, and checked.
    ty_noise_kind kind; ///< Default TY_NOISE_CLOUD.
    int32_t size[3];    ///< Voxels along x, y, z, each 1..4096; default 96.
    uint32_t seed;      ///< Default 1.
    int32_t up_axis;    ///< The axis along which clouds and nebulae rise: 1 for y (default), 2 for z.
    float frequency;    ///< Lattice cells along the longest side in the first octave, (0, 4096]; default 4.
    int32_t octaves;    ///< 1..12; default 5. Octaves with lattice cells below two voxels are left out.
    float gain;         ///< Amplitude of each octave relative to the one before, (0, 1]; default 0.5.
    float lacunarity;   ///< Frequency of each octave relative to the one before, 1..4096; default 2.
    float coverage;     ///< Threshold of density from 0 (empty) to 1 (full); default 0.5.
    float sharpness;    ///< Slope of the edge from 0 to 1, (0, 1e6]; default 4.
} ty_noise_def;

/// Sets the `bytes` bytes of a ty_noise_def to the defaults, as ty_init_context_def() does.
TY_API void ty_init_noise_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_noise_def ty_default_noise_def(void) {
    ty_noise_def def;
    ty_init_noise_def(&def, sizeof def);
    return def;
}
/// Creates an unplaced half-float grid of procedural density, with one reference.
/// Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_grid_create_noise(ty_context* context, const ty_noise_def* def, ty_grid** out);
/// Creates an unplaced grid, one voxel wide, of exp(-h / scale_height) along an axis (0 x, 1 y, 2 z) of the box that it
/// fills, with h rising from `low` to `high` between the box's faces; all in metres, or any other unit. low is at least
/// -20 scale heights. Errors: TY_ERROR_ARGUMENT, TY_ERROR_MEMORY.
TY_API ty_result ty_grid_create_exponential(ty_context* context, int32_t axis, double low, double high,
                                            double scale_height, ty_grid** out);

#ifdef __cplusplus
}
#endif
#endif
