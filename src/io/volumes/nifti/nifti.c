/* Voxels of NIfTI files: behind the header or in a separate .img file, plain or in gzip. */
#include "io/volumes/nifti/nifti.h"

#include "base/context.h"
#include "io/file.h"
#include "io/volumes/gzip_file.h"
#include "io/volumes/sample_file.h"
#include "io/volumes/volume_file.h"

#include <string.h>
#include <strings.h>

bool ty_is_nifti_file(const char* path) {
    uint8_t head[TY_NIFTI2_BYTES];
    return ty_is_nifti(head, ty_read_head(path, head, sizeof head));
}

static bool is_packed(const uint8_t* bytes, size_t size) {
    return size >= 2 && bytes[0] == 0x1f && bytes[1] == 0x8b;
}

/* The header of a file, packed or not. */
static ty_result read_header(ty_context* context, const char* path, ty_nifti* nifti) {
    enum { PACKED_MAX = 1 << 16 };
    uint8_t *bytes = NULL, plain[TY_NIFTI2_BYTES];
    size_t size = 0;
    uint64_t got = 0;
    ty_result result = ty_read_part(context, path, 0, PACKED_MAX, &bytes, &size);
    if (result != TY_OK) return result;
    const bool packed = is_packed(bytes, size);
    if (packed) ty_inflate_gzip(bytes, size, 0, plain, sizeof plain, &got);
    if (got > sizeof plain) got = sizeof plain;
    result = ty_nifti_parse(context, path, packed ? plain : bytes, packed ? (size_t)got : size, nifti);
    ty_free_file(context, bytes, size);
    return result;
}

char* ty_nifti_image_path(ty_context* context, const char* path) {
    char* image = ty_copy_text(context, path);
    if (image == NULL) return NULL;
    char* end = image + strlen(image);
    if (end - image > 3 && strcasecmp(end - 3, ".gz") == 0) end -= 3;
    const char* from = "hdr";
    if (end - image < 4 || strncasecmp(end - 4, ".hdr", 4) != 0) return image;
    for (int i = 0; i < 3; ++i) {
        char* at = end - 3 + i;
        *at = (char)(*at - from[i] + "img"[i]);
    }
    return image;
}

/* Bytes of one volume. */
static size_t volume_bytes(const ty_nifti* nifti) {
    return nifti->voxels * (size_t)nifti->channels * ty_sample_size(nifti->type);
}

static ty_result cut_short(ty_context* context, const char* path, const ty_nifti* nifti) {
    return ty_fail(context, TY_ERROR_INPUT,
                   "%s: cut short: %d x %d x %d voxels of %d %s in %d volumes do not fit in it", path, nifti->size[0],
                   nifti->size[1], nifti->size[2], nifti->channels, ty_sample_name(nifti->type), nifti->volumes);
}

/* The grid of a packed file, whose samples begin after `first` inflated bytes. */
static ty_result read_packed(ty_context* context, const char* path, const ty_nifti* nifti, uint64_t first,
                             ty_samples* samples, const ty_grid_def* def, ty_grid** out) {
    ty_gzip_file file;
    ty_result result = ty_gzip_file_open(context, path, 0, first, volume_bytes(nifti), &file);
    if (result != TY_OK) return result;
    if (first + file.size > file.packed * TY_INFLATE_RATIO_MAX) {
        result = cut_short(context, path, nifti);
    } else {
        samples->read = ty_gzip_file_read;
        samples->user = &file;
        result = ty_samples_make_grid(context, samples, def, out);
        if (result == TY_OK) {
            file.fault = ty_gzip_file_finish(&file);
            if (file.fault == TY_INFLATED_SHORT || file.fault == TY_INFLATED_DAMAGED) {
                ty_grid_release(*out);
                *out = NULL;
                result = TY_ERROR_INPUT;
            }
        }
        if (result == TY_ERROR_INPUT && file.fault == TY_INFLATED_SHORT) cut_short(context, path, nifti);
        if (result == TY_ERROR_INPUT && file.fault == TY_INFLATED_DAMAGED)
            ty_fail(context, TY_ERROR_INPUT, "%s: the gzip data is damaged or cut short", path);
    }
    ty_gzip_file_close(&file);
    return result;
}

/* Opens a file of samples that are not packed, from `first` on. */
static ty_result open_plain(ty_context* context, const char* path, const ty_nifti* nifti, uint64_t first,
                            ty_sample_file* file) {
    FILE* stream = NULL;
    uint64_t length = 0;
    const ty_result result = ty_open_file(context, path, &stream, &length);
    if (result != TY_OK) return result;
    fclose(stream);
    if (length < first || length - first < volume_bytes(nifti)) return cut_short(context, path, nifti);
    return ty_sample_file_open(context, path, first, file);
}

static ty_result find_packed(ty_context* context, const char* path, bool* packed) {
    uint8_t* head = NULL;
    size_t size = 0;
    const ty_result result = ty_read_part(context, path, 0, 2, &head, &size);
    if (result != TY_OK) return result;
    *packed = is_packed(head, size);
    ty_free_file(context, head, size);
    return TY_OK;
}

/* The grid of the volume that has the component. */
static ty_result read_volume(ty_context* context, const char* path, const ty_nifti* nifti, int32_t component,
                             const ty_grid_plan* plan, ty_grid** out) {
    const uint64_t first = nifti->data + (nifti->channels == 1 ? (uint64_t)component * volume_bytes(nifti) : 0);
    ty_sample_file file = {.context = context};
    ty_samples samples = {.type = nifti->type,
                          .big_endian = nifti->big_endian,
                          .first = nifti->channels > 1 ? (size_t)component : 0,
                          .step = (size_t)nifti->channels,
                          .plan = *plan,
                          .slope = nifti->slope,
                          .intercept = nifti->intercept};
    ty_grid_def def = ty_default_grid_def();
    memcpy(def.size, nifti->size, sizeof def.size);
    def.index_to_local = nifti->index_to_local;
    def.placed = true;
    bool packed = false;
    ty_result result = find_packed(context, path, &packed);
    if (result == TY_OK && packed) return read_packed(context, path, nifti, first, &samples, &def, out);
    if (result == TY_OK) result = open_plain(context, path, nifti, first, &file);
    if (result != TY_OK) return result;
    samples.read = ty_sample_file_read;
    samples.user = &file;
    result = ty_samples_make_grid(context, &samples, &def, out);
    ty_sample_file_close(&file);
    return result;
}

ty_result ty_nifti_read(ty_context* context, const char* path, int32_t component, const ty_grid_plan* plan,
                        ty_grid** out) {
    ty_nifti nifti;
    ty_result result = read_header(context, path, &nifti);
    if (result == TY_OK) result = ty_check_component(context, path, NULL, component, nifti.channels * nifti.volumes);
    if (result != TY_OK) return result;
    char* image = nifti.pair ? ty_nifti_image_path(context, path) : ty_copy_text(context, path);
    if (image == NULL) return TY_ERROR_MEMORY;
    result = read_volume(context, image, &nifti, component, plan, out);
    ty_free_text(context, image);
    return result;
}

ty_result ty_nifti_components(ty_context* context, const char* path, int32_t* out) {
    ty_nifti nifti;
    const ty_result result = read_header(context, path, &nifti);
    if (result == TY_OK) *out = nifti.channels * nifti.volumes;
    return result;
}

void ty_nifti_describe(ty_context* context, const char* path, ty_volume_notes* notes) {
    static const char* const placements[] = {"sform", "qform", "spacing alone"};
    ty_nifti nifti;
    if (read_header(context, path, &nifti) != TY_OK) return;
    ty_note(notes, "format", "NIfTI-%d, %s%s", nifti.version, ty_sample_name(nifti.type), nifti.pair ? ", a pair" : "");
    ty_note(notes, "unit", "%s", nifti.unit[0] != '\0' ? nifti.unit : "unknown");
    ty_note(notes, "placement", "%s (right, anterior, superior)", placements[nifti.placement]);
    if (nifti.slope != 0) ty_note(notes, "scaling", "%.9g times the sample plus %.9g", nifti.slope, nifti.intercept);
    if (nifti.description[0] != '\0') ty_note(notes, "description", "%s", nifti.description);
}
