/* Density that falls off exponentially along an axis. */
#include "base/context.h"
#include "grid/grid.h"

#include <math.h>

/* Voxels per scale height: linear interpolation between them is within 0.13 % of the exponential. */
enum { VOXELS_PER_SCALE = 10, VOXELS_MAX = 1024 };

/* The largest exponent. */
static const double exponent_max = 20;

ty_result ty_grid_create_exponential(ty_context* context, int32_t axis, double low, double high, double scale_height,
                                     ty_grid** out) {
    if (context == NULL || out == NULL || axis < 0 || axis > 2)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_grid_create_exponential: an argument is not valid");
    if (!(scale_height > 0 && scale_height <= 1e9))
        return ty_fail(context, TY_ERROR_ARGUMENT, "scale_height: %g is outside (0, 1e9]", scale_height);
    if (!(high > low && fabs(low) <= 1e9 && fabs(high) <= 1e9))
        return ty_fail(context, TY_ERROR_ARGUMENT, "heights: %g to %g is no range within 1e9", low, high);
    if (-low / scale_height > exponent_max)
        return ty_fail(context, TY_ERROR_ARGUMENT, "base: it is %g scale heights above the lower end, more than %g",
                       -low / scale_height, exponent_max);
    float values[VOXELS_MAX];
    const double wanted = ceil(VOXELS_PER_SCALE * (high - low) / scale_height);
    const int32_t count = wanted < 2 ? 2 : wanted > VOXELS_MAX ? VOXELS_MAX : (int32_t)wanted;
    for (int32_t i = 0; i < count; ++i)
        values[i] = (float)exp(-(low + (high - low) * (i + 0.5) / count) / scale_height);
    ty_grid_def def = ty_default_grid_def();
    for (int32_t a = 0; a < 3; ++a) def.size[a] = a == axis ? count : 1;
    def.values = values;
    return ty_grid_create(context, &def, out);
}
