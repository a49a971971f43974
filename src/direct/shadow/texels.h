/* Rays of the texels of a map, traced in packets; shared by reflective shadow maps and VPL candidates. */
#ifndef TY_DIRECT_SHADOW_TEXELS_H
#define TY_DIRECT_SHADOW_TEXELS_H

#include "scene/surfaces/ray_counter.h"
#include "scene/scene.h"

/* Fails, naming `what`, unless an index of a committed scene's lights is that of a directional, point or spot light. */
ty_result ty_texels_check_light(const ty_scene* scene, const char* what, int32_t light);

/* The interval that a box covers along an axis. */
void ty_texels_extent(ty_vec axis, const double lower[3], const double upper[3], double range[2]);

/* A map of faces x side x side texels, row by row. */
typedef struct ty_texels {
    const ty_scene* scene; /* with surfaces */
    int32_t side, faces;
    const void* user;
    /* The ray of a texel, with unit direction; false: the texel needs no ray. */
    bool (*ray)(const void* user, int32_t face, int32_t x, int32_t y, ty_ray* out);
    bool bare; /* whether only the distance is needed: hits hold nothing else and `point` is NULL */
    /* Called for each hit, from any thread, at most once per texel. */
    void (*meet)(const void* user, size_t texel, const ty_ray* ray, const ty_hit* hit, const ty_surface_point* point);
} ty_texels;

/* counter: NULL, or a counter of the rays. */
void ty_texels_trace(const ty_texels* texels, ty_ray_counter* counter);

#endif
