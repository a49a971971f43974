/* tyndall bake --resume: the list of finished units, in a text file beside their images. */
#define _GNU_SOURCE
#include "cli/bake/bake.h"
#include "cli/text/text_file.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>
#include <unistd.h>

void bake_make_key(const bake_run* run, char key[BAKE_KEY_SIZE]) {
    const bake_options* o = run->options;
    uint64_t probes = 0;
    for (int64_t i = 0; i < 3 * run->plan.probe_count; ++i) {
        uint32_t bits;
        memcpy(&bits, &run->plan.probes[i], sizeof bits);
        probes = (probes ^ bits) * 0x100000001b3u;
    }
    snprintf(key, BAKE_KEY_SIZE,
             "version=%s scene=%016" PRIx64 " seed=%" PRIu64 " method=%s spp=%d error=%.17g bounces=%d scatterings=%d "
             "cells=%d cell_paths=%d composition=%d back=%d lightmaps=%d vertices=%d grid=%s spacing=%.17g "
             "probes=%016" PRIx64 " sh=%d density=%.17g size=%dx%d padding=%d denoise=%d units=%d\n",
             ty_version(), ty_scene_hash(run->scene), run->def.seed, bake_method_names[o->method], (int)run->def.spp,
             o->error, (int)o->bounces, (int)run->def.scatterings, (int)o->cells, (int)o->cell_paths, o->composition,
             !o->no_back_scattering, o->lightmaps, o->vertices, o->grid_text == NULL ? "" : o->grid_text,
             o->grid_spacing, probes, (int)o->sh, o->density, (int)o->size[0], (int)o->size[1], (int)o->padding,
             o->denoise, (int)run->plan.count);
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
    bake_make_key(run, key);
    bake_print_state(file, run, key);
    return TY_OK;
}

ty_result bake_write_state(const bake_run* run) {
    char path[BAKE_PATH_SIZE];
    state_path(run, path);
    return cli_write_text_file(run->session->context, path, print_state, run);
}

int bake_read_state(bake_run* run) {
    char path[BAKE_PATH_SIZE], key[BAKE_KEY_SIZE];
    uint8_t* bytes = NULL;
    size_t size = 0;
    state_path(run, path);
    if (access(path, F_OK) != 0 && errno == ENOENT) return CLI_GO;
    const ty_result result = ty_bytes_read(run->session->context, path, (size_t)1 << 28, &bytes, &size);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    bake_make_key(run, key);
    const bake_state_kind kind = bake_take_state(run, key, (const char*)bytes);
    ty_bytes_destroy(run->session->context, bytes, size);
    if (kind == BAKE_STATE_NONE)
        return cli_fail(CLI_USAGE, "%s: not the state of a bake; remove it to start again", path);
    if (kind == BAKE_STATE_OTHER)
        return cli_fail(CLI_USAGE,
                        "%s: the state of another bake: the scene, the options or the seed were others; remove it to "
                        "start again",
                        path);
    return CLI_GO;
}
