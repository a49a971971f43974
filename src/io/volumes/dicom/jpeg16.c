/* JPEG frames of samples of up to 16 bits. */
#include "io/volumes/dicom/codec.h"

#if TYNDALL_DICOM_JPEG

#include <stdio.h>

#include <gdcmjpeg/16/jpeglib.h>
#include <gdcmjpeg/16/jerror.h>

#define TY_JPEG_DECODER ty_dicom_decode_jpeg16
#include "io/volumes/dicom/jpeg_decoder.h"

#endif
