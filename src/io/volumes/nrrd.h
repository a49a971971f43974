/* NRRD files in two parts: nrrd_header.c parses the header, nrrd.c reads the voxels. */
#ifndef TY_IO_NRRD_H
#define TY_IO_NRRD_H

#include "io/volumes/samples.h"

typedef enum ty_nrrd_encoding { TY_NRRD_RAW, TY_NRRD_GZIP, TY_NRRD_TEXT } ty_nrrd_encoding;

typedef struct ty_nrrd {
    ty_sample_type type;
    ty_nrrd_encoding encoding;
    bool big_endian;
    int32_t size[3], components;
    size_t voxels;
    bool components_last; /* true: components are the slowest axis, else the fastest */
    ty_affine index_to_local;
    int64_t line_skip, byte_skip; /* byte_skip -1: all bytes before the samples at the end of the file */
    const char* data_file;        /* in the header's text; NULL: the data follows the header */
    size_t data;                  /* offset of the end of the header */
} ty_nrrd;

/* Parses the header at the start of bytes, which end with a zero at bytes[size] and are split into lines in place. */
ty_result ty_nrrd_parse(ty_context* context, const char* path, uint8_t* bytes, size_t size, ty_nrrd* out);

#endif
