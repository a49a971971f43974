/* The noise of path-traced images. */
#include "bench/noise.h"

#include <math.h>

void bench_noise(const ty_image* image, int32_t block, double noise[4]) {
    static const char* const names[3] = {"variance.R", "variance.G", "variance.B"};
    const size_t count = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    double squares = 0;
    for (int c = 0; c < 3; ++c) {
        const float* variance = ty_image_plane_const(image, ty_image_find_channel(image, names[c]));
        double sum = 0;
        for (size_t i = 0; i < count; ++i) sum += (double)variance[i];
        const double variance_of_mean = sum / (double)count / (block * block);
        noise[c] = sqrt(variance_of_mean);
        squares += variance_of_mean / 3;
    }
    noise[3] = sqrt(squares);
}

double bench_without_noise(double rmse, double noise) {
    return rmse > noise ? sqrt(rmse * rmse - noise * noise) : NAN;
}
