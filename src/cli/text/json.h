/* Writes JSON to a stream, indented by two, one member a line; arrays of numbers stay on one line. The library that
 * reads JSON writes doubles with 17 digits, which is not the shortest number that reads back, and an element of an
 * array a line. */
#ifndef TY_CLI_TEXT_JSON_H
#define TY_CLI_TEXT_JSON_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum { JSON_DEPTH_MAX = 16 };

typedef struct json_writer {
    FILE* file;
    bool plain;  /* for a terminal: YAML with at most five digits */
    bool dashed; /* plain: the dash of an array element is written, and its content follows on the same line */
    int depth;
    bool filled[JSON_DEPTH_MAX]; /* true once the object or array at a depth has a member */
} json_writer;

json_writer json_begin(FILE* file);
/* Makes the following calls write YAML. */
json_writer json_begin_plain(FILE* file);

/* name NULL: an element of an array, or the outermost value. */
void json_open_object(json_writer* json, const char* name);
void json_close_object(json_writer* json);
void json_open_array(json_writer* json, const char* name);
void json_close_array(json_writer* json);

void json_text(json_writer* json, const char* name, const char* value);
/* The shortest number that reads back exactly; null for NaN and infinities, which JSON lacks. */
void json_number(json_writer* json, const char* name, double value);
void json_int(json_writer* json, const char* name, int64_t value);
void json_unsigned(json_writer* json, const char* name, uint64_t value);
void json_bool(json_writer* json, const char* name, bool value);
void json_numbers(json_writer* json, const char* name, const double* values, int count);

#endif
