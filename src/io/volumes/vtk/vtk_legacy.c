/* Legacy .vtk files of structured points: keywords and text, or big-endian values between them. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"
#include "base/number.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { WORD_SIZE = 256, LINES_BEFORE = 3 };

typedef struct reader {
    ty_vtk_image* image;
    size_t at;
    bool binary, dataset, dimensions;
    int section;     /* 0: none yet, 1: point data, 2: cell data */
    bool cut;        /* the beginning of the file ended */
    uint64_t tuples; /* values of the section */
} reader;

/* ---- words ---- */

static void skip_blanks(reader* r) {
    const ty_vtk_image* image = r->image;
    while (r->at < image->size && isspace(image->bytes[r->at])) ++r->at;
}

/* The next word, cut to the size; "" at the end. */
static void take_word(reader* r, char word[WORD_SIZE]) {
    const ty_vtk_image* image = r->image;
    size_t length = 0;
    skip_blanks(r);
    for (; r->at < image->size && !isspace(image->bytes[r->at]); ++r->at)
        if (length + 1 < WORD_SIZE) word[length++] = (char)image->bytes[r->at];
    word[length] = '\0';
}

static void skip_line(reader* r) {
    const ty_vtk_image* image = r->image;
    const uint8_t* newline = memchr(image->bytes + r->at, '\n', image->size - r->at);
    r->at = newline != NULL ? (size_t)(newline - image->bytes) + 1 : image->size;
}

/* The word that follows in the same line; "" without one. */
static void take_word_of_line(reader* r, char word[WORD_SIZE]) {
    const ty_vtk_image* image = r->image;
    while (r->at < image->size && memchr(" \t\r", image->bytes[r->at], 3) != NULL) ++r->at;
    word[0] = '\0';
    if (r->at < image->size && image->bytes[r->at] != '\n') take_word(r, word);
}

static ty_result fail_word(const reader* r, const char* word, const char* what) {
    char shown[64];
    size_t length = 0;
    for (; word[length] != '\0' && length + 1 < sizeof shown; ++length)
        shown[length] = isprint((unsigned char)word[length]) ? word[length] : '?';
    shown[length] = '\0';
    return ty_fail(r->image->context, TY_ERROR_INPUT, "%s: \"%s\" %s", r->image->path, shown, what);
}

static ty_result take_count(reader* r, uint64_t* out) {
    char word[WORD_SIZE];
    const char* end;
    take_word(r, word);
    const int64_t value = ty_parse_integer(word, &end);
    if (end == word || *end != '\0' || value < 0) return fail_word(r, word, "is not a whole number");
    *out = (uint64_t)value;
    return TY_OK;
}

static ty_result take_numbers(reader* r, double out[3]) {
    for (int a = 0; a < 3; ++a) {
        char word[WORD_SIZE];
        const char* end;
        take_word(r, word);
        out[a] = ty_parse_number(word, &end);
        if (end == word || *end != '\0' || !(out[a] >= -1e30 && out[a] <= 1e30))
            return fail_word(r, word, "is not a number");
    }
    return TY_OK;
}

/* ---- values ---- */

static ty_sample_type type_of(const char* name) {
    static const struct {
        const char* name;
        ty_sample_type type;
    } types[] = {{"char", TY_SAMPLE_INT8},
                 {"signed_char", TY_SAMPLE_INT8},
                 {"unsigned_char", TY_SAMPLE_UINT8},
                 {"short", TY_SAMPLE_INT16},
                 {"unsigned_short", TY_SAMPLE_UINT16},
                 {"int", TY_SAMPLE_INT32},
                 {"vtkIdType", TY_SAMPLE_INT32},
                 {"unsigned_int", TY_SAMPLE_UINT32},
                 {"long", TY_SAMPLE_INT64},
                 {"unsigned_long", TY_SAMPLE_UINT64},
                 {"vtktypeint64", TY_SAMPLE_INT64},
                 {"vtktypeuint64", TY_SAMPLE_UINT64},
                 {"float", TY_SAMPLE_FLOAT},
                 {"double", TY_SAMPLE_DOUBLE}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (strcasecmp(name, types[i].name) == 0) return types[i].type;
    return TY_SAMPLE_TYPES;
}

/* Passes `count` values of a type; fails where the file is shorter. */
static ty_result skip_values(reader* r, const char* name, ty_sample_type type, uint64_t count) {
    const ty_vtk_image* image = r->image;
    const uint64_t size = r->binary ? ty_sample_size(type) : 2, left = image->size - r->at;
    if (count > UINT64_MAX / size || count * size > left + 1) { /* text may end without a blank */
        r->cut = image->beginning;
        if (r->cut) return TY_OK;
        return ty_vtk_damaged(image, name, "is cut short");
    }
    if (r->binary) {
        if (count * size > left) return ty_vtk_damaged(image, name, "is cut short");
        r->at += (size_t)(count * size);
        return TY_OK;
    }
    for (; count > 0; --count) {
        skip_blanks(r);
        if (r->at == image->size) {
            r->cut = image->beginning;
            return r->cut ? TY_OK : ty_vtk_damaged(image, name, "is cut short");
        }
        while (r->at < image->size && !isspace(image->bytes[r->at])) ++r->at;
    }
    return TY_OK;
}

/* Names have blanks as %20. */
static void decode_name(const char* from, char to[TY_VTK_NAME_SIZE]) {
    size_t length = 0;
    for (; *from != '\0' && length + 1 < TY_VTK_NAME_SIZE; ++from) {
        if (from[0] == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2])) {
            const char digits[3] = {from[1], from[2], '\0'};
            to[length++] = (char)strtol(digits, NULL, 16);
            from += 2;
        } else {
            to[length++] = *from;
        }
    }
    to[length] = '\0';
}

/* The values of an array, which begin after the line. */
static ty_result take_array(reader* r, const char* name, const char* type_name, ty_sample_type type,
                            uint64_t components, uint64_t tuples, bool kept) {
    ty_vtk_array array = {.type = type, .cells = r->section == 2, .form = r->binary ? TY_VTK_PLAIN : TY_VTK_TEXT};
    decode_name(name, array.name);
    if (type == TY_SAMPLE_TYPES) return fail_word(r, type_name, "is not a type of values that can be read");
    if (components < 1 || components > TY_VTK_COMPONENTS_MAX)
        return ty_vtk_damaged(r->image, array.name, "does not have 1 to 65536 values each");
    array.components = (int32_t)components;
    array.at = r->at;
    if (tuples > UINT64_MAX / components) return ty_vtk_damaged(r->image, array.name, "is cut short");
    ty_result result = skip_values(r, array.name, type, tuples * components);
    array.end = r->at;
    if (result == TY_OK && kept && !r->cut) result = ty_vtk_add_array(r->image, &array);
    return result;
}

/* ---- keywords ---- */

static ty_result read_dimensions(reader* r) {
    uint64_t sides[3];
    for (int a = 0; a < 3; ++a) {
        const ty_result result = take_count(r, &sides[a]);
        if (result != TY_OK) return result;
        if (sides[a] < 1 || sides[a] > INT32_MAX)
            return ty_fail(r->image->context, TY_ERROR_INPUT, "%s: DIMENSIONS are not from 1 on", r->image->path);
        r->image->extent[2 * a] = 0;
        r->image->extent[2 * a + 1] = (int64_t)sides[a] - 1;
    }
    r->dimensions = true;
    return TY_OK;
}

static ty_result read_section(reader* r, const char* keyword) {
    int64_t sides[3];
    r->section = strcasecmp(keyword, "CELL_DATA") == 0 ? 2 : 1;
    ty_result result = take_count(r, &r->tuples);
    if (result != TY_OK) return result;
    if (!r->dimensions) return fail_word(r, keyword, "stands before DIMENSIONS");
    ty_vtk_sides(r->image->extent, r->section == 2, sides);
    const double product = (double)sides[0] * (double)sides[1] * (double)sides[2];
    if (product != (double)r->tuples)
        return ty_fail(r->image->context, TY_ERROR_INPUT, "%s: %s are %llu, which do not go with the DIMENSIONS",
                       r->image->path, keyword, (unsigned long long)r->tuples);
    return TY_OK;
}

static ty_result read_field(reader* r) {
    char name[WORD_SIZE], type[WORD_SIZE];
    uint64_t arrays = 0, components = 0, tuples = 0;
    take_word(r, name);
    ty_result result = take_count(r, &arrays);
    for (; arrays > 0 && result == TY_OK && !r->cut; --arrays) {
        take_word(r, name);
        if (strcasecmp(name, "METADATA") == 0) { /* of the array before */
            while (r->at < r->image->size && name[0] != '\0') {
                skip_line(r);
                take_word_of_line(r, name);
            }
            take_word(r, name);
        }
        result = take_count(r, &components);
        if (result == TY_OK) result = take_count(r, &tuples);
        take_word(r, type);
        skip_line(r);
        if (result == TY_OK)
            result =
                take_array(r, name, type, type_of(type), components, tuples, r->section > 0 && tuples == r->tuples);
    }
    return result;
}

static ty_result read_scalars(reader* r) {
    char name[WORD_SIZE], type[WORD_SIZE], components[WORD_SIZE], keyword[WORD_SIZE], table[WORD_SIZE];
    take_word(r, name);
    take_word(r, type);
    take_word_of_line(r, components);
    skip_line(r);
    const size_t start = r->at;
    take_word(r, keyword);
    take_word_of_line(r, table);
    const char* end;
    const int64_t size = components[0] != '\0' ? ty_parse_integer(components, &end) : 1;
    if (strcasecmp(keyword, "LOOKUP_TABLE") == 0)
        skip_line(r);
    else
        r->at = start;
    return take_array(r, name, type, type_of(type), size > 0 ? (uint64_t)size : 0, r->tuples, true);
}

/* Arrays whose keyword tells the number of their components; 0: a number follows. */
static const struct {
    const char* keyword;
    uint64_t components;
    bool typed;
} attributes[] = {
    {"VECTORS", 3, true},    {"NORMALS", 3, true},      {"TENSORS", 9, true},        {"TENSORS6", 6, true},
    {"GLOBAL_IDS", 1, true}, {"PEDIGREE_IDS", 1, true}, {"COLOR_SCALARS", 0, false}, {"TEXTURE_COORDINATES", 0, true}};
enum { ATTRIBUTES = sizeof attributes / sizeof attributes[0] };

static ty_result read_attribute(reader* r, int i) {
    char name[WORD_SIZE], type[WORD_SIZE] = "";
    uint64_t components = attributes[i].components;
    take_word(r, name);
    ty_result result = components == 0 ? take_count(r, &components) : TY_OK;
    if (result != TY_OK) return result;
    if (attributes[i].typed) take_word(r, type);
    skip_line(r);
    const ty_sample_type colors = r->binary ? TY_SAMPLE_UINT8 : TY_SAMPLE_FLOAT;
    return take_array(r, name, type, attributes[i].typed ? type_of(type) : colors, components, r->tuples, true);
}

static ty_result read_table(reader* r) {
    char name[WORD_SIZE];
    uint64_t size = 0;
    take_word(r, name);
    const ty_result result = take_count(r, &size);
    if (result != TY_OK) return result;
    skip_line(r);
    return skip_values(r, name, TY_SAMPLE_UINT32, r->binary ? size : size < UINT64_MAX / 4 ? 4 * size : UINT64_MAX);
}

static void skip_metadata(reader* r) {
    char word[WORD_SIZE];
    do {
        skip_line(r);
        take_word_of_line(r, word);
    } while (word[0] != '\0' && r->at < r->image->size);
}

static ty_result read_keyword(reader* r, const char* keyword) {
    ty_vtk_image* image = r->image;
    char word[WORD_SIZE];
    if (strcasecmp(keyword, "DATASET") == 0) {
        take_word(r, word);
        r->dataset = strcasecmp(word, "STRUCTURED_POINTS") == 0;
        return r->dataset ? TY_OK : fail_word(r, word, "is the kind of its data; STRUCTURED_POINTS can be read");
    }
    if (strcasecmp(keyword, "DIMENSIONS") == 0) return read_dimensions(r);
    if (strcasecmp(keyword, "ORIGIN") == 0) return take_numbers(r, image->origin);
    if (strcasecmp(keyword, "SPACING") == 0 || strcasecmp(keyword, "ASPECT_RATIO") == 0)
        return take_numbers(r, image->spacing);
    if (strcasecmp(keyword, "FIELD") == 0) return read_field(r);
    if (strcasecmp(keyword, "METADATA") == 0) {
        skip_metadata(r);
        return TY_OK;
    }
    if (strcasecmp(keyword, "POINT_DATA") == 0 || strcasecmp(keyword, "CELL_DATA") == 0)
        return read_section(r, keyword);
    if (r->section > 0 && strcasecmp(keyword, "SCALARS") == 0) return read_scalars(r);
    if (r->section > 0 && strcasecmp(keyword, "LOOKUP_TABLE") == 0) return read_table(r);
    for (int i = 0; i < ATTRIBUTES && r->section > 0; ++i)
        if (strcasecmp(keyword, attributes[i].keyword) == 0) return read_attribute(r, i);
    return fail_word(r, keyword, "is not a keyword that can stand there in a .vtk file of structured points");
}

ty_result ty_vtk_legacy_parse(ty_vtk_image* image) {
    reader r = {.image = image};
    char word[WORD_SIZE];
    for (int i = 0; i < 9; ++i) image->direction[i] = i % 4 == 0;
    for (int a = 0; a < 3; ++a) image->spacing[a] = 1;
    image->big_endian = true;
    for (int i = 0; i + 1 < LINES_BEFORE; ++i) skip_line(&r); /* the version and a title */
    take_word(&r, word);
    r.binary = strcasecmp(word, "BINARY") == 0;
    if (!r.binary && strcasecmp(word, "ASCII") != 0) return fail_word(&r, word, "is neither ASCII nor BINARY");
    ty_result result = TY_OK;
    while (result == TY_OK && !r.cut) {
        take_word(&r, word);
        if (word[0] == '\0') break;
        if (image->beginning && r.at == image->size) break;
        result = read_keyword(&r, word);
    }
    if (image->beginning && r.at == image->size) result = TY_OK; /* it ended within a line */
    image->complete = !image->beginning;
    if (result == TY_OK && !image->beginning && (!r.dataset || !r.dimensions))
        return ty_fail(image->context, TY_ERROR_INPUT, "%s: there is no DATASET with DIMENSIONS", image->path);
    return result;
}
