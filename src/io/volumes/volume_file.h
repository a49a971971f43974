/* Readers of volume files by format, and common functions. component is -1 if only grids of one value per voxel are
 * accepted. */
#ifndef TY_IO_VOLUME_FILE_H
#define TY_IO_VOLUME_FILE_H

#include <tyndall/io.h>

/* Refuses sides outside a grid's limits and more voxels than a dense grid may have; *voxels is the product. */
ty_result ty_check_volume_size(ty_context* context, const char* path, const int64_t sides[3], size_t* voxels);
/* Refuses a component that a grid with that many values per voxel does not have. */
ty_result ty_check_component(ty_context* context, const char* path, const char* name, int32_t component,
                             int32_t components);

ty_result ty_vdb_read_component(ty_context* context, const char* path, const char* name, int32_t component,
                                ty_grid** out);
ty_result ty_vdb_components(ty_context* context, const char* path, const char* name, int32_t* out);
ty_result ty_nanovdb_read(ty_context* context, const char* path, const char* name, int32_t component, ty_grid** out);
ty_result ty_nanovdb_components(ty_context* context, const char* path, const char* name, int32_t* out);
bool ty_is_nanovdb(const char* path);
/* As ty_vdb_list. */
ty_result ty_nanovdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                          int32_t* count);
ty_result ty_nrrd_read(ty_context* context, const char* path, int32_t component, ty_grid** out);
ty_result ty_nrrd_components(ty_context* context, const char* path, int32_t* out);
/* As ty_volume_read; *radius, where droplets are read, is the mean of their effective radius by extinction,
 * micrometres.
 */
ty_result ty_volume_read_droplets(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                                  ty_grid** out);
ty_result ty_raw_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out);

#endif
