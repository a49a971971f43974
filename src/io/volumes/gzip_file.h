/* Voxel samples in gzip data of a file, inflated part by part. */
#ifndef TY_IO_GZIP_FILE_H
#define TY_IO_GZIP_FILE_H

#include "io/volumes/inflate.h"
#include "io/volumes/samples.h"

#include <stdio.h>
#include <zlib.h>

typedef struct ty_gzip_file {
    ty_context* context;
    const char* path;
    FILE* stream;
    uint64_t start, packed; /* offset of the data, and its size up to the end of the file */
    uint64_t skip;          /* inflated bytes before the first sample */
    uint64_t size;          /* of the samples */
    z_stream z;
    bool begun;
    int status;     /* of the last call of zlib */
    uint64_t left;  /* packed bytes that were not read yet */
    uint64_t at;    /* inflated bytes so far */
    uint8_t* input; /* packed bytes that were read last */
    uint8_t* bytes; /* the part that was asked for last */
    size_t capacity;
    ty_inflated fault; /* of a read that failed with TY_ERROR_INPUT and without a message; else TY_INFLATED_WHOLE */
} ty_gzip_file;

/* Opens one or several gzip (or zlib) streams from `start` on. ty_gzip_file_close must follow success. */
ty_result ty_gzip_file_open(ty_context* context, const char* path, uint64_t start, uint64_t skip, uint64_t size,
                            ty_gzip_file* file);
/* As `read` of ty_samples; user is a ty_gzip_file. Reads that go back begin anew. */
ty_result ty_gzip_file_read(void* user, size_t at, size_t size, const uint8_t** bytes);
/* Inflates the rest, and tells as ty_inflate_gzip how the data end. */
ty_inflated ty_gzip_file_finish(ty_gzip_file* file);
void ty_gzip_file_close(ty_gzip_file* file);

#endif
