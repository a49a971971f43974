/* The images of a grid that repeats along some axes (ty_diffusion_def.periodic): what lies beyond its faces is the
 * cells at the opposite ones. For other grids the calls do nothing. */
#ifndef TY_SOLVE_DIFFUSION_IMAGES_H
#define TY_SOLVE_DIFFUSION_IMAGES_H

#include "solve/diffusion/job.h"

/* Fills the ghosts at those faces; origin: cell (0, 0, 0) of an array of items of so many bytes. */
void ty_diffusion_wrap(const ty_diffusion_job* job, const ty_box* box, void* origin, size_t item);
/* The coupling across those faces, from that through the lower ones; none to itself of a cell that is alone along an
 * axis. */
void ty_diffusion_couple_images(const ty_diffusion_job* job, const ty_level* level);

#endif
