/* Values of NetCDF variables: packing, missing values, units. */
#include "io/volumes/netcdf/netcdf.h"

#include "base/context.h"

#if TYNDALL_NETCDF

#include "io/volumes/netcdf/calls.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Ratio of deflate, beyond which a file cannot hold what it says; and the bytes that are read at once. */
enum { RATIO_MAX = 1032, PART = 1 << 22 };

/* Values from here on are the library's own marks of what was not written. */
static const double unwritten = 9.9e36;

void ty_netcdf_text(const ty_netcdf_file* file, int id, const char* attribute, char* text, size_t size) {
    enum { LONGEST = 255 };
    char found[LONGEST + 1] = "";
    char* string = NULL;
    nc_type type = NC_NAT;
    size_t length = 0;
    text[0] = '\0';
    if (file->calls->inq_att(file->id, id, attribute, &type, &length) != NC_NOERR) return;
    if (type == NC_CHAR && length <= LONGEST && file->calls->get_att_text(file->id, id, attribute, found) == NC_NOERR) {
        found[length] = '\0';
        snprintf(text, size, "%s", found);
    }
    if (type == NC_STRING && length == 1 && file->calls->get_att_string(file->id, id, attribute, &string) == NC_NOERR) {
        if (string != NULL) snprintf(text, size, "%s", string);
        file->calls->free_string(1, &string);
    }
}

/* ---- units ---- */

typedef struct unit {
    const char* name;
    double factor;
    bool ratio;
} unit;

/* Units without what their spellings differ in: "g m^-3" and "g m**-3" are "gm-3". */
static double find_unit(const unit* units, const char* text, bool* ratio) {
    char name[64];
    size_t length = 0;
    for (; *text != '\0' && length + 1 < sizeof name; ++text)
        if (strchr(" ^*_.()", *text) == NULL) name[length++] = *text;
    name[length] = '\0';
    for (; units->name != NULL; ++units)
        if (strcmp(units->name, name) == 0) {
            if (ratio != NULL) *ratio = units->ratio;
            return units->factor;
        }
    return 0;
}

double ty_netcdf_length_unit(const char* units) {
    static const unit known[] = {
        {"m", 1, 0},           {"meter", 1, 0},        {"meters", 1, 0},      {"metre", 1, 0},
        {"metres", 1, 0},      {"km", 1e3, 0},         {"kilometer", 1e3, 0}, {"kilometers", 1e3, 0},
        {"kilometre", 1e3, 0}, {"kilometres", 1e3, 0}, {"cm", 1e-2, 0},       {"mm", 1e-3, 0},
        {NULL, 0, 0}};
    return find_unit(known, units, NULL);
}

double ty_netcdf_water_unit(const char* units, bool* ratio) {
    static const unit known[] = {
        {"", 1e-3, false},      {"g/m3", 1e-3, false},  {"gm-3", 1e-3, false}, {"kg/m3", 1, false}, {"kgm-3", 1, false},
        {"mg/m3", 1e-6, false}, {"mgm-3", 1e-6, false}, {"kg/kg", 1, true},    {"kgkg-1", 1, true}, {"1", 1, true},
        {"g/kg", 1e-3, true},   {"gkg-1", 1e-3, true},  {NULL, 0, false}};
    return find_unit(known, units, ratio);
}

double ty_netcdf_radius_unit(const char* units) {
    static const unit known[] = {
        {"", 1, 0},        {"um", 1, 0},         {"\xc2\xb5m", 1, 0},   {"\xce\xbcm", 1, 0},  {"micron", 1, 0},
        {"microns", 1, 0}, {"micrometer", 1, 0}, {"micrometers", 1, 0}, {"micrometre", 1, 0}, {"micrometres", 1, 0},
        {"m", 1e6, 0},     {"cm", 1e4, 0},       {"mm", 1e3, 0},        {"nm", 1e-3, 0},      {NULL, 0, 0}};
    return find_unit(known, units, NULL);
}

double ty_netcdf_density_unit(const char* units) {
    static const unit known[] = {{"", 1, 0},        {"kg/m3", 1, 0},   {"kgm-3", 1, 0},
                                 {"g/m3", 1e-3, 0}, {"gm-3", 1e-3, 0}, {NULL, 0, 0}};
    return find_unit(known, units, NULL);
}

/* ---- values ---- */

typedef struct packing {
    double scale, offset;
    double missing[2];
    bool has_missing[2];
    double valid[2]; /* lowest and highest packed value that is none of the missing ones */
} packing;

static bool number_attribute(const ty_netcdf_file* file, int id, const char* name, size_t count, double* out) {
    nc_type type = NC_NAT;
    size_t length = 0;
    return file->calls->inq_att(file->id, id, name, &type, &length) == NC_NOERR && type != NC_CHAR &&
           type <= NC_UINT64 && length == count && file->calls->get_att_double(file->id, id, name, out) == NC_NOERR;
}

static packing find_packing(const ty_netcdf_file* file, int id) {
    packing p = {.scale = 1, .valid = {-INFINITY, INFINITY}};
    number_attribute(file, id, "scale_factor", 1, &p.scale);
    number_attribute(file, id, "add_offset", 1, &p.offset);
    p.has_missing[0] = number_attribute(file, id, "_FillValue", 1, &p.missing[0]);
    p.has_missing[1] = number_attribute(file, id, "missing_value", 1, &p.missing[1]);
    number_attribute(file, id, "valid_min", 1, &p.valid[0]);
    number_attribute(file, id, "valid_max", 1, &p.valid[1]);
    number_attribute(file, id, "valid_range", 2, p.valid);
    return p;
}

static float unpack(const packing* p, double value) {
    for (int i = 0; i < 2; ++i)
        if (p->has_missing[i] && value == p->missing[i]) return 0;
    if (!(value >= p->valid[0] && value <= p->valid[1]) || fabs(value) >= unwritten) return 0;
    return (float)(value * p->scale + p->offset);
}

/* A hyperslab of a variable: where it begins, and its lengths. */
typedef struct slab {
    size_t start[TY_NETCDF_DIMENSIONS_MAX], count[TY_NETCDF_DIMENSIONS_MAX];
} slab;

static slab make_slab(const ty_netcdf_variable* variable, int32_t time, int along, size_t first, size_t length) {
    slab s = {{0}, {1}}; /* of a scalar, too */
    for (int d = 0; d < variable->dimension_count; ++d) s.count[d] = variable->lengths[d];
    if (variable->times >= 0) {
        s.start[variable->times] = (size_t)time;
        s.count[variable->times] = 1;
    }
    if (along >= 0) {
        s.start[along] = first;
        s.count[along] = length;
    }
    return s;
}

/* Reads parts along the slab's first axis with more than one value. */
static ty_result read_parts(const ty_netcdf_file* file, const ty_netcdf_variable* variable, slab* s, size_t part,
                            size_t row, double* scratch, float* out) {
    const packing p = find_packing(file, variable->id);
    int first = 0;
    while (first + 1 < variable->dimension_count && s->count[first] == 1) ++first;
    const size_t begin = s->start[first], total = s->count[first];
    for (size_t at = 0; at < total; at += part) {
        s->start[first] = begin + at;
        s->count[first] = part < total - at ? part : total - at;
        const int status = file->calls->get_vara_double(file->id, variable->id, s->start, s->count, scratch);
        if (status != NC_NOERR) return ty_netcdf_fail(file, status);
        for (size_t i = 0; i < s->count[first] * row; ++i) out[at * row + i] = unpack(&p, scratch[i]);
    }
    return TY_OK;
}

/* Number of values, and length of the first axis of more than one. */
static ty_result count_values(const ty_netcdf_file* file, const ty_netcdf_variable* variable, const slab* s,
                              size_t* total, size_t* longest) {
    bool begun = false;
    *total = *longest = 1;
    for (int d = 0; d < variable->dimension_count; ++d) {
        const size_t length = s->count[d];
        if (length > 0 && *total > SIZE_MAX / 16 / length)
            return ty_fail(file->context, TY_ERROR_INPUT, "%s: \"%s\" is too large", file->path, variable->name);
        *total *= length;
        if (!begun && length > 1) {
            *longest = length;
            begun = true;
        }
    }
    return *total > 0 ? TY_OK
                      : ty_fail(file->context, TY_ERROR_INPUT, "%s: \"%s\" is empty", file->path, variable->name);
}

ty_result ty_netcdf_load(const ty_netcdf_file* file, const ty_netcdf_variable* variable, int32_t time, int along,
                         size_t first, size_t length, float** out, size_t* count) {
    size_t total = 1, longest = 1;
    const slab whole = make_slab(variable, time, -1, 0, 0);
    slab s = make_slab(variable, time, along, first, length);
    ty_result result = count_values(file, variable, &whole, &total, &longest);
    if (result == TY_OK && total / RATIO_MAX > file->size)
        return ty_fail(file->context, TY_ERROR_INPUT, "%s: %llu bytes cannot hold the %zu values of \"%s\"", file->path,
                       (unsigned long long)file->size, total, variable->name);
    if (result == TY_OK) result = count_values(file, variable, &s, &total, &longest);
    if (result != TY_OK) return result;
    const size_t row = total / longest;
    size_t part = PART / sizeof(double) / row;
    part = part < 1 ? 1 : part > longest ? longest : part;
    double* scratch = ty_alloc_array(file->context, part * row, sizeof *scratch, false);
    float* values = scratch == NULL ? NULL : ty_alloc_array(file->context, total, sizeof *values, false);
    result = values == NULL ? TY_ERROR_MEMORY : read_parts(file, variable, &s, part, row, scratch, values);
    ty_free_array(file->context, scratch, part * row, sizeof *scratch);
    if (result != TY_OK) {
        ty_free_array(file->context, values, total, sizeof *values);
        return result;
    }
    *out = values;
    *count = total;
    return TY_OK;
}

#endif
