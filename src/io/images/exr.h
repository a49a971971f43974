/* Common parts of reading and writing OpenEXR: file access for the core C library, and error messages. */
#ifndef TY_IO_EXR_H
#define TY_IO_EXR_H

#include "image/image.h"
#include "io/file.h"

#include <openexr.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TY_EXR_MESSAGE_SIZE = 256 };

/* User data of the library's callbacks. */
typedef struct ty_exr_stream {
    const uint8_t* bytes; /* reading */
    size_t size;
    ty_output* output;   /* writing */
    bool out_of_memory;  /* an allocation failed, of which the library does not always tell */
    size_t refused_size; /* bytes of the allocation that failed last */
    char message[TY_EXR_MESSAGE_SIZE];
} ty_exr_stream;

/* Initializer of a context for reading or writing on the calling thread. The stream must outlive the context;
 * ty_exr_stream_end follows exr_finish. */
exr_context_initializer_t ty_exr_initializer(ty_exr_stream* stream);
void ty_exr_stream_end(void);
/* Fails with the library's first message about the stream, or with the text of the error code. */
ty_result ty_exr_fail(ty_context* context, ty_result result, const char* path, const ty_exr_stream* stream,
                      exr_result_t code);

/* A part compressed as DWAA or DWAB, which the core library does not decode. */
typedef struct ty_exr_dwa_part {
    int index;
    exr_attr_box2i_t data;
    const exr_attr_chlist_t* channels;
    int32_t first_channel; /* index of its first channel in the image */
    int32_t x0, y0;        /* the image's first pixel in file coordinates */
} ty_exr_dwa_part;

ty_result ty_exr_read_dwa(ty_context* context, const char* path, const ty_exr_stream* stream,
                          const ty_exr_dwa_part* part, ty_image* image);

/* Reads an image of luminance and subsampled chroma (Y, RY, BY, and A if alpha is true), which is its only part, as the
 * planes B, G, R, preceded by A. The image has the size of the data window. */
ty_result ty_exr_read_chroma(ty_context* context, const char* path, const ty_exr_stream* stream,
                             const exr_attr_box2i_t* data, bool alpha, ty_image* image);

#ifdef __cplusplus
}
#endif
#endif
