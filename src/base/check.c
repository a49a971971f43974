/* Argument checks shared by defs. */
#include "base/check.h"

#include "base/context.h"

#include <math.h>

/* Largest accepted coordinate: its square is finite in single precision. */
#define POINT_MAX 1e15

ty_result ty_check_point(ty_context* context, const char* field, const double point[3]) {
    for (int a = 0; a < 3; ++a)
        if (!(fabs(point[a]) <= POINT_MAX))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s[%d]: %g is outside [-1e15, 1e15]", field, a, point[a]);
    return TY_OK;
}

ty_result ty_check_direction(ty_context* context, const char* field, const double direction[3]) {
    const double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    if (!(length > 0) || !isfinite(length))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: (%g, %g, %g) is not a direction", field, direction[0],
                       direction[1], direction[2]);
    return TY_OK;
}

ty_result ty_check_rays(ty_context* context, const double* rays, int64_t count, const double* radiance) {
    if (count < 1) return ty_fail(context, TY_ERROR_ARGUMENT, "radiance: a count of %lld rays", (long long)count);
    if (rays == NULL || radiance == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "radiance: rays or radiance is NULL");
    ty_result result = TY_OK;
    for (int64_t i = 0; i < count && result == TY_OK; ++i) {
        result = ty_check_point(context, "rays: point", rays + 6 * i);
        if (result == TY_OK) result = ty_check_direction(context, "rays: direction", rays + 6 * i + 3);
    }
    return result;
}

ty_result ty_check_affine(ty_context* context, const char* field, const ty_affine* affine) {
    ty_affine inverse;
    if (!ty_affine_invert(affine, &inverse))
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the map cannot be inverted", field);
    return TY_OK;
}

ty_result ty_check_rgb(ty_context* context, const char* field, const float rgb[3], double low, double high) {
    for (int c = 0; c < 3; ++c)
        if (!(rgb[c] >= low && rgb[c] <= high))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s[%d]: %g is outside [%g, %g]", field, c, (double)rgb[c], low,
                           high);
    return TY_OK;
}

ty_result ty_check_number(ty_context* context, const char* field, double value, double low, double high) {
    if (value >= low && value <= high) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %g is outside [%g, %g]", field, value, low, high);
}

ty_result ty_check_edges(ty_context* context, const char* field, const double u[3], const double v[3]) {
    for (int a = 0; a < 3; ++a)
        if (!(fabs(u[a]) <= POINT_MAX && fabs(v[a]) <= POINT_MAX))
            return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the edges u and v reach outside [-1e15, 1e15]", field);
    const double cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double area = sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    if (!(area > 0)) return ty_fail(context, TY_ERROR_ARGUMENT, "%s: the edges u and v span no area", field);
    return TY_OK;
}
