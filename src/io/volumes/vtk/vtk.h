/* Images of VTK: uniform grids with named arrays of values at points or in cells. vti_header.c reads the XML of .vti
 * files, vtk_legacy.c reads .vtk files, vti_data.c decodes arrays, vtk.c chooses one and makes a grid of it,
 * vti_pieces.c puts pieces together, and vti_write.c writes .vti files. */
#ifndef TY_IO_VTK_H
#define TY_IO_VTK_H

#include "io/file.h"
#include "io/volumes/samples.h"

#include <tyndall/io.h>

enum { TY_VTK_NAME_SIZE = 128, TY_VTK_ARRAYS_MAX = 4096, TY_VTK_COMPONENTS_MAX = 65536 };

typedef enum ty_vtk_form {
    TY_VTK_TEXT,  /* numbers in decimal */
    TY_VTK_PLAIN, /* bytes of values alone */
    TY_VTK_RAW,   /* sizes, then bytes, compressed or not */
    TY_VTK_BASE64 /* the same in base64 */
} ty_vtk_form;

typedef struct ty_vtk_array {
    char name[TY_VTK_NAME_SIZE];
    ty_sample_type type; /* TY_SAMPLE_TYPES: of values that are not read */
    bool cells;          /* a value per cell; false: per point */
    bool active;         /* the section's own choice of scalars */
    int32_t components;
    int32_t piece;     /* of a .vti file, from 0 */
    int64_t extent[6]; /* of a piece beside others */
    ty_vtk_form form;
    uint64_t at, end; /* bytes of the file that it lies in; it may end before `end` */
} ty_vtk_array;

typedef struct ty_vtk_image {
    ty_context* context;
    const char* path;
    const uint8_t* bytes; /* of the file or its beginning, with a zero behind */
    size_t size;
    bool beginning;    /* true: more bytes follow in the file */
    bool complete;     /* false: arrays may follow behind the beginning */
    int64_t extent[6]; /* of all pieces */
    int32_t pieces;    /* more than one in some .vti files */
    double origin[3], spacing[3], direction[9];
    bool big_endian, wide, compressed; /* of RAW and BASE64: sizes of 64 bits, blocks of zlib */
    ty_vtk_array* arrays;
    size_t count, capacity;
} ty_vtk_image;

/* Parse path, bytes, size and beginning of *image; ty_vtk_close must follow, whatever the result. */
ty_result ty_vti_parse(ty_vtk_image* image);
ty_result ty_vtk_legacy_parse(ty_vtk_image* image);
void ty_vtk_close(ty_vtk_image* image);
/* Appends an array; fails if there are too many. */
ty_result ty_vtk_add_array(ty_vtk_image* image, const ty_vtk_array* array);
/* Number of points, or of cells, along each axis of an extent. */
void ty_vtk_sides(const int64_t extent[6], bool cells, int64_t sides[3]);
/* Reads an array in its pieces, whose first one is array; def has size, placement and type of the whole. */
ty_result ty_vtk_read_pieces(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component,
                             const ty_grid_def* def, ty_grid** out);
/* Reads the values of one array, of def->size voxels. */
ty_result ty_vtk_read_values(const ty_vtk_image* image, const ty_vtk_array* array, int32_t component,
                             const ty_grid_plan* plan, ty_grid_def* def, ty_grid** out);
ty_result ty_vtk_damaged(const ty_vtk_image* image, const char* name, const char* what);

/* Finds the `needed` bytes of an array's values, form TEXT excepted: sets `bytes`, or `read` and `user`, of samples.
 * ty_vtk_close_reader must follow, whatever the result. */
typedef struct ty_vtk_reader ty_vtk_reader;
ty_result ty_vtk_open(const ty_vtk_image* image, const ty_vtk_array* array, size_t needed, ty_samples* samples,
                      ty_vtk_reader** out);
/* Decodes what was not read, and fails if it is damaged. */
ty_result ty_vtk_finish(ty_vtk_reader* r);
void ty_vtk_close_reader(ty_vtk_reader* r);

/* As ty_volume_read and so on, of a .vti or .vtk file. component is -1 if only arrays of one value are accepted. */
ty_result ty_vtk_read(ty_context* context, const char* path, const ty_volume_def* def, ty_grid** out);
ty_result ty_vtk_components(ty_context* context, const char* path, const ty_volume_def* def, int32_t* out);
ty_result ty_vtk_list(ty_context* context, const char* path, ty_vdb_entry* entries, int32_t capacity, int32_t* count);

/* Writes fields of one size and placement. Write errors are left to the output's commit. */
ty_result ty_vti_write_file(ty_context* context, const ty_volume_field* fields, int32_t count, bool zip,
                            ty_output* output);

#endif
