/* Discrete ordinates with a first-collision source as a method; surfaces are path traced through the media. */
#include "method/dom/job.h"

#include <stdio.h>

static const ty_stat stats[] = {
    {TY_STAT_FIELD(ty_dom_stats, direct_size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, planes), TY_STAT_INT},
    {TY_STAT_FIELD(ty_dom_stats, directions), TY_STAT_INT},
    {TY_STAT_FIELD(ty_dom_stats, bands), TY_STAT_INT},
    {TY_STAT_FIELD(ty_dom_stats, converged), TY_STAT_BOOL},
    {TY_STAT_FIELD(ty_dom_stats, sweeps), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, cycles), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, change), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, emitted), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, absorbed), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, absorbed_by_surfaces), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, leaving), TY_STAT_NUMBER, .count = 3},
    {TY_STAT_FIELD(ty_dom_stats, medium_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_dom_stats, direct_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_dom_stats, source_seconds), TY_STAT_NUMBER, .stage = true},
    {.name = "walls_seconds", .offset = offsetof(ty_dom_stats, wall_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_dom_stats, solve_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_dom_stats, march_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_dom_stats, sweep_seconds), TY_STAT_NUMBER},
    {.name = "bytes", .offset = offsetof(ty_dom_stats, memory_bytes), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_dom_stats, isa), TY_STAT_TEXT},
};

TY_DEFINE_VOLUME_METHOD(dom, ty_volume_dom, NULL);

static void describe(const ty_method_run* run, char* text, size_t size) {
    const ty_dom_stats* dom = (const ty_dom_stats*)run->stats;
    const int32_t *fine = dom->direct_size, *coarse = dom->size;
    int32_t sweeps = 0;
    for (int32_t plane = 0; plane < dom->planes; ++plane) sweeps += dom->sweeps[plane];
    snprintf(text, size,
             "%dx%dx%d cells of direct light, %dx%dx%d of %d ordinates, %d sweeps%s, %.2f s (before the march %.3f, "
             "march %.3f)",
             fine[0], fine[1], fine[2], coarse[0], coarse[1], coarse[2], dom->directions, sweeps,
             dom->converged ? "" : ", not converged", run->own_seconds, dom->seconds - dom->march_seconds,
             dom->march_seconds);
}

const ty_method ty_method_dom = {.name = "dom",
                                 .summary = "discrete ordinates with a first-collision source",
                                 .options = &ty_dom_options,
                                 .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                 .stats = stats,
                                 .stat_count = sizeof stats / sizeof stats[0],
                                 .divides = true,
                                 TY_VOLUME_METHOD_CALLS(dom),
                                 .describe = describe};
