/* Options of discrete ordinates. */
#include "image/options.h"
#include "method/dom/job.h"

static const char* const accelerations[] = {"diffusion", "none", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_dom_def, directions), .type = TY_OPTION_INT, .min = 8, .max = TY_DOM_DIRECTIONS_MAX,
     .preset = 96,
     .doc = "Number of ordinates; time grows with it and memory does not; 48 do for a first look, 400 for g above "
            "0.95."},
    {TY_OPTION_FIELD(ty_dom_def, last_directions), .type = TY_OPTION_INT, .min = 8, .max = TY_DOM_DIRECTIONS_MAX,
     .flags = TY_OPTION_OR_ZERO,
     .doc = "Number of ordinates of one more sweep at the end, against rays and curtains: 400 take the time of four "
            "sweeps of 96 and show as much as 400 all along; 0 means none."},
    {TY_OPTION_FIELD(ty_dom_def, resolution), .type = TY_OPTION_INT, .min = 4, .max = TY_DOM_CELLS_MAX,
     .preset = TY_AUTO, .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "Cells that ordinates go through, along the longest side; auto is a third of the voxels, 24 to 64, and up "
            "to twice as many where they would be thicker than 4 mean free paths (as many as voxels, 96 at most, where "
            "a transfer function makes edges and they would be thicker than 2); time grows with its third power."},
    {TY_OPTION_FIELD(ty_dom_def, direct), .type = TY_OPTION_INT, .min = 4, .max = 1024, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc =
         "Cells of uncollided light along that side; auto is as fine as the finest voxels, or twice as fine where a "
         "transfer function makes edges within them, 256 at most (192 of these where not all lights shine from one "
         "direction or position), and 64 without voxels; voxels thicker than 1.5 mean free paths that point and "
         "spot lights alone, or with directional ones, shine on are divided into up to 4 per side, 128 cells at most; "
         "raise it where shadows within media look blurred or stepped; time grows with its third power."},
    {TY_OPTION_FIELD(ty_dom_def, bands), .type = TY_OPTION_INT, .min = 1, .max = TY_DOM_BANDS_MAX, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "L, the number of Legendre terms that the phase function keeps without its forward peak; auto follows from "
            "the g of the media and the number of directions."},
    {TY_OPTION_FIELD(ty_dom_def, acceleration), .type = TY_OPTION_WORD, .words = accelerations,
     .doc = "Acceleration of the sweeps: diffusion on a coarser grid of the same light, or none, which takes a sweep "
            "per order of scattering and serves comparisons."},
    {TY_OPTION_FIELD(ty_dom_def, tolerance), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 1e-3,
     .flags = TY_OPTION_OPEN,
     .doc = "Relative change of the fluence (root mean square) that is still to come when sweeps end."},
    {TY_OPTION_FIELD(ty_dom_def, iterations), .type = TY_OPTION_INT, .min = 1, .max = INT32_MAX, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .doc = "Sweeps of each channel at most; auto is 100, and 10000 without acceleration."},
    TY_OPTION_INTERIOR_RESOLUTION(ty_dom_def),
    TY_OPTION_ENVIRONMENT_BEAMS(ty_dom_def),
    TY_OPTION_SURFACE_POINTS(ty_dom_def),
    {TY_OPTION_FIELD(ty_dom_def, interreflection), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Lights media by what surfaces outside of their box reflect, and these by the media, over and over."},
    {TY_OPTION_FIELD(ty_dom_def, differentiable), .type = TY_OPTION_BOOL,
     .doc = "Solves for light that has a gradient: ordinates go through thick cells, too, in place of diffusion."},
    TY_OPTION_SPP(ty_dom_def),
    TY_OPTION_STEP(ty_dom_def, "voxels"),
    TY_OPTION_RAY_SPACING(ty_dom_def),
};

const ty_option_table ty_dom_options = TY_OPTION_TABLE("dom", ty_dom_def, "ty_default_dom_def", options);

void ty_init_dom_def(void* def, size_t bytes) {
    ty_options_init(&ty_dom_options, def, bytes);
}
