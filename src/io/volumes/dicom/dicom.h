/* DICOM files (PS3.3, PS3.5, PS3.10): elements.c parses a file's data elements, pixels.c decodes its frames, series.c
 * puts the frames of a series in order. Tags stand beside the fields as (group,element). */
#ifndef TY_IO_DICOM_H
#define TY_IO_DICOM_H

#include <tyndall/grid.h>

/* Place of a frame and the scale of its values. */
typedef struct ty_dicom_frame {
    double position[3];      /* centre of the first pixel, mm, left, posterior, superior of the patient (0020,0032) */
    double orientation[6];   /* direction along a row, and down a column (0020,0037) */
    double spacing[2];       /* between rows, and between columns, mm (0028,0030) */
    double slope, intercept; /* a value is slope times its sample plus intercept (0028,1053), (0028,1052) */
    bool has_position, has_orientation, has_spacing, has_slope, has_intercept;
} ty_dicom_frame;

typedef enum ty_dicom_coding {
    TY_DICOM_RAW,
    TY_DICOM_RLE,
    TY_DICOM_JPEG,
    TY_DICOM_JPEG_LS,
    TY_DICOM_JPEG_2000,
    TY_DICOM_UNKNOWN
} ty_dicom_coding;

/* A file's content. A text is empty and a number 0 where the file does not have the element. */
typedef struct ty_dicom {
    uint8_t* bytes; /* the file, or its first part; inflated if it was deflated */
    size_t size;
    bool whole; /* bytes go to the end of the file */

    char syntax[65]; /* transfer syntax (0002,0010) */
    ty_dicom_coding coding;
    bool explicit_vr, big_endian, deflated;

    char series[65], description[65], modality[17], photometric[17];
    int32_t series_number; /* (0020,0011) */
    int32_t columns, rows, frames, samples;
    int32_t bits_allocated, bits_stored, high_bit;
    bool is_signed;
    bool floats;               /* samples are float, or double with 64 bits allocated (7FE0,0008), (7FE0,0009) */
    double thickness, between; /* thickness of slices and spacing between them, mm (0018,0050), (0018,0088) */
    double dose_scale;         /* (3004,000E) */

    ty_dicom_frame shared;  /* what frames have in common */
    ty_dicom_frame* places; /* of each frame, if the file has them one by one */
    size_t place_count, place_capacity;
    double* offsets; /* of each frame along the normal, mm (3004,000C) */
    size_t offset_count, offset_capacity;

    size_t pixels;     /* offset of the pixel data in the (inflated) file; 0: none was found */
    size_t pixel_size; /* bytes; of encapsulated data up to the end of `bytes` */
    bool encapsulated; /* the pixel data is a sequence of fragments */
    bool words;        /* samples of 8 bits lie in words of two, in the order of their bytes */
} ty_dicom;

/* True if a file that begins with these bytes is a DICOM file. */
bool ty_is_dicom(const uint8_t* bytes, size_t size);
/* The same of a file on disk; false if it cannot be read. */
bool ty_is_dicom_file(const char* path);

/* Paths of the DICOM files in a folder, or in that of a file, by name. Freed with ty_dicom_free_list, also on failure.
 */
typedef struct ty_dicom_list {
    char** paths;
    size_t count, capacity;
} ty_dicom_list;
ty_result ty_dicom_list_files(ty_context* context, const char* path, ty_dicom_list* out);
void ty_dicom_free_list(ty_context* context, ty_dicom_list* list);

/* Opens a file and parses its elements up to the pixel data; all of it is in memory only if `pixels`, or if there was
 * no other way to find the elements. Freed with ty_dicom_close, also on failure. */
ty_result ty_dicom_open(ty_context* context, const char* path, bool pixels, ty_dicom* out);
void ty_dicom_close(ty_context* context, ty_dicom* dicom);
/* Place and scale of a frame. */
ty_dicom_frame ty_dicom_place(const ty_dicom* dicom, int32_t frame);
/* Name of the coding for people. */
const char* ty_dicom_coding_name(const ty_dicom* dicom);

/* Bytes that a sample takes. */
size_t ty_dicom_sample_size(const ty_dicom* dicom);
/* Fails if frames are not of a kind that can be decoded, or if the file is too short for its frames. */
ty_result ty_dicom_check_pixels(ty_context* context, const char* path, const ty_dicom* dicom, uint64_t file_size);
/* Decodes a frame into columns x rows values, scaled. */
ty_result ty_dicom_decode(ty_context* context, const char* path, const ty_dicom* dicom, int32_t frame, float* out);

#endif
