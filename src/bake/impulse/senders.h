/* Points that stand for all surfaces and lamps when media answer to their light: found once per bake, shared by all
 * receivers. */
#ifndef TY_BAKE_IMPULSE_SENDERS_H
#define TY_BAKE_IMPULSE_SENDERS_H

#include "base/vector.k.h"

enum { TY_SENDERS_MAX = 2048, TY_FOG_SIDE_MAX = 16, TY_FOG_SIDES = 6 };

/* A disc on a surface or a lamp, a lamp without extent, or a part of a medium that light from afar shines into. */
typedef struct ty_sender {
    ty_vec position, normal; /* on the side that sends */
    ty_vec face;             /* of the flat face on that side */
    float margin;
    int32_t kind;  /* ty_impulse_emitter */
    int32_t light; /* lamps without extent: which; else -1 */
    int32_t lit;   /* whether it is part of a medium, */
    ty_vec toward; /* and, unit, where its light comes from */
    float g[3];
    float area;     /* of the disc, m^2; of a part of a medium, what keeps it as far off as it is in the mean */
    float amount;   /* what it stands for: area, volume, of lamps without extent how many */
    float sends[3]; /* radiance that it reflects, or intensity that it scatters, by volume */
    float
        glows[3]; /* radiance, or intensity, of its own: of surfaces, unless they are lamps that are senders as well */
    float albedo[3];
} ty_sender;

/* Light that media sent to surfaces, and what surfaces made of it, as irradiance: of places on a lattice and sides
 * -x, +x, -y, +y, -z, +z that surfaces look to. */
typedef struct ty_fog_cell {
    float irradiance[TY_FOG_SIDES][3];
} ty_fog_cell;

typedef struct ty_senders {
    int32_t count;
    ty_sender* at;
    int32_t surfaces, lamps; /* the first of them, and the next; the rest is parts of media */
    /* What choosing goes by, as arrays: power is what it sends times how much of it there is, all channels together;
     * the normal of lamps without extent is 0. */
    float *x, *y, *z, *nx, *ny, *nz, *power, *area;
    int32_t side; /* cells along each axis */
    float lower[3], per_metre[3];
    ty_fog_cell* cells;
} ty_senders;

/* Of a place and normal. */
TY_FN void ty_senders_fog(const ty_senders* senders, ty_vec position, ty_vec normal, float irradiance[3]) {
    const float at[3] = {position.x, position.y, position.z}, to[3] = {normal.x, normal.y, normal.z};
    const float last = (float)(senders->side - 1);
    int32_t index = 0;
    for (int a = 2; a >= 0; --a) {
        const float place = ty_clampf((at[a] - senders->lower[a]) * senders->per_metre[a], 0.0f, last);
        index = index * senders->side + (int32_t)place;
    }
    const ty_fog_cell* cell = &senders->cells[index];
    for (int c = 0; c < 3; ++c) irradiance[c] = 0.0f;
    for (int a = 0; a < 3; ++a) {
        const float* side = cell->irradiance[2 * a + (to[a] > 0.0f)];
        for (int c = 0; c < 3; ++c) irradiance[c] += to[a] * to[a] * side[c];
    }
}

#endif
