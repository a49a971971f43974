/* Writing OpenEXR: all channels as ZIP-compressed floats. */
#include "io/images/exr.h"

#include "base/context.h"

#include <string.h>
#include <tyndall/io.h>

enum { CHANNEL_NAME_SHORT = 31 };

/* The library's default chunk compressor. */
typedef struct chunk_compressor {
    exr_result_t (*compress)(exr_encode_pipeline_t* encode);
} chunk_compressor;

static exr_result_t write_header(exr_context_t exr, const ty_image* image) {
    int index = 0;
    exr_result_t code = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &index);
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    const ty_window window = ty_image_window(image);
    const exr_attr_box2i_t data = {
        .min.x = window.x0, .min.y = window.y0, .max.x = window.x1 - 1, .max.y = window.y1 - 1};
    const exr_attr_box2i_t display = {.max.x = image->frame[2] - 1, .max.y = image->frame[3] - 1};
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr(exr, index, &display, &data, 1, &centre, 1, EXR_LINEORDER_INCREASING_Y,
                                            EXR_COMPRESSION_ZIP);
    bool long_names = false;
    for (int32_t i = 0; i < image->channel_count; ++i) long_names |= strlen(image->names[i]) > CHANNEL_NAME_SHORT;
    if (code == EXR_ERR_SUCCESS && long_names) code = exr_set_longname_support(exr, 1);
    for (int32_t i = 0; code == EXR_ERR_SUCCESS && i < image->channel_count; ++i)
        code = exr_add_channel(exr, index, image->names[i], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    for (size_t i = 0; code == EXR_ERR_SUCCESS && i < image->metadata_count; ++i) {
        const ty_metadata* entry = &image->metadata[i];
        code = entry->is_number ? exr_attr_set_double(exr, index, entry->key, entry->number)
                                : exr_attr_set_string(exr, index, entry->key, entry->text);
    }
    if (code == EXR_ERR_SUCCESS) code = exr_write_header(exr);
    return code;
}

/* A chunk with the length of its pixels counts as uncompressed. If ZIP yields exactly that length, which happens
 * with noise, the chunk must hold the raw pixels; the core of OpenEXR 3.1 stores ZIP's bytes. */
static exr_result_t compress_unambiguously(exr_encode_pipeline_t* encode) {
    const chunk_compressor* compressor = encode->encoding_user_data;
    const exr_result_t code = compressor->compress(encode);
    if (code == EXR_ERR_SUCCESS && encode->compressed_bytes == encode->packed_bytes)
        memcpy(encode->compressed_buffer, encode->packed_buffer, encode->packed_bytes);
    return code;
}

static exr_result_t write_pixels(exr_context_t exr, const ty_image* image) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(exr, 0, &lines);
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    chunk_compressor compressor = {NULL};
    bool encoding = false;
    for (int32_t y = 0; code == EXR_ERR_SUCCESS && y < image->height; y += lines) {
        exr_chunk_info_t info;
        code = exr_write_scanline_chunk_info(exr, 0, image->frame[1] + y, &info);
        if (code != EXR_ERR_SUCCESS) break;
        code = encoding ? exr_encoding_update(exr, 0, &info, &encode) : exr_encoding_initialize(exr, 0, &info, &encode);
        if (code != EXR_ERR_SUCCESS) break;
        for (int i = 0; i < encode.channel_count; ++i) {
            exr_coding_channel_info_t* channel = &encode.channels[i];
            const float* plane = ty_image_plane_const(image, ty_image_find_channel(image, channel->channel_name));
            channel->encode_from_ptr = (const uint8_t*)(plane + (size_t)y * (size_t)image->width);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = sizeof(float);
            channel->user_line_stride = image->width * (int32_t)sizeof(float);
        }
        if (!encoding) {
            code = exr_encoding_choose_default_routines(exr, 0, &encode);
            compressor.compress = encode.compress_fn;
            encode.encoding_user_data = &compressor;
            encode.compress_fn = compress_unambiguously;
        }
        encoding = true;
        if (code == EXR_ERR_SUCCESS) code = exr_encoding_run(exr, 0, &encode);
    }
    if (encoding) exr_encoding_destroy(exr, &encode);
    return code;
}

ty_result ty_image_write_exr(ty_context* context, const ty_image* image, const char* path) {
    if (image == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "ty_image_write_exr: the image is NULL");
    ty_output output;
    const ty_result result = ty_output_open(context, path, &output);
    if (result != TY_OK) return result;
    ty_exr_stream s = {.output = &output};
    const exr_context_initializer_t setup = ty_exr_initializer(&s);
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (code == EXR_ERR_SUCCESS) code = write_header(exr, image);
    if (code == EXR_ERR_SUCCESS) code = write_pixels(exr, image);
    if (exr != NULL) {
        const exr_result_t finished = exr_finish(&exr);
        if (code == EXR_ERR_SUCCESS) code = finished;
    }
    ty_exr_stream_end();
    if (code == EXR_ERR_SUCCESS && s.out_of_memory) code = EXR_ERR_OUT_OF_MEMORY;
    if (code == EXR_ERR_SUCCESS || output.error != 0) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return ty_exr_fail(context, TY_ERROR_FILE, path, &s, code);
}
