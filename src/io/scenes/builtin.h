/* Scenes embedded in the library: "builtin:NAME" instead of a path. The table is generated from scenes/builtin. */
#ifndef TY_IO_BUILTIN_H
#define TY_IO_BUILTIN_H

#include <stddef.h>

typedef struct ty_builtin_scene {
    const char* name; /* file name without .json; NULL ends the table */
    const char* text;
    size_t size; /* of text, without the zero byte */
} ty_builtin_scene;

extern const ty_builtin_scene ty_builtin_scenes[];

/* src/io/scenes/scene_base.schema.json, zero-terminated. */
extern const char ty_scene_schema_text[];
extern const unsigned ty_scene_schema_size; /* without the zero byte */

#endif
