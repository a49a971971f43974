/* NRRD files in two parts: nrrd_header.c reads what the header says, nrrd.c the voxels. */
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
    bool components_last; /* whether they are the slowest axis instead of the fastest */
    ty_affine index_to_local;
    int64_t line_skip, byte_skip; /* byte_skip -1: as many as there are too many */
    const char* data_file;        /* within the header's text; NULL: the data follows the header */
    size_t data;                  /* where the header ends */
} ty_nrrd;

/* Reads the header at the start of bytes, which end with a zero at bytes[size] and are cut into lines meanwhile. */
ty_result ty_nrrd_parse(ty_context* context, const char* path, uint8_t* bytes, size_t size, ty_nrrd* out);

#endif
