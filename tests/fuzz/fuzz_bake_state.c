/* The text state of bakes: as it is, and after a true beginning, so that its lines are reached. An accepted state is in
 * range, has its files, and is the same once printed and read again. */
#include "fuzz_target.h"

#include "cli/bake/bake.h"

#include <math.h>
#include <string.h>

enum { UNITS = 6 };

static const char head[] = "tyndall bake state 1\n", key[] = "version=1 units=6\n";

static const bake_unit units[UNITS] = {
    {.kind = BAKE_LIGHTMAP, .count = 2, .receivers = 1},
    {.kind = BAKE_LIGHTMAP, .count = 3, .receivers = 10},
    {.kind = BAKE_LIGHTMAP, .count = 2, .receivers = 100},
    {.kind = BAKE_VERTICES, .count = 1, .receivers = 1000},
    {.kind = BAKE_GRID, .receivers = 10000},
    {.kind = BAKE_PROBES, .receivers = 100000},
};

/* Lightmaps have denoised images, too. */
static const bake_options options = {.denoise = true};

/* The first lightmap has all files, the second its own alone, the third those of its primitives; the points have none.
 */
static bool has_file(ptrdiff_t unit, int32_t primitive) {
    return unit == 1 ? primitive < 0 : unit == 2 ? primitive >= 0 : unit != 5;
}

/* In place of the baker's, which names files in a folder. */
void bake_image_path(const bake_run* run, const bake_unit* unit, int32_t primitive, const char* extension,
                     char path[BAKE_PATH_SIZE]) {
    /* The reader hands in a copy of the unit, which its number of receivers tells. */
    ptrdiff_t index = 0;
    while (index < UNITS && units[index].receivers != unit->receivers) ++index;
    if (index == UNITS || primitive >= unit->count || run->plan.count != UNITS) abort();
    if ((strcmp(extension, ".json") == 0) != (unit->kind == BAKE_PROBES)) abort();
    snprintf(path, BAKE_PATH_SIZE, "%s", has_file(index, primitive) ? "/dev/null" : "/dev/null/absent");
}

static void check_run(const bake_run* run, bool taken) {
    double receivers = 0;
    for (int i = 0; i < UNITS; ++i) {
        const bake_unit* unit = &run->plan.units[i];
        if (unit->done != unit->resumed || (unit->done && !taken)) abort();
        if (!isfinite(unit->seconds) || !isfinite(unit->mean_samples)) abort();
        if (unit->seconds < 0 || unit->mean_samples < 0 || unit->paths < 0 || unit->rays < 0) abort();
        if (unit->overlapping && unit->kind != BAKE_LIGHTMAP) abort();
        if (unit->done && !has_file(i, unit->overlapping ? 0 : -1)) abort();
        if (unit->done) receivers += (double)unit->receivers;
    }
    if (receivers != run->receivers_done || receivers != run->receivers_skipped) abort();
}

static bake_state_kind take(const char* text, bake_unit taken[UNITS]) {
    bake_run run = {.options = &options, .plan = {.units = taken, .count = UNITS}};
    memcpy(taken, units, sizeof units);
    const bake_state_kind kind = bake_take_state(&run, key, text);
    check_run(&run, kind == BAKE_STATE_TAKEN);
    return kind;
}

static char* print(bake_unit taken[UNITS]) {
    const bake_run run = {.options = &options, .plan = {.units = taken, .count = UNITS}};
    char* text = NULL;
    size_t size = 0;
    FILE* file = open_memstream(&text, &size);
    if (file == NULL) abort();
    bake_print_state(file, &run, key);
    if (fclose(file) != 0) abort();
    return text;
}

static void try_text(const char* text, bool begins_well) {
    bake_unit taken[UNITS], again[UNITS];
    const bake_state_kind kind = take(text, taken);
    if (begins_well && kind != BAKE_STATE_TAKEN) abort();
    if (kind != BAKE_STATE_TAKEN) return;
    char* printed = print(taken);
    if (take(printed, again) != BAKE_STATE_TAKEN) abort();
    for (int i = 0; i < UNITS; ++i) {
        if (taken[i].done != again[i].done || taken[i].overlapping != again[i].overlapping) abort();
        if (taken[i].seconds != again[i].seconds || taken[i].mean_samples != again[i].mean_samples) abort();
        if (taken[i].paths != again[i].paths || taken[i].rays != again[i].rays) abort();
    }
    free(printed);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    char* text = (char*)fuzz_copy_text(bytes, size);
    try_text(text, false);
    char* begun = malloc(sizeof head + sizeof key + size);
    if (begun == NULL) abort();
    snprintf(begun, sizeof head + sizeof key + size, "%s%s%s", head, key, text);
    try_text(begun, true);
    free(begun);
    free(text);
    return 0;
}
