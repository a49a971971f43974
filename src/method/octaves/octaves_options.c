/* Options of multiple scattering octaves. */
#include "image/march/froxels.h"
#include "image/options.h"
#include "method/octaves/job.h"

#include "base/context.h"

#include <math.h>

static const char* const views[] = {"unscaled", "scaled", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_octaves_def, count), .type = TY_OPTION_INT, .min = 1, .max = TY_OCTAVES_COUNT_MAX, .preset = 6,
     .doc = "Octaves N, single scattering included."},
    {TY_OPTION_FIELD(ty_octaves_def, scattering), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 0.5,
     .doc = "Scale a of scattering: octave i scatters a^i sigma_s."},
    {TY_OPTION_FIELD(ty_octaves_def, extinction), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 0.5,
     .doc = "Scale b of extinction: b^i sigma_t attenuates the light of octave i."},
    {TY_OPTION_FIELD(ty_octaves_def, anisotropy), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 0.5,
     .doc = "Scale c of anisotropy: c^i g is the mean cosine of octave i."},
    {TY_OPTION_FIELD(ty_octaves_def, view_extinction), .type = TY_OPTION_WORD, .words = views,
     .doc = "Extinction towards the eye: unscaled is sigma_t in all octaves, as in engines; scaled is b^i sigma_t, for "
            "which scattering must not exceed extinction."},
    {TY_OPTION_FIELD(ty_octaves_def, resolution), .type = TY_OPTION_INT, .min = 4, .max = 1024, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "Cells of light along the longest side, never finer than voxels; auto is as fine, 256 at most, and 64 "
            "without voxels."},
    TY_OPTION_ENVIRONMENT_BEAMS(ty_octaves_def),
    TY_OPTION_SURFACE_POINTS(ty_octaves_def),
    TY_OPTION_SPP(ty_octaves_def),
    TY_OPTION_STEP(ty_octaves_def, "voxels"),
    TY_OPTION_RAY_SPACING(ty_octaves_def),
    {TY_OPTION_FIELD(ty_octaves_def, froxels), .type = TY_OPTION_INT, .min = 4, .max = TY_FROXEL_COLUMNS_MAX,
     .flags = TY_OPTION_OR_ZERO, .unit = "columns",
     .doc = "Columns of froxels as high as wide, from which pixels are interpolated as in engines, which have 160; spp "
            "rays go through each, and step and ray_spacing have no effect; 0: rays march through the media."},
    {TY_OPTION_FIELD(ty_octaves_def, froxel_slices), .type = TY_OPTION_INT, .min = 1, .max = TY_FROXEL_SLICES_MAX,
     .preset = 64, .unit = "slices", .doc = "Slices of froxels in depth, as many as in engines by default."},
};

const ty_option_table ty_octaves_options =
    TY_OPTION_TABLE("octaves", ty_octaves_def, "ty_default_octaves_def", options);

void ty_init_octaves_def(void* def, size_t bytes) {
    ty_options_init(&ty_octaves_options, def, bytes);
}

/* a <= b bounds the octaves of an attenuated view: along a ray with extinction b^i sigma_t, the radiance of octave i is
 * at most (a / b)^i times the albedo (Wrenninge 2013). */
ty_result ty_octaves_check_scales(ty_context* context, const void* def) {
    const ty_octaves_def* own = def;
    if (own->view_extinction != TY_OCTAVES_VIEW_SCALED || own->scattering <= own->extinction) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT,
                   "octaves.scattering: %g exceeds octaves.extinction (%g), with which a scaled view gains energy",
                   own->scattering, own->extinction);
}

ty_march_octaves ty_octaves_of(const ty_octaves_def* def) {
    const bool scaled = def->view_extinction == TY_OCTAVES_VIEW_SCALED;
    ty_march_octaves octaves = {.count = def->count, .scales_view = scaled && def->count > 1};
    for (int32_t i = 0; i < def->count; ++i) {
        octaves.scattering[i] = (float)pow(def->scattering, i);
        octaves.extinction[i] = (float)pow(def->extinction, i);
        octaves.anisotropy[i] = (float)pow(def->anisotropy, i);
    }
    return octaves;
}
