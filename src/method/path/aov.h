/* Output image of a run: R, G, B and the channels of ty_path_def.aovs. */
#ifndef TY_PATH_AOV_H
#define TY_PATH_AOV_H

#include "method/path/driver.h"

/* True if some of these channels are sums per path class. */
bool ty_aovs_need_classes(uint32_t aovs);
/* True if some of these channels describe the first hit. */
bool ty_aovs_need_first_hit(uint32_t aovs);

/* Bytes per pixel of an image with these channels. */
size_t ty_aovs_pixel_size(uint32_t aovs);

/* Creates an image of the run's crop, all channels 0. */
ty_result ty_path_image_create(const ty_path_run* run, ty_image** out);
/* Fills the image from the run's items. */
void ty_path_image_fill(const ty_path_run* run, ty_image* image);

#endif
