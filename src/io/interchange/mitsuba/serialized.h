/* Meshes in Mitsuba's .serialized files. */
#ifndef TY_IO_INTERCHANGE_SERIALIZED_H
#define TY_IO_INTERCHANGE_SERIALIZED_H

#include "io/meshes/model.h"

/* Reads one shape of a .serialized file, of version 3 or 4. */
ty_result ty_read_serialized(ty_context* context, const char* path, const uint8_t* bytes, size_t size, int32_t index,
                             ty_model_mesh* out);

#endif
