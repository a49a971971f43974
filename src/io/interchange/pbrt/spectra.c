/* Spectra among parameters: colours, black bodies, tables, and those with names. */
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/pbrt/pbrt.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A table of wavelengths and values; the numbers are the parameter's own, or from a file. */
typedef struct table {
    ty_spectrum spectrum;
    double* owned;
    size_t capacity;
} table;

static void free_table(const ty_pbrt* reader, table* t) {
    ty_free_array(reader->context, t->owned, t->capacity, sizeof *t->owned);
}

static ty_result check_table(const ty_pbrt* reader, const ty_pbrt_parameter* parameter, const double* numbers,
                             size_t count, table* out) {
    bool ascending = count >= 2 && count % 2 == 0;
    for (size_t i = 2; i < count && ascending; i += 2) ascending = numbers[i] > numbers[i - 2];
    if (!ascending)
        return ty_pbrt_fail(reader, parameter->file, parameter->line,
                            "the spectrum \"%s\" is not pairs of ascending wavelengths and values", parameter->name);
    out->spectrum = (ty_spectrum){numbers, count / 2};
    return TY_OK;
}

/* Reads a file of numbers: pairs, with comments from # on. */
static ty_result read_file(ty_pbrt* reader, const ty_pbrt_parameter* parameter, const char* name, table* out) {
    char location[512];
    uint8_t* bytes = NULL;
    size_t size = 0, count = 0;
    ty_pbrt_location(reader, parameter->file, parameter->line, location, sizeof location);
    ty_result result = ty_conversion_read_file(reader->conversion, location, name, &bytes, &size);
    if (result != TY_OK || bytes == NULL) return result;
    ty_pbrt_text text = {(const char*)bytes, (const char*)bytes + size, 1, parameter->file};
    for (ty_pbrt_token token = ty_pbrt_next(&text); token.kind != TY_PBRT_END && result == TY_OK;
         token = ty_pbrt_next(&text)) {
        double number;
        if (!ty_pbrt_number(&token, &number))
            result = ty_fail(reader->context, TY_ERROR_INPUT, "%s: %s:%d: not a number of a spectrum", location, name,
                             (int)token.line);
        else if (!ty_grow_array(reader->context, (void**)&out->owned, &out->capacity, count, sizeof *out->owned))
            result = TY_ERROR_MEMORY;
        else
            out->owned[count++] = number;
    }
    ty_free_file(reader->context, bytes, size);
    return result == TY_OK ? check_table(reader, parameter, out->owned, count, out) : result;
}

/* True for the names of tables in files. */
static bool is_file_name(const char* name) {
    return strchr(name, '.') != NULL || strchr(name, '/') != NULL;
}

static ty_result unknown_name(ty_pbrt* reader, const ty_pbrt_parameter* parameter, const char* name) {
    return ty_pbrt_fail(reader, parameter->file, parameter->line, "the spectrum \"%s\" is not known", name);
}

static void sample(ty_spectrum spectrum, double values[3]) {
    static const double nm[3] = {650, 550, 450};
    for (int c = 0; c < 3; ++c) values[c] = ty_spectrum_at(spectrum, nm[c]);
}

/* "metal-Au-eta" and "metal-Au-k", a glass, or a file. */
static ty_result sample_named(ty_pbrt* reader, const ty_pbrt_parameter* parameter, double values[3]) {
    char name[256], metal[32];
    double eta[3], k[3], ior;
    snprintf(name, sizeof name, "%.*s", (int)parameter->strings[0].length, parameter->strings[0].text);
    const char* last = strrchr(name, '-');
    if (strncmp(name, "metal-", 6) == 0 && last != NULL && last > name + 6) {
        snprintf(metal, sizeof metal, "%.*s", (int)(last - name - 6), name + 6);
        if (!ty_named_metal(metal, eta, k)) {
            ty_conversion_approximate(reader->conversion, "the metal \"%s\" is not known; aluminium was taken", metal);
            ty_named_metal("Al", eta, k);
        }
        memcpy(values, strcmp(last, "-k") == 0 ? k : eta, 3 * sizeof *values);
        return TY_OK;
    }
    if (ty_named_ior(name, &ior)) {
        values[0] = values[1] = values[2] = ior;
        return TY_OK;
    }
    if (!is_file_name(name)) return unknown_name(reader, parameter, name);
    table t = {0};
    const ty_result result = read_file(reader, parameter, name, &t);
    if (result == TY_OK && t.spectrum.count > 0) sample(t.spectrum, values);
    free_table(reader, &t);
    return result;
}

static ty_result find_named(ty_pbrt* reader, const ty_pbrt_parameter* parameter, ty_pbrt_role role, double rgb[3]) {
    char name[256];
    snprintf(name, sizeof name, "%.*s", (int)parameter->strings[0].length, parameter->strings[0].text);
    if (ty_named_illuminant(name, rgb)) return TY_OK;
    if (!is_file_name(name)) return sample_named(reader, parameter, rgb);
    table t = {0};
    const ty_result result = read_file(reader, parameter, name, &t);
    if (result == TY_OK && t.spectrum.count > 0) {
        if (role == TY_PBRT_LIGHT)
            ty_spectrum_light(t.spectrum, rgb);
        else
            ty_spectrum_reflectance(t.spectrum, rgb);
    }
    free_table(reader, &t);
    return result;
}

static void clip(ty_pbrt* reader, const ty_pbrt_parameter* parameter, double rgb[3]) {
    double lowest = 0, highest = 0;
    for (int c = 0; c < 3; ++c) {
        lowest = fmin(lowest, rgb[c]);
        highest = fmax(highest, rgb[c]);
        rgb[c] = fmax(rgb[c], 0);
    }
    if (lowest < -1e-3 * highest)
        ty_conversion_approximate(reader->conversion, "\"%s\": a colour outside of Rec. 709 was clipped",
                                  parameter->name);
}

ty_result ty_pbrt_spectrum(const ty_pbrt_parameters* parameters, const char* name, ty_pbrt_role role, double rgb[3],
                           bool* found) {
    ty_pbrt* reader = parameters->reader;
    const ty_pbrt_parameter* parameter = ty_pbrt_find(parameters, name);
    *found = parameter != NULL && parameter->type != TY_PBRT_TEXTURE &&
             (parameter->number_count > 0 || parameter->string_count > 0);
    if (!*found) return TY_OK;
    ty_result result = TY_OK;
    if (parameter->type == TY_PBRT_RGB) {
        for (int c = 0; c < 3; ++c) rgb[c] = parameter->numbers[c];
        ty_colour_from_space(ty_pbrt_now(reader)->color_space, rgb);
    } else if (parameter->type == TY_PBRT_BLACKBODY) {
        ty_blackbody_colour(parameter->numbers[0], rgb);
    } else if (parameter->type == TY_PBRT_SPECTRUM && parameter->string_count > 0) {
        result = find_named(reader, parameter, role, rgb);
    } else if (parameter->type == TY_PBRT_SPECTRUM) {
        table t = {0};
        result = check_table(reader, parameter, parameter->numbers, parameter->number_count, &t);
        if (result != TY_OK) return result;
        if (role == TY_PBRT_LIGHT)
            ty_spectrum_light(t.spectrum, rgb);
        else
            ty_spectrum_reflectance(t.spectrum, rgb);
    } else if (parameter->type == TY_PBRT_FLOAT) {
        rgb[0] = rgb[1] = rgb[2] = parameter->numbers[0];
    } else {
        return ty_pbrt_fail(reader, parameter->file, parameter->line, "\"%s\" is not a spectrum", parameter->name);
    }
    if (result == TY_OK) clip(reader, parameter, rgb);
    return result;
}

/* ---- values at wavelengths ---- */

ty_result ty_pbrt_spectrum_at(const ty_pbrt_parameters* parameters, const char* name, double values[3], bool* found) {
    ty_pbrt* reader = parameters->reader;
    const ty_pbrt_parameter* parameter = ty_pbrt_find(parameters, name);
    *found = parameter != NULL && (parameter->number_count > 0 || parameter->string_count > 0) &&
             parameter->type != TY_PBRT_TEXTURE;
    if (!*found) return TY_OK;
    if (parameter->string_count > 0) return sample_named(reader, parameter, values);
    if (parameter->type == TY_PBRT_RGB) {
        memcpy(values, parameter->numbers, 3 * sizeof *values);
    } else if (parameter->type == TY_PBRT_SPECTRUM) {
        table t = {0};
        const ty_result result = check_table(reader, parameter, parameter->numbers, parameter->number_count, &t);
        if (result != TY_OK) return result;
        sample(t.spectrum, values);
    } else {
        values[0] = values[1] = values[2] = parameter->numbers[0];
    }
    return TY_OK;
}
