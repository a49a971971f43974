/* The fraction of a scene's light that starts within the box around its media. */
#ifndef TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H
#define TY_DIRECT_LIGHTS_INTERIOR_LIGHT_H

#include "direct/media/grid_medium.h"
#include "direct/lights/discrete_light.h"

/* Estimated power that enters the box, and power of point lights inside, W. */
typedef struct ty_interior_light {
    double from_outside, from_inside;
} ty_interior_light;

void ty_interior_light_add_directional(ty_interior_light* sum, const ty_grid_box* box, ty_vec direction,
                                       const float irradiance[3]);
/* intensity: maximum over directions, W sr^-1. */
void ty_interior_light_add_point(ty_interior_light* sum, const ty_grid_box* box, ty_vec position,
                                 const float intensity[3]);

/* The flux limit max |F| / phi of diffuse light (ty_diffusion_def.streaming). Light from outside scatters near the
 * surface of the media and leaves them into the whole hemisphere; light of interior point lights leaves them closer to
 * the normal. So the limit grows with the interior fraction from exterior_max to 0.8. */
double ty_interior_light_max_flux(const ty_interior_light* sum, double exterior_max);
/* Its derivative by a factor of a part of the light. */
double ty_interior_light_max_flux_slope(const ty_interior_light* sum, const ty_interior_light* part,
                                        double exterior_max);

#endif
