/* Mitsuba's .vol grids, version 3: a header of 48 bytes, then values with x fastest, components side by side; all
 * little-endian. The layout is that of the plugin gridvolume in the documentation of Mitsuba 3. */
#include "io/volumes/sample_file.h"
#include "io/volumes/volume_file.h"

#include "base/context.h"
#include "io/file.h"

#include <math.h>
#include <string.h>

enum { HEADER_SIZE = 48, VERSION = 3, COMPONENTS_MAX = 65536 };

typedef struct vol_header {
    ty_sample_type type;
    int32_t size[3], components;
    size_t voxels;
    float box[6]; /* lower and upper corner */
    bool placed;
} vol_header;

static int32_t integer_at(const uint8_t* bytes) {
    return (int32_t)ty_sample_value(TY_SAMPLE_INT32, false, bytes);
}

static ty_result parse_type(ty_context* context, const char* path, int32_t encoding, vol_header* out) {
    static const ty_sample_type types[] = {TY_SAMPLE_FLOAT, TY_SAMPLE_HALF, TY_SAMPLE_UINT8};
    if (encoding >= 1 && encoding <= 3) {
        out->type = types[encoding - 1];
        return TY_OK;
    }
    return ty_fail(context, TY_ERROR_INPUT, "%s: .vol encoding %d cannot be read (1 float, 2 half, 3 uint8)", path,
                   encoding);
}

/* A box without a volume places nothing. */
static ty_result parse_box(ty_context* context, const char* path, const uint8_t* bytes, vol_header* out) {
    out->placed = true;
    for (int i = 0; i < 6; ++i) {
        out->box[i] = (float)ty_sample_value(TY_SAMPLE_FLOAT, false, bytes + 4 * i);
        if (!(fabsf(out->box[i]) <= 1e15f))
            return ty_fail(context, TY_ERROR_INPUT, "%s: the .vol header's bounding box is not finite", path);
    }
    for (int a = 0; a < 3; ++a) out->placed = out->placed && out->box[3 + a] > out->box[a];
    return TY_OK;
}

static ty_result read_header(ty_context* context, const char* path, vol_header* out) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    ty_result result = ty_read_part(context, path, 0, HEADER_SIZE, &bytes, &size);
    if (result != TY_OK) return result;
    *out = (vol_header){0};
    if (size < HEADER_SIZE || memcmp(bytes, "VOL", 3) != 0)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: not a .vol file of Mitsuba, or cut short in its header", path);
    else if (bytes[3] != VERSION)
        result = ty_fail(context, TY_ERROR_INPUT, "%s: .vol version %d; version 3 can be read", path, bytes[3]);
    if (result == TY_OK) result = parse_type(context, path, integer_at(bytes + 4), out);
    int64_t sides[3] = {0, 0, 0};
    for (int a = 0; a < 3 && result == TY_OK; ++a) {
        out->size[a] = integer_at(bytes + 8 + 4 * a);
        sides[a] = out->size[a];
    }
    if (result == TY_OK) result = ty_check_volume_size(context, path, sides, &out->voxels);
    if (result == TY_OK) out->components = integer_at(bytes + 20);
    if (result == TY_OK && (out->components < 1 || out->components > COMPONENTS_MAX))
        result = ty_fail(context, TY_ERROR_INPUT, "%s: %d values per voxel, outside [1, %d]", path, out->components,
                         COMPONENTS_MAX);
    if (result == TY_OK) result = parse_box(context, path, bytes + 24, out);
    ty_free_file(context, bytes, size);
    return result;
}

/* Fails unless the file has exactly the bytes that the header tells. */
static ty_result check_length(ty_context* context, const char* path, const vol_header* header) {
    FILE* stream = NULL;
    uint64_t length = 0;
    const ty_result result = ty_open_file(context, path, &stream, &length);
    if (result != TY_OK) return result;
    fclose(stream);
    const size_t needed = header->voxels * (size_t)header->components * ty_sample_size(header->type);
    if (length == needed + HEADER_SIZE) return TY_OK;
    return ty_fail(context, TY_ERROR_INPUT, "%s: %llu bytes, of which its header accounts for %zu", path,
                   (unsigned long long)length, needed + HEADER_SIZE);
}

/* Voxels fill the box: the centre of the first one is half a voxel inside. */
static ty_grid_def place(const vol_header* header) {
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, header->size, sizeof def.size);
    def.placed = header->placed;
    for (int a = 0; a < 3 && def.placed; ++a) {
        const double spacing = ((double)header->box[3 + a] - (double)header->box[a]) / header->size[a];
        def.index_to_local.m[5 * a] = spacing;
        def.index_to_local.m[4 * a + 3] = (double)header->box[a] + spacing / 2;
    }
    return def;
}

ty_result ty_mitsuba_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                          ty_grid** out) {
    vol_header header;
    ty_sample_file file;
    ty_result result = read_header(context, path, &header);
    if (result == TY_OK) result = ty_check_component(context, path, NULL, component, header.components);
    if (result == TY_OK) result = check_length(context, path, &header);
    if (result == TY_OK) result = ty_sample_file_open(context, path, HEADER_SIZE, &file);
    if (result != TY_OK) return result;
    const ty_samples samples = {.read = ty_sample_file_read,
                                .user = &file,
                                .type = header.type,
                                .first = (size_t)component,
                                .step = (size_t)header.components,
                                .plan = *plan,
                                .slope = header.type == TY_SAMPLE_UINT8 ? 1.0 / UINT8_MAX : 0};
    const ty_grid_def def = place(&header);
    result = ty_samples_make_grid(context, &samples, &def, out);
    ty_sample_file_close(&file);
    return result;
}

ty_result ty_mitsuba_components(ty_context* context, const char* path, int32_t* out) {
    vol_header header;
    const ty_result result = read_header(context, path, &header);
    if (result == TY_OK) *out = header.components;
    return result;
}

void ty_mitsuba_describe(ty_context* context, const char* path, ty_volume_notes* notes) {
    vol_header header;
    if (read_header(context, path, &header) == TY_OK)
        ty_note(notes, "format", "Mitsuba .vol, version 3, %s", ty_sample_name(header.type));
}
