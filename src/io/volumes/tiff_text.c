/* Descriptions of TIFF stacks: the lines of ImageJ, and the Pixels element of OME-XML. */
#include "io/volumes/tiff_stack.h"

#include "base/number.h"

#include <stdio.h>
#include <string.h>

enum { PLANES_MAX = 1 << 24 };

static int32_t positive(double value) {
    return value >= 1 && value <= PLANES_MAX ? (int32_t)value : 1;
}

static double length_of(const char* text) {
    const char* end;
    const double value = ty_parse_number(text, &end);
    return end != text && value > 0 && value <= 1e15 ? value : 0;
}

/* ---- ImageJ ---- */

/* The value of a key at the start of a line, NULL without one. */
static const char* find_line(const char* text, const char* key) {
    const size_t length = strlen(key);
    for (const char* line = text; line != NULL; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (strncmp(line, key, length) == 0 && line[length] == '=') return line + length + 1;
    }
    return NULL;
}

static double line_number(const char* text, const char* key) {
    const char* value = find_line(text, key);
    return value != NULL ? length_of(value) : 0;
}

static void parse_imagej(const char* text, ty_stack_layout* out) {
    out->writer = TY_STACK_IMAGEJ;
    out->channels = positive(line_number(text, "channels"));
    out->times = positive(line_number(text, "frames"));
    const double images = line_number(text, "images"), slices = line_number(text, "slices");
    out->slices = positive(slices > 0 ? slices : images / ((double)out->channels * out->times));
    const char *spacing = find_line(text, "spacing"), *unit = find_line(text, "unit");
    if (spacing != NULL)
        out->spacing[2] = length_of(spacing + (*spacing == '-')); /* ImageJ takes it without its sign */
    if (unit == NULL) return;
    const bool escaped = strncmp(unit, "\\u00B5m", 7) == 0;
    snprintf(out->unit, sizeof out->unit, "%.*s", escaped ? 6 : (int)strcspn(unit, "\r\n"), escaped ? "micron" : unit);
}

/* ---- OME ---- */

/* The value of an attribute between `from` and `to`, up to its quote; NULL without one. */
static const char* find_attribute(const char* from, const char* to, const char* key) {
    const size_t length = strlen(key);
    for (const char* at = strstr(from, key); at != NULL && at < to; at = strstr(at + 1, key)) {
        const bool starts = at[-1] == ' ' || at[-1] == '\n' || at[-1] == '\t' || at[-1] == '\r';
        if (starts && at[length] == '=' && (at[length + 1] == '"' || at[length + 1] == '\'')) return at + length + 2;
    }
    return NULL;
}

static double attribute_number(const char* from, const char* to, const char* key) {
    const char* value = find_attribute(from, to, key);
    return value != NULL ? length_of(value) : 0;
}

/* A unit of length in micrometres, which are OME's default; 0 for one that is not known. */
static double unit_in_micrometres(const char* unit) {
    static const struct {
        const char* name;
        double micrometres;
    } units[] = {{"\xc2\xb5m", 1}, {"\xce\xbcm", 1}, {"um", 1},   {"nm", 1e-3}, {"pm", 1e-6}, {"\xc3\x85", 1e-4},
                 {"mm", 1e3},      {"cm", 1e4},      {"dm", 1e5}, {"m", 1e6},   {"km", 1e9}};
    for (size_t i = 0; i < sizeof units / sizeof units[0]; ++i) {
        const size_t length = strlen(units[i].name);
        if (strncmp(unit, units[i].name, length) == 0 && (unit[length] == '"' || unit[length] == '\''))
            return units[i].micrometres;
    }
    return 0;
}

/* Spacings in micrometres where all units are known, else as they are. */
static void parse_ome_spacing(const char* from, const char* to, ty_stack_layout* out) {
    static const char* const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    static const char* const units[] = {"PhysicalSizeXUnit", "PhysicalSizeYUnit", "PhysicalSizeZUnit"};
    double factors[3];
    bool known = true;
    for (int a = 0; a < 3; ++a) {
        const char* unit = find_attribute(from, to, units[a]);
        factors[a] = unit != NULL ? unit_in_micrometres(unit) : 1;
        known = known && factors[a] > 0;
        out->spacing[a] = attribute_number(from, to, sizes[a]);
    }
    for (int a = 0; a < 3 && known; ++a) out->spacing[a] *= factors[a];
    snprintf(out->unit, sizeof out->unit, "%s", known ? "micron" : "unknown");
}

static void parse_ome(const char* text, ty_stack_layout* out) {
    const char* from = strstr(text, "<Pixels");
    if (from == NULL) from = strstr(text, ":Pixels");
    const char* to = from != NULL ? strchr(from, '>') : NULL;
    if (to == NULL) return;
    out->writer = TY_STACK_OME;
    out->slices = positive(attribute_number(from, to, "SizeZ"));
    out->channels = positive(attribute_number(from, to, "SizeC"));
    out->times = positive(attribute_number(from, to, "SizeT"));
    const char* order = find_attribute(from, to, "DimensionOrder");
    if (order != NULL && strncmp(order, "XY", 2) == 0 && strspn(order + 2, "ZCT") == 3 && order[2] != order[3] &&
        order[3] != order[4] && order[2] != order[4])
        memcpy(out->order, order + 2, 3);
    parse_ome_spacing(from, to, out);
}

ty_stack_layout ty_stack_parse(const char* description) {
    ty_stack_layout out = {.slices = 1, .channels = 1, .times = 1, .order = "CZT"};
    if (description == NULL) return out;
    if (strncmp(description, "ImageJ=", 7) == 0)
        parse_imagej(description, &out);
    else if (strstr(description, "<OME") != NULL || strstr(description, ":OME") != NULL)
        parse_ome(description, &out);
    return out;
}
