/* Black bodies for kernels. */
#ifndef TY_SCENE_BLACKBODY_H
#define TY_SCENE_BLACKBODY_H

#include "base/kernel.h"

typedef struct ty_blackbody_table {
    float x[3];
} ty_blackbody_table;

TY_FN void ty_blackbody_lookup(TY_GLOBAL const ty_blackbody_table* table, float kelvin, float radiance[3]) {
    for (int c = 0; c < 3; ++c) radiance[c] = table->x[c] * kelvin;
}

void ty_blackbody_fill(ty_blackbody_table* table);

#endif
