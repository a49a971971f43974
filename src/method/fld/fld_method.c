/* Flux-limited and classical diffusion as methods; surfaces are path traced through the media. */
#include "method/fld/job.h"

#include <stdio.h>

static const ty_stat stats[] = {
    {TY_STAT_FIELD(ty_fld_stats, direct_size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, diffusion_size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, converged), TY_STAT_BOOL},
    {TY_STAT_FIELD(ty_fld_stats, iterations), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, cycles), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, work), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, residual), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, emitted), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, absorbed), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, absorbed_by_surfaces), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, solve_ranks), TY_STAT_INT},
    {TY_STAT_FIELD(ty_fld_stats, leaving), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_fld_stats, medium_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_fld_stats, direct_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_fld_stats, solve_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_fld_stats, march_seconds), TY_STAT_NUMBER, .stage = true},
    {.name = "bytes", .offset = offsetof(ty_fld_stats, memory_bytes), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_fld_stats, isa), TY_STAT_TEXT},
};

static void remove_limiter(void* def) {
    ((ty_fld_def*)def)->limiter = TY_FLD_LIMITER_NONE;
}

TY_DEFINE_VOLUME_METHOD(fld, ty_volume_fld, NULL);
TY_DEFINE_VOLUME_METHOD(cda, ty_volume_fld, remove_limiter);

static void describe(const ty_method_run* run, char* text, size_t size) {
    const ty_fld_stats* fld = (const ty_fld_stats*)run->stats;
    const int32_t *fine = fld->direct_size, *coarse = fld->diffusion_size;
    snprintf(text, size,
             "%dx%dx%d cells of direct light, %dx%dx%d of diffusion%s, %.2f s (medium %.2f, direct %.2f, solve %.2f, "
             "march %.2f)",
             fine[0], fine[1], fine[2], coarse[0], coarse[1], coarse[2], fld->converged ? "" : ", not converged",
             run->own_seconds, fld->medium_seconds, fld->direct_seconds, fld->solve_seconds, fld->march_seconds);
}

const ty_method ty_method_fld = {.name = "fld",
                                 .summary = "flux-limited diffusion",
                                 .options = &ty_fld_options,
                                 .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                 .stats = stats,
                                 .stat_count = sizeof stats / sizeof stats[0],
                                 .divides = true,
                                 TY_VOLUME_METHOD_CALLS(fld),
                                 .describe = describe};

const ty_method ty_method_cda = {.name = "cda",
                                 .summary = "classical diffusion: fld without a limiter",
                                 .options = &ty_fld_options,
                                 .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                 .stats = stats,
                                 .stat_count = sizeof stats / sizeof stats[0],
                                 TY_VOLUME_METHOD_CALLS(cda),
                                 .describe = describe};
