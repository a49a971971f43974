/* Maps of lights by hand: faces placed as a light needs them, depths from a function of the ray. */
#ifndef TY_TESTS_LIGHT_MAP_MAKER_H
#define TY_TESTS_LIGHT_MAP_MAKER_H

#include "checks.h"
#include "scene/lights/light.k.h"

#include <tyndall/rsm.h>

/* Distance along a ray to a surface, in lengths of its direction; INFINITY: none. */
typedef double (*made_depth)(const void* user, const double origin[3], const double direction[3]);

static inline void made_set_face(ty_rsm* map, int face, ty_vec forward, double half) {
    ty_vec right, up;
    ty_onb(forward, &right, &up);
    set3(map->forward[face], (double)forward.x, (double)forward.y, (double)forward.z);
    set3(map->right[face], half * (double)right.x, half * (double)right.y, half * (double)right.z);
    set3(map->up[face], half * (double)up.x, half * (double)up.y, half * (double)up.z);
}

/* Of a directional light: half of the map's sides, m, and where it begins; of a spot: the tangent. */
static inline ty_rsm made_light_map(const ty_light_view* light, int32_t side, double half, ty_vec origin) {
    static const float ways[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    ty_rsm map = {.side = side, .faces = light->kind == TY_KIND_POINT ? 6 : 1};
    set3(map.origin, (double)origin.x, (double)origin.y, (double)origin.z);
    for (int face = 0; face < map.faces; ++face)
        made_set_face(&map, face, map.faces == 6 ? ty_vec_load(ways[face]) : light->direction,
                      map.faces == 6 ? 1 : half);
    return map;
}

static inline void made_map_ray(const ty_rsm* map, const ty_light_view* light, int32_t face, double x, double y,
                                double origin[3], double direction[3]) {
    const bool flat = light->kind == TY_KIND_DIRECTIONAL;
    const double s = 2 * x / map->side - 1, t = 2 * y / map->side - 1;
    const double position[3] = {(double)light->position.x, (double)light->position.y, (double)light->position.z};
    for (int a = 0; a < 3; ++a) {
        const double off = map->right[face][a] * s + map->up[face][a] * t;
        origin[a] = flat ? map->origin[a] + off : position[a];
        direction[a] = map->forward[face][a] + (flat ? 0 : off);
    }
}

/* Fills in the depths, which are freed with free. */
static inline void made_trace(ty_rsm* map, const ty_light_view* light, made_depth depth, const void* user) {
    const int32_t side = map->side;
    float* out = malloc((size_t)map->faces * (size_t)side * (size_t)side * sizeof *out);
    assert_non_null(out);
    map->depth = out;
    for (int32_t i = 0; i < map->faces * side * side; ++i) {
        double origin[3], direction[3];
        made_map_ray(map, light, i / (side * side), i % side + 0.5, i / side % side + 0.5, origin, direction);
        out[i] = (float)depth(user, origin, direction);
    }
}

/* The part of a ray within a box, in lengths of its direction; false where it misses. */
static inline bool made_clip(const double lower[3], const double upper[3], const double origin[3],
                             const double direction[3], double part[2]) {
    for (int a = 0; a < 3; ++a) {
        if (direction[a] == 0 && (origin[a] < lower[a] || origin[a] > upper[a])) return false;
        if (direction[a] == 0) continue;
        const double low = (lower[a] - origin[a]) / direction[a], high = (upper[a] - origin[a]) / direction[a];
        part[0] = fmax(part[0], fmin(low, high));
        part[1] = fmin(part[1], fmax(low, high));
    }
    return part[0] < part[1];
}

#endif
