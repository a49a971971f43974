/* Images: surfaces lit by the lights and the lattices, seen through the media. Channels: `single` is airlight,
 * `multiple` is the lattices' light that media scatter towards the camera. The lattices' irradiance on surfaces is in
 * neither, because light scattered by media cannot be separated there from light reflected by other surfaces. `albedo`
 * is, as in the path tracer, the fraction of the light that media scatter before the first surface. */
#ifndef TY_METHOD_LPV_IMAGE_IMAGE_H
#define TY_METHOD_LPV_IMAGE_IMAGE_H

#include "method/lpv/image/image_job.h"

/* Renders the image and fills in the image stages and ray counts of the stats. Errors: TY_ERROR_MEMORY; TY_CANCELLED
 * with *out NULL. */
ty_result ty_lpv_image(const ty_lpv_image_job* job, ty_image** out, ty_lpv_stats* stats);

#endif
