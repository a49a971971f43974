/* Options of flux-limited diffusion. */
#include "image/options.h"
#include "method/fld/job.h"
#include "base/check.h"

static const char* const limiters[] = {"none", "sum", "max", "kershaw", "larsen", "levermore_pomraning", NULL};
static const char* const boundaries[] = {"marshak", "dirichlet", NULL};
static const char* const solvers[] = {"multigrid", "sor", "sor_float", NULL};
static const char* const beams[] = {"reduced", "published", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_fld_def, limiter), .type = TY_OPTION_WORD, .words = limiters,
     .preset = TY_FLD_LIMITER_LEVERMORE_POMRANING,
     .doc = "Flux limiter F(R) of Table 2; none is classical diffusion, which the method cda has."},
    {TY_OPTION_FIELD(ty_fld_def, larsen_power), .type = TY_OPTION_DOUBLE, .min = 1, .max = 100, .preset = 2,
     .doc = "Exponent n of the limiter larsen."},
    {TY_OPTION_FIELD(ty_fld_def, max_flux_fraction), .formerly = "streaming", .type = TY_OPTION_DOUBLE, .min = 0,
     .max = 1, .preset = TY_AUTO, .flags = TY_OPTION_AUTO | TY_OPTION_OPEN_MIN,
     .doc =
         "Largest ratio of flux to fluence; 1 is the paper's; auto is 0.55, and up to 0.8 with the fraction of light "
         "that comes from local lights within the media; larger values suit emissive media, and 0.8 a light within "
         "media that auto weighs too little beside others."},
    {TY_OPTION_FIELD(ty_fld_def, boundary), .type = TY_OPTION_WORD, .words = boundaries,
     .doc = "Boundary condition on the faces of the box around all media; dirichlet is the paper's."},
    {TY_OPTION_FIELD(ty_fld_def, beam), .type = TY_OPTION_WORD, .words = beams,
     .doc = "Treatment of light that scattering sends nearly straight on: reduced leaves it with the uncollided light; "
            "published is the paper's, for isotropic media."},
    {TY_OPTION_FIELD(ty_fld_def, resolution), .type = TY_OPTION_INT, .min = 4, .max = TY_FLD_CELLS_MAX,
     .preset = TY_AUTO, .flags = TY_OPTION_AUTO, .unit = "cells",
     .doc = "Cells of direct light along the longest side, never finer than voxels; auto is as fine, 256 at most, and "
            "64 without voxels."},
    {TY_OPTION_FIELD(ty_fld_def, ratio), .type = TY_OPTION_DOUBLE, .min = 1, .max = 64, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO,
     .doc = "Cells of direct light per cell of diffusion along each side; auto is 3, or 2 where that leaves less than "
            "48 along the longest; the paper's is 4; 1 resolves more and takes some 60 times as long to solve as 3."},
    {TY_OPTION_FIELD(ty_fld_def, sigma_eps), .type = TY_OPTION_DOUBLE, .min = 0, .max = TY_COLOR_MAX, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO | TY_OPTION_OPEN_MIN, .unit = "1/m",
     .doc = "Least extinction; auto is 1e-3 over the longest side; larger values take fewer iterations in vacuum, and "
            "hold light back there."},
    {TY_OPTION_FIELD(ty_fld_def, solver), .type = TY_OPTION_WORD, .words = solvers,
     .doc = "Solver of the diffusion equation; sor is the paper's, and all agree within the tolerance."},
    {TY_OPTION_FIELD(ty_fld_def, relaxation), .type = TY_OPTION_DOUBLE, .min = 0, .max = 2, .preset = 1.85,
     .flags = TY_OPTION_OPEN, .doc = "Relaxation factor omega of the solver sor."},
    {TY_OPTION_FIELD(ty_fld_def, tolerance), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1, .preset = 1e-3,
     .flags = TY_OPTION_OPEN,
     .doc =
         "Residual over source (root mean squares) at which iterations end; images are good to about a third of it."},
    {TY_OPTION_FIELD(ty_fld_def, iterations), .type = TY_OPTION_INT, .min = 1, .max = INT32_MAX, .preset = TY_AUTO,
     .flags = TY_OPTION_AUTO, .doc = "Iterations at most; auto is the solver's own bound."},
    TY_OPTION_INTERIOR_RESOLUTION(ty_fld_def),
    TY_OPTION_ENVIRONMENT_BEAMS(ty_fld_def),
    TY_OPTION_SURFACE_POINTS(ty_fld_def),
    TY_OPTION_SPP(ty_fld_def),
    TY_OPTION_STEP(ty_fld_def, "voxels"),
    TY_OPTION_RAY_SPACING(ty_fld_def),
};

const ty_option_table ty_fld_options = TY_OPTION_TABLE("fld", ty_fld_def, "ty_default_fld_def", options);

void ty_init_fld_def(void* def, size_t bytes) {
    ty_options_init(&ty_fld_options, def, bytes);
}
