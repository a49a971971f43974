/* Virtual emitters: points that represent all surfaces and local lights as emitters into the media, found once per bake
 * and shared by all receivers. */
#ifndef TY_BAKE_GATHER_VIRTUAL_EMITTERS_H
#define TY_BAKE_GATHER_VIRTUAL_EMITTERS_H

#include "base/vector.k.h"

enum { TY_VIRTUAL_EMITTERS_MAX = 2048, TY_FOG_SIDE_MAX = 16, TY_FOG_SIDES = 6 };

/* A virtual emitter: a disc on a surface or an area light, a point light, or a part of a medium lit by distant lights.
 */
typedef struct ty_virtual_emitter {
    ty_vec position, normal; /* normal on the emitting side */
    ty_vec face;             /* geometric normal on that side */
    float margin;
    int32_t kind;      /* ty_impulse_emitter */
    int32_t light;     /* index of a point light; else -1 */
    int32_t in_medium; /* 1: part of a medium, */
    ty_vec wi;         /* and the unit direction towards its light */
    float g[3];
    float radius;      /* of a sphere around the position, whose surface hides nothing of its light, m */
    float area;        /* of the disc, m^2; for a part of a medium, the value that gives its mean distance */
    float measure;     /* area or volume it represents; for point lights the number of lights */
    float outgoing[3]; /* radiance reflected by it, or intensity scattered by it per volume */
    float emission[3]; /* radiance or intensity emitted by it, except surfaces sampled as lights */
    float albedo[3];
} ty_virtual_emitter;

/* Irradiance of light scattered by media, including reflections of it, on a lattice of positions, for surfaces facing
 * -x, +x, -y, +y, -z, +z. */
typedef struct ty_fog_cell {
    float irradiance[TY_FOG_SIDES][3];
} ty_fog_cell;

typedef struct ty_virtual_emitters {
    int32_t count;
    ty_virtual_emitter* items;
    int32_t surfaces,
        local_lights; /* counts of surface emitters (first) and local lights (next); the rest is parts of media */
    /* Selection data as arrays: power is the emitted radiance times the measure, summed over channels; the normal of
     * point lights is 0. */
    float *x, *y, *z, *nx, *ny, *nz, *power, *area;
    int32_t side; /* cells along each axis */
    float lower[3], per_metre[3];
    ty_fog_cell* cells;
} ty_virtual_emitters;

/* Interpolates the lattice irradiance at a position and normal. */
TY_FN void ty_virtual_emitters_fog(const ty_virtual_emitters* emitters, ty_vec position, ty_vec normal,
                                   float irradiance[3]) {
    const float at[3] = {position.x, position.y, position.z}, to[3] = {normal.x, normal.y, normal.z};
    const float last = (float)(emitters->side - 1);
    int32_t index = 0;
    for (int a = 2; a >= 0; --a) {
        const float coordinate = ty_clampf((at[a] - emitters->lower[a]) * emitters->per_metre[a], 0.0f, last);
        index = index * emitters->side + (int32_t)coordinate;
    }
    const ty_fog_cell* cell = &emitters->cells[index];
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int a = 0; a < 3; ++a) {
        const float* side = cell->irradiance[2 * a + (to[a] > 0.0f)];
        for (int c = 0; c < 3; ++c) irradiance[c] += to[a] * to[a] * side[c];
    }
}

#endif
