/* NIfTI-1 and NIfTI-2 files: header.c parses the header, nifti.c reads the voxels, nifti_write.c writes. The layouts
 * are those of nifti1.h and nifti2.h of the NIfTI Data Format Working Group. */
#ifndef TY_IO_NIFTI_H
#define TY_IO_NIFTI_H

#include "io/volumes/samples.h"

#include <tyndall/io.h>

enum { TY_NIFTI1_BYTES = 348, TY_NIFTI2_BYTES = 540 };

/* Source of the placement, in order of precedence. */
typedef enum ty_nifti_placement { TY_NIFTI_SFORM, TY_NIFTI_QFORM, TY_NIFTI_SPACING } ty_nifti_placement;

typedef struct ty_nifti {
    int version; /* 1 or 2 */
    ty_sample_type type;
    bool big_endian;
    bool pair; /* the voxels are in a file of their own, .img */
    int32_t size[3];
    int32_t channels; /* samples per voxel, side by side: 3 or 4 of colours, 2 of complex numbers */
    int32_t volumes;  /* volumes, one after another: times or components */
    size_t voxels;
    uint64_t data; /* offset of the samples in their file, bytes */
    double slope, intercept;
    ty_affine index_to_local;
    ty_nifti_placement placement;
    const char* unit; /* "m", "mm", "micron" or "" */
    char description[81];
} ty_nifti;

/* True if a file that begins with these bytes has a NIfTI header. */
bool ty_is_nifti(const uint8_t* bytes, size_t size);
/* The same of a file on disk; false if it cannot be read. */
bool ty_is_nifti_file(const char* path);
/* Parses the header at the start of bytes. */
ty_result ty_nifti_parse(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_nifti* out);
/* Path of the voxels of a pair: .img in place of .hdr, in the same case; freed with ty_free_text. NULL if memory runs
 * out. */
char* ty_nifti_image_path(ty_context* context, const char* path);

/* Writes a field of 1 or 3 components, as floats. */
ty_result ty_nifti_write_file(ty_context* context, const ty_volume_field* field, bool gzip, const char* path);

#endif
