/* Decoders of compressed frames of one sample per pixel. */
#ifndef TY_IO_DICOM_CODEC_H
#define TY_IO_DICOM_CODEC_H

#include <tyndall/base.h>

/* A compressed frame, and what the file says of it. */
typedef struct ty_dicom_packed {
    ty_context* context;
    const char* path;
    const uint8_t* bytes;
    size_t size;
    int32_t columns, rows;
    size_t sample_size; /* bytes of a decoded sample: 1, 2 or (RLE) 4 */
} ty_dicom_packed;

/* Decode a frame into columns x rows samples, in the byte order of the machine. Fail with TY_ERROR_INPUT if it is
 * damaged or has another size, or in a build without the library. */
ty_result ty_dicom_decode_rle(const ty_dicom_packed* frame, uint8_t* out);
ty_result ty_dicom_decode_jpeg(const ty_dicom_packed* frame, uint8_t* out);
ty_result ty_dicom_decode_jpeg_ls(const ty_dicom_packed* frame, uint8_t* out);
ty_result ty_dicom_decode_jpeg_2000(const ty_dicom_packed* frame, uint8_t* out);

/* Fails: the frame's own header tells another size than the file. */
ty_result ty_dicom_wrong_frame(const ty_dicom_packed* frame, int64_t columns, int64_t rows, int64_t components,
                               int64_t bits);

/* One decoder of JPEG for each precision of its samples, which is built into the library. */
ty_result ty_dicom_decode_jpeg8(const ty_dicom_packed* frame, uint8_t* out);
ty_result ty_dicom_decode_jpeg12(const ty_dicom_packed* frame, uint8_t* out);
ty_result ty_dicom_decode_jpeg16(const ty_dicom_packed* frame, uint8_t* out);

#endif
