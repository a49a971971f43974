/* Interreflection between media and the surfaces outside of their box: an irradiance cache (Ward, Rubinstein and Clear
 * 1988) of those surfaces on a hashed grid, with the rays between its points, and those to the faces of the box. */
#ifndef TY_IMAGE_IRRADIANCE_CACHE_H
#define TY_IMAGE_IRRADIANCE_CACHE_H

#include "direct/lights/discrete_light.h"
#include "direct/media/grid_medium.h"
#include "image/march/irradiance_cache.k.h"
#include "image/march/march.h"

/* Patches along a side of each face of the box. */
enum { TY_IRRADIANCE_PATCHES = 3, TY_IRRADIANCE_FACE_PATCHES = 9 };

/* Light that surfaces outside of the box send to it. */
typedef enum ty_reflected_light {
    TY_REFLECTED_LAMPS, /* of the scene's lights, reflected once or more and not scattered, and of other surfaces */
    TY_REFLECTED_MEDIA, /* of media */
    TY_REFLECTED_MORE   /* of media, a further part */
} ty_reflected_light;

/* Points of the surfaces that rays from a medium's box reach, and those that rays from these reach; *out is NULL where
 * there are none outside of it. Errors: TY_ERROR_MEMORY. Freed with ty_irradiance_cache_destroy. */
ty_result ty_irradiance_cache_create(const ty_scene* scene, const ty_grid_medium* medium, ty_irradiance_cache** out);
void ty_irradiance_cache_destroy(ty_irradiance_cache* cache);
void ty_irradiance_cache_get_view(const ty_irradiance_cache* cache, ty_irradiance_view* out);

/* Lights the points by samples of the lights through the medium, by surfaces that emit and are no lights, and by one
 * another. Errors: TY_ERROR_MEMORY. */
ty_result ty_irradiance_cache_light(ty_irradiance_cache* cache, const ty_scene* scene, const ty_grid_medium* medium,
                                    const ty_discrete_light* sources, int32_t count);
/* Lights them by the media of `march`, whose image options are unused, and by one another. light: TY_REFLECTED_MEDIA
 * or _MORE. emission: with what media emit. Errors: those of ty_march. */
ty_result ty_irradiance_cache_gather(ty_irradiance_cache* cache, const ty_scene* scene, const ty_march_def* march,
                                     bool emission, ty_reflected_light light);
/* Adds factor times the further part to the light of media. */
void ty_irradiance_cache_add_more(ty_irradiance_cache* cache, double factor);

/* Irradiance of patches of the box's faces (lower x, upper x, lower y, ...; the lower axis fastest), W m^-2. */
void ty_irradiance_cache_faces(const ty_irradiance_cache* cache, ty_reflected_light light,
                               float out[6][TY_IRRADIANCE_FACE_PATCHES][3]);
/* Its integral, sum of the channels, W. */
double ty_irradiance_cache_power(const ty_irradiance_cache* cache, ty_reflected_light light);
/* Irradiance of a point of a surface; 0 where the cache has none. */
void ty_irradiance_cache_at(const ty_irradiance_cache* cache, ty_reflected_light light, ty_vec position, ty_vec normal,
                            float irradiance[3]);

#endif
