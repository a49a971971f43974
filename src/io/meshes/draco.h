/* Decoding of Draco meshes (KHR_draco_mesh_compression). */
#ifndef TY_IO_DRACO_H
#define TY_IO_DRACO_H

#include <tyndall/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ty_draco ty_draco;

/* Decodes a mesh; `place` names it in messages. Fails with TY_ERROR_INPUT if it is damaged, or in a build without
 * Draco. Freed with ty_draco_free. */
ty_result ty_draco_decode(ty_context* context, const char* place, const uint8_t* bytes, size_t size, ty_draco** out);
void ty_draco_free(ty_draco* draco);
size_t ty_draco_vertices(const ty_draco* draco);
size_t ty_draco_triangles(const ty_draco* draco);
/* Three vertex indices per triangle, each below ty_draco_vertices; false if the mesh is damaged. */
bool ty_draco_read_indices(const ty_draco* draco, uint32_t* out);
/* Values of the attribute with unique id `id` as floats, `width` per vertex. *normalized: true if integers were divided
 * by their largest value. False if there is no such attribute of that width. */
bool ty_draco_read_attribute(const ty_draco* draco, uint32_t id, size_t width, float* out, bool* normalized);

#ifdef __cplusplus
}
#endif
#endif
