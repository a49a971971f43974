/* Reading OpenEXR: the channels of all parts as floats over the union of the parts' data windows. */
#include "io/images/exr.h"
#include "io/images/image_file.h"

#include "base/context.h"

#include <string.h>

/* Limit of an unpacked chunk: tiles may be declared far larger than the image at no cost in file size. */
static uint64_t chunk_size_max(size_t file_size) {
    const uint64_t max_size = (uint64_t)1 << 31, expected = ((uint64_t)1 << 26) + ((uint64_t)file_size << 10);
    return expected < max_size ? expected : max_size;
}

/* A part of the file, and the index of its first channel in the image. */
typedef struct part {
    int index;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t data, display;
    const exr_attr_chlist_t* channels;
    int32_t first_channel;
} part;

typedef struct reader {
    ty_context* context;
    const char* path;
    exr_context_t exr;
    ty_exr_stream stream;
    part* parts;
    size_t part_count;
    int64_t channel_count;
    exr_attr_box2i_t data; /* union of the data windows */
    bool chroma, alpha;    /* luminance and chroma, with alpha */
    ty_image* image;
} reader;

static ty_result fail(reader* r, exr_result_t code) {
    return ty_exr_fail(r->context, TY_ERROR_INPUT, r->path, &r->stream, code);
}

static int64_t side(int32_t low, int32_t high) {
    return (int64_t)high - low + 1;
}

/* True if the channels are Y, RY and BY, with chroma at every second pixel of every second row, and perhaps A. */
static bool is_chroma(const exr_attr_chlist_t* channels, bool* alpha) {
    int found = 0;
    *alpha = false;
    for (int i = 0; i < channels->num_channels; ++i) {
        const exr_attr_chlist_entry_t* channel = &channels->entries[i];
        const char* name = channel->name.str;
        const bool chroma = strcmp(name, "RY") == 0 || strcmp(name, "BY") == 0, a = strcmp(name, "A") == 0;
        const int sampling = chroma ? 2 : 1;
        if (channel->x_sampling != sampling || channel->y_sampling != sampling) return false;
        if (!chroma && !a && strcmp(name, "Y") != 0) return false;
        found += !a;
        *alpha = *alpha || a;
    }
    return found == 3;
}

static ty_result check_channels(reader* r, const part* p, int parts) {
    r->chroma = parts == 1 && is_chroma(p->channels, &r->alpha);
    if (r->chroma) return TY_OK;
    for (int i = 0; i < p->channels->num_channels; ++i)
        if (p->channels->entries[i].x_sampling != 1 || p->channels->entries[i].y_sampling != 1)
            return ty_fail(r->context, TY_ERROR_INPUT,
                           "%s: channel %s is subsampled, which can be read of RY and BY beside Y alone", r->path,
                           p->channels->entries[i].name.str);
    return TY_OK;
}

static ty_result inspect_part(reader* r, int index, int parts, part* p) {
    p->index = index;
    exr_result_t code = exr_get_storage(r->exr, index, &p->storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_compression(r->exr, index, &p->compression);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(r->exr, index, &p->data);
    if (code == EXR_ERR_SUCCESS) code = exr_get_display_window(r->exr, index, &p->display);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(r->exr, index, &p->channels);
    if (code != EXR_ERR_SUCCESS) return fail(r, code);
    if (p->storage != EXR_STORAGE_SCANLINE && p->storage != EXR_STORAGE_TILED)
        return ty_fail(r->context, TY_ERROR_INPUT,
                       "%s: deep images cannot be read; \"oiiotool deep.exr --flatten -o flat.exr\" makes it flat",
                       r->path);
    const ty_result result = check_channels(r, p, parts);
    if (result != TY_OK) return result;
    uint64_t unpacked = 0;
    code = exr_get_chunk_unpacked_size(r->exr, index, &unpacked);
    if (code != EXR_ERR_SUCCESS) return fail(r, code);
    if (unpacked > chunk_size_max(r->stream.size))
        return ty_fail(r->context, TY_ERROR_INPUT, "%s: a block of pixels takes %llu bytes, more than can be read",
                       r->path, (unsigned long long)unpacked);
    return TY_OK;
}

static void include(exr_attr_box2i_t* box, const exr_attr_box2i_t* other) {
    if (other->min.x < box->min.x) box->min.x = other->min.x;
    if (other->min.y < box->min.y) box->min.y = other->min.y;
    if (other->max.x > box->max.x) box->max.x = other->max.x;
    if (other->max.y > box->max.y) box->max.y = other->max.y;
}

static ty_result inspect(reader* r) {
    int count = 0;
    const exr_result_t code = exr_get_count(r->exr, &count);
    if (code != EXR_ERR_SUCCESS || count < 1) return fail(r, code);
    r->parts = ty_alloc_array(r->context, (size_t)count, sizeof *r->parts, true);
    if (r->parts == NULL) return TY_ERROR_MEMORY;
    r->part_count = (size_t)count;
    for (int i = 0; i < count; ++i) {
        part* p = &r->parts[i];
        const ty_result result = inspect_part(r, i, count, p);
        if (result != TY_OK) return result;
        if (memcmp(&p->display, &r->parts[0].display, sizeof p->display) != 0)
            return ty_fail(r->context, TY_ERROR_INPUT, "%s: the display windows of its parts differ", r->path);
        if (i == 0) r->data = p->data;
        include(&r->data, &p->data);
        p->first_channel = (int32_t)r->channel_count;
        r->channel_count += p->channels->num_channels;
        if (r->channel_count > TY_IMAGE_CHANNELS_MAX) break; /* reported by the next check */
    }
    return ty_check_image_size(r->context, r->path, r->stream.size, side(r->data.min.x, r->data.max.x),
                               side(r->data.min.y, r->data.max.y), r->channel_count);
}

static ty_result set_frame(reader* r) {
    const exr_attr_box2i_t* display = &r->parts[0].display;
    const int64_t width = side(display->min.x, display->max.x), height = side(display->min.y, display->max.y);
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX)
        return ty_fail(r->context, TY_ERROR_INPUT, "%s: the display window is %lld x %lld pixels, outside 1..%d",
                       r->path, (long long)width, (long long)height, (int)TY_IMAGE_SIDE_MAX);
    const int64_t x = (int64_t)r->data.min.x - display->min.x, y = (int64_t)r->data.min.y - display->min.y;
    if (x < -TY_IMAGE_OFFSET_MAX || y < -TY_IMAGE_OFFSET_MAX || x > TY_IMAGE_OFFSET_MAX || y > TY_IMAGE_OFFSET_MAX)
        return ty_fail(r->context, TY_ERROR_INPUT,
                       "%s: the data window begins at (%lld, %lld) of the display window, beyond %d", r->path,
                       (long long)x, (long long)y, (int)TY_IMAGE_OFFSET_MAX);
    return ty_image_set_frame(r->image, (int32_t)x, (int32_t)y, (int32_t)width, (int32_t)height);
}

typedef char channel_name[TY_IMAGE_NAME_MAX + 1];

/* Channels of the first part keep their names, for readers that expect a single part; those of other parts become
 * "part.channel". */
static ty_result name_channels(reader* r, channel_name* names, const char** pointers) {
    for (size_t k = 0; k < r->part_count; ++k) {
        const part* p = &r->parts[k];
        const char* name = NULL;
        if (k > 0) exr_get_name(r->exr, p->index, &name);
        for (int32_t i = 0; i < p->channels->num_channels; ++i) {
            const int32_t at = p->first_channel + i;
            static const char* const colors[] = {"A", "B", "G", "R"};
            const char* own = r->chroma ? colors[i + !r->alpha] : p->channels->entries[i].name.str;
            const int length =
                snprintf(names[at], sizeof *names, "%s%s%s", name == NULL ? "" : name, name == NULL ? "" : ".", own);
            if (length < 1 || length > TY_IMAGE_NAME_MAX)
                return ty_fail(r->context, TY_ERROR_INPUT, "%s: the name of a channel is not 1..%d characters long",
                               r->path, (int)TY_IMAGE_NAME_MAX);
            for (int32_t j = 0; j < at; ++j)
                if (strcmp(names[j], names[at]) == 0)
                    return ty_fail(r->context, TY_ERROR_INPUT, "%s: two channels are called \"%s\"", r->path,
                                   names[at]);
            pointers[at] = names[at];
        }
    }
    return TY_OK;
}

static ty_result create_image(reader* r) {
    const size_t count = (size_t)r->channel_count;
    channel_name* names = ty_alloc_array(r->context, count, sizeof *names, false);
    const char** pointers = ty_alloc_array(r->context, count, sizeof *pointers, false);
    ty_result result = names == NULL || pointers == NULL ? TY_ERROR_MEMORY : name_channels(r, names, pointers);
    if (result == TY_OK)
        result = ty_image_create(r->context, (int32_t)side(r->data.min.x, r->data.max.x),
                                 (int32_t)side(r->data.min.y, r->data.max.y), (int32_t)count, pointers, &r->image);
    ty_free_array(r->context, pointers, count, sizeof *pointers);
    ty_free_array(r->context, names, count, sizeof *names);
    return result == TY_OK ? set_frame(r) : result;
}

/* Decodes one chunk with corner pixel (x, y) in file coordinates to its position in the image. */
static ty_result read_chunk(reader* r, const part* p, const exr_chunk_info_t* info, exr_decode_pipeline_t* decode,
                            int64_t x, int64_t y) {
    const int64_t left = x - r->data.min.x, top = y - r->data.min.y;
    if (left < 0 || top < 0 || left + info->width > r->image->width || top + info->height > r->image->height)
        return ty_fail(r->context, TY_ERROR_INPUT, "%s: a block of pixels lies outside the data window", r->path);
    const bool first = decode->context == NULL;
    exr_result_t code = first ? exr_decoding_initialize(r->exr, p->index, info, decode)
                              : exr_decoding_update(r->exr, p->index, info, decode);
    if (code != EXR_ERR_SUCCESS) return fail(r, code);
    for (int i = 0; i < decode->channel_count; ++i) {
        exr_coding_channel_info_t* channel = &decode->channels[i];
        float* plane = ty_image_plane(r->image, p->first_channel + i);
        channel->decode_to_ptr = (uint8_t*)(plane + top * r->image->width + left);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = r->image->width * (int32_t)sizeof(float);
    }
    if (first) code = exr_decoding_choose_default_routines(r->exr, p->index, decode);
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(r->exr, p->index, decode);
    return code == EXR_ERR_SUCCESS ? TY_OK : fail(r, code);
}

static ty_result read_scanlines(reader* r, const part* p, exr_decode_pipeline_t* decode) {
    int32_t lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(r->exr, p->index, &lines);
    if (code != EXR_ERR_SUCCESS || lines < 1) return fail(r, code);
    for (int64_t y = p->data.min.y; y <= p->data.max.y; y += lines) {
        exr_chunk_info_t info;
        code = exr_read_scanline_chunk_info(r->exr, p->index, (int)y, &info);
        if (code != EXR_ERR_SUCCESS) return fail(r, code);
        const ty_result result = read_chunk(r, p, &info, decode, p->data.min.x, y);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

/* The full-resolution level only. */
static ty_result read_tiles(reader* r, const part* p, exr_decode_pipeline_t* decode) {
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes(r->exr, p->index, 0, 0, &width, &height);
    if (code != EXR_ERR_SUCCESS || width < 1 || height < 1) return fail(r, code);
    const int64_t across = side(p->data.min.x, p->data.max.x), down = side(p->data.min.y, p->data.max.y);
    for (int64_t y = 0; y * height < down; ++y)
        for (int64_t x = 0; x * width < across; ++x) {
            exr_chunk_info_t info;
            code = exr_read_tile_chunk_info(r->exr, p->index, (int)x, (int)y, 0, 0, &info);
            if (code != EXR_ERR_SUCCESS) return fail(r, code);
            const ty_result result =
                read_chunk(r, p, &info, decode, p->data.min.x + x * width, p->data.min.y + y * height);
            if (result != TY_OK) return result;
        }
    return TY_OK;
}

static ty_result read_part(reader* r, const part* p) {
    const bool dwa = p->compression == EXR_COMPRESSION_DWAA || p->compression == EXR_COMPRESSION_DWAB;
    /* The C++ library allocates by the header's sizes, so it runs only after the core has validated them. */
    if ((dwa || r->chroma) && r->stream.message[0] != '\0') return fail(r, EXR_ERR_FILE_BAD_HEADER);
    if (r->chroma) return ty_exr_read_chroma(r->context, r->path, &r->stream, &p->data, r->alpha, r->image);
    if (dwa) {
        const ty_exr_dwa_part part_data = {p->index,         p->data,       p->channels,
                                           p->first_channel, r->data.min.x, r->data.min.y};
        return ty_exr_read_dwa(r->context, r->path, &r->stream, &part_data, r->image);
    }
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    const ty_result result =
        p->storage == EXR_STORAGE_TILED ? read_tiles(r, p, &decode) : read_scanlines(r, p, &decode);
    if (decode.context != NULL) exr_decoding_destroy(r->exr, &decode);
    return result;
}

/* Metadata of the first part. */
static ty_result read_metadata(reader* r) {
    int32_t count = 0;
    exr_get_attribute_count(r->exr, 0, &count);
    for (int32_t i = 0; i < count; ++i) {
        const exr_attribute_t* attribute = NULL;
        if (exr_get_attribute_by_index(r->exr, 0, EXR_ATTR_LIST_FILE_ORDER, i, &attribute) != EXR_ERR_SUCCESS ||
            !ty_metadata_key_allowed(attribute->name))
            continue;
        ty_result result = TY_OK;
        switch (attribute->type) {
        case EXR_ATTR_STRING: result = ty_image_set_text(r->image, attribute->name, attribute->string->str); break;
        case EXR_ATTR_DOUBLE: result = ty_image_set_number(r->image, attribute->name, attribute->d); break;
        case EXR_ATTR_FLOAT: result = ty_image_set_number(r->image, attribute->name, attribute->f); break;
        case EXR_ATTR_INT: result = ty_image_set_number(r->image, attribute->name, attribute->i); break;
        default: break;
        }
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

ty_result ty_read_exr(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_image** out) {
    reader r = {.context = context, .path = path, .stream = {.bytes = bytes, .size = size}};
    const exr_context_initializer_t setup = ty_exr_initializer(&r.stream);
    const exr_result_t code = exr_start_read(&r.exr, path, &setup);
    if (code != EXR_ERR_SUCCESS) {
        ty_exr_stream_end();
        return fail(&r, code);
    }
    ty_result result = r.stream.out_of_memory ? fail(&r, EXR_ERR_OUT_OF_MEMORY) : inspect(&r);
    if (result == TY_OK) result = create_image(&r);
    for (size_t i = 0; result == TY_OK && i < r.part_count; ++i) result = read_part(&r, &r.parts[i]);
    if (result == TY_OK) result = read_metadata(&r);
    if (result == TY_OK && r.stream.out_of_memory) result = fail(&r, EXR_ERR_OUT_OF_MEMORY);
    ty_free_array(context, r.parts, r.part_count, sizeof *r.parts);
    exr_finish(&r.exr);
    ty_exr_stream_end();
    if (result != TY_OK) {
        ty_image_destroy(r.image);
        return result;
    }
    *out = r.image;
    return TY_OK;
}

/* Bytes of a part's pixels, with those of the smaller images of its levels and of the heads of its blocks; 0 if they
 * are not known. */
static uint64_t longest_part(exr_const_context_t exr, int index) {
    enum { LEVELS = 4, BLOCK_HEAD = 64 }; /* there is a pixel in each block */
    exr_attr_box2i_t data;
    const exr_attr_chlist_t* channels = NULL;
    if (exr_get_data_window(exr, index, &data) != EXR_ERR_SUCCESS ||
        exr_get_channels(exr, index, &channels) != EXR_ERR_SUCCESS)
        return 0;
    const int64_t width = side(data.min.x, data.max.x), height = side(data.min.y, data.max.y);
    if (width < 1 || height < 1 || width > TY_IMAGE_SIDE_MAX || height > TY_IMAGE_SIDE_MAX ||
        channels->num_channels > TY_IMAGE_CHANNELS_MAX)
        return 0;
    return LEVELS * (uint64_t)width * (uint64_t)height *
           (BLOCK_HEAD + sizeof(float) * (uint64_t)channels->num_channels);
}

uint64_t ty_exr_longest(const uint8_t* head, size_t size) {
    ty_exr_stream stream = {.bytes = head, .size = size};
    const exr_context_initializer_t setup = ty_exr_initializer(&stream);
    exr_context_t exr = NULL;
    int count = 0;
    uint64_t longest = size;
    bool known = exr_start_read(&exr, "head", &setup) == EXR_ERR_SUCCESS;
    if (known) {
        known = exr_get_count(exr, &count) == EXR_ERR_SUCCESS && count > 0;
        for (int i = 0; i < count && known; ++i) {
            const uint64_t more = longest_part(exr, i);
            known = more > 0 && !__builtin_add_overflow(longest, more, &longest);
        }
        exr_finish(&exr);
    }
    ty_exr_stream_end();
    return known ? longest : UINT64_MAX;
}
