/* Options of path tracing. */
#include "base/context.h"
#include "image/options.h"
#include "method/path/driver.h"

static const char* const guides[] = {"auto", "none", "dom", NULL};
static const uint32_t guide_values[] = {(uint32_t)TY_PATH_GUIDE_AUTO, TY_PATH_GUIDE_NONE, TY_PATH_GUIDE_DOM};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_path_def, max_depth), .type = TY_OPTION_INT, .min = 0, .max = INT32_MAX,
     .doc = "Scatterings and reflections at most; 0 means no bound but Russian roulette."},
    {TY_OPTION_FIELD(ty_path_def, point_light_directions), .type = TY_OPTION_BOOL, .preset = 1,
     .doc =
         "Sample directions about point and spot lights in media, and distances along rays past them by the light that "
         "they scatter; false means equiangular sampling alone, to show what that is worth."},
    {TY_OPTION_FIELD(ty_path_def, energy_compensation), .type = TY_OPTION_BOOL, .preset = 1,
     .doc =
         "Return the light that microfacets of rough surfaces scatter several times, and give the diffuse part of a "
         "dielectric what its reflection leaves; false means the formulas of glTF 2.0, appendix B, which lose light."},
    {TY_OPTION_FIELD(ty_path_def, guide), .type = TY_OPTION_WORD, .words = guides, .values = guide_values,
     .preset = TY_PATH_GUIDE_AUTO,
     .doc =
         "Sample directions and distances by the light that a coarse solve by discrete ordinates finds in the media, "
         "too: less noise where light comes from few places; none means by lights and media alone. Automatic means the "
         "one with less noise in the same time by a pilot, and none for images of less than 8 million paths."},
    {TY_OPTION_FIELD(ty_path_def, spp), .type = TY_OPTION_INT, .min = 1, .max = TY_PATH_SPP_MAX, .preset = 64,
     .flags = TY_OPTION_CALLS_ONLY, .doc = "Samples per pixel, ray or cell at most."},
    {TY_OPTION_FIELD(ty_path_def, seconds), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1e9, .unit = "s",
     .flags = TY_OPTION_CALLS_ONLY, .doc = "Time after which sampling stops; 0 means no bound."},
    {TY_OPTION_FIELD(ty_path_def, error), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1e9, .flags = TY_OPTION_CALLS_ONLY,
     .doc = "Relative error at which sampling stops; 0 means no bound."},
    {TY_OPTION_FIELD(ty_path_def, aovs), .type = TY_OPTION_INT, .min = 0, .max = TY_AOV_ALL | TY_AOV_HALF,
     .preset = TY_AOV_VARIANCE, .flags = TY_OPTION_CALLS_ONLY, .doc = "Channels of images, TY_AOV_... together."},
    {TY_OPTION_FIELD(ty_path_def, state_seconds), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1e9, .preset = TY_AUTO,
     .unit = "s", .flags = TY_OPTION_AUTO | TY_OPTION_CALLS_ONLY,
     .doc = "Time between two states that are handed out; automatic means 2 s, or longer where that took more than 2 % "
            "of the time."},
};

const ty_option_table ty_path_options = TY_OPTION_TABLE("path", ty_path_def, "ty_default_path_def", options);

void ty_init_path_def(void* def, size_t bytes) {
    ty_options_init(&ty_path_options, def, bytes);
}

ty_result ty_path_take_def(ty_context* context, const ty_path_def* def, ty_path_def* own) {
    const ty_result result = ty_options_take(context, &ty_path_options, def, own);
    if (result != TY_OK) return result;
    if (own->resume == NULL && own->resume_size > 0)
        return ty_fail(context, TY_ERROR_ARGUMENT, "path.resume is NULL, and path.resume_size is %zu",
                       own->resume_size);
    return ty_check_resolution(context, "path", own->width, own->height);
}
