/* The image of a run: R, G, B and the channels that ty_path_def.aovs asks for. */
#ifndef TY_PATH_AOV_H
#define TY_PATH_AOV_H

#include "method/path/driver.h"

/* Whether some of these channels are made of parts. */
bool ty_aovs_need_classes(uint32_t aovs);
/* Whether channels say what the first ray meets. */
bool ty_aovs_need_first_hit(uint32_t aovs);

/* Bytes of an image with these channels, per pixel. */
size_t ty_aovs_pixel_size(uint32_t aovs);

/* An image of the run's crop, with all channels still 0. */
ty_result ty_path_image_create(const ty_path_run* run, ty_image** out);
/* Fills it in from the run's items. */
void ty_path_image_fill(const ty_path_run* run, ty_image* image);

#endif
