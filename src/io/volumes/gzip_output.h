/* Output of voxels: into the file as they are, or through deflate into a member of gzip. */
#ifndef TY_IO_GZIP_OUTPUT_H
#define TY_IO_GZIP_OUTPUT_H

#include "io/file.h"

#include <tyndall/grid.h>
#include <zlib.h>

typedef struct ty_gzip_output {
    ty_output* output;
    bool gzip;
    z_stream z;
    uint8_t packed[1 << 16];
} ty_gzip_output;

/* NULL, with a message, if memory runs out. Write errors are left to the output's commit. */
ty_gzip_output* ty_gzip_begin(ty_context* context, ty_output* output, bool gzip);
bool ty_gzip_put(ty_gzip_output* g, const void* bytes, size_t size);
/* Puts the voxels of a grid as floats, x fastest. */
ty_result ty_gzip_put_voxels(ty_context* context, ty_gzip_output* g, const ty_grid* grid);
/* Ends the member, and frees; NULL is allowed. */
void ty_gzip_end(ty_context* context, ty_gzip_output* g);

#endif
