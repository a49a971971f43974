/* Files, content and noise of a scene, kept from one reading of it to the next: digests, volumes, maps, closed meshes,
 * textures. */
#ifndef TY_IO_ASSET_CACHE_H
#define TY_IO_ASSET_CACHE_H

#include "scene/lights/environment.h"
#include "scene/lights/sky.h"

#include <tyndall/io.h>

/* A file that was hashed; its path is that by which it is opened. */
typedef struct ty_asset_file {
    char* path;
    int64_t size, seconds, nanoseconds; /* of the file when it was hashed */
    uint64_t digest;                    /* of the file and the files that it names */
    uint64_t used;                      /* number of the last reading that used it */
} ty_asset_file;

typedef enum ty_asset_kind {
    TY_ASSET_COMPONENTS, /* values per voxel of a volume */
    TY_ASSET_GRID,
    TY_ASSET_NOISE,
    TY_ASSET_EXPONENTIAL,
    TY_ASSET_MAP,
    TY_ASSET_SKY,
    TY_ASSET_SHELL,
    TY_ASSET_CAMERA,
    TY_ASSET_TEXTURE
} ty_asset_kind;

/* Channels of an image that a texture has. */
typedef enum ty_texture_content {
    TY_TEXTURE_COLORS,    /* sRGB */
    TY_TEXTURE_NUMBERS,   /* linear */
    TY_TEXTURE_ROUGHNESS, /* linear green alone; the other channels are 1 */
    TY_TEXTURE_METALLIC   /* linear blue alone */
} ty_texture_content;

/* Density that falls off exponentially along the up axis, over heights of a box, m. */
typedef struct ty_exponential_density {
    double low, high, scale_height;
} ty_exponential_density;

/* Content, and what it was made from: fields that do not matter to its kind are zero. */
typedef struct ty_asset {
    ty_asset_kind kind;
    const ty_asset_file* file; /* NULL: computed */
    ty_volume_def volume;      /* TY_ASSET_COMPONENTS, TY_ASSET_GRID; its frame does not matter */
    ty_noise_def noise;
    ty_exponential_density exponential;
    ty_sky_def sky;
    ty_affine placement; /* TY_ASSET_SHELL, TY_ASSET_CAMERA, with to_z_up */
    bool to_z_up;
    const char* camera_name; /* TY_ASSET_CAMERA; "": the first */
    int32_t components;
    ty_grid* grid;
    double droplet_radius; /* of a grid of droplets, the mean by extinction, micrometres */
    ty_environment_map* map;
    float sun[3]; /* irradiance of a sky's sun */
    ty_closed_mesh* shell;
    ty_camera_def camera;
    bool has_camera;
    ty_texture_content content; /* TY_ASSET_TEXTURE */
    ty_texture* texture;
    uint64_t used; /* number of the last reading that used it */
} ty_asset;

typedef struct ty_asset_cache {
    ty_context* context;
    uint64_t reading; /* number of the reading; a file is looked at once in each */
    ty_asset_file** files;
    size_t file_count, file_capacity;
    ty_asset** assets;
    size_t asset_count, asset_capacity;
    ty_sky_table sky_table;
} ty_asset_cache;

void ty_assets_release(ty_asset_cache* cache);

/* Drops content that nothing else holds, and the records of its files, least recently used first, until at most
 * TY_ASSETS_SPARE_BYTES of it and TY_ASSETS_SPARE_COUNT pieces remain. */
#define TY_ASSETS_SPARE_BYTES ((size_t)1 << 30)
enum { TY_ASSETS_SPARE_COUNT = 256 };
void ty_assets_trim(ty_asset_cache* cache);

/* The record of a file, which lives until ty_assets_trim. Hashes the file if it is new, or if its size or time of
 * modification have changed since it was hashed: content made from it is dropped then. */
ty_result ty_assets_file(ty_asset_cache* cache, const char* path, const ty_asset_file** out);
/* Content made from the same as that of key; NULL if there is none. */
const ty_asset* ty_assets_find(ty_asset_cache* cache, const ty_asset* key);
/* Keeps content; the grid, map, closed mesh or texture of *asset is taken over, also on failure, and strings are
 * copied. */
ty_result ty_assets_keep(ty_asset_cache* cache, const ty_asset* asset);

#endif
