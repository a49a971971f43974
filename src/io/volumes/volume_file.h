/* Readers of volume files by format, and common functions. component is -1 if only grids of one value per voxel are
 * accepted. */
#ifndef TY_IO_VOLUME_FILE_H
#define TY_IO_VOLUME_FILE_H

#include "grid/grid.h"

#include <tyndall/io.h>

/* Refuses sides outside a grid's limits and more voxels than a dense grid may have; *voxels is the product. */
ty_result ty_check_volume_size(ty_context* context, const char* path, const int64_t sides[3], size_t* voxels);
/* The same for grids that may span more: those in a sparse tree, and more so paged ones. */
ty_result ty_check_volume_storage(ty_context* context, const char* path, ty_grid_storage storage, bool in_tree,
                                  const int64_t sides[3], size_t* voxels);
/* Refuses a component that a grid with that many values per voxel does not have. */
ty_result ty_check_component(ty_context* context, const char* path, const char* name, int32_t component,
                             int32_t components);

/* The plan of the grid of a def: its part, and a storage on the way, TY_GRID_AUTO or TY_GRID_PAGED. */
ty_grid_plan ty_volume_plan(const ty_volume_def* def);
/* The storage whose limits of size a plan has: parts may span as much as paged grids. */
ty_grid_storage ty_plan_limits(const ty_grid_plan* plan);

/* Readers that take a plan make no dense array on the way to a paged grid or a part. */
ty_result ty_vdb_read_component(ty_context* context, const char* path, const char* name, int32_t component,
                                const ty_grid_plan* plan, ty_grid** out);
ty_result ty_vdb_components(ty_context* context, const char* path, const char* name, int32_t* out);
ty_result ty_nanovdb_read(ty_context* context, const char* path, const char* name, int32_t component,
                          const ty_grid_plan* plan, ty_grid** out);
ty_result ty_nanovdb_components(ty_context* context, const char* path, const char* name, int32_t* out);
bool ty_is_nanovdb(const char* path);
/* As ty_vdb_list. */
ty_result ty_nanovdb_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity,
                          int32_t* count);
ty_result ty_nrrd_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                       ty_grid** out);
ty_result ty_nrrd_components(ty_context* context, const char* path, int32_t* out);
/* As ty_volume_read; *radius, where droplets are read, is the mean of their effective radius by extinction,
 * micrometres.
 */
ty_result ty_volume_read_droplets(ty_context* context, const char* path, const ty_volume_def* def, double* radius,
                                  ty_grid** out);
ty_result ty_raw_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out);

ty_result ty_dicom_read(ty_context* context, const char* path, const char* name, int32_t component,
                        const ty_grid_plan* plan, ty_grid** out);
ty_result ty_dicom_components(ty_context* context, const char* path, const char* series, int32_t* out);
ty_result ty_nifti_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                        ty_grid** out);
ty_result ty_nifti_components(ty_context* context, const char* path, int32_t* out);
ty_result ty_tiff_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                       ty_grid** out);
ty_result ty_tiff_components(ty_context* context, const char* path, int32_t* out);
ty_result ty_mitsuba_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                          ty_grid** out);
ty_result ty_mitsuba_components(ty_context* context, const char* path, int32_t* out);

/* Files of bricks (bricks.c): a grid as TY_GRID_PAGED keeps it, mapped where it is read. */
ty_result ty_bricks_read(ty_context* context, const char* path, ty_grid** out);
ty_result ty_bricks_write(ty_context* context, const ty_grid* grid, const char* path);
/* Extends *hash by the head of a file of bricks, in which there is a hash of the rest; false for other files. */
bool ty_bricks_hash(const char* path, uint64_t* hash);

/* Formats that tell more than their voxels, for `tyndall info`. */
enum { TY_VOLUME_NOTES_MAX = 12 };
typedef struct ty_volume_note {
    char name[16], text[160];
} ty_volume_note;
typedef struct ty_volume_notes {
    int32_t count;
    ty_volume_note items[TY_VOLUME_NOTES_MAX];
} ty_volume_notes;

/* Adds a note; text is cut to its room. */
void ty_note(ty_volume_notes* notes, const char* name, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* Notes about the volume that ty_volume_read reads; none for formats without, and for files that cannot be read. */
void ty_volume_describe(ty_context* context, const char* path, const ty_volume_def* def, ty_volume_notes* notes);
void ty_dicom_describe(ty_context* context, const char* path, const char* name, ty_volume_notes* notes);
void ty_nifti_describe(ty_context* context, const char* path, ty_volume_notes* notes);
void ty_tiff_describe(ty_context* context, const char* path, ty_volume_notes* notes);
void ty_mitsuba_describe(ty_context* context, const char* path, ty_volume_notes* notes);

/* Format of a file by its content, or by its name where the content does not tell. */
typedef enum ty_volume_format {
    TY_VOLUME_VDB,
    TY_VOLUME_NANOVDB,
    TY_VOLUME_NRRD,
    TY_VOLUME_VTK,
    TY_VOLUME_NETCDF,
    TY_VOLUME_DICOM, /* also folders */
    TY_VOLUME_NIFTI,
    TY_VOLUME_TIFF,
    TY_VOLUME_MITSUBA,
    TY_VOLUME_BRICKS,
    TY_VOLUME_RAW
} ty_volume_format;
/* True if a path ends with an extension, such as ".vdb", in any case. */
bool ty_volume_has_extension(const char* path, const char* extension);

/* Format by the first bytes of a file (TY_VOLUME_HEAD of them are enough), else by its name. */
enum { TY_VOLUME_HEAD = 544 };
ty_volume_format ty_volume_format_of(const char* path, const uint8_t* head, size_t size);

#endif
