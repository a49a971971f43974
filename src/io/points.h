/* Points in JSON. */
#ifndef TY_IO_POINTS_H
#define TY_IO_POINTS_H

#include <tyndall/io.h>

/* As ty_points_read, from text; `path` names it in messages. */
ty_result ty_points_parse(ty_context* context, const char* path, const uint8_t* text, size_t size, float** out,
                          int64_t* count);

#endif
