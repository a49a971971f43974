/* Tyndall: files. Apache-2.0.
 *
 * Writers write to a temporary name beside the target and rename, so that a target is whole or untouched.
 * Readers check every size before they allocate. Messages name the file and what is wrong with it. */
#ifndef TYNDALL_IO_H
#define TYNDALL_IO_H

#include <tyndall/base.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Radiance .hdr or OpenEXR, told by content. EXR: half, float and uint channels; metadata comes along.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_read(ty_context* context, const char* path, ty_image** out);

/* OpenEXR: all channels as 32-bit float, ZIP, with metadata. Errors: TY_ERROR_FILE, TY_ERROR_MEMORY. */
TY_API ty_result ty_image_write_exr(ty_context* context, const ty_image* image, const char* path);
/* PNG, 8-bit sRGB, through ty_image_tonemap. Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT (no RGB), TY_ERROR_MEMORY. */
TY_API ty_result ty_image_write_png(ty_context* context, const ty_image* image, double exposure, bool curve,
                                    const char* path);

/* One grid of an OpenVDB file. */
typedef struct ty_vdb_entry {
    char name[128];
    char type[32]; /* "float", "half", "vec3s", ... as the file says */
    int64_t active_voxels;
    int32_t lower[3], upper[3]; /* index box of active voxels, inclusive; lower > upper when empty */
    double voxel_size[3];
} ty_vdb_entry;

/* At most capacity entries are written; *count is how many there are. Errors: TY_ERROR_FILE, TY_ERROR_INPUT. */
TY_API ty_result ty_vdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                             int32_t* count);
/* A float or half scalar grid by name, dense over its active box, placed by the file's affine transform (index ->
 * file units). A missing grid's message lists those that are there; an empty grid gives one voxel of background.
 * Half grids stay half. Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY. */
TY_API ty_result ty_vdb_read(ty_context* context, const char* path, const char* grid_name, ty_grid** out);
/* Writes one grid (values equal to background are left inactive), codec "none", "zip" or "blosc".
 * Errors: TY_ERROR_FILE, TY_ERROR_ARGUMENT. */
TY_API ty_result ty_vdb_write(ty_context* context, const ty_grid* grid, const char* grid_name, const char* codec,
                              const char* path);

/* A scene file (docs/scene.md). overrides: override_count strings "render.spp=16", "media[0].g=0.5": a path of
 * keys, then a JSON value or a bare word; applied before the file is checked. The scene comes committed.
 * Errors: TY_ERROR_FILE, TY_ERROR_INPUT, TY_ERROR_MEMORY, TY_ERROR_ARGUMENT (an override that is not one). */
TY_API ty_result ty_scene_load(ty_context* context, const char* path, const char* const* overrides,
                               int32_t override_count, ty_scene** out);
/* The same from text; name stands for the file in messages. folder is where relative paths start: "" is the current
 * folder, and with NULL the scene may name no files. */
TY_API ty_result ty_scene_parse(ty_context* context, const char* text, size_t length, const char* name,
                                const char* folder, const char* const* overrides, int32_t override_count,
                                ty_scene** out);
/* The JSON Schema that scene files are checked against. */
TY_API const char* ty_scene_schema(void);

#ifdef __cplusplus
}
#endif
#endif
