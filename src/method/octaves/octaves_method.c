/* Multiple scattering octaves as a method; surfaces are path traced through the media. */
#include "method/octaves/job.h"

#include <stdio.h>

static const ty_stat stats[] = {
    {TY_STAT_FIELD(ty_octaves_stats, size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_octaves_stats, planes), TY_STAT_INT},
    {TY_STAT_FIELD(ty_octaves_stats, lights), TY_STAT_INT},
    {TY_STAT_FIELD(ty_octaves_stats, medium_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_octaves_stats, direct_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_octaves_stats, march_seconds), TY_STAT_NUMBER, .stage = true},
    {.name = "bytes", .offset = offsetof(ty_octaves_stats, memory_bytes), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_octaves_stats, isa), TY_STAT_TEXT},
};

TY_DEFINE_VOLUME_METHOD(octaves, ty_volume_octaves, NULL);

static void describe(const ty_method_run* run, char* text, size_t size) {
    const ty_octaves_stats* octaves = (const ty_octaves_stats*)run->stats;
    const int32_t* cells = octaves->size;
    snprintf(text, size, "%dx%dx%d cells of light, %.2f s (medium %.2f, direct %.2f, march %.2f)", cells[0], cells[1],
             cells[2], run->own_seconds, octaves->medium_seconds, octaves->direct_seconds, octaves->march_seconds);
}

const ty_method ty_method_octaves = {.name = "octaves",
                                     .summary = "multiple scattering octaves, the approximation of game engines",
                                     .options = &ty_octaves_options,
                                     .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                     .stats = stats,
                                     .stat_count = sizeof stats / sizeof stats[0],
                                     TY_VOLUME_METHOD_CALLS(octaves),
                                     .describe = describe};
