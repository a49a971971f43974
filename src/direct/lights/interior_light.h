/* How much of a scene's light comes from within the box around its media. */
#ifndef TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H
#define TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H

#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

/* W that come into the box, about: from outside, and from lamps in it. */
typedef struct ty_interior_light {
    double from_outside, from_inside;
} ty_interior_light;

void ty_interior_light_add_directional(ty_interior_light* sum, const ty_grid_box* box, ty_vec direction,
                                       const float irradiance[3]);
/* intensity: W sr^-1, where it is brightest. */
void ty_interior_light_add_point(ty_interior_light* sum, const ty_grid_box* box, ty_vec position,
                                 const float intensity[3]);

/* The largest ratio of flux to fluence of diffuse light (ty_diffusion_def.streaming). Light that comes from outside
 * scatters near the surface of media and leaves them in all outward directions; light from lamps within leaves them
 * more directly, so that the limit grows with its share, from `outside` to 0.8. */
double ty_interior_light_max_flux(const ty_interior_light* sum, double exterior_max);

#endif
