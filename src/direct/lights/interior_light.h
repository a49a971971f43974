/* How much of a scene's light comes from within the box around its media. */
#ifndef TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H
#define TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H

#include "direct/media/grid_medium.h"
#include "direct/lights/discretize.h"

/* W that come into the box, about: from outside, and from lamps in it. */
typedef struct ty_inside {
    double from_outside, from_inside;
} ty_inside;

void ty_inside_add_beam(ty_inside* sum, const ty_grid_box* box, ty_vec direction, const float irradiance[3]);
/* intensity: W sr^-1, where it is brightest. */
void ty_inside_add_lamp(ty_inside* sum, const ty_grid_box* box, ty_vec position, const float intensity[3]);

/* The largest ratio of flux to fluence of diffuse light (ty_diffusion_def.streaming). Light that comes from outside
 * scatters near the surface of media and leaves them in all outward directions; light from lamps within leaves them
 * more directly, so that the limit grows with its share, from `outside` to 0.8. */
double ty_inside_streaming(const ty_inside* sum, double outside);

#endif
