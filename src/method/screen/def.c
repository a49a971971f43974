/* Options: their defaults, the baselines made of them, and their checks. */
#include "method/screen/job.h"

#include "base/context.h"
#include "scene/check.h"
#include "scene/phase.k.h"

#include <math.h>

ty_screen_def ty_default_screen_def(void) {
    return (ty_screen_def){.cookie = TY_DEF_COOKIE,
                           .forward = {1, 1, 1},
                           .center = {-1, -1},
                           .unknown = 1e6f,
                           .filter = 4,
                           .levels = TY_SCREEN_LEVELS_AUTO,
                           .mask = TY_SCREEN_MASK_SMOOTH,
                           .mask_width = 0.5f,
                           .luminance_weights = true,
                           .blurred_distance = true,
                           .normalise = true,
                           .level_scale = 0.8f};
}

void ty_screen_naive_def(ty_screen_def* def) {
    def->variant = TY_SCREEN_GATHER;
    def->mask = TY_SCREEN_MASK_NONE;
    def->luminance_weights = false;
    def->blurred_distance = false;
}

void ty_screen_published_def(ty_screen_def* def) {
    const ty_screen_def paper = ty_default_screen_def();
    def->variant = TY_SCREEN_GATHER;
    def->mask = paper.mask;
    def->luminance_weights = true;
    def->blurred_distance = true;
    def->normalise = false;
}

double ty_screen_focal(int32_t height, double fov_y) {
    return 0.5 * height / tan(fov_y * (TY_PI_F64 / 360));
}

void ty_screen_balance(ty_screen_def* def, const float radiance[3]) {
    for (int c = 0; c < 3; ++c) {
        const double forward = ty_hg_forward_share((double)def->g[c]);
        def->forward[c] = (float)forward;
        def->environment[c] = (float)((1 - forward) * (double)radiance[c]);
    }
}

static ty_result check_medium(ty_context* context, const ty_screen_def* def) {
    ty_result result = ty_check_rgb(context, "screen.sigma_s", def->sigma_s, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_rgb(context, "screen.sigma_a", def->sigma_a, 0, TY_COLOR_MAX);
    for (int c = 0; c < 3 && result == TY_OK; ++c)
        if (!(fabsf(def->g[c]) < 1))
            result = ty_fail(context, TY_ERROR_ARGUMENT, "screen.g: %g is outside (-1, 1)", (double)def->g[c]);
    if (result == TY_OK) result = ty_check_rgb(context, "screen.environment", def->environment, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_rgb(context, "screen.forward", def->forward, 0, 1);
    return result;
}

static ty_result check_camera(ty_context* context, const ty_screen_def* def) {
    for (int axis = 0; axis < 2; ++axis) {
        if (!(def->focal[axis] > 0 && def->focal[axis] <= 1e9))
            return ty_fail(context, TY_ERROR_ARGUMENT,
                           "screen.focal: %g is not a focal length in pixels, above 0 and at most 1e9",
                           def->focal[axis]);
        if (!(fabs(def->center[axis]) <= 1e9))
            return ty_fail(context, TY_ERROR_ARGUMENT, "screen.center: %g is outside -1e9..1e9", def->center[axis]);
    }
    if (!(def->unknown > 0 && def->unknown <= 1e15f))
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen.unknown: %g m is not a distance, above 0 and at most 1e15",
                       (double)def->unknown);
    return TY_OK;
}

bool ty_screen_has_filter(const ty_screen_def* def) {
    return def->filter == 2 || def->filter == 4 || def->filter == 6;
}

bool ty_screen_has_levels(const ty_screen_def* def) {
    return def->levels == TY_SCREEN_LEVELS_AUTO || def->levels == TY_SCREEN_LEVELS_ALL ||
           (def->levels >= 1 && def->levels <= TY_SCREEN_LEVELS_MAX);
}

static ty_result check_filter(ty_context* context, const ty_screen_def* def) {
    if (!ty_screen_has_filter(def))
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen.filter: %d is not 2, 4 or 6", def->filter);
    if (!ty_screen_has_levels(def))
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen.levels: %d is outside 1..%d", def->levels,
                       TY_SCREEN_LEVELS_MAX);
    ty_result result = ty_check_number(context, "screen.variant", def->variant, 0, TY_SCREEN_REFERENCE);
    if (result == TY_OK) result = ty_check_number(context, "screen.spread", def->spread, 0, TY_SCREEN_SPREAD_GAUSSIAN);
    if (result == TY_OK) result = ty_check_number(context, "screen.mask", def->mask, 0, TY_SCREEN_MASK_SMOOTH);
    if (result == TY_OK)
        result = ty_check_number(context, "screen.mask_width", (double)def->mask_width, (double)1e-6f, 1e6);
    if (result == TY_OK) result = ty_check_number(context, "screen.level_scale", (double)def->level_scale, 1e-3, 1e3);
    if (result == TY_OK) result = ty_check_number(context, "screen.window", def->window, 0, 65536);
    return result;
}

ty_result ty_screen_check(ty_context* context, const ty_screen_def* def) {
    ty_result result = ty_check_def(context, def, "ty_default_screen_def");
    if (result == TY_OK) result = check_medium(context, def);
    if (result == TY_OK) result = check_camera(context, def);
    return result == TY_OK ? check_filter(context, def) : result;
}

static ty_result check_planes(ty_context* context, const char* name, const ty_screen_planes* planes) {
    for (int c = 0; c < 3; ++c)
        if (planes->data[c] == NULL)
            return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %s.data[%d] is NULL", name, c);
    if (planes->step == 0) return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %s.step is 0", name);
    return TY_OK;
}

ty_result ty_screen_check_image(ty_context* context, const ty_screen_image* image, bool out) {
    if (image == NULL) return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: it is NULL");
    if (image->width < 1 || image->height < 1 || image->width > TY_SCREEN_SIDE_MAX ||
        image->height > TY_SCREEN_SIDE_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %d x %d is outside 1..%d", image->width,
                       image->height, TY_SCREEN_SIDE_MAX);
    ty_result result = check_planes(context, "color", &image->color);
    if (result != TY_OK) return result;
    if (image->distance == NULL || image->distance_step == 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: distance is NULL, or distance_step is 0");
    return out ? check_planes(context, "out", &image->out) : TY_OK;
}
