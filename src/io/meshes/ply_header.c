/* PLY header: the file's elements and their properties. */
#include "base/context.h"
#include "base/number.h"
#include "io/meshes/ply.h"

#include <string.h>

size_t ty_ply_type_size(ty_ply_type type) {
    static const size_t sizes[TY_PLY_TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[type];
}

static ty_result fail(const ty_ply* ply, size_t line, const char* text) {
    return ty_fail(ply->context, TY_ERROR_INPUT, "%s:%zu: %s", ply->path, line, text);
}

static bool find_type(ty_word word, ty_ply_type* type) {
    static const struct {
        const char* name;
        ty_ply_type type;
    } names[] = {{"char", TY_PLY_I8},   {"uchar", TY_PLY_U8},   {"short", TY_PLY_I16},   {"ushort", TY_PLY_U16},
                 {"int", TY_PLY_I32},   {"uint", TY_PLY_U32},   {"float", TY_PLY_F32},   {"double", TY_PLY_F64},
                 {"int8", TY_PLY_I8},   {"uint8", TY_PLY_U8},   {"int16", TY_PLY_I16},   {"uint16", TY_PLY_U16},
                 {"int32", TY_PLY_I32}, {"uint32", TY_PLY_U32}, {"float32", TY_PLY_F32}, {"float64", TY_PLY_F64}};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (ty_word_is(word, names[i].name)) {
            *type = names[i].type;
            return true;
        }
    return false;
}

static int32_t vertex_role(ty_word word) {
    static const struct {
        const char* name;
        int32_t role;
    } names[] = {{"x", TY_PLY_X},        {"y", TY_PLY_X + 1},         {"z", TY_PLY_X + 2},
                 {"nx", TY_PLY_NORMAL},  {"ny", TY_PLY_NORMAL + 1},   {"nz", TY_PLY_NORMAL + 2},
                 {"s", TY_PLY_UV},       {"t", TY_PLY_UV + 1},        {"u", TY_PLY_UV},
                 {"v", TY_PLY_UV + 1},   {"texture_u", TY_PLY_UV},    {"texture_v", TY_PLY_UV + 1},
                 {"red", TY_PLY_COLOR},  {"green", TY_PLY_COLOR + 1}, {"blue", TY_PLY_COLOR + 2},
                 {"alpha", TY_PLY_ALPHA}};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (ty_word_is(word, names[i].name)) return names[i].role;
    return TY_PLY_NOTHING;
}

static ty_result read_format(ty_ply* ply, ty_words* line, size_t number) {
    ty_word name, version;
    if (!ty_next_word(line, &name) || !ty_next_word(line, &version) || !ty_word_is(version, "1.0"))
        return fail(ply, number, "the format is not one of version 1.0");
    if (ty_word_is(name, "ascii"))
        ply->format = TY_PLY_ASCII;
    else if (ty_word_is(name, "binary_little_endian"))
        ply->format = TY_PLY_LITTLE;
    else if (ty_word_is(name, "binary_big_endian"))
        ply->format = TY_PLY_BIG;
    else
        return fail(ply, number, "the format is not ascii, binary_little_endian or binary_big_endian");
    return TY_OK;
}

static ty_result read_element(ty_ply* ply, ty_words* line, size_t number) {
    ty_word name, count;
    const char* after = NULL;
    if (!ty_next_word(line, &name) || !ty_next_word(line, &count)) return fail(ply, number, "the element is damaged");
    const int64_t value = ty_parse_integer(count.text, &after);
    if (after != count.text + count.length || value < 0 || value > INT32_MAX)
        return fail(ply, number, "the number of elements is outside [0, 2147483647]");
    if (!ty_grow_array(ply->context, (void**)&ply->elements, &ply->element_capacity, ply->element_count,
                       sizeof *ply->elements))
        return TY_ERROR_MEMORY;
    const ty_ply_kind kind = ty_word_is(name, "vertex") ? TY_PLY_VERTEX
                             : ty_word_is(name, "face") ? TY_PLY_FACE
                                                        : TY_PLY_OTHER;
    for (size_t i = 0; i < ply->element_count && kind != TY_PLY_OTHER; ++i)
        if (ply->elements[i].kind == kind) return fail(ply, number, "the element is there twice");
    ply->elements[ply->element_count++] = (ty_ply_element){kind, (size_t)value, ply->property_count, 0};
    return TY_OK;
}

/* "property TYPE NAME" or "property list COUNT_TYPE TYPE NAME" */
static ty_result read_property(ty_ply* ply, ty_words* line, size_t number) {
    ty_ply_property property = {.role = TY_PLY_NOTHING};
    ty_word word;
    if (ply->element_count == 0) return fail(ply, number, "a property without an element");
    if (!ty_next_word(line, &word)) return fail(ply, number, "the property is damaged");
    property.list = ty_word_is(word, "list");
    if (property.list) {
        const bool counted = ty_next_word(line, &word) && find_type(word, &property.count_type);
        if (!counted || property.count_type >= TY_PLY_F32 || !ty_next_word(line, &word))
            return fail(ply, number, "the list has no type for its count");
    }
    ty_word name;
    if (!find_type(word, &property.type) || !ty_next_word(line, &name))
        return fail(ply, number, "the property has no known type or no name");
    ty_ply_element* element = &ply->elements[ply->element_count - 1];
    if (element->kind == TY_PLY_VERTEX && !property.list) property.role = vertex_role(name);
    const bool corners = ty_word_is(name, "vertex_indices") || ty_word_is(name, "vertex_index");
    if (element->kind == TY_PLY_FACE && property.list && corners) property.role = TY_PLY_CORNERS;
    if (!ty_grow_array(ply->context, (void**)&ply->properties, &ply->property_capacity, ply->property_count,
                       sizeof *ply->properties))
        return TY_ERROR_MEMORY;
    ply->properties[ply->property_count++] = property;
    ++element->property_count;
    return TY_OK;
}

static bool has_role(const ty_ply* ply, const ty_ply_element* element, int32_t role) {
    for (size_t i = 0; i < element->property_count; ++i)
        if (ply->properties[element->first + i].role == role) return true;
    return false;
}

static ty_result check_elements(const ty_ply* ply) {
    bool vertices = false, faces = false;
    for (size_t i = 0; i < ply->element_count; ++i) {
        const ty_ply_element* element = &ply->elements[i];
        if (element->kind == TY_PLY_VERTEX)
            vertices = has_role(ply, element, TY_PLY_X) && has_role(ply, element, TY_PLY_X + 1) &&
                       has_role(ply, element, TY_PLY_X + 2) && element->count > 0;
        if (element->kind == TY_PLY_FACE) faces = has_role(ply, element, TY_PLY_CORNERS) && element->count > 0;
    }
    if (!vertices) return ty_fail(ply->context, TY_ERROR_INPUT, "%s: there are no vertices with x, y and z", ply->path);
    if (!faces)
        return ty_fail(ply->context, TY_ERROR_INPUT, "%s: there are no faces with a list vertex_indices", ply->path);
    return TY_OK;
}

/* Reads a line up to a carriage return, which ends the lines of some files; data may begin with a newline. */
static bool next_cr_line(ty_words* text, ty_words* line, size_t* number) {
    if (text->at == text->end) return false;
    const char* end = memchr(text->at, '\r', (size_t)(text->end - text->at));
    *line = (ty_words){text->at, end != NULL ? end : text->end};
    text->at = end != NULL ? end + 1 : text->end;
    ++*number;
    return true;
}

ty_result ty_ply_read_header(ty_ply* ply) {
    const bool returns = ply->data.end - ply->data.at > 4 && ply->data.at[3] == '\r' && ply->data.at[4] != '\n';
    bool (*next_line)(ty_words*, ty_words*, size_t*) = returns ? next_cr_line : ty_next_line;
    ty_words line;
    ty_word word;
    size_t number = 0;
    bool format = false;
    if (!next_line(&ply->data, &line, &number) || !ty_next_word(&line, &word) || !ty_word_is(word, "ply"))
        return ty_fail(ply->context, TY_ERROR_INPUT, "%s: not a PLY file", ply->path);
    while (next_line(&ply->data, &line, &number)) {
        ty_result result = TY_OK;
        if (!ty_next_word(&line, &word)) continue;
        if (ty_word_is(word, "end_header"))
            return format ? check_elements(ply) : fail(ply, number, "the header has no format");
        if (ty_word_is(word, "format")) {
            result = read_format(ply, &line, number);
            format = true;
        } else if (ty_word_is(word, "element")) {
            result = read_element(ply, &line, number);
        } else if (ty_word_is(word, "property")) {
            result = read_property(ply, &line, number);
        } else if (!ty_word_is(word, "comment") && !ty_word_is(word, "obj_info")) {
            return fail(ply, number, "the header is damaged");
        }
        if (result != TY_OK) return result;
    }
    return ty_fail(ply->context, TY_ERROR_INPUT, "%s: the header has no end", ply->path);
}
