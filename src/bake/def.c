/* Options and their checks. */
#include "bake/gather/run.h"
#include "option/option.h"

static const char* const methods[] = {"cache", "impulse", "attenuation", "surfaces", "path", NULL};

static const char* const compositions[] = {"collisions", "published", NULL};

static const ty_option options[] = {
    {TY_OPTION_FIELD(ty_bake_def, method), .type = TY_OPTION_WORD, .words = methods,
     .doc = "Method for light that media scatter."},
    {TY_OPTION_FIELD(ty_bake_def, spp), .type = TY_OPTION_INT, .min = 1, .max = 1 << 20, .preset = 64,
     .doc = "Paths per receiver at most."},
    {TY_OPTION_FIELD(ty_bake_def, error), .type = TY_OPTION_DOUBLE, .min = 0, .max = 1e9,
     .doc = "Standard error, relative to its irradiance, at which a receiver is done; 0 means no bound."},
    {TY_OPTION_FIELD(ty_bake_def, bounces), .type = TY_OPTION_INT, .min = 0, .max = INT32_MAX,
     .doc = "Reflections and scatterings at most; 0 means no bound but Russian roulette."},
    {TY_OPTION_FIELD(ty_bake_def, scatterings), .type = TY_OPTION_INT, .min = 1, .max = TY_IMPULSE_BOUNCES_MAX,
     .preset = 10, .doc = "Scatterings between two surfaces, or a light and a surface, at most."},
    {TY_OPTION_FIELD(ty_bake_def, back_scattering), .type = TY_OPTION_BOOL, .preset = 1,
     .doc = "Counts light that surfaces behind a receiver send into the medium."},
    {TY_OPTION_FIELD(ty_bake_def, cells), .type = TY_OPTION_INT, .min = 1, .max = TY_CACHE_CELLS_MAX, .preset = 32,
     .unit = "cells", .doc = "Cells of a cache along the longest side of its box."},
    {TY_OPTION_FIELD(ty_bake_def, cell_paths), .type = TY_OPTION_INT, .min = 1, .max = 1 << 20, .preset = 64,
     .doc = "Paths per cell of a cache."},
    {TY_OPTION_FIELD(ty_bake_def, composition), .type = TY_OPTION_WORD, .words = compositions,
     .doc = "Composition of impulse responses at a receiver."},
};

static const ty_option_table table = TY_OPTION_TABLE("bake", ty_bake_def, "ty_default_bake_def", options);

void ty_init_bake_def(void* def, size_t bytes) {
    ty_options_init(&table, def, bytes);
}

ty_result ty_bake_take_def(ty_context* context, const ty_bake_def* def, ty_bake_def* own) {
    return ty_options_take(context, &table, def, own);
}
