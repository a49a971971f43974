/* OpenEXR through its core C interface: reading into planes of the display window, writing ZIP floats. */
#define _POSIX_C_SOURCE 200809L
#include "base/context.h"
#include "io/file.h"
#include "io/image_file.h"

#include <openexr.h>
#include <string.h>
#include <tyndall/io.h>
#include <unistd.h>

enum { MESSAGE_SIZE = 256, CHANNEL_NAME_SHORT = 31 };

/* No more of a chunk than this is unpacked at once. */
static const uint64_t chunk_size_max = (uint64_t)1 << 31;

/* What the library's callbacks see. */
typedef struct stream {
    const uint8_t* bytes; /* when reading */
    size_t size;
    FILE* file; /* when writing */
    char message[MESSAGE_SIZE];
} stream;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char* text) {
    (void)code;
    void* user = NULL;
    if (exr == NULL || exr_get_user_data(exr, &user) != EXR_ERR_SUCCESS || user == NULL) return;
    stream* s = user;
    if (s->message[0] == '\0') strncpy(s->message, text, MESSAGE_SIZE - 1);
}

static int64_t read_bytes(exr_const_context_t exr, void* user, void* buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t fail) {
    (void)exr;
    (void)fail;
    const stream* s = user;
    const uint64_t left = offset < s->size ? s->size - offset : 0;
    const uint64_t count = size < left ? size : left; /* the header is read ahead, so short reads are no error */
    if (count > 0) memcpy(buffer, s->bytes + offset, count);
    return (int64_t)count;
}

static int64_t byte_count(exr_const_context_t exr, void* user) {
    (void)exr;
    return (int64_t)((const stream*)user)->size;
}

static int64_t write_bytes(exr_const_context_t exr, void* user, const void* buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail) {
    const stream* s = user;
    uint64_t done = 0;
    while (done < size) {
        const ssize_t wrote =
            pwrite(fileno(s->file), (const uint8_t*)buffer + done, size - done, (off_t)(offset + done));
        if (wrote <= 0) {
            fail(exr, EXR_ERR_WRITE_IO, "the disk is full or failed");
            return -1;
        }
        done += (uint64_t)wrote;
    }
    return (int64_t)size;
}

static exr_context_initializer_t initializer(stream* s) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.user_data = s;
    setup.read_fn = read_bytes;
    setup.size_fn = byte_count;
    setup.write_fn = write_bytes;
    setup.max_image_width = setup.max_image_height = TY_IMAGE_SIDE_MAX;
    setup.max_tile_width = setup.max_tile_height = TY_IMAGE_SIDE_MAX;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return setup;
}

static ty_result report(ty_context* context, ty_result result, const char* path, const stream* s, exr_result_t code) {
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory for OpenEXR", path);
    return ty_fail(context, result, "%s: %s", path,
                   s->message[0] != '\0' ? s->message : exr_get_default_error_message(code));
}

/* Everything about the first part that reading its pixels needs. */
typedef struct part {
    ty_context* context;
    const char* path;
    exr_context_t exr;
    stream* stream;
    exr_attr_box2i_t data, display;
    const exr_attr_chlist_t* channels;
    exr_storage_t storage;
    ty_image* image;
    exr_decode_pipeline_t decode;
    bool decoding;
    float* chunk; /* the channels' planes of one chunk, one after the other */
    size_t chunk_capacity;
} part;

static int64_t side(int32_t low, int32_t high) {
    return (int64_t)high - low + 1;
}

static ty_result inspect(part* p) {
    exr_result_t code = exr_get_storage(p->exr, 0, &p->storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(p->exr, 0, &p->data);
    if (code == EXR_ERR_SUCCESS) code = exr_get_display_window(p->exr, 0, &p->display);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(p->exr, 0, &p->channels);
    if (code != EXR_ERR_SUCCESS) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
    if (p->storage != EXR_STORAGE_SCANLINE && p->storage != EXR_STORAGE_TILED)
        return ty_fail(p->context, TY_ERROR_INPUT, "%s: deep images cannot be read", p->path);
    for (int i = 0; i < p->channels->num_channels; ++i)
        if (p->channels->entries[i].x_sampling != 1 || p->channels->entries[i].y_sampling != 1)
            return ty_fail(p->context, TY_ERROR_INPUT, "%s: channel %s is subsampled, which cannot be read", p->path,
                           p->channels->entries[i].name.str);
    const int64_t channels = p->channels->num_channels;
    ty_result result = ty_check_image_size(p->context, p->path, p->stream->size, side(p->data.min.x, p->data.max.x),
                                           side(p->data.min.y, p->data.max.y), channels);
    if (result == TY_OK)
        result = ty_check_image_size(p->context, p->path, p->stream->size, side(p->display.min.x, p->display.max.x),
                                     side(p->display.min.y, p->display.max.y), channels);
    if (result != TY_OK) return result;
    uint64_t unpacked = 0;
    code = exr_get_chunk_unpacked_size(p->exr, 0, &unpacked);
    if (code != EXR_ERR_SUCCESS) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
    if (unpacked > chunk_size_max)
        return ty_fail(p->context, TY_ERROR_INPUT, "%s: a block of pixels takes %llu bytes, more than can be read",
                       p->path, (unsigned long long)unpacked);
    return TY_OK;
}

static ty_result create_image(part* p) {
    const size_t count = (size_t)p->channels->num_channels;
    const char** names = ty_alloc_array(p->context, count, sizeof *names, false);
    if (names == NULL) return TY_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) names[i] = p->channels->entries[i].name.str;
    ty_result result =
        ty_image_create(p->context, (int32_t)side(p->display.min.x, p->display.max.x),
                        (int32_t)side(p->display.min.y, p->display.max.y), (int32_t)count, names, &p->image);
    ty_free_array(p->context, names, count, sizeof *names);
    if (result == TY_ERROR_ARGUMENT) result = TY_ERROR_INPUT; /* channel names that no image can have */
    return result;
}

/* Copies the chunk whose corner is pixel (x, y) of the file's coordinates to where it lies in the display window. */
static void place_chunk(part* p, int64_t x, int64_t y, int64_t width, int64_t height) {
    const int64_t left = x - p->display.min.x, top = y - p->display.min.y;
    const int64_t from = left < 0 ? -left : 0;
    const int64_t to = left + width > p->image->width ? p->image->width - left : width;
    if (from >= to) return;
    for (int32_t c = 0; c < p->image->channel_count; ++c) {
        float* plane = ty_image_plane(p->image, c);
        const float* source = p->chunk + (size_t)c * (size_t)(width * height);
        for (int64_t row = 0; row < height; ++row) {
            if (top + row < 0 || top + row >= p->image->height) continue;
            memcpy(plane + (top + row) * p->image->width + left + from, source + row * width + from,
                   (size_t)(to - from) * sizeof(float));
        }
    }
}

static ty_result read_chunk(part* p, const exr_chunk_info_t* info, int64_t x, int64_t y) {
    const size_t pixels = (size_t)info->width * (size_t)info->height;
    const size_t needed = pixels * (size_t)p->image->channel_count;
    if (needed > p->chunk_capacity) {
        ty_free_array(p->context, p->chunk, p->chunk_capacity, sizeof *p->chunk);
        p->chunk = ty_alloc_array(p->context, needed, sizeof *p->chunk, false);
        p->chunk_capacity = p->chunk == NULL ? 0 : needed;
        if (p->chunk == NULL) return TY_ERROR_MEMORY;
    }
    exr_result_t code = p->decoding ? exr_decoding_update(p->exr, 0, info, &p->decode)
                                    : exr_decoding_initialize(p->exr, 0, info, &p->decode);
    if (code == EXR_ERR_SUCCESS) {
        for (int i = 0; i < p->decode.channel_count; ++i) {
            exr_coding_channel_info_t* channel = &p->decode.channels[i];
            channel->decode_to_ptr = (uint8_t*)(p->chunk + (size_t)i * pixels);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = sizeof(float);
            channel->user_line_stride = info->width * (int32_t)sizeof(float);
        }
        if (!p->decoding) code = exr_decoding_choose_default_routines(p->exr, 0, &p->decode);
        p->decoding = true;
    }
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(p->exr, 0, &p->decode);
    if (code != EXR_ERR_SUCCESS) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
    place_chunk(p, x, y, info->width, info->height);
    return TY_OK;
}

static ty_result read_scanlines(part* p) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(p->exr, 0, &lines);
    if (code != EXR_ERR_SUCCESS || lines < 1) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
    for (int64_t y = p->data.min.y; y <= p->data.max.y; y += lines) {
        exr_chunk_info_t info;
        code = exr_read_scanline_chunk_info(p->exr, 0, (int)y, &info);
        if (code != EXR_ERR_SUCCESS) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
        const ty_result result = read_chunk(p, &info, p->data.min.x, y);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* The full-size level only. */
static ty_result read_tiles(part* p) {
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes(p->exr, 0, 0, 0, &width, &height);
    if (code != EXR_ERR_SUCCESS || width < 1 || height < 1)
        return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
    const int64_t across = side(p->data.min.x, p->data.max.x), down = side(p->data.min.y, p->data.max.y);
    for (int64_t y = 0; y * height < down; ++y)
        for (int64_t x = 0; x * width < across; ++x) {
            exr_chunk_info_t info;
            code = exr_read_tile_chunk_info(p->exr, 0, (int)x, (int)y, 0, 0, &info);
            if (code != EXR_ERR_SUCCESS) return report(p->context, TY_ERROR_INPUT, p->path, p->stream, code);
            const ty_result result = read_chunk(p, &info, p->data.min.x + x * width, p->data.min.y + y * height);
            if (result != TY_OK) return result;
        }
    return TY_OK;
}

static ty_result read_metadata(part* p) {
    int32_t count = 0;
    exr_get_attribute_count(p->exr, 0, &count);
    for (int32_t i = 0; i < count; ++i) {
        const exr_attribute_t* attribute = NULL;
        if (exr_get_attribute_by_index(p->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) != EXR_ERR_SUCCESS ||
            !ty_metadata_key_allowed(attribute->name))
            continue;
        ty_result result = TY_OK;
        switch (attribute->type) {
        case EXR_ATTR_STRING: result = ty_image_set_text(p->image, attribute->name, attribute->string->str); break;
        case EXR_ATTR_DOUBLE: result = ty_image_set_number(p->image, attribute->name, attribute->d); break;
        case EXR_ATTR_FLOAT: result = ty_image_set_number(p->image, attribute->name, attribute->f); break;
        case EXR_ATTR_INT: result = ty_image_set_number(p->image, attribute->name, attribute->i); break;
        default: break;
        }
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

ty_result ty_read_exr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out) {
    stream s = {.bytes = bytes, .size = size};
    const exr_context_initializer_t setup = initializer(&s);
    part p = {.context = context, .path = path, .stream = &s, .decode = EXR_DECODE_PIPELINE_INITIALIZER};
    const exr_result_t code = exr_start_read(&p.exr, path, &setup);
    if (code != EXR_ERR_SUCCESS) return report(context, TY_ERROR_INPUT, path, &s, code);
    ty_result result = inspect(&p);
    if (result == TY_OK) result = create_image(&p);
    if (result == TY_OK) result = p.storage == EXR_STORAGE_TILED ? read_tiles(&p) : read_scanlines(&p);
    if (result == TY_OK) result = read_metadata(&p);
    if (p.decoding) exr_decoding_destroy(p.exr, &p.decode);
    ty_free_array(context, p.chunk, p.chunk_capacity, sizeof *p.chunk);
    exr_finish(&p.exr);
    if (result != TY_OK) {
        ty_image_destroy(p.image);
        return result;
    }
    *out = p.image;
    return TY_OK;
}

static exr_result_t write_header(exr_context_t exr, const ty_image* image) {
    int index = 0;
    exr_result_t code = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &index);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr_simple(exr, index, image->width, image->height, EXR_COMPRESSION_ZIP);
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

static exr_result_t write_pixels(exr_context_t exr, const ty_image* image) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(exr, 0, &lines);
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool encoding = false;
    for (int32_t y = 0; code == EXR_ERR_SUCCESS && y < image->height; y += lines) {
        exr_chunk_info_t info;
        code = exr_write_scanline_chunk_info(exr, 0, y, &info);
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
        if (!encoding) code = exr_encoding_choose_default_routines(exr, 0, &encode);
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
    stream s = {.file = output.stream};
    const exr_context_initializer_t setup = initializer(&s);
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (code == EXR_ERR_SUCCESS) code = write_header(exr, image);
    if (code == EXR_ERR_SUCCESS) code = write_pixels(exr, image);
    if (exr != NULL) {
        const exr_result_t finished = exr_finish(&exr);
        if (code == EXR_ERR_SUCCESS) code = finished;
    }
    if (code == EXR_ERR_SUCCESS) return ty_output_commit(context, &output);
    ty_output_discard(context, &output);
    return report(context, TY_ERROR_FILE, path, &s, code);
}
