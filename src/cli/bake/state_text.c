/* The text of a bake's state: a first line, a line with the settings, and one for each finished unit. */
#include "cli/bake/bake.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINE_SIZE = 256 };

/* The most paths or rays of a unit that are taken from a text, so that totals over all units fit their type. */
static const int64_t count_max = (int64_t)1 << 48;

static const char state_head[] = "tyndall bake state 1\n";

void bake_print_state(FILE* file, const bake_run* run, const char* key) {
    fprintf(file, "%s%s", state_head, key);
    for (int32_t i = 0; i < run->plan.count; ++i) {
        const bake_unit* unit = &run->plan.units[i];
        if (unit->done)
            fprintf(file, "unit %d %d %.17g %.17g %" PRId64 " %" PRId64 "\n", (int)i, unit->overlapping, unit->seconds,
                    unit->mean_samples, unit->paths, unit->rays);
    }
}

static bool consume_text(const char** text, const char* expected_text) {
    const size_t length = strlen(expected_text);
    if (strncmp(*text, expected_text, length) != 0) return false;
    *text += length;
    return true;
}

/* A space and a number in 0..max. */
static bool consume_count(const char** text, int64_t max, int64_t* out) {
    if (!consume_text(text, " ") || **text < '0' || **text > '9') return false;
    char* end;
    errno = 0;
    const long long value = strtoll(*text, &end, 10);
    if (errno != 0 || value > max) return false;
    *text = end;
    *out = value;
    return true;
}

/* A space and a number that is finite and not negative. */
static bool consume_real(const char** text, double* out) {
    if (!consume_text(text, " ") || **text < '0' || **text > '9') return false;
    char* end;
    const double value = strtod(*text, &end);
    if (!isfinite(value)) return false;
    *text = end;
    *out = value;
    return true;
}

/* True if all files of a finished unit still exist. */
static bool is_there(const bake_run* run, const bake_unit* unit) {
    char path[BAKE_PATH_SIZE];
    const char* extension = unit->kind == BAKE_PROBES ? ".json" : ".exr";
    for (int32_t i = 0; i < (unit->overlapping ? unit->count : 1); ++i) {
        bake_image_path(run, unit, unit->overlapping ? i : -1, extension, path);
        if (access(path, R_OK) != 0) return false;
        if (!run->options->denoise || unit->kind != BAKE_LIGHTMAP) continue;
        bake_image_path(run, unit, unit->overlapping ? i : -1, BAKE_DENOISED ".exr", path);
        if (access(path, R_OK) != 0) return false;
    }
    return true;
}

/* A damaged line counts as none: its unit is baked again. */
static void take_line(bake_run* run, const char* line) {
    int64_t index = 0, overlapping = 0, paths = 0, rays = 0;
    double seconds = 0, mean_samples = 0;
    if (!consume_text(&line, "unit") || !consume_count(&line, run->plan.count - 1, &index) ||
        !consume_count(&line, 1, &overlapping) || !consume_real(&line, &seconds) ||
        !consume_real(&line, &mean_samples) || !consume_count(&line, count_max, &paths) ||
        !consume_count(&line, count_max, &rays) || *line != '\0')
        return;
    bake_unit* unit = &run->plan.units[index];
    if (unit->done || (overlapping != 0 && unit->kind != BAKE_LIGHTMAP)) return;
    bake_unit taken = *unit;
    taken.overlapping = overlapping != 0;
    if (!is_there(run, &taken)) return;
    taken.done = taken.resumed = true;
    taken.seconds = seconds;
    taken.mean_samples = mean_samples;
    taken.paths = paths;
    taken.rays = rays;
    *unit = taken;
    run->receivers_done += (double)unit->receivers;
}

bake_state_kind bake_take_state(bake_run* run, const char* key, const char* text) {
    if (!consume_text(&text, state_head)) return BAKE_STATE_NONE;
    if (!consume_text(&text, key)) return BAKE_STATE_OTHER;
    while (*text != '\0') {
        char line[LINE_SIZE];
        const size_t length = strcspn(text, "\n");
        if (text[length] == '\n' && length < sizeof line) {
            memcpy(line, text, length);
            line[length] = '\0';
            take_line(run, line);
        }
        text += length + (text[length] == '\n');
    }
    run->receivers_skipped = run->receivers_done;
    return BAKE_STATE_TAKEN;
}
