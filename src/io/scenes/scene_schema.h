/* The JSON Schema of scene files: its fixed part from scene_base.schema.json, `render.METHOD` from the methods' tables
 * of options. */
#ifndef TY_IO_SCENE_SCHEMA_H
#define TY_IO_SCENE_SCHEMA_H

#include <jansson.h>

/* The whole schema, for the caller to release; NULL when memory is short. */
json_t* ty_scene_schema_tree(void);

#endif
