/* Options of principal-ordinates propagation. */
#include "image/options.h"
#include "method/pop/job.h"

static const char* const modes[] = {"split", "published", "collided", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_pop_def, mode), .type = TY_OPTION_WORD, .words = modes,
     .doc = "Form of the method: split is right in absolute units; published is the paper's, for its figures, and "
            "several times too bright; collided is the same, from light that scatters for the first time."},
    {TY_OPTION_FIELD(ty_pop_def, resolution), .type = TY_OPTION_INT, .min = 4, .max = TY_POP_CELLS_MAX,
     .preset = TY_AUTO, .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "Cells of an ordinate's grid along each axis; auto is a third of the voxels along the longest side (of "
            "direct), 32 to 48, and 32 in the modes published and collided."},
    {TY_OPTION_FIELD(ty_pop_def, merged), .type = TY_OPTION_INT, .min = 4, .max = 512, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "Cells of the grid that ordinates are brought together in, along the longest side; auto is one and a half "
            "of resolution, but at most 48 or resolution, and twice resolution in the modes published and collided."},
    {TY_OPTION_FIELD(ty_pop_def, fine_lights), .formerly = "sharp", .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Puts the first eight directional, point and spot lights through cells as fine as the medium's instead of "
            "grids of their own; mode split alone."},
    {TY_OPTION_FIELD(ty_pop_def, direct), .type = TY_OPTION_INT, .min = 4, .max = 1024, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "These cells along the longest side; auto is as fine as the finest voxels, 256 at most, and 64 without "
            "voxels."},
    {TY_OPTION_FIELD(ty_pop_def, ordinates), .type = TY_OPTION_INT, .min = 1, .max = 4096, .preset = 64,
     .doc = "Number of ordinates per environment light."},
    {TY_OPTION_FIELD(ty_pop_def, prefilter), .type = TY_OPTION_DOUBLE, .min = 0, .max = 16, .preset = 1,
     .doc = "Exponent beta of the prefilter: ordinates begin with the width of the solid angle that they stand for; 0 "
            "makes them lines."},
    {TY_OPTION_FIELD(ty_pop_def, importance), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Chooses ordinates by the light that the camera sees of them, too."},
    {TY_OPTION_FIELD(ty_pop_def, surface_points), .type = TY_OPTION_INT, .min = 1, .max = 65536, .preset = 16,
     .doc = "Number of points that each area light and glowing sphere is replaced by."},
    {TY_OPTION_FIELD(ty_pop_def, vpls), .type = TY_OPTION_INT, .min = 0, .max = 4096, .preset = 64,
     .doc = "Number of virtual point lights for the light that surfaces reflect into media, in the modes published and "
            "collided; 0 means none."},
    {TY_OPTION_FIELD(ty_pop_def, shadow_texels), .type = TY_OPTION_INT, .min = 16, .max = 1024, .preset = 128,
     .unit = "texels", .doc = "Side of the reflective shadow maps that virtual point lights are chosen from."},
    {TY_OPTION_FIELD(ty_pop_def, vpl_min_distance), .formerly = "clamp", .type = TY_OPTION_DOUBLE, .min = 0, .max = 1,
     .preset = 0.05,
     .doc = "Distance below which virtual point lights get no brighter, as a fraction of the longest side of the box "
            "around all media; smaller values lose less light near surfaces and show single virtual lights."},
    {TY_OPTION_FIELD(ty_pop_def, iterations), .type = TY_OPTION_INT, .min = 1, .max = 10000, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "Iterations of propagation in the modes published and collided; auto is as many as light needs."},
    {TY_OPTION_FIELD(ty_pop_def, residuum), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 0.1,
     .doc =
         "Mean cosine below which light goes on as isotropic, for all ordinates together, in the same modes; 0 means "
         "never, 0.02 errs by 0.4 % and 0.3 by 10 %, at 63 and 20 iterations."},
    {TY_OPTION_FIELD(ty_pop_def, residuum_iterations), .type = TY_OPTION_INT, .min = 1, .max = 10000, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "Iterations of that light at most; auto ends when a thousandth is left; lower it where dense media that "
            "hardly "
            "absorb take too long, and what is left (`left` in --stats) is lost."},
    {TY_OPTION_FIELD(ty_pop_def, max_flux_fraction), .formerly = "streaming", .type = TY_OPTION_DOUBLE, .min = 0,
     .max = 1, .preset = TY_AUTO, .flags = TY_OPTION_AUTO | TY_OPTION_OPEN_MIN,
     .doc =
         "Largest ratio of flux to fluence, as of fld, in mode split; auto is 0.5, and up to 0.8 with the fraction "
         "of light that comes from local lights within the media; 0.8 suits a light within media that auto weighs too "
         "little beside others."},
    {TY_OPTION_FIELD(ty_pop_def, tolerance), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 1e-2,
     .flags = TY_OPTION_OPEN,
     .doc = "Residual of the diffusion over its source (root mean squares), as of fld, in mode split."},
    {TY_OPTION_FIELD(ty_pop_def, interreflection), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Lights media by what surfaces outside of their box reflect, and these by the media, over and over."},
    TY_OPTION_SPP(ty_pop_def),
    TY_OPTION_STEP(ty_pop_def, "voxels"),
    TY_OPTION_RAY_SPACING(ty_pop_def),
};

const ty_option_table ty_pop_options = TY_OPTION_TABLE("pop", ty_pop_def, "ty_default_pop_def", options);

void ty_init_pop_def(void* def, size_t bytes) {
    ty_options_init(&ty_pop_options, def, bytes);
}
