/* Paths in a JSON document, and their line numbers in its text. */
#ifndef TY_IO_JSON_LOCATE_H
#define TY_IO_JSON_LOCATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TY_JSON_PATH_STEPS = 16 };

/* One step of a path: a member's key, or an element's index if key is NULL. Keys are borrowed. */
typedef struct ty_json_step {
    const char* key;
    size_t index;
} ty_json_step;

typedef struct ty_json_path {
    size_t depth;
    ty_json_step steps[TY_JSON_PATH_STEPS];
} ty_json_path;

/* base with one more step; base itself if it is full. */
ty_json_path ty_json_path_key(const ty_json_path* base, const char* key);
ty_json_path ty_json_path_index(const ty_json_path* base, size_t index);
/* True if path equals start or is below it. */
bool ty_json_path_within(const ty_json_path* path, const ty_json_path* start);
/* Length of the longest prefix of text in `size` bytes that does not split a UTF-8 sequence. */
size_t ty_text_fit(const char* text, size_t size);
/* Text of a path, "media[0].g"; long keys are truncated, control characters become '?'. */
void ty_json_path_text(const ty_json_path* path, char* out, size_t size);

/* Line number, from 1, at which the value at path begins (for a member, its key); 0 if it is not in the text. The
 * text must have been accepted by a JSON reader; other text is read safely, with an unspecified result. */
int32_t ty_json_line(const char* text, size_t length, const ty_json_path* path);

#endif
