/* Headers of NIfTI files. */
#include "io/volumes/nifti/nifti.h"

#include "base/context.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <string.h>

enum { AXES_MAX = 7, COMPONENTS_MAX = 65536 };

/* Offsets of fields in the two versions, and the types of those that differ. */
typedef struct layout {
    size_t bytes, magic, dim, datatype, pixdim, vox_offset, slope, intercept, units, description, qform_code,
        sform_code, quaternion, qoffset, srow;
    ty_sample_type dim_type, real_type, offset_type, code_type, unit_type;
} layout;

static const layout layouts[2] = {{.bytes = TY_NIFTI1_BYTES,
                                   .magic = 344,
                                   .dim = 40,
                                   .datatype = 70,
                                   .pixdim = 76,
                                   .vox_offset = 108,
                                   .slope = 112,
                                   .intercept = 116,
                                   .units = 123,
                                   .description = 148,
                                   .qform_code = 252,
                                   .sform_code = 254,
                                   .quaternion = 256,
                                   .qoffset = 268,
                                   .srow = 280,
                                   .dim_type = TY_SAMPLE_INT16,
                                   .real_type = TY_SAMPLE_FLOAT,
                                   .offset_type = TY_SAMPLE_FLOAT,
                                   .code_type = TY_SAMPLE_INT16,
                                   .unit_type = TY_SAMPLE_UINT8},
                                  {.bytes = TY_NIFTI2_BYTES,
                                   .magic = 4,
                                   .dim = 16,
                                   .datatype = 12,
                                   .pixdim = 104,
                                   .vox_offset = 168,
                                   .slope = 176,
                                   .intercept = 184,
                                   .units = 500,
                                   .description = 240,
                                   .qform_code = 344,
                                   .sform_code = 348,
                                   .quaternion = 352,
                                   .qoffset = 376,
                                   .srow = 400,
                                   .dim_type = TY_SAMPLE_INT64,
                                   .real_type = TY_SAMPLE_DOUBLE,
                                   .offset_type = TY_SAMPLE_INT64,
                                   .code_type = TY_SAMPLE_INT32,
                                   .unit_type = TY_SAMPLE_INT32}};

static const struct {
    int code;
    ty_sample_type type;
    int32_t channels;
} datatypes[] = {{2, TY_SAMPLE_UINT8, 1},     {4, TY_SAMPLE_INT16, 1},    {8, TY_SAMPLE_INT32, 1},
                 {16, TY_SAMPLE_FLOAT, 1},    {32, TY_SAMPLE_FLOAT, 2},   {64, TY_SAMPLE_DOUBLE, 1},
                 {128, TY_SAMPLE_UINT8, 3},   {256, TY_SAMPLE_INT8, 1},   {512, TY_SAMPLE_UINT16, 1},
                 {768, TY_SAMPLE_UINT32, 1},  {1024, TY_SAMPLE_INT64, 1}, {1280, TY_SAMPLE_UINT64, 1},
                 {1792, TY_SAMPLE_DOUBLE, 2}, {2304, TY_SAMPLE_UINT8, 4}};

typedef struct header {
    ty_context* context;
    const char* path;
    const uint8_t* bytes;
    const layout* at;
    bool big_endian;
} header;

/* The i-th number of a field. */
static double number(const header* h, size_t field, ty_sample_type type, int i) {
    return ty_sample_value(type, h->big_endian, h->bytes + field + (size_t)i * ty_sample_size(type));
}

static double real(const header* h, size_t field, int i) {
    return number(h, field, h->at->real_type, i);
}

/* Version and byte order by the first number, which is the header's length; 0 for other files. */
static int find_version(const uint8_t* bytes, size_t size, bool* big_endian) {
    for (int version = 1; version <= 2; ++version)
        for (int big = 0; big < 2; ++big)
            if (size >= 4 && ty_sample_value(TY_SAMPLE_INT32, big == 1, bytes) == (double)layouts[version - 1].bytes) {
                *big_endian = big == 1;
                return version;
            }
    return 0;
}

/* "n+" for one file, "ni" for a pair, then the version. */
static bool has_magic(const uint8_t* bytes, size_t size, int version) {
    const uint8_t* magic = bytes + layouts[version - 1].magic;
    return size >= layouts[version - 1].bytes && magic[0] == 'n' && (magic[1] == '+' || magic[1] == 'i') &&
           magic[2] == '0' + version && magic[3] == 0;
}

bool ty_is_nifti(const uint8_t* bytes, size_t size) {
    bool big_endian;
    const int version = find_version(bytes, size, &big_endian);
    return version != 0 && has_magic(bytes, size, version);
}

static ty_result read_type(const header* h, ty_nifti* out) {
    const double code = number(h, h->at->datatype, TY_SAMPLE_INT16, 0);
    for (size_t i = 0; i < sizeof datatypes / sizeof datatypes[0]; ++i)
        if (code == datatypes[i].code) {
            out->type = datatypes[i].type;
            out->channels = datatypes[i].channels;
            return TY_OK;
        }
    return ty_fail(
        h->context, TY_ERROR_INPUT,
        "%s: NIfTI datatype %.0f cannot be read (whole numbers of 8 to 64 bits, float, double, their complex "
        "numbers, RGB and RGBA can)",
        h->path, code);
}

static ty_result read_sizes(const header* h, ty_nifti* out) {
    const double axes = number(h, h->at->dim, h->at->dim_type, 0);
    if (!(axes >= 1 && axes <= AXES_MAX))
        return ty_fail(h->context, TY_ERROR_INPUT, "%s: NIfTI dim[0] is %.0f, outside [1, 7]", h->path, axes);
    int64_t sizes[3] = {1, 1, 1};
    double volumes = 1;
    for (int a = 0; a < (int)axes; ++a) {
        const double size = number(h, h->at->dim, h->at->dim_type, 1 + a);
        if (!(size >= 1 && size <= INT32_MAX))
            return ty_fail(h->context, TY_ERROR_INPUT, "%s: NIfTI dim[%d] is %.0f, outside [1, 2147483647]", h->path,
                           1 + a, size);
        if (a < 3)
            sizes[a] = (int64_t)size;
        else
            volumes *= size;
    }
    if (volumes * out->channels > COMPONENTS_MAX || (volumes > 1 && out->channels > 1))
        return ty_fail(
            h->context, TY_ERROR_INPUT,
            "%s: %.0f volumes of %d values per voxel; %d volumes of one value, or one of several, can be read", h->path,
            volumes, (int)out->channels, COMPONENTS_MAX);
    out->volumes = (int32_t)volumes;
    const ty_result result = ty_check_volume_size(h->context, h->path, sizes, &out->voxels);
    for (int a = 0; a < 3 && result == TY_OK; ++a) out->size[a] = (int32_t)sizes[a];
    return result;
}

static ty_result read_data_place(const header* h, ty_nifti* out) {
    const double offset = number(h, h->at->vox_offset, h->at->offset_type, 0);
    out->pair = h->bytes[h->at->magic + 1] == 'i';
    const double first = out->pair ? 0 : (double)h->at->bytes;
    if (!(offset >= 0 && offset <= 9007199254740992.0) || (offset != 0 && offset < first))
        return ty_fail(h->context, TY_ERROR_INPUT, "%s: NIfTI vox_offset is %g, inside the header", h->path, offset);
    out->data = (uint64_t)(offset == 0 ? first : offset);
    out->slope = real(h, h->at->slope, 0);
    out->intercept = real(h, h->at->intercept, 0);
    if (!isfinite(out->slope) || !isfinite(out->intercept) || (out->slope == 1 && out->intercept == 0) ||
        out->channels > 1)
        out->slope = 0; /* samples as they are */
    return TY_OK;
}

/* Rows of nifti1.h's method 3. */
static ty_affine read_sform(const header* h) {
    ty_affine map;
    for (int i = 0; i < 12; ++i) map.m[i] = real(h, h->at->srow, i);
    return map;
}

/* A spacing of 0, as of an axis that a file does not have, counts as 1. */
static double spacing_of(const header* h, int axis) {
    const double spacing = fabs(real(h, h->at->pixdim, 1 + axis));
    return spacing > 0 ? spacing : 1;
}

/* The rotation of a unit quaternion and the spacings, nifti1.h's method 2. */
static ty_affine read_qform(const header* h) {
    const double b = real(h, h->at->quaternion, 0), c = real(h, h->at->quaternion, 1),
                 d = real(h, h->at->quaternion, 2);
    const double rest = 1 - b * b - c * c - d * d, scale = rest < 0 ? 1 / sqrt(b * b + c * c + d * d) : 1;
    const double w = rest < 0 ? 0 : sqrt(rest), x = b * scale, y = c * scale, z = d * scale;
    const double rotation[9] = {
        w * w + x * x - y * y - z * z, 2 * (x * y - w * z),           2 * (x * z + w * y),
        2 * (x * y + w * z),           w * w + y * y - x * x - z * z, 2 * (y * z - w * x),
        2 * (x * z - w * y),           2 * (y * z + w * x),           w * w + z * z - x * x - y * y};
    ty_affine map;
    for (int r = 0; r < 3; ++r) {
        for (int a = 0; a < 3; ++a) map.m[4 * r + a] = rotation[3 * r + a] * spacing_of(h, a);
        if (real(h, h->at->pixdim, 0) < 0) map.m[4 * r + 2] = -map.m[4 * r + 2];
        map.m[4 * r + 3] = real(h, h->at->qoffset, r);
    }
    return map;
}

static ty_affine read_spacings(const header* h) {
    ty_affine map = ty_affine_identity();
    for (int a = 0; a < 3; ++a) map.m[5 * a] = spacing_of(h, a);
    return map;
}

static ty_result read_placement(const header* h, ty_nifti* out) {
    static const char* const names[] = {"sform", "qform", "pixdim"};
    const bool sform = number(h, h->at->sform_code, h->at->code_type, 0) > 0;
    const bool qform = number(h, h->at->qform_code, h->at->code_type, 0) > 0;
    out->placement = sform ? TY_NIFTI_SFORM : qform ? TY_NIFTI_QFORM : TY_NIFTI_SPACING;
    out->index_to_local = sform ? read_sform(h) : qform ? read_qform(h) : read_spacings(h);
    bool usable = true;
    for (int i = 0; i < 12; ++i) usable = usable && fabs(out->index_to_local.m[i]) <= 1e15;
    ty_affine inverse;
    if (usable && ty_affine_invert(&out->index_to_local, &inverse)) return TY_OK;
    return ty_fail(h->context, TY_ERROR_INPUT, "%s: the NIfTI %s does not place the voxels: it cannot be inverted",
                   h->path, names[out->placement]);
}

/* Bits 0 to 2 of xyzt_units. */
static void read_notes(const header* h, ty_nifti* out) {
    static const char* const units[] = {"", "m", "mm", "micron"};
    const int unit = (int)number(h, h->at->units, h->at->unit_type, 0) & 7;
    out->unit = units[unit < 4 ? unit : 0];
    memcpy(out->description, h->bytes + h->at->description, sizeof out->description - 1);
}

ty_result ty_nifti_parse(ty_context* context, const char* path, const uint8_t* bytes, size_t size, ty_nifti* out) {
    header h = {.context = context, .path = path, .bytes = bytes};
    *out = (ty_nifti){.version = find_version(bytes, size, &h.big_endian)};
    if (out->version == 0 || size < layouts[out->version - 1].bytes)
        return ty_fail(context, TY_ERROR_INPUT, "%s: not a NIfTI file, or cut short in its header", path);
    if (!has_magic(bytes, size, out->version))
        return ty_fail(context, TY_ERROR_INPUT,
                       "%s: a header of ANALYZE 7.5, which does not say how the voxels lie; NIfTI files can be read",
                       path);
    h.at = &layouts[out->version - 1];
    out->big_endian = h.big_endian;
    ty_result result = read_type(&h, out);
    if (result == TY_OK) result = read_sizes(&h, out);
    if (result == TY_OK) result = read_data_place(&h, out);
    if (result == TY_OK) result = read_placement(&h, out);
    read_notes(&h, out);
    return result;
}
