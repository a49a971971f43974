/* What maps of what lights meet have in common: one ray a texel, in packets, and where parallel rays begin. */
#ifndef TY_DIRECT_TEXELS_H
#define TY_DIRECT_TEXELS_H

#include "scene/ray_counter.h"
#include "scene/scene.h"

/* Fails, naming `what`, unless an index of a committed scene's lights is that of a directional, point or spot light. */
ty_result ty_texels_check_light(const ty_scene* scene, const char* what, int32_t light);

/* The stretch of a box along an axis. */
void ty_texels_extent(ty_vec axis, const double lower[3], const double upper[3], double range[2]);

/* Maps of faces x side x side texels, row by row. */
typedef struct ty_texels {
    const ty_scene* scene; /* with surfaces */
    int32_t side, faces;
    const void* user;
    /* The ray (unit direction) of a texel; false: it needs none. */
    bool (*ray)(const void* user, int32_t face, int32_t x, int32_t y, ty_ray* out);
    bool bare; /* whether how far surfaces are is all that counts: hits have nothing else, `point` is NULL */
    /* What it meets; any thread, each texel once at most. */
    void (*meet)(const void* user, size_t texel, const ty_ray* ray, const ty_hit* hit, const ty_surface_point* point);
} ty_texels;

/* counter: NULL, or is added to. */
void ty_texels_trace(const ty_texels* texels, ty_ray_counter* counter);

#endif
