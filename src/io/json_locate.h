/* Places in a JSON document, and the lines of the text where they stand. */
#ifndef TY_IO_JSON_LOCATE_H
#define TY_IO_JSON_LOCATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TY_JSON_PATH_STEPS = 16 };

/* One step down: a member's key, or an element's index when key is NULL. Keys are borrowed. */
typedef struct ty_json_step {
    const char* key;
    size_t index;
} ty_json_step;

typedef struct ty_json_path {
    size_t depth;
    ty_json_step steps[TY_JSON_PATH_STEPS];
} ty_json_path;

/* base with one more step; base itself when it is full. */
ty_json_path ty_json_path_key(const ty_json_path* base, const char* key);
ty_json_path ty_json_path_index(const ty_json_path* base, size_t index);
/* Whether path is start or lies below it. */
bool ty_json_path_within(const ty_json_path* path, const ty_json_path* start);
/* How many bytes of text fit in size without cutting a UTF-8 sequence. */
size_t ty_text_fit(const char* text, size_t size);
/* "media[0].g"; long keys are cut, control characters become '?'. */
void ty_json_path_text(const ty_json_path* path, char* out, size_t size);

/* The line, from 1, on which the place at path begins (a member at its key); 0 when it is not in the text. The text
 * must be one that a JSON reader accepted; any other text is read safely, with any answer. */
int32_t ty_json_line(const char* text, size_t length, const ty_json_path* path);

#endif
