/* DICOM files: a file and its frames. The bytes go through a file in memory. */
#include "fuzz_target.h"

#include "io/volumes/dicom/dicom.h"

#include "base/context.h"

/* As the reader of a series does, with one file. */
static void read_all(ty_context* context, const char* path) {
    ty_dicom dicom;
    if (ty_dicom_open(context, path, false, &dicom) == TY_OK && dicom.pixels > 0)
        for (int32_t frame = 0; frame < 4; ++frame) ty_dicom_place(&dicom, frame);
    ty_dicom_close(context, &dicom);
    if (ty_dicom_open(context, path, true, &dicom) == TY_OK &&
        ty_dicom_check_pixels(context, path, &dicom, dicom.size) == TY_OK) {
        const size_t pixels = (size_t)dicom.columns * (size_t)dicom.rows;
        float* values = ty_alloc_array(context, pixels, sizeof *values, false);
        for (int32_t frame = 0; frame < dicom.frames && frame < 4 && values != NULL; ++frame)
            ty_dicom_decode(context, path, &dicom, frame, values);
        if (values != NULL) ty_free_array(context, values, pixels, sizeof *values);
    }
    ty_dicom_close(context, &dicom);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_read_bytes(bytes, size, read_all);
}
