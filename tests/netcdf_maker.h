/* Classic NetCDF files (CDF-1), made in memory without the library: dimensions, variables with attributes, floats or
 * doubles. */
#ifndef TY_TESTS_NETCDF_MAKER_H
#define TY_TESTS_NETCDF_MAKER_H

#include "files.h"

#include <stdlib.h>

enum { MADE_VARIABLES_MAX = 16, MADE_FLOAT = 5, MADE_DOUBLE = 6 };

typedef struct made_variable {
    const char* name;
    int dimensions[4], count;
    const char* attributes[4][2]; /* names and texts, up to a NULL; "=0,2.5" are numbers */
    int type;
    const double* values;
} made_variable;

typedef struct made_file {
    const char* dimensions[6]; /* up to a NULL */
    int lengths[6];
    made_variable variables[MADE_VARIABLES_MAX]; /* up to one without a name */
} made_file;

typedef struct made_bytes {
    uint8_t bytes[1 << 16];
    size_t size;
} made_bytes;

static inline void made_put(made_bytes* to, uint64_t value, size_t size) {
    assert_true(to->size + size <= sizeof to->bytes);
    while (size-- > 0) to->bytes[to->size++] = (uint8_t)(value >> 8 * size);
}

static inline void made_text(made_bytes* to, const char* text) {
    made_put(to, strlen(text), 4);
    for (const char* at = text; *at != '\0'; ++at) made_put(to, (uint8_t)*at, 1);
    while (to->size % 4 != 0) made_put(to, 0, 1);
}

/* Doubles that stand in a text between commas. */
static inline void made_numbers(made_bytes* to, const char* text) {
    double numbers[4];
    unsigned count = 0;
    for (char* end; count < 4 && *text != '\0'; text = end + (*end == ',')) numbers[count++] = strtod(text, &end);
    made_put(to, count, 4);
    for (unsigned i = 0; i < count; ++i) {
        uint64_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        made_put(to, bits, 8);
    }
}

/* The head of a list, which is empty without items. */
static inline void made_list(made_bytes* to, unsigned kind, int count) {
    made_put(to, count > 0 ? kind : 0, 4);
    made_put(to, (unsigned)count, 4);
}

static inline size_t made_values(const made_file* file, const made_variable* variable) {
    size_t count = 1;
    for (int d = 0; d < variable->count; ++d) count *= (size_t)file->lengths[variable->dimensions[d]];
    return count;
}

static inline void made_variable_head(made_bytes* to, const made_file* file, const made_variable* variable,
                                      size_t begin) {
    enum { ATTRIBUTES = 12, TEXT = 2 };
    int attributes = 0;
    made_text(to, variable->name);
    made_put(to, (unsigned)variable->count, 4);
    for (int d = 0; d < variable->count; ++d) made_put(to, (unsigned)variable->dimensions[d], 4);
    while (attributes < 4 && variable->attributes[attributes][0] != NULL) ++attributes;
    made_list(to, ATTRIBUTES, attributes);
    for (int i = 0; i < attributes; ++i) {
        made_text(to, variable->attributes[i][0]);
        const char* value = variable->attributes[i][1];
        made_put(to, value[0] == '=' ? MADE_DOUBLE : TEXT, 4);
        if (value[0] == '=')
            made_numbers(to, value + 1);
        else
            made_text(to, value);
    }
    made_put(to, (unsigned)variable->type, 4);
    made_put(to, made_values(file, variable) * (variable->type == MADE_DOUBLE ? 8 : 4), 4);
    made_put(to, begin, 4);
}

static inline size_t made_head(made_bytes* to, const made_file* file, size_t data) {
    enum { DIMENSIONS = 10, VARIABLES = 11 };
    int dimensions = 0, variables = 0;
    to->size = 0;
    made_put(to, 0x43444601, 4); /* "CDF", 1 */
    made_put(to, 0, 4);
    while (dimensions < 6 && file->dimensions[dimensions] != NULL) ++dimensions;
    made_list(to, DIMENSIONS, dimensions);
    for (int d = 0; d < dimensions; ++d) {
        made_text(to, file->dimensions[d]);
        made_put(to, (unsigned)file->lengths[d], 4);
    }
    made_list(to, 0, 0); /* attributes of the file */
    while (variables < MADE_VARIABLES_MAX && file->variables[variables].name != NULL) ++variables;
    made_list(to, VARIABLES, variables);
    for (int v = 0; v < variables; ++v) {
        const made_variable* variable = &file->variables[v];
        made_variable_head(to, file, variable, data);
        data += made_values(file, variable) * (variable->type == MADE_DOUBLE ? 8 : 4);
    }
    return to->size;
}

static inline void made_data(made_bytes* to, const made_file* file) {
    for (int v = 0; v < MADE_VARIABLES_MAX && file->variables[v].name != NULL; ++v) {
        const made_variable* variable = &file->variables[v];
        for (size_t i = 0; i < made_values(file, variable); ++i) {
            const double value = variable->values[i];
            const float single = (float)value;
            uint64_t bits = 0;
            uint32_t word = 0;
            memcpy(&bits, &value, sizeof bits);
            memcpy(&word, &single, sizeof word);
            if (variable->type == MADE_DOUBLE)
                made_put(to, bits, 8);
            else
                made_put(to, word, 4);
        }
    }
}

static inline void make_netcdf(const char* path, const made_file* file) {
    static made_bytes to;
    made_head(&to, file, made_head(&to, file, 0)); /* the second one knows where data begin */
    made_data(&to, file);
    put_file(path, to.bytes, to.size);
}

#endif
