/* The noise of path-traced images, and error estimates corrected for it. */
#ifndef TY_BENCH_NOISE_H
#define TY_BENCH_NOISE_H

#include <tyndall/image.h>

/* Standard errors of the means over block x block pixels of a path-traced image with variance, as root mean squares,
 * W m^-2 sr^-1: R, G, B, all. */
void bench_noise(const ty_image* image, int32_t block, double noise[4]);
/* The RMSE after subtraction of the reference's noise variance; NaN when it is below the noise. */
double bench_without_noise(double rmse, double noise);

#endif
