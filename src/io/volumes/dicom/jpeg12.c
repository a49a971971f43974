/* JPEG frames of samples of up to 12 bits. */
#include "io/volumes/dicom/codec.h"

#if TYNDALL_DICOM_JPEG

#include <stdio.h>

#include <gdcmjpeg/12/jpeglib.h>
#include <gdcmjpeg/12/jerror.h>

#define TY_JPEG_DECODER ty_dicom_decode_jpeg12
#include "io/volumes/dicom/jpeg_decoder.h"

#endif
