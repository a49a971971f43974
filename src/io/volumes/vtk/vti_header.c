/* The XML of .vti files, by Expat, up to the appended data, which need not be XML. Arrays within the XML are located by
 * their bytes, so that their values are copied once. */
#include "io/volumes/vtk/vtk.h"

#include "base/context.h"
#include "base/number.h"

#include <string.h>

#if TYNDALL_EXPAT

#include <expat.h>
#include <stdarg.h>

enum { DEPTH_MAX = 32, PART = 1 << 24 };

typedef enum section { SECTION_NONE, SECTION_POINTS, SECTION_CELLS } section;

typedef struct header {
    ty_vtk_image* image;
    XML_Parser parser;
    ty_result result;
    int depth;                  /* of the element that the parser is in */
    int array_depth;            /* of the DataArray that it is in, or 0 */
    int64_t whole[6], piece[6]; /* extents */
    bool image_data, appended;
    section section;
    char scalars[TY_VTK_NAME_SIZE]; /* the section's own choice */
    ty_vtk_array array;
    bool has_offset;
    uint64_t offset;
} header;

/* Ends the parsing with a message that names the line. */
__attribute__((format(printf, 2, 3))) static void stop(header* h, const char* format, ...) {
    if (h->result == TY_OK) {
        char text[512];
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(text, sizeof text, format, arguments);
        va_end(arguments);
        h->result = ty_fail(h->image->context, TY_ERROR_INPUT, "%s:%lu: %s", h->image->path,
                            (unsigned long)XML_GetCurrentLineNumber(h->parser), text);
    }
    XML_StopParser(h->parser, XML_FALSE);
}

static const char* attribute(const char** attributes, const char* name) {
    for (; attributes[0] != NULL; attributes += 2)
        if (strcmp(attributes[0], name) == 0) return attributes[1];
    return NULL;
}

/* Reads `count` finite numbers of an attribute; an absent one leaves them as they are. */
static void read_numbers(header* h, const char** attributes, const char* name, int count, double* out) {
    const char* text = attribute(attributes, name);
    if (text == NULL) return;
    const char* at = text;
    for (int i = 0; i < count; ++i) {
        const char* end;
        out[i] = ty_parse_number(at, &end);
        if (end == at || !(out[i] >= -1e30 && out[i] <= 1e30)) {
            stop(h, "\"%.100s\" is not a list of the numbers that it takes", text);
            return;
        }
        at = end;
    }
    if (at[strspn(at, " \t\r\n")] != '\0') stop(h, "\"%.100s\" has too many numbers", text);
}

static void read_extent(header* h, const char** attributes, const char* name, int64_t extent[6]) {
    double numbers[6];
    if (attribute(attributes, name) == NULL) {
        stop(h, "%s is missing", name);
        return;
    }
    read_numbers(h, attributes, name, 6, numbers);
    for (int i = 0; i < 6 && h->result == TY_OK; ++i) {
        if (!(numbers[i] >= -2e9 && numbers[i] <= 2e9) || numbers[i] != (double)(int64_t)numbers[i] ||
            (i % 2 == 1 && numbers[i] < numbers[i - 1])) {
            stop(h, "%s does not have a first and a last index along each axis", name);
            return;
        }
        extent[i] = (int64_t)numbers[i];
    }
}

static void start_file(header* h, const char** attributes) {
    const char *type = attribute(attributes, "type"), *order = attribute(attributes, "byte_order"),
               *words = attribute(attributes, "header_type"), *compressor = attribute(attributes, "compressor");
    if (type == NULL || strcmp(type, "ImageData") != 0)
        stop(h, "a VTK file of type \"%.60s\"; ImageData can be read", type != NULL ? type : "");
    if (order != NULL && strcmp(order, "BigEndian") != 0 && strcmp(order, "LittleEndian") != 0)
        stop(h, "the byte order \"%.60s\" is not known", order);
    if (words != NULL && strcmp(words, "UInt32") != 0 && strcmp(words, "UInt64") != 0)
        stop(h, "the header type \"%.60s\" is neither UInt32 nor UInt64", words);
    if (compressor != NULL && compressor[0] != '\0' && strcmp(compressor, "vtkZLibDataCompressor") != 0)
        stop(h, "data of \"%.60s\" cannot be read; those of vtkZLibDataCompressor can", compressor);
    h->image->big_endian = order != NULL && strcmp(order, "BigEndian") == 0;
    h->image->wide = words != NULL && strcmp(words, "UInt64") == 0;
    h->image->compressed = compressor != NULL && compressor[0] != '\0';
}

static ty_sample_type type_of(const char* name) {
    static const struct {
        const char* name;
        ty_sample_type type;
    } types[] = {{"Int8", TY_SAMPLE_INT8},     {"UInt8", TY_SAMPLE_UINT8},   {"Int16", TY_SAMPLE_INT16},
                 {"UInt16", TY_SAMPLE_UINT16}, {"Int32", TY_SAMPLE_INT32},   {"UInt32", TY_SAMPLE_UINT32},
                 {"Int64", TY_SAMPLE_INT64},   {"UInt64", TY_SAMPLE_UINT64}, {"Float32", TY_SAMPLE_FLOAT},
                 {"Float64", TY_SAMPLE_DOUBLE}};
    for (size_t i = 0; i < sizeof types / sizeof types[0] && name != NULL; ++i)
        if (strcmp(name, types[i].name) == 0) return types[i].type;
    return TY_SAMPLE_TYPES;
}

/* A whole number of an attribute, which may be absent. */
static uint64_t read_count(header* h, const char** attributes, const char* name, uint64_t missing) {
    const char *text = attribute(attributes, name), *end;
    if (text == NULL) return missing;
    const int64_t value = ty_parse_integer(text, &end);
    if (end == text || end[strspn(end, " \t\r\n")] != '\0' || value < 0)
        stop(h, "\"%.60s\" is not a whole number", text);
    return value < 0 ? 0 : (uint64_t)value;
}

/* A piece among others lies in the whole extent; a single one is the whole. */
static void start_piece(header* h, const char** attributes) {
    ty_vtk_image* image = h->image;
    read_extent(h, attributes, "Extent", h->piece);
    memcpy(image->extent, ++image->pieces > 1 ? h->whole : h->piece, sizeof image->extent);
}

static void start_array(header* h, const char** attributes) {
    const char *name = attribute(attributes, "Name"), *format = attribute(attributes, "format");
    const uint64_t components = read_count(h, attributes, "NumberOfComponents", 1);
    h->array = (ty_vtk_array){.type = type_of(attribute(attributes, "type")), .cells = h->section == SECTION_CELLS};
    h->array.piece = h->image->pieces - 1;
    memcpy(h->array.extent, h->piece, sizeof h->array.extent);
    snprintf(h->array.name, sizeof h->array.name, "%s", name != NULL ? name : "");
    if (components < 1 || components > TY_VTK_COMPONENTS_MAX)
        stop(h, "the array \"%.100s\" does not have 1 to 65536 components", h->array.name);
    h->array.components = (int32_t)(components <= TY_VTK_COMPONENTS_MAX ? components : 0);
    h->array.active = h->scalars[0] != '\0' && strcmp(h->scalars, h->array.name) == 0;
    h->has_offset = format != NULL && strcmp(format, "appended") == 0;
    h->offset = read_count(h, attributes, "offset", 0);
    if (format == NULL || strcmp(format, "ascii") == 0)
        h->array.form = TY_VTK_TEXT;
    else if (strcmp(format, "binary") == 0)
        h->array.form = TY_VTK_BASE64;
    else if (h->has_offset)
        h->array.form = TY_VTK_RAW; /* or base64, which the appended data tell */
    else
        stop(h, "the format \"%.60s\" is not ascii, binary or appended", format);
    h->array_depth = h->depth;
    h->array.at = (uint64_t)XML_GetCurrentByteIndex(h->parser) + (uint64_t)XML_GetCurrentByteCount(h->parser);
}

/* Keys of an array stand before or behind its values. */
static void start_key(header* h) {
    const size_t here = (size_t)XML_GetCurrentByteIndex(h->parser);
    size_t at = (size_t)h->array.at;
    while (at < here && memchr(" \t\r\n", h->image->bytes[at], 4) != NULL) ++at;
    if (at < here && h->array.end == 0) h->array.end = here;
}

/* Offsets become bytes of the file, which begin behind an underscore. */
static void start_appended(header* h, const char** attributes) {
    const char* encoding = attribute(attributes, "encoding");
    const bool base64 = encoding == NULL || strcmp(encoding, "base64") == 0;
    ty_vtk_image* image = h->image;
    size_t at = (size_t)XML_GetCurrentByteIndex(h->parser) + (size_t)XML_GetCurrentByteCount(h->parser);
    if (!base64 && strcmp(encoding, "raw") != 0) {
        stop(h, "appended data of encoding \"%.60s\" cannot be read; raw and base64 can", encoding);
        return;
    }
    while (at < image->size && memchr(" \t\r\n", image->bytes[at], 4) != NULL) ++at;
    if (at >= image->size || image->bytes[at] != '_') {
        stop(h, "the appended data do not begin with an underscore");
        return;
    }
    for (size_t i = 0; i < image->count; ++i) {
        ty_vtk_array* array = &image->arrays[i];
        if (array->form != TY_VTK_RAW) continue;
        array->form = base64 ? TY_VTK_BASE64 : TY_VTK_RAW;
        array->at = array->at < UINT64_MAX / 2 ? array->at + at + 1 : UINT64_MAX;
        array->end = UINT64_MAX;
    }
    h->appended = true;
    image->complete = true;
    XML_StopParser(h->parser, XML_FALSE);
}

static void start_section(header* h, const char** attributes, section entered) {
    const char* scalars = attribute(attributes, "Scalars");
    h->section = entered;
    snprintf(h->scalars, sizeof h->scalars, "%s", scalars != NULL ? scalars : "");
}

static void XMLCALL start_element(void* user, const char* name, const char** attributes) {
    header* h = user;
    if (h->result != TY_OK || h->appended) return; /* a stopped parser may still report an element */
    ++h->depth;
    if (h->array_depth > 0) start_key(h);
    if (h->depth > DEPTH_MAX) {
        stop(h, "elements are nested too deep at \"%.60s\"", name);
    } else if (h->depth == 1) {
        if (strcmp(name, "VTKFile") != 0)
            stop(h, "the document is \"%.60s\", not a VTKFile", name);
        else
            start_file(h, attributes);
    } else if (h->depth == 2 && strcmp(name, "ImageData") == 0) {
        h->image_data = true;
        read_extent(h, attributes, "WholeExtent", h->whole);
        read_numbers(h, attributes, "Origin", 3, h->image->origin);
        read_numbers(h, attributes, "Spacing", 3, h->image->spacing);
        read_numbers(h, attributes, "Direction", 9, h->image->direction);
    } else if (h->depth == 3 && h->image_data && strcmp(name, "Piece") == 0) {
        start_piece(h, attributes);
    } else if (h->depth == 4 && h->image->pieces > 0 && strcmp(name, "PointData") == 0) {
        start_section(h, attributes, SECTION_POINTS);
    } else if (h->depth == 4 && h->image->pieces > 0 && strcmp(name, "CellData") == 0) {
        start_section(h, attributes, SECTION_CELLS);
    } else if (h->depth == 5 && h->section != SECTION_NONE && strcmp(name, "DataArray") == 0) {
        start_array(h, attributes);
    } else if (h->depth == 2 && strcmp(name, "AppendedData") == 0) {
        start_appended(h, attributes);
    }
}

static void XMLCALL end_element(void* user, const char* name) {
    header* h = user;
    (void)name;
    if (h->result != TY_OK || h->appended) return;
    const int depth = h->depth--;
    if (depth == 4) h->section = SECTION_NONE;
    if (h->array_depth == 0 || depth < h->array_depth) return;
    if (depth > h->array_depth) {
        if (h->array.end > 0) return;
        h->array.at = (uint64_t)XML_GetCurrentByteIndex(h->parser) + (uint64_t)XML_GetCurrentByteCount(h->parser);
        return;
    }
    h->array_depth = 0;
    if (h->array.end == 0) h->array.end = (uint64_t)XML_GetCurrentByteIndex(h->parser);
    if (h->has_offset) h->array.at = h->offset;
    h->result = ty_vtk_add_array(h->image, &h->array);
    if (h->result != TY_OK) XML_StopParser(h->parser, XML_FALSE);
}

/* Entities, which no writer uses, could be defined to be large. */
static void XMLCALL start_doctype(void* user, const char* name, const char* system, const char* public, int internal) {
    (void)system;
    (void)public;
    (void)internal;
    stop(user, "a document type, \"%.60s\", has no place in a VTK file", name);
}

static ty_result parse(header* h) {
    const ty_vtk_image* image = h->image;
    size_t at = 0;
    enum XML_Status status = XML_STATUS_OK;
    while (status == XML_STATUS_OK && at < image->size) {
        const size_t part = image->size - at < PART ? image->size - at : PART;
        const bool last = at + part == image->size && !image->beginning;
        status = XML_Parse(h->parser, (const char*)image->bytes + at, (int)part, last);
        at += part;
    }
    if (h->result != TY_OK || h->appended || status == XML_STATUS_OK) return h->result;
    const enum XML_Error error = XML_GetErrorCode(h->parser);
    if (error == XML_ERROR_NO_MEMORY)
        return ty_fail(image->context, TY_ERROR_MEMORY, "not enough memory to read %s", image->path);
    return ty_fail(image->context, TY_ERROR_INPUT, "%s:%lu: not XML: %s", image->path,
                   (unsigned long)XML_GetCurrentLineNumber(h->parser), XML_ErrorString(error));
}

static ty_result check(const header* h) {
    const ty_vtk_image* image = h->image;
    if (image->beginning && !h->appended) return TY_OK;
    if (!h->image_data || image->pieces == 0)
        return ty_fail(image->context, TY_ERROR_INPUT, "%s: there is no ImageData with a Piece", image->path);
    for (size_t i = 0; i < image->count; ++i)
        if (image->arrays[i].form == TY_VTK_RAW && !h->appended)
            return ty_vtk_damaged(image, image->arrays[i].name, "is appended, and there is no AppendedData");
    return TY_OK;
}

ty_result ty_vti_parse(ty_vtk_image* image) {
    header h = {.image = image, .parser = XML_ParserCreate(NULL)};
    if (h.parser == NULL) return ty_fail(image->context, TY_ERROR_MEMORY, "not enough memory to read %s", image->path);
    for (int i = 0; i < 9; ++i) image->direction[i] = i % 4 == 0;
    for (int a = 0; a < 3; ++a) image->spacing[a] = 1;
    image->complete = !image->beginning;
    XML_SetUserData(h.parser, &h);
    XML_SetElementHandler(h.parser, start_element, end_element);
    XML_SetStartDoctypeDeclHandler(h.parser, start_doctype);
    ty_result result = parse(&h);
    if (result == TY_OK) result = check(&h);
    XML_ParserFree(h.parser);
    return result;
}

#else

ty_result ty_vti_parse(ty_vtk_image* image) {
    return ty_fail(image->context, TY_ERROR_INPUT, "%s: this build reads no .vti files, which take Expat", image->path);
}

#endif
