/* Headers of NRRD files, versions 1 to 5. Fields are collected as text and interpreted once all are present. */
#include "io/volumes/nrrd.h"

#include "base/context.h"
#include "base/number.h"
#include "io/schema_text.h"
#include "io/volumes/volume_file.h"

#include <math.h>
#include <string.h>
#include <strings.h>

enum { AXES_MAX = 4, COMPONENTS_GUESSED_MAX = 4, COMPONENTS_MAX = 65536 };

/* Fields that are read; FIELD_IGNORED stands for all other valid fields. */
typedef enum field {
    FIELD_DIMENSION,
    FIELD_TYPE,
    FIELD_SIZES,
    FIELD_ENCODING,
    FIELD_ENDIAN,
    FIELD_SPACINGS,
    FIELD_DIRECTIONS,
    FIELD_ORIGIN,
    FIELD_KINDS,
    FIELD_DATA_FILE,
    FIELD_LINE_SKIP,
    FIELD_BYTE_SKIP,
    FIELD_COUNT,
    FIELD_IGNORED = FIELD_COUNT
} field;

static const struct {
    const char* name;
    field field;
} field_names[] = {
    {"dimension", FIELD_DIMENSION},
    {"type", FIELD_TYPE},
    {"sizes", FIELD_SIZES},
    {"encoding", FIELD_ENCODING},
    {"endian", FIELD_ENDIAN},
    {"spacings", FIELD_SPACINGS},
    {"space directions", FIELD_DIRECTIONS},
    {"space origin", FIELD_ORIGIN},
    {"kinds", FIELD_KINDS},
    {"data file", FIELD_DATA_FILE},
    {"datafile", FIELD_DATA_FILE},
    {"line skip", FIELD_LINE_SKIP},
    {"lineskip", FIELD_LINE_SKIP},
    {"byte skip", FIELD_BYTE_SKIP},
    {"byteskip", FIELD_BYTE_SKIP},
    {"space", FIELD_IGNORED},
    {"space dimension", FIELD_IGNORED},
    {"space units", FIELD_IGNORED},
    {"measurement frame", FIELD_IGNORED},
    {"thicknesses", FIELD_IGNORED},
    {"axis mins", FIELD_IGNORED},
    {"axismins", FIELD_IGNORED},
    {"axis maxs", FIELD_IGNORED},
    {"axismaxs", FIELD_IGNORED},
    {"centers", FIELD_IGNORED},
    {"centerings", FIELD_IGNORED},
    {"labels", FIELD_IGNORED},
    {"units", FIELD_IGNORED},
    {"content", FIELD_IGNORED},
    {"number", FIELD_IGNORED},
    {"block size", FIELD_IGNORED},
    {"blocksize", FIELD_IGNORED},
    {"min", FIELD_IGNORED},
    {"max", FIELD_IGNORED},
    {"old min", FIELD_IGNORED},
    {"oldmin", FIELD_IGNORED},
    {"old max", FIELD_IGNORED},
    {"oldmax", FIELD_IGNORED},
    {"sample units", FIELD_IGNORED},
    {"sampleunits", FIELD_IGNORED},
};
enum { FIELD_NAMES = sizeof field_names / sizeof field_names[0] };

static const struct {
    const char* name;
    ty_sample_type type;
} type_names[] = {
    {"signed char", TY_SAMPLE_INT8},
    {"int8", TY_SAMPLE_INT8},
    {"int8_t", TY_SAMPLE_INT8},
    {"uchar", TY_SAMPLE_UINT8},
    {"unsigned char", TY_SAMPLE_UINT8},
    {"uint8", TY_SAMPLE_UINT8},
    {"uint8_t", TY_SAMPLE_UINT8},
    {"short", TY_SAMPLE_INT16},
    {"short int", TY_SAMPLE_INT16},
    {"signed short", TY_SAMPLE_INT16},
    {"signed short int", TY_SAMPLE_INT16},
    {"int16", TY_SAMPLE_INT16},
    {"int16_t", TY_SAMPLE_INT16},
    {"ushort", TY_SAMPLE_UINT16},
    {"unsigned short", TY_SAMPLE_UINT16},
    {"unsigned short int", TY_SAMPLE_UINT16},
    {"uint16", TY_SAMPLE_UINT16},
    {"uint16_t", TY_SAMPLE_UINT16},
    {"int", TY_SAMPLE_INT32},
    {"signed int", TY_SAMPLE_INT32},
    {"int32", TY_SAMPLE_INT32},
    {"int32_t", TY_SAMPLE_INT32},
    {"uint", TY_SAMPLE_UINT32},
    {"unsigned int", TY_SAMPLE_UINT32},
    {"uint32", TY_SAMPLE_UINT32},
    {"uint32_t", TY_SAMPLE_UINT32},
    {"longlong", TY_SAMPLE_INT64},
    {"long long", TY_SAMPLE_INT64},
    {"long long int", TY_SAMPLE_INT64},
    {"signed long long", TY_SAMPLE_INT64},
    {"signed long long int", TY_SAMPLE_INT64},
    {"int64", TY_SAMPLE_INT64},
    {"int64_t", TY_SAMPLE_INT64},
    {"ulonglong", TY_SAMPLE_UINT64},
    {"unsigned long long", TY_SAMPLE_UINT64},
    {"unsigned long long int", TY_SAMPLE_UINT64},
    {"uint64", TY_SAMPLE_UINT64},
    {"uint64_t", TY_SAMPLE_UINT64},
    {"float", TY_SAMPLE_FLOAT},
    {"double", TY_SAMPLE_DOUBLE},
};

static const struct {
    const char* name;
    ty_nrrd_encoding encoding;
} encoding_names[] = {{"raw", TY_NRRD_RAW},  {"gzip", TY_NRRD_GZIP}, {"gz", TY_NRRD_GZIP},
                      {"txt", TY_NRRD_TEXT}, {"text", TY_NRRD_TEXT}, {"ascii", TY_NRRD_TEXT}};

typedef struct header {
    ty_context* context;
    const char* path;
    const char* fields[FIELD_COUNT];
    int axes, component_axis; /* component_axis -1: one value per voxel */
    int64_t sizes[AXES_MAX];
} header;

static ty_result fail_line(const header* h, const char* line, const char* matter) {
    char quoted[80] = "";
    ty_append_quoted(quoted, sizeof quoted, line);
    return ty_fail(h->context, TY_ERROR_INPUT, "%s: NRRD header: %s %s", h->path, quoted, matter);
}

static ty_result fail_field(const header* h, field which, const char* matter) {
    int name = 0;
    while (field_names[name].field != which) ++name;
    char quoted[80] = "";
    ty_append_quoted(quoted, sizeof quoted, h->fields[which]);
    return ty_fail(h->context, TY_ERROR_INPUT, "%s: NRRD field %s: %s %s", h->path, field_names[name].name, quoted,
                   matter);
}

static const char* skip_blanks(const char* text) {
    return text + strspn(text, " \t");
}

/* Stores a "name: value" line; comments and "key:=value" are skipped. */
static ty_result store_line(header* h, char* line) {
    char* colon = strchr(line, ':');
    if (line[0] == '#') return TY_OK;
    if (colon == NULL) return fail_line(h, line, "is not a field");
    if (colon[1] == '=') return TY_OK;
    *colon = '\0';
    int name = 0;
    while (name < FIELD_NAMES && strcasecmp(line, field_names[name].name) != 0) ++name;
    if (name == FIELD_NAMES) return fail_line(h, line, "is not a field of NRRD");
    const field which = field_names[name].field;
    if (which == FIELD_IGNORED) return TY_OK;
    if (h->fields[which] != NULL) return fail_line(h, line, "is there twice");
    h->fields[which] = skip_blanks(colon + 1);
    return TY_OK;
}

/* Splits the header into lines up to an empty one or the end; *data is the rest. */
static ty_result split_lines(header* h, uint8_t* bytes, size_t size, size_t* data) {
    size_t at = 0;
    for (int number = 0; at < size; ++number) {
        char* line = (char*)bytes + at;
        char* newline = memchr(line, '\n', size - at);
        char* end = newline != NULL ? newline : (char*)bytes + size;
        at = (size_t)(end - (char*)bytes) + (newline != NULL);
        while (end > line && memchr("\r \t", end[-1], 3) != NULL) --end;
        *end = '\0';
        if (number > 0 && line[0] == '\0') break;
        const ty_result result = number > 0 ? store_line(h, line) : TY_OK;
        if (result != TY_OK) return result;
    }
    *data = at;
    return TY_OK;
}

static ty_result check_magic(const header* h, const uint8_t* bytes, size_t size) {
    if (size < 9 || memcmp(bytes, "NRRD", 4) != 0 || memchr("\r\n", bytes[8], 2) == NULL)
        return ty_fail(h->context, TY_ERROR_INPUT, "%s: not an NRRD file", h->path);
    if (memcmp(bytes + 4, "000", 3) != 0 || bytes[7] < '1' || bytes[7] > '5')
        return ty_fail(h->context, TY_ERROR_INPUT, "%s: NRRD version %.4s; 0001 to 0005 can be read", h->path,
                       (const char*)bytes + 4);
    return TY_OK;
}

static ty_result check_present(const header* h) {
    static const field needed[] = {FIELD_DIMENSION, FIELD_TYPE, FIELD_SIZES, FIELD_ENCODING};
    for (size_t i = 0; i < sizeof needed / sizeof needed[0]; ++i)
        if (h->fields[needed[i]] == NULL)
            return ty_fail(h->context, TY_ERROR_INPUT, "%s: NRRD header: the field %s is missing", h->path,
                           field_names[needed[i]].name);
    return TY_OK;
}

static ty_result read_type(const header* h, ty_nrrd* out) {
    const size_t count = sizeof type_names / sizeof type_names[0];
    for (size_t i = 0; i < count; ++i)
        if (strcasecmp(h->fields[FIELD_TYPE], type_names[i].name) == 0) {
            out->type = type_names[i].type;
            return TY_OK;
        }
    return fail_field(h, FIELD_TYPE, "is not a type that can be read (int8 to uint64, float, double)");
}

static ty_result read_encoding(const header* h, ty_nrrd* out) {
    const size_t count = sizeof encoding_names / sizeof encoding_names[0];
    size_t i = 0;
    while (i < count && strcasecmp(h->fields[FIELD_ENCODING], encoding_names[i].name) != 0) ++i;
    if (i == count) return fail_field(h, FIELD_ENCODING, "is not one that can be read (raw, gzip, text)");
    out->encoding = encoding_names[i].encoding;
    if (h->fields[FIELD_ENDIAN] == NULL) {
        if (out->encoding == TY_NRRD_TEXT || ty_sample_size(out->type) == 1) return TY_OK;
        return ty_fail(h->context, TY_ERROR_INPUT, "%s: NRRD header: the field endian is missing", h->path);
    }
    out->big_endian = strcasecmp(h->fields[FIELD_ENDIAN], "big") == 0;
    if (out->big_endian || strcasecmp(h->fields[FIELD_ENDIAN], "little") == 0) return TY_OK;
    return fail_field(h, FIELD_ENDIAN, "is neither little nor big");
}

static ty_result read_skip(const header* h, field which, int64_t min_value, int64_t* out) {
    if (h->fields[which] == NULL) return TY_OK;
    const char* end;
    *out = ty_parse_integer(h->fields[which], &end);
    if (end == h->fields[which] || *end != '\0' || *out < min_value)
        return fail_field(h, which, "is not a number of lines or bytes to skip");
    return TY_OK;
}

static ty_result read_axes(header* h) {
    const char *end, *text = h->fields[FIELD_DIMENSION];
    const int64_t axes = ty_parse_integer(text, &end);
    if (end == text || *end != '\0' || axes < 2 || axes > 4) return fail_field(h, FIELD_DIMENSION, "is not 2, 3 or 4");
    h->axes = (int)axes;
    text = h->fields[FIELD_SIZES];
    for (int a = 0; a < h->axes; ++a) {
        h->sizes[a] = ty_parse_integer(text, &end);
        if (end == text) return fail_field(h, FIELD_SIZES, "is not one whole number per axis");
        if (h->sizes[a] < 1) return fail_field(h, FIELD_SIZES, "has an axis without samples");
        text = end;
    }
    if (*skip_blanks(text) != '\0') return fail_field(h, FIELD_SIZES, "is not one whole number per axis");
    return TY_OK;
}

/* Length of the next word of *text, up to a blank. */
static size_t next_word(const char** text) {
    *text = skip_blanks(*text);
    return strcspn(*text, " \t");
}

static bool word_is(const char* text, size_t length, const char* word) {
    return strlen(word) == length && strncasecmp(text, word, length) == 0;
}

static bool is_component_kind(const char* text, size_t length) {
    static const char* const others[] = {"domain", "space", "time", "none", "???"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        if (word_is(text, length, others[i])) return false;
    return length > 0;
}

static int find_time_axis(const header* h) {
    const char* kinds = h->fields[FIELD_KINDS];
    for (int a = 0; a < h->axes && kinds != NULL; ++a) {
        const size_t length = next_word(&kinds);
        if (word_is(kinds, length, "time")) return a;
        kinds += length;
    }
    return -1;
}

/* The only axis without a direction, if all others have one; -1 otherwise. */
static int find_axis_without_direction(const header* h) {
    const char* text = h->fields[FIELD_DIRECTIONS];
    int found = -1, count = 0;
    for (int a = 0; a < h->axes && text != NULL; ++a) {
        const size_t length = next_word(&text);
        if (word_is(text, length, "none")) {
            found = a;
            ++count;
            text += length;
        } else if ((text = strchr(text, ')')) != NULL) {
            ++text;
        }
    }
    return count == 1 ? found : -1;
}

/* Axis of components or times: the only one so declared by kinds or without a direction in space, else, of four, the
 * first or the last if it is short; -1 if there is none or it is ambiguous. */
static int find_component_axis(const header* h) {
    int found = -1, count = 0;
    const char* kinds = h->fields[FIELD_KINDS];
    for (int a = 0; a < h->axes && kinds != NULL; ++a) {
        const size_t length = next_word(&kinds);
        if (is_component_kind(kinds, length)) {
            found = a;
            ++count;
        }
        kinds += length;
    }
    if (count > 0) return count == 1 ? found : -1;
    const int bare = find_axis_without_direction(h);
    if (bare >= 0 || h->axes < AXES_MAX) return bare;
    if (find_time_axis(h) >= 0) return find_time_axis(h);
    return h->sizes[0] <= COMPONENTS_GUESSED_MAX ? 0 : h->sizes[3] <= COMPONENTS_GUESSED_MAX ? 3 : -1;
}

static ty_result choose_axes(header* h, ty_nrrd* out) {
    h->component_axis = -1;
    out->components = 1;
    h->component_axis = h->axes == 2 ? -1 : find_component_axis(h);
    const int last = h->axes - 1;
    if (h->axes == 4 || h->component_axis >= 0) {
        if (h->component_axis != 0 && h->component_axis != last)
            return fail_field(h, FIELD_SIZES,
                              "has an axis of components or times, but neither the first nor the last is one");
        const int64_t components = h->sizes[h->component_axis];
        if (components > COMPONENTS_MAX) return fail_field(h, FIELD_SIZES, "has too many values per voxel");
        out->components = (int32_t)components;
        out->components_last = h->component_axis == last;
    }
    const int first = h->component_axis == 0 ? 1 : 0, count = h->axes - (h->component_axis >= 0);
    int64_t sizes[3] = {1, 1, 1}; /* an image is a volume one voxel deep */
    for (int a = 0; a < count; ++a) sizes[a] = h->sizes[first + a];
    const ty_result result = ty_check_volume_size(h->context, h->path, sizes, &out->voxels);
    for (int a = 0; a < 3 && result == TY_OK; ++a) out->size[a] = (int32_t)sizes[a];
    return result;
}

/* Parses "(x, y, z)" or, of images, "(x, y)"; false for other text. */
static bool read_vector(const header* h, const char** text, double vector[3]) {
    const char* at = skip_blanks(*text);
    int count = 0;
    if (*at != '(') return false;
    do {
        const char* end;
        vector[count] = ty_parse_number(at + 1, &end);
        if (end == at + 1 || !isfinite(vector[count])) return false;
        at = skip_blanks(end);
    } while (++count < 3 && *at == ',');
    if (*at != ')' || count < (h->axes - (h->component_axis >= 0) < 3 ? 2 : 3)) return false;
    if (count == 2) vector[2] = 0;
    *text = at + 1;
    return true;
}

/* Directions that are "none" for every axis say nothing. */
static bool has_directions(const header* h) {
    const char* text = h->fields[FIELD_DIRECTIONS];
    return text != NULL && strchr(text, '(') != NULL;
}

/* The third axis of an image is perpendicular to it, one unit long. */
static void add_perpendicular(ty_affine* map) {
    double* m = map->m;
    const double n[3] = {m[4] * m[9] - m[8] * m[5], m[8] * m[1] - m[0] * m[9], m[0] * m[5] - m[4] * m[1]};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int r = 0; r < 3; ++r) m[4 * r + 2] = length > 0 ? n[r] / length : 0;
}

static ty_result read_directions(const header* h, ty_affine* map) {
    const char* text = h->fields[FIELD_DIRECTIONS];
    int column = 0;
    for (int a = 0; a < h->axes; ++a) {
        double vector[3];
        if (a == h->component_axis) {
            const size_t length = next_word(&text);
            if (word_is(text, length, "none"))
                text += length;
            else if (!read_vector(h, &text, vector))
                return fail_field(h, FIELD_DIRECTIONS, "is not a vector of three numbers or none per axis");
            continue;
        }
        if (!read_vector(h, &text, vector))
            return fail_field(h, FIELD_DIRECTIONS, "does not give each axis of space a vector of three numbers");
        for (int r = 0; r < 3; ++r) map->m[4 * r + column] = vector[r];
        ++column;
    }
    if (column == 2) add_perpendicular(map);
    ty_affine inverse;
    if (*skip_blanks(text) != '\0') return fail_field(h, FIELD_DIRECTIONS, "gives more vectors than there are axes");
    if (!ty_affine_invert(map, &inverse)) return fail_field(h, FIELD_DIRECTIONS, "cannot be inverted");
    return TY_OK;
}

/* An unknown spacing (nan) counts as 1. */
static ty_result read_spacings(const header* h, ty_affine* map) {
    const char *text = h->fields[FIELD_SPACINGS], *end;
    int axis = 0;
    for (int a = 0; a < h->axes; ++a) {
        const double spacing = ty_parse_number(text, &end);
        if (end == text) return fail_field(h, FIELD_SPACINGS, "is not one number per axis");
        text = end;
        if (a == h->component_axis) continue;
        if (!isnan(spacing) && !(spacing > 0 && spacing <= 1e15))
            return fail_field(h, FIELD_SPACINGS, "has a spacing outside (0, 1e15]");
        map->m[5 * axis++] = isnan(spacing) ? 1 : spacing;
    }
    if (*skip_blanks(text) != '\0') return fail_field(h, FIELD_SPACINGS, "is not one number per axis");
    return TY_OK;
}

static ty_result read_placement(const header* h, ty_nrrd* out) {
    out->index_to_local = ty_affine_identity();
    ty_result result = TY_OK;
    if (has_directions(h))
        result = read_directions(h, &out->index_to_local);
    else if (h->fields[FIELD_SPACINGS] != NULL)
        result = read_spacings(h, &out->index_to_local);
    if (result != TY_OK || h->fields[FIELD_ORIGIN] == NULL) return result;
    const char* text = h->fields[FIELD_ORIGIN];
    double origin[3];
    if (!read_vector(h, &text, origin) || *skip_blanks(text) != '\0')
        return fail_field(h, FIELD_ORIGIN, "is not a vector of three numbers");
    for (int r = 0; r < 3; ++r) out->index_to_local.m[4 * r + 3] = origin[r];
    return TY_OK;
}

ty_result ty_nrrd_parse(ty_context* context, const char* path, uint8_t* bytes, size_t size, ty_nrrd* out) {
    header h = {.context = context, .path = path};
    *out = (ty_nrrd){0};
    ty_result result = check_magic(&h, bytes, size);
    if (result == TY_OK) result = split_lines(&h, bytes, size, &out->data);
    if (result == TY_OK) result = check_present(&h);
    if (result == TY_OK) result = read_type(&h, out);
    if (result == TY_OK) result = read_encoding(&h, out);
    if (result == TY_OK) result = read_axes(&h);
    if (result == TY_OK) result = choose_axes(&h, out);
    if (result == TY_OK) result = read_placement(&h, out);
    if (result == TY_OK) result = read_skip(&h, FIELD_LINE_SKIP, 0, &out->line_skip);
    if (result == TY_OK) result = read_skip(&h, FIELD_BYTE_SKIP, -1, &out->byte_skip);
    if (result == TY_OK && out->byte_skip < 0 && out->encoding != TY_NRRD_RAW)
        result = fail_field(&h, FIELD_BYTE_SKIP, "is for raw data only");
    out->data_file = h.fields[FIELD_DATA_FILE];
    return result;
}
