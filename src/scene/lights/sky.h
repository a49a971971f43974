/* Skies of which tables are kept. */
#ifndef TY_SCENE_LIGHTS_SKY_H
#define TY_SCENE_LIGHTS_SKY_H

#include <tyndall/scene.h>

/* Tables of an atmosphere, which are the same wherever the sun is. Zeros: none yet. */
typedef struct ty_sky_table {
    float* transmittance; /* of haze and ozone */
    double haze, ozone;
    float* light; /* multiply scattered, over ground, if solved */
    float ground[3];
    bool solved;
} ty_sky_table;

/* As ty_sky_create_image; takes from the table what suits the def, and keeps there what it makes. */
ty_result ty_sky_create_image_with(ty_context* context, const ty_sky_def* def, ty_sky_table* table, ty_image** out,
                                   float sun_irradiance[3]);
void ty_sky_table_release(ty_context* context, ty_sky_table* table);

#endif
