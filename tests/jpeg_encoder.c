/* Encoder of JPEG frames of one precision, JPEG_BITS, for test_dicom.c. */
#include <stdio.h>

#if JPEG_BITS == 8
#include <gdcmjpeg/8/jpeglib.h>
#define encode_jpeg encode_jpeg8
#elif JPEG_BITS == 12
#include <gdcmjpeg/12/jpeglib.h>
#define encode_jpeg encode_jpeg12
#else
#include <gdcmjpeg/16/jpeglib.h>
#define encode_jpeg encode_jpeg16
#endif

#include "dicom_encoders.h"

static void ignore_destination(j_compress_ptr jpeg) {
    (void)jpeg;
}

static boolean refuse_more(j_compress_ptr jpeg) {
    jpeg->err->error_exit((j_common_ptr)jpeg); /* ends the program */
    return FALSE;
}

size_t encode_jpeg(const int64_t* samples, bool lossless, uint8_t* out, size_t size) {
    enum { QUALITY = 100 };
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_destination_mgr destination = {.next_output_byte = out,
                                               .free_in_buffer = size,
                                               .init_destination = ignore_destination,
                                               .empty_output_buffer = refuse_more,
                                               .term_destination = ignore_destination};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg.dest = &destination;
    jpeg.image_width = ENCODED_WIDTH;
    jpeg.image_height = ENCODED_HEIGHT;
    jpeg.input_components = 1;
    jpeg.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, QUALITY, FALSE);
    if (lossless) jpeg_simple_lossless(&jpeg, 1, 0);
    jpeg_start_compress(&jpeg, TRUE);
    for (int j = 0; j < ENCODED_HEIGHT; ++j) {
        JSAMPLE row[ENCODED_WIDTH];
        JSAMPROW rows[1] = {row};
        for (int i = 0; i < ENCODED_WIDTH; ++i) row[i] = (JSAMPLE)samples[j * ENCODED_WIDTH + i];
        jpeg_write_scanlines(&jpeg, rows, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return size - destination.free_in_buffer;
}
