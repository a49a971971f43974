#include "scene/blackbody.h"
void ty_blackbody_fill(ty_blackbody_table* table) {
    for (int c = 0; c < 3; ++c) table->x[c] = 0;
}
