/* Writing JSON. */
#include "cli/text/json.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

json_writer json_begin(FILE* file) {
    return (json_writer){.file = file};
}

json_writer json_begin_plain(FILE* file) {
    return (json_writer){.file = file, .plain = true};
}

static void write_text(FILE* file, const char* text) {
    fputc('"', file);
    for (const unsigned char* c = (const unsigned char*)text; *c != '\0'; ++c) {
        if (*c == '"' || *c == '\\')
            fprintf(file, "\\%c", *c);
        else if (*c < 0x20)
            fprintf(file, "\\u%04x", *c);
        else
            fputc(*c, file);
    }
    fputc('"', file);
}

static void write_number(const json_writer* json, double value) {
    FILE* const file = json->file;
    if (!isfinite(value)) {
        fputs("null", file);
        return;
    }
    if (json->plain) {
        fprintf(file, fabs(value) >= 1e5 && fabs(value) < 1e15 ? "%.0f" : "%.5g", value);
        return;
    }
    char text[40];
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    fputs(text, file);
}

static void end_line(json_writer* json) {
    fprintf(json->file, "\n%*s", 2 * json->depth, "");
}

/* A line of YAML: indentation, the name of a member or the dash of an element. */
static void start_plain(json_writer* json, const char* name) {
    const bool first = json->depth <= 1 && !json->filled[json->depth];
    if (!first && !json->dashed) fprintf(json->file, "\n%*s", 2 * (json->depth - 1), "");
    json->filled[json->depth] = true;
    json->dashed = false;
    if (name != NULL)
        fprintf(json->file, "%s:", name);
    else if (json->depth > 0)
        fputs("- ", json->file);
}

/* Writes the prefix of a value, an object or an array: comma, line, name. */
static void start_member(json_writer* json, const char* name) {
    if (json->plain) {
        start_plain(json, name);
        return;
    }
    if (json->depth > 0) {
        if (json->filled[json->depth]) fputc(',', json->file);
        json->filled[json->depth] = true;
        end_line(json);
    }
    if (name != NULL) {
        write_text(json->file, name);
        fputs(": ", json->file);
    }
}

/* Writes the prefix of a number or a string. */
static void start_value(json_writer* json, const char* name) {
    start_member(json, name);
    if (json->plain && name != NULL) fputc(' ', json->file);
}

static void open_bracket(json_writer* json, const char* name, char bracket) {
    start_member(json, name);
    json->dashed = json->plain && name == NULL && json->depth > 0;
    if (!json->plain) fputc(bracket, json->file);
    if (json->depth + 1 < JSON_DEPTH_MAX) ++json->depth;
    json->filled[json->depth] = false;
}

static void close_bracket(json_writer* json, char bracket) {
    const bool filled = json->filled[json->depth];
    --json->depth;
    if (filled && !json->plain) end_line(json);
    if (!json->plain) fputc(bracket, json->file);
    if (json->depth == 0) fputc('\n', json->file);
}

void json_open_object(json_writer* json, const char* name) {
    open_bracket(json, name, '{');
}

void json_close_object(json_writer* json) {
    close_bracket(json, '}');
}

void json_open_array(json_writer* json, const char* name) {
    open_bracket(json, name, '[');
}

void json_close_array(json_writer* json) {
    close_bracket(json, ']');
}

void json_text(json_writer* json, const char* name, const char* value) {
    start_value(json, name);
    write_text(json->file, value);
}

void json_number(json_writer* json, const char* name, double value) {
    start_value(json, name);
    write_number(json, value);
}

void json_int(json_writer* json, const char* name, int64_t value) {
    start_value(json, name);
    fprintf(json->file, "%" PRId64, value);
}

void json_unsigned(json_writer* json, const char* name, uint64_t value) {
    start_value(json, name);
    fprintf(json->file, "%" PRIu64, value);
}

void json_bool(json_writer* json, const char* name, bool value) {
    start_value(json, name);
    fputs(value ? "true" : "false", json->file);
}

void json_numbers(json_writer* json, const char* name, const double* values, int count) {
    start_value(json, name);
    fputc('[', json->file);
    for (int i = 0; i < count; ++i) {
        if (i > 0) fputs(", ", json->file);
        write_number(json, values[i]);
    }
    fputc(']', json->file);
}
