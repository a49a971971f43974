/* Volumes, meshes and images that a program gives a scene in memory, under the names "memory:NAME" in place of files.
 */
#ifndef TY_IO_MEMORY_FILES_H
#define TY_IO_MEMORY_FILES_H

#include "io/scenes/asset_cache.h"

/* One of them; the others are NULL. */
typedef struct ty_memory_file {
    ty_asset_file file; /* whose path is "memory:NAME", and whose digest is that of the content */
    ty_grid* grids[3];  /* one value per voxel, or red, green and blue */
    int32_t grid_count;
    ty_image* image; /* an environment's map, or a texture: R, G, B, and A where the program gave it */
    ty_scene* mesh;  /* a scene of this mesh alone */
} ty_memory_file;

/* True for "memory:NAME". */
bool ty_is_memory_name(const char* path);

/* The record of a name; fails for names that were not given. */
ty_result ty_memory_find(const ty_asset_cache* cache, const char* path, const ty_asset_file** out);

/* Keep content under "memory:NAME" in place of earlier content, of which *replaced tells; they retain grids and copy
 * the rest. */
ty_result ty_memory_set_volume(ty_asset_cache* cache, const char* name, ty_grid* const* grids, int32_t count,
                               bool* replaced);
ty_result ty_memory_set_mesh(ty_asset_cache* cache, const char* name, const ty_mesh_def* def, bool* replaced);
ty_result ty_memory_set_image(ty_asset_cache* cache, const char* name, const ty_image* image, bool* replaced);
/* Forgets a name, if it is there. */
void ty_memory_drop(ty_asset_cache* cache, const char* name);
/* Forgets all. */
void ty_memory_release(ty_asset_cache* cache);

/* Uses of the content of a record with `memory`. Errors: TY_ERROR_INPUT for content of another kind. */
ty_result ty_memory_components(const ty_asset_cache* cache, const ty_asset_file* file, int32_t* components);
ty_result ty_memory_grid(const ty_asset_cache* cache, const ty_asset_file* file, int32_t component, ty_grid** out);
/* *out is a copy of R, G, B. */
ty_result ty_memory_image(const ty_asset_cache* cache, const ty_asset_file* file, ty_image** out);
/* Texels of an image, whose values count from 0 to 1: colours are encoded as sRGB, other numbers linearly; without A it
 * is 1. *rgba8 is freed with ty_free_array(). */
ty_result ty_memory_texels(const ty_asset_cache* cache, const ty_asset_file* file, bool colors, int32_t* width,
                           int32_t* height, uint8_t** rgba8);
/* Of def, transform, meshes and material count. */
ty_result ty_memory_add_mesh(const ty_asset_cache* cache, const ty_asset_file* file, const ty_mesh_file_def* def,
                             ty_scene* scene);
ty_result ty_memory_closed_mesh(const ty_asset_cache* cache, const ty_asset_file* file, const ty_mesh_file_def* def,
                                ty_closed_mesh** out);

#endif
