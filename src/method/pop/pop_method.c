/* Principal-ordinates propagation as a method; surfaces are path traced through the media. */
#include "method/pop/job.h"

#include <stdio.h>

static const ty_stat stats[] = {
    {TY_STAT_FIELD(ty_pop_stats, ordinates), TY_STAT_INT},
    {TY_STAT_FIELD(ty_pop_stats, vpls), TY_STAT_INT},
    {TY_STAT_FIELD(ty_pop_stats, size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_pop_stats, merged_size), TY_STAT_INT, .count = 3},
    {TY_STAT_FIELD(ty_pop_stats, planes), TY_STAT_INT},
    {TY_STAT_FIELD(ty_pop_stats, iterations), TY_STAT_INT},
    {TY_STAT_FIELD(ty_pop_stats, residuum_iterations), TY_STAT_INT},
    {TY_STAT_FIELD(ty_pop_stats, converged), TY_STAT_BOOL},
    {TY_STAT_FIELD(ty_pop_stats, left), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_pop_stats, medium_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, importance_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, ordinate_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, vpl_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, direct_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, initial_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, propagation_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, residuum_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, merge_seconds), TY_STAT_NUMBER, .stage = true},
    {TY_STAT_FIELD(ty_pop_stats, march_seconds), TY_STAT_NUMBER, .stage = true},
    {.name = "bytes", .offset = offsetof(ty_pop_stats, memory_bytes), TY_STAT_NUMBER},
    {TY_STAT_FIELD(ty_pop_stats, isa), TY_STAT_TEXT},
};

TY_DEFINE_VOLUME_METHOD(pop, ty_volume_pop, NULL);

static void describe(const ty_method_run* run, char* text, size_t size) {
    const ty_pop_stats* pop = (const ty_pop_stats*)run->stats;
    const int32_t *own = pop->size, *merged = pop->merged_size;
    snprintf(text, size,
             "%d ordinates of %dx%dx%d cells, %dx%dx%d merged%s, %.2f s (before the march %.3f, march %.3f)",
             pop->ordinates, own[0], own[1], own[2], merged[0], merged[1], merged[2],
             pop->converged ? "" : ", not converged", run->own_seconds, pop->seconds - pop->march_seconds,
             pop->march_seconds);
}

const ty_method ty_method_pop = {.name = "pop",
                                 .summary = "principal-ordinates propagation",
                                 .options = &ty_pop_options,
                                 .aovs = TY_MARCH_AOVS | TY_AOV_SAMPLES,
                                 .stats = stats,
                                 .stat_count = sizeof stats / sizeof stats[0],
                                 TY_VOLUME_METHOD_CALLS(pop),
                                 .describe = describe};
