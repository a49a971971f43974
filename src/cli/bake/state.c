/* tyndall bake --resume: the list of finished units, in a text file beside their images. */
#define _GNU_SOURCE
#include "cli/bake/bake.h"
#include "cli/text_file.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

static const char state_head[] = "tyndall bake state 1\n";

/* The settings that a resumed bake must have in common with the earlier run, as one line. */
static void make_key(const bake_run* run, char key[BAKE_KEY_SIZE]) {
    const bake_options* o = run->options;
    uint64_t probes = 0;
    for (int64_t i = 0; i < 3 * run->plan.probe_count; ++i) {
        uint32_t bits;
        memcpy(&bits, &run->plan.probes[i], sizeof bits);
        probes = (probes ^ bits) * 0x100000001b3u;
    }
    snprintf(key, BAKE_KEY_SIZE,
             "version=%s scene=%016" PRIx64 " seed=%" PRIu64 " method=%s spp=%d error=%.17g bounces=%d scatterings=%d "
             "cells=%d cell_paths=%d back=%d lightmaps=%d vertices=%d grid=%s spacing=%.17g probes=%016" PRIx64
             " sh=%d density=%.17g size=%dx%d padding=%d units=%d\n",
             ty_version(), ty_scene_hash(run->scene), run->def.seed, bake_method_names[o->method], (int)run->def.spp,
             o->error, (int)o->bounces, (int)run->def.scatterings, (int)o->cells, (int)o->cell_paths,
             !o->no_back_scattering, o->lightmaps, o->vertices, o->grid_text == NULL ? "" : o->grid_text,
             o->grid_spacing, probes, (int)o->sh, o->density, (int)o->size[0], (int)o->size[1], (int)o->padding,
             (int)run->plan.count);
}

static void state_path(const bake_run* run, char path[BAKE_PATH_SIZE]) {
    snprintf(path, BAKE_PATH_SIZE, "%s/bake.state", run->options->folder);
}

int bake_lock(bake_run* run) {
    char path[BAKE_PATH_SIZE];
    state_path(run, path);
    return cli_lock_take(&run->lock, run->session, path);
}

static ty_result print_state(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const bake_run* run = user;
    char key[BAKE_KEY_SIZE];
    make_key(run, key);
    fprintf(file, "%s%s", state_head, key);
    for (int32_t i = 0; i < run->plan.count; ++i) {
        const bake_unit* unit = &run->plan.units[i];
        if (unit->done)
            fprintf(file, "unit %d %d %.17g %.17g %" PRId64 " %" PRId64 "\n", (int)i, unit->overlapping, unit->seconds,
                    unit->mean_samples, unit->paths, unit->rays);
    }
    return TY_OK;
}

ty_result bake_write_state(const bake_run* run) {
    char path[BAKE_PATH_SIZE];
    state_path(run, path);
    return cli_write_text_file(run->session->context, path, print_state, run);
}

/* True if all files of a finished unit still exist. */
static bool is_there(const bake_run* run, const bake_unit* unit) {
    char path[BAKE_PATH_SIZE];
    const char* extension = unit->kind == BAKE_PROBES ? ".json" : ".exr";
    for (int32_t i = 0; i < (unit->overlapping ? unit->count : 1); ++i) {
        bake_image_path(run, unit, unit->overlapping ? i : -1, extension, path);
        if (access(path, R_OK) != 0) return false;
    }
    return true;
}

static void read_line(bake_run* run, const char* line) {
    int index = -1, overlapping = 0;
    bake_unit read = {.done = true, .resumed = true};
    if (sscanf(line, "unit %d %d %lf %lf %" SCNd64 " %" SCNd64, &index, &overlapping, &read.seconds, &read.mean_samples,
               &read.paths, &read.rays) != 6 ||
        index < 0 || index >= run->plan.count)
        return;
    bake_unit* unit = &run->plan.units[index];
    unit->overlapping = overlapping != 0;
    if (!is_there(run, unit)) return;
    unit->done = unit->resumed = true;
    unit->seconds = read.seconds;
    unit->mean_samples = read.mean_samples;
    unit->paths = read.paths;
    unit->rays = read.rays;
    run->receivers_done += (double)unit->receivers;
}

static bool consume_text(const char** text, const char* expected_text) {
    const size_t length = strlen(expected_text);
    if (strncmp(*text, expected_text, length) != 0) return false;
    *text += length;
    return true;
}

int bake_read_state(bake_run* run) {
    char path[BAKE_PATH_SIZE], key[BAKE_KEY_SIZE];
    uint8_t* bytes = NULL;
    size_t size = 0;
    state_path(run, path);
    if (access(path, F_OK) != 0 && errno == ENOENT) return CLI_GO;
    const ty_result result = ty_bytes_read(run->session->context, path, (size_t)1 << 28, &bytes, &size);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    const char* text = (const char*)bytes;
    int status = CLI_GO;
    make_key(run, key);
    if (!consume_text(&text, state_head))
        status = cli_fail(CLI_USAGE, "%s: not the state of a bake; remove it to start again", path);
    else if (!consume_text(&text, key))
        status = cli_fail(CLI_USAGE,
                          "%s: the state of another bake: the scene, the options or the seed were others; remove it to "
                          "start again",
                          path);
    for (; status == CLI_GO && *text != '\0'; text += *text == '\n') {
        read_line(run, text);
        text += strcspn(text, "\n");
    }
    run->receivers_skipped = run->receivers_done;
    ty_bytes_destroy(run->session->context, bytes, size);
    return status;
}
