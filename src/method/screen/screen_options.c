/* Options of the method screen in scene files. */
#include "method/screen/screen_options.h"

static const char* const variants[] = {"scatter", "gather", "naive", "published", "reference", NULL};
const char* const ty_screen_spreads[] = {"small_angle", "gaussian", NULL};
static const char* const environments[] = {"around", "lights", "none", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_screen_scene_def, variant), .type = TY_OPTION_WORD, .words = variants,
     .doc = "Variant of the method: scatter is ours; gather is the paper's with masks normalised; naive is the paper's "
            "without masks; published is the paper's to the letter; reference is the exact point spread function, "
            "which is slow."},
    {TY_OPTION_FIELD(ty_screen_scene_def, spread), .type = TY_OPTION_WORD, .words = ty_screen_spreads,
     .doc = "Spread of scattered light by many small angles, as measured, or by the Gaussian of the paper, which "
            "variants but scatter and reference always have."},
    {TY_OPTION_FIELD(ty_screen_scene_def, filter), .type = TY_OPTION_INT, .min = 2, .max = 6, .preset = 4,
     .multiple = 2, .doc = "Number of taps along x and y from one level to the next."},
    {TY_OPTION_FIELD(ty_screen_scene_def, levels), .type = TY_OPTION_INT, .min = 1, .max = TY_SCREEN_LEVELS_MAX,
     .preset = TY_AUTO, .flags = TY_OPTION_AUTO,
     .doc = "Number of levels of the pyramid; auto is as many as the widest spread needs (of Gaussians 6 at most)."},
    {TY_OPTION_FIELD(ty_screen_scene_def, environment), .type = TY_OPTION_WORD, .words = environments,
     .doc = "Light from outside the picture: the mean radiance that arrives at the camera in clear air, that of "
            "environment lights alone, or none."},
    {TY_OPTION_FIELD(ty_screen_scene_def, balance), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Adds that light only in place of the picture's own light that is lost to backward scattering, not in "
            "full."},
};

const ty_option_table ty_screen_options =
    TY_OPTION_TABLE("screen", ty_screen_scene_def, "ty_default_screen_scene_def", options);
