/* Raw voxel samples in a file, read part by part. */
#ifndef TY_IO_SAMPLE_FILE_H
#define TY_IO_SAMPLE_FILE_H

#include "io/volumes/samples.h"

#include <stdio.h>

typedef struct ty_sample_file {
    ty_context* context;
    const char* path;
    FILE* stream;
    uint64_t start; /* offset of the first sample */
    uint8_t* bytes; /* the part that was read last */
    size_t capacity;
} ty_sample_file;

ty_result ty_sample_file_open(ty_context* context, const char* path, uint64_t start, ty_sample_file* file);
/* As `read` of ty_samples; user is a ty_sample_file. */
ty_result ty_sample_file_read(void* user, size_t at, size_t size, const uint8_t** bytes);
void ty_sample_file_close(ty_sample_file* file);

#endif
