/* Maps of lights at infinity as equirectangular maps of scene files. */
#ifndef TY_IO_INTERCHANGE_ENVIRONMENT_MAP_H
#define TY_IO_INTERCHANGE_ENVIRONMENT_MAP_H

#include <tyndall/image.h>
#include <tyndall/scene.h>

typedef enum ty_map_kind {
    TY_MAP_OCTAHEDRAL, /* pbrt's: a square in equal-area octahedral mapping (Clarberg 2008), +z at its center */
    TY_MAP_ANGLES      /* Mitsuba's: equirectangular, y up, the left edge along -z, +x at a quarter */
} ty_map_kind;

/* light: the map's space into the scene. *illuminance, which may be NULL, is as pbrt measures that of an octahedral
 * map. */
ty_result ty_convert_map(ty_context* context, const ty_image* image, ty_map_kind kind, const ty_affine* light,
                         double* illuminance, ty_image** out);

#endif
