/* tyndall bake --part and --merge: bakes in parts by machines without MPI. A part samples a share of the receivers of
 * every mesh and of all probes, and its file has their light, call by call; a merge takes the light of all receivers
 * from the files of all parts, and goes on as one bake: padding, seams, denoising. */
#define _GNU_SOURCE
#include "cli/bake/bake.h"

#include "base/context.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEAD_SIZE = BAKE_KEY_SIZE + 64 };

/* Before the light of a call's receivers. */
typedef struct part_record {
    int64_t begin, count; /* of the call's receivers, this part's */
    int64_t paths, rays;
    double samples; /* mean of each */
} part_record;

static void part_path(const bake_run* run, int32_t part, char path[BAKE_PATH_SIZE]) {
    snprintf(path, BAKE_PATH_SIZE, "%s/part-%d-of-%d.light", run->options->folder, (int)part, (int)run->parts.count);
}

/* The first bytes of a part's file: the settings that all parts and the merge have in common. */
static size_t make_head(const bake_run* run, int32_t part, char head[HEAD_SIZE]) {
    char key[BAKE_KEY_SIZE];
    bake_make_key(run, key);
    return (size_t)snprintf(head, HEAD_SIZE, "tyndall bake part %d of %d\n%s", (int)part, (int)run->parts.count, key);
}

/* ---- files ---- */

static bool append(bake_part_file* file, const void* bytes, size_t size) {
    if (size > file->capacity - file->size) {
        const size_t capacity = 2 * (file->size + size);
        uint8_t* grown = realloc(file->bytes, capacity);
        if (grown == NULL) return false;
        file->bytes = grown;
        file->capacity = capacity;
    }
    memcpy(file->bytes + file->size, bytes, size);
    file->size += size;
    return true;
}

/* Copies the next bytes; false: there are not as many. */
static bool take(bake_part_file* file, void* out, size_t size) {
    if (size > file->size - file->at) return false;
    memcpy(out, file->bytes + file->at, size);
    file->at += size;
    return true;
}

/* Reads the file of a part, whose head must be the merge's own. */
static int read_part(bake_run* run, int32_t part) {
    char path[BAKE_PATH_SIZE], head[HEAD_SIZE];
    bake_part_file* file = &run->parts.files[part - 1];
    part_path(run, part, path);
    const ty_result result = ty_bytes_read(run->session->context, path, PTRDIFF_MAX, &file->bytes, &file->size);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    file->capacity = file->size;
    file->at = make_head(run, part, head);
    if (file->size >= file->at && memcmp(file->bytes, head, file->at) == 0) return CLI_GO;
    return cli_fail(CLI_USAGE, "%s: a part of another bake: the scene, the options or the seed were others", path);
}

static int open_files(bake_run* run) {
    bake_parts* parts = &run->parts;
    parts->files = calloc((size_t)parts->count, sizeof *parts->files);
    if (parts->files == NULL) return cli_fail_running(run->session, TY_ERROR_MEMORY);
    int status = CLI_GO;
    for (int32_t part = 1; part <= parts->count && status == CLI_GO; ++part) status = read_part(run, part);
    return status;
}

/* A part that was finished before is left as it is. */
static int open_part(bake_run* run) {
    bake_parts* parts = &run->parts;
    char path[BAKE_PATH_SIZE], head[HEAD_SIZE];
    part_path(run, parts->part, path);
    int status = cli_lock_take(&run->lock, run->session, path);
    if (status != CLI_GO) return status;
    parts->files = calloc((size_t)parts->count, sizeof *parts->files);
    if (parts->files == NULL) return cli_fail_running(run->session, TY_ERROR_MEMORY);
    if (run->options->resume && access(path, F_OK) == 0) {
        status = read_part(run, parts->part);
        if (status == CLI_GO && !run->session->common.quiet)
            printf("part %d of %d was finished before\n", (int)parts->part, (int)parts->count);
        return status == CLI_GO ? CLI_DONE : status;
    }
    const size_t size = make_head(run, parts->part, head);
    return append(&parts->files[parts->part - 1], head, size) ? CLI_GO
                                                              : cli_fail_running(run->session, TY_ERROR_MEMORY);
}

int bake_open_parts(bake_run* run) {
    if (run->parts.count == 0) return CLI_GO;
    return run->parts.part > 0 ? open_part(run) : open_files(run);
}

ty_result bake_write_part(bake_run* run) {
    char path[BAKE_PATH_SIZE];
    const bake_part_file* file = &run->parts.files[run->parts.part - 1];
    part_path(run, run->parts.part, path);
    const ty_result result = ty_bytes_write(run->session->context, path, file->bytes, file->size);
    if (result == TY_OK && !run->session->common.quiet)
        printf("part %d of %d done, %.1f s\nwrote %s\n", (int)run->parts.part, (int)run->parts.count,
               cli_wall_seconds() - run->started, path);
    return result;
}

/* Bytes of ty_bytes_read are the context's, those of append are not. */
void bake_close_parts(bake_run* run) {
    bake_parts* parts = &run->parts;
    for (int32_t i = 0; parts->files != NULL && i < parts->count; ++i) {
        bake_part_file* file = &parts->files[i];
        if (file->at > 0)
            ty_bytes_destroy(run->session->context, file->bytes, file->size);
        else
            free(file->bytes);
    }
    free(parts->files);
    parts->files = NULL;
}

/* ---- light ---- */

/* One call of the baker's: its receivers, or points, and where their light goes. */
typedef struct light_call {
    const bake_run* run;
    ty_bake_def def;
    const ty_bake_receiver* receivers; /* NULL: points */
    const float* points;
    size_t item; /* bytes of the light of each */
    uint8_t* light;
} light_call;

static ty_result sample(const light_call* call, int64_t begin, int64_t count, ty_bake_stats* stats) {
    void* light = call->light + (size_t)begin * call->item;
    ty_bake_def def = call->def;
    def.first = begin;
    if (call->receivers == NULL)
        return ty_bake_probes(call->run->scene, &def, call->points + 3 * begin, count, light, stats);
    return ty_bake_surfaces(call->run->scene, &def, call->receivers + begin, count, light, stats);
}

/* Samples this part's receivers, and keeps their light for its file. */
static ty_result sample_part(const light_call* call, const bake_parts* parts, int64_t count, ty_bake_stats* stats) {
    bake_part_file* file = &parts->files[parts->part - 1];
    const int64_t begin = count * (parts->part - 1) / parts->count, end = count * parts->part / parts->count;
    const ty_result result = sample(call, begin, end - begin, stats);
    if (result != TY_OK) return result;
    const part_record record = {begin, end - begin, stats->paths, stats->rays, stats->mean_samples};
    const bool kept = append(file, &record, sizeof record) &&
                      append(file, call->light + (size_t)begin * call->item, (size_t)(end - begin) * call->item);
    return kept ? TY_OK : TY_ERROR_MEMORY;
}

/* Takes the light of all receivers from the parts' files. */
static ty_result take_parts(const light_call* call, const bake_parts* parts, int64_t count, ty_bake_stats* stats) {
    int64_t at = 0;
    for (int32_t i = 0; i < parts->count; ++i) {
        part_record record;
        bake_part_file* file = &parts->files[i];
        if (!take(file, &record, sizeof record) || record.begin != at || record.count < 0 ||
            record.count > count - at ||
            !take(file, call->light + (size_t)at * call->item, (size_t)record.count * call->item)) {
            char path[BAKE_PATH_SIZE];
            part_path(call->run, i + 1, path);
            return ty_fail(call->run->session->context, TY_ERROR_INPUT, "%s: the file of a part that is cut short",
                           path);
        }
        at += record.count;
        stats->paths += record.paths;
        stats->rays += record.rays;
        stats->mean_samples += record.samples * (double)record.count / (double)(count > 0 ? count : 1);
    }
    return TY_OK;
}

static ty_result light_of(const light_call* call, int64_t count, ty_bake_stats* stats) {
    const bake_parts* parts = &call->run->parts;
    if (parts->count == 0) return sample(call, 0, count, stats);
    return parts->part > 0 ? sample_part(call, parts, count, stats) : take_parts(call, parts, count, stats);
}

ty_result bake_light_surfaces(const bake_run* run, const ty_bake_def* def, const ty_bake_receiver* receivers,
                              int64_t count, ty_bake_light* light, ty_bake_stats* stats) {
    const light_call call = {run, *def, receivers, NULL, sizeof *light, (uint8_t*)light};
    return light_of(&call, count, stats);
}

ty_result bake_light_points(const bake_run* run, const float* points, int64_t count, ty_bake_probe* probes,
                            ty_bake_stats* stats) {
    const light_call call = {run, run->def, NULL, points, sizeof *probes, (uint8_t*)probes};
    return light_of(&call, count, stats);
}
