/* Skies of which tables are kept. */
#ifndef TY_SCENE_SKY_H
#define TY_SCENE_SKY_H

#include <tyndall/scene.h>

/* Transmittance of the atmosphere, which is the same for skies of one haze wherever the sun is. Zeros: none yet. */
typedef struct ty_sky_table {
    float* values;
    double haze;
} ty_sky_table;

/* As ty_sky_create_image; takes the transmittance from the table if that is of the same haze, and keeps it there. */
ty_result ty_sky_create_image_with(ty_context* context, const ty_sky_def* def, ty_sky_table* table, ty_image** out,
                                   float sun_irradiance[3]);
void ty_sky_table_release(ty_context* context, ty_sky_table* table);

#endif
