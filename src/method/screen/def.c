/* Options: their defaults, the baselines made of them, and their checks. */
#include "method/screen/job.h"

#include "base/context.h"
#include "method/screen/screen_options.h"
#include "base/check.h"
#include "scene/media/phase.k.h"

#include <math.h>

/* Values per channel, and per axis of the picture. */
#define CHANNELS(field) TY_OPTION_FIELD(ty_screen_def, field), .type = TY_OPTION_FLOAT, .count = 3
#define AXES(field) TY_OPTION_FIELD(ty_screen_def, field), .type = TY_OPTION_DOUBLE, .count = 2

static const char* const variants[] = {"scatter", "gather", "reference", NULL};
static const char* const masks[] = {"none", "step", "smooth", NULL};

static const ty_option options[] = {
    {CHANNELS(sigma_s), .max = TY_COLOR_MAX, .unit = "1/m", .doc = "Scattering coefficient of the medium."},
    {CHANNELS(sigma_a), .max = TY_COLOR_MAX, .unit = "1/m", .doc = "Absorption coefficient of the medium."},
    {CHANNELS(g), .min = -1, .max = 1, .flags = TY_OPTION_OPEN, .doc = "Mean cosine of the phase function."},
    {CHANNELS(environment), .max = TY_COLOR_MAX, .unit = "W m^-2 sr^-1",
     .doc = "Radiance that arrives at the medium from all around."},
    {CHANNELS(forward), .max = 1, .preset = 1, .doc = "Fraction of the scattered light that still arrives."},
    {AXES(focal), .max = 1e9, .flags = TY_OPTION_OPEN_MIN, .unit = "pixels", .doc = "Focal length."},
    {AXES(center), .min = -1e9, .max = 1e9, .preset = -1, .unit = "pixels",
     .doc = "Principal point from the left and top edge; -1 is the center."},
    {TY_OPTION_FIELD(ty_screen_def, missing_depth), .type = TY_OPTION_FLOAT, .max = 1e15, .preset = 1e6,
     .flags = TY_OPTION_OPEN_MIN, .unit = "m", .doc = "Distance of pixels that have none, such as sky."},
    {TY_OPTION_FIELD(ty_screen_def, variant), .type = TY_OPTION_WORD, .words = variants,
     .doc = "Algorithm that spreads the light."},
    {TY_OPTION_FIELD(ty_screen_def, spread), .type = TY_OPTION_WORD, .words = ty_screen_spreads,
     .doc = "Shape of the spread."},
    {TY_OPTION_FIELD(ty_screen_def, filter), .type = TY_OPTION_INT, .min = INT32_MIN, .max = INT32_MAX, .preset = 4,
     .doc = "Taps along x and y from one level to the next: 2, 4 or 6."},
    {TY_OPTION_FIELD(ty_screen_def, levels), .type = TY_OPTION_INT, .min = INT32_MIN, .max = INT32_MAX,
     .preset = TY_AUTO, .flags = TY_OPTION_AUTO, .doc = "Levels of the pyramid."},
    {TY_OPTION_FIELD(ty_screen_def, mask), .type = TY_OPTION_WORD, .words = masks, .preset = TY_SCREEN_MASK_SMOOTH,
     .doc = "Mask of the gather."},
    {TY_OPTION_FIELD(ty_screen_def, mask_width), .type = TY_OPTION_FLOAT, .min = (double)1e-6f, .max = 1e6,
     .preset = 0.5, .doc = "Width epsilon of the mask (Eq. 7)."},
    {TY_OPTION_FIELD(ty_screen_def, luminance_weights), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Weights by luminance (Eq. 8)."},
    {TY_OPTION_FIELD(ty_screen_def, blurred_distance), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Takes levels from a blurred distance map (Eq. 11)."},
    {TY_OPTION_FIELD(ty_screen_def, normalise), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Divides by the filtered mask."},
    {TY_OPTION_FIELD(ty_screen_def, level_scale), .type = TY_OPTION_FLOAT, .min = 1e-3, .max = 1e3,
     .preset = (double)0.8f, .unit = "pixels", .doc = "Factor c of Eq. 7 and 10."},
    {TY_OPTION_FIELD(ty_screen_def, window), .type = TY_OPTION_INT, .max = 65536, .unit = "pixels",
     .doc = "Pixels that a pixel's light reaches in the reference; 0 means no bound."},
};

static const ty_option_table table = TY_OPTION_TABLE("screen", ty_screen_def, "ty_default_screen_def", options);

void ty_init_screen_def(void* def, size_t bytes) {
    ty_options_init(&table, def, bytes);
}

void ty_init_screen_image(void* image, size_t bytes) {
    const ty_screen_image own = {.color.step = 1, .distance_step = 1, .out.step = 1};
    ty_init_def(image, bytes, &own, sizeof own);
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

bool ty_screen_has_filter(const ty_screen_def* def) {
    return def->filter == 2 || def->filter == 4 || def->filter == 6;
}

bool ty_screen_has_levels(const ty_screen_def* def) {
    return def->levels == TY_AUTO || def->levels == TY_SCREEN_LEVELS_ALL ||
           (def->levels >= 1 && def->levels <= TY_SCREEN_LEVELS_MAX);
}

ty_result ty_screen_take_def(ty_context* context, const ty_screen_def* def, ty_screen_def* own) {
    const ty_result result = ty_options_take(context, &table, def, own);
    if (result != TY_OK) return result;
    if (!ty_screen_has_filter(own))
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen.filter: %d is not 2, 4 or 6", own->filter);
    if (!ty_screen_has_levels(own))
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "screen.levels: %d is outside 1..%d; write TY_AUTO for the default choice", own->levels,
                       TY_SCREEN_LEVELS_MAX);
    return TY_OK;
}

static ty_result check_planes(ty_context* context, const char* name, const ty_screen_planes* planes) {
    for (int c = 0; c < 3; ++c)
        if (planes->data[c] == NULL)
            return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %s.data[%d] is NULL", name, c);
    if (planes->step == 0) return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %s.step is 0", name);
    return TY_OK;
}

static ty_result check_image(ty_context* context, const ty_screen_image* image, bool out) {
    if (image->width < 1 || image->height < 1 || image->width > TY_SCREEN_SIDE_MAX ||
        image->height > TY_SCREEN_SIDE_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: %d x %d is outside 1..%d", image->width,
                       image->height, TY_SCREEN_SIDE_MAX);
    const ty_result result = check_planes(context, "color", &image->color);
    if (result != TY_OK) return result;
    if (image->distance == NULL || image->distance_step == 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "screen image: distance is NULL, or distance_step is 0");
    return out ? check_planes(context, "out", &image->out) : TY_OK;
}

ty_result ty_screen_take_image(ty_context* context, const ty_screen_image* image, ty_screen_image* own, bool out) {
    *own = ty_default_screen_image();
    const ty_result result = ty_take_def(context, image, "ty_default_screen_image", own, sizeof *own);
    return result == TY_OK ? check_image(context, own, out) : result;
}
