/* JPEG frames of samples of up to 8 bits. */
#include "io/volumes/dicom/codec.h"

#if TYNDALL_DICOM_JPEG

#include <stdio.h>

#include <gdcmjpeg/8/jpeglib.h>
#include <gdcmjpeg/8/jerror.h>

#define TY_JPEG_DECODER ty_dicom_decode_jpeg8
#include "io/volumes/dicom/jpeg_decoder.h"

#endif
