/* Voxel samples in gzip data: the parts that a grid is made of in turn. */
#define _POSIX_C_SOURCE 200809L
#include "io/volumes/gzip_file.h"

#include "base/context.h"
#include "io/file.h"

enum { WINDOW_DETECT = 15 + 32, INPUT = 1 << 16, SCRATCH = 1 << 15 };

ty_result ty_gzip_file_open(ty_context* context, const char* path, uint64_t start, uint64_t skip, uint64_t size,
                            ty_gzip_file* file) {
    uint64_t length = 0;
    *file = (ty_gzip_file){.context = context, .path = path, .start = start, .skip = skip, .size = size};
    const ty_result result = ty_open_file(context, path, &file->stream, &length);
    if (result != TY_OK) return result;
    file->packed = length > start ? length - start : 0;
    file->input = ty_alloc_array(context, INPUT, 1, false);
    if (file->input != NULL) return TY_OK;
    fclose(file->stream);
    return TY_ERROR_MEMORY;
}

void ty_gzip_file_close(ty_gzip_file* file) {
    if (file->begun) inflateEnd(&file->z);
    ty_free_array(file->context, file->input, INPUT, 1);
    ty_free_array(file->context, file->bytes, file->capacity, 1);
    fclose(file->stream);
}

/* Begins with the first inflated byte. */
static bool begin(ty_gzip_file* file) {
    if (file->begun) inflateEnd(&file->z);
    file->z = (z_stream){0};
    file->begun = inflateInit2(&file->z, WINDOW_DETECT) == Z_OK;
    file->status = Z_OK;
    file->left = file->packed;
    file->at = 0;
    return file->begun && fseeko(file->stream, (off_t)file->start, SEEK_SET) == 0;
}

/* Reads packed bytes where none wait. */
static bool fill(ty_gzip_file* file) {
    if (file->z.avail_in > 0 || file->left == 0) return true;
    const size_t wanted = file->left < INPUT ? (size_t)file->left : (size_t)INPUT;
    const size_t got = fread(file->input, 1, wanted, file->stream);
    file->left -= got;
    file->z.next_in = file->input;
    file->z.avail_in = (uInt)got;
    return got == wanted;
}

/* Packed bytes behind the end of a stream. */
static uint64_t behind(const ty_gzip_file* file) {
    return file->left + file->z.avail_in;
}

/* Inflates up to `room` bytes of the stream under way, and returns their number. */
static uInt inflate_some(ty_gzip_file* file, uint8_t* to, uInt room) {
    if (!fill(file)) {
        file->status = Z_DATA_ERROR;
        return 0;
    }
    file->z.next_out = to;
    file->z.avail_out = room;
    file->status = inflate(&file->z, Z_NO_FLUSH);
    const uInt got = room - file->z.avail_out;
    file->at += got;
    return got;
}

/* Inflates `size` bytes; fewer were left where it is not TY_INFLATED_WHOLE. */
static ty_inflated inflate_part(ty_gzip_file* file, uint8_t* to, size_t size) {
    while (size > 0) {
        if (file->status == Z_STREAM_END) {
            if (behind(file) <= 1) return TY_INFLATED_SHORT;
            file->status = inflateReset(&file->z);
        }
        if (file->status != Z_OK) return TY_INFLATED_DAMAGED;
        const uInt got = inflate_some(file, to, size > UINT32_MAX ? UINT32_MAX : (uInt)size);
        to += got;
        size -= got;
    }
    return TY_INFLATED_WHOLE;
}

/* Inflates and leaves out bytes up to a place. */
static ty_inflated skip_to(ty_gzip_file* file, uint64_t at) {
    uint8_t scratch[SCRATCH];
    ty_inflated state = TY_INFLATED_WHOLE;
    while (file->at < at && state == TY_INFLATED_WHOLE)
        state = inflate_part(file, scratch, at - file->at < SCRATCH ? (size_t)(at - file->at) : (size_t)SCRATCH);
    return state;
}

static bool reserve(ty_gzip_file* file, size_t size) {
    if (size <= file->capacity) return true;
    ty_free_array(file->context, file->bytes, file->capacity, 1);
    file->bytes = ty_alloc_array(file->context, size, 1, false);
    file->capacity = file->bytes != NULL ? size : 0;
    return file->bytes != NULL;
}

ty_result ty_gzip_file_read(void* user, size_t at, size_t size, const uint8_t** bytes) {
    ty_gzip_file* file = user;
    const uint64_t first = file->skip + at;
    if (!reserve(file, size)) return TY_ERROR_MEMORY;
    file->fault = TY_INFLATED_WHOLE;
    if ((!file->begun || first < file->at) && !begin(file)) file->fault = TY_INFLATED_DAMAGED;
    if (file->fault == TY_INFLATED_WHOLE) file->fault = skip_to(file, first);
    if (file->fault == TY_INFLATED_WHOLE) file->fault = inflate_part(file, file->bytes, size);
    *bytes = file->bytes;
    return file->fault == TY_INFLATED_WHOLE ? TY_OK : TY_ERROR_INPUT;
}

ty_inflated ty_gzip_file_finish(ty_gzip_file* file) {
    uint8_t beyond;
    const ty_inflated state = skip_to(file, file->skip + file->size);
    if (state != TY_INFLATED_WHOLE) return state;
    while (file->status == Z_OK)
        if (inflate_some(file, &beyond, 1) > 0) return TY_INFLATED_MORE;
    return file->status == Z_STREAM_END ? TY_INFLATED_WHOLE : TY_INFLATED_DAMAGED;
}
