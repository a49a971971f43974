/* tyndall bench edit: time from a change of a scene that is shown to the committed scene, beside loading it. */
#define _GNU_SOURCE
#include "bench/bench.h"
#include "io/scenes/scene_editor.h"
#include "scenes/scenes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { RUNS_MAX = 99, EDITS_MAX = 6 };

/* A change of one number. */
typedef struct timed_edit {
    const char *name, *path;
} timed_edit;

typedef struct edit_case {
    const char *name, *scene; /* builtin:NAME, or text of a file with %s for the folder of third-party data */
    const char* data;         /* file that it needs, or NULL */
    timed_edit edits[EDITS_MAX];
} edit_case;

#define SKY "{\"type\":\"environment\",\"scale\":4,\"sky\":{\"sun_direction\":[-0.5,-1,0.42]}}"

static const edit_case cases[] = {
    {"cloud of noise",
     "builtin:cloud_sun",
     NULL,
     {{"coefficient", "media[0].g"},
      {"camera", "camera.exposure"},
      {"light", "lights[0].irradiance"},
      {"noise", "media[0].density.noise.coverage"}}},
    {"cloud of a file",
     "{\"tyndall\":1,\"media\":[{\"sigma_t\":0.5,\"albedo\":0.999,\"density\":{\"file\":\"%s/" DISNEY_CLOUD_FILE
     "\",\"grid\":\"density\"}}],\"lights\":[" SKY "]}",
     DISNEY_CLOUD_FILE,
     {{"coefficient", "media[0].g"},
      {"camera", "camera.exposure"},
      {"light", "lights[0].scale"},
      {"sun", "lights[0].sky.sun_direction[0]"}}},
    {"sponza",
     "{\"tyndall\":1,\"camera\":{\"position\":[-10.2,1.6,-1.7]},\"media\":[{\"sigma_t\":0.06,\"albedo\":1,"
     "\"bounds\":[[-14,0,-6],[13,13,6]]}],\"lights\":[" SKY ",{\"type\":\"area\",\"origin\":[0,5,0],\"u\":[1,0,0],"
     "\"v\":[0,0,1],\"radiance\":1}],\"geometry\":[{\"file\":\"%s/" SPONZA_FILE "\"}]}",
     SPONZA_FILE,
     {{"coefficient", "media[0].g"},
      {"camera", "camera.exposure"},
      {"light", "lights[0].scale"},
      {"sun", "lights[0].sky.sun_direction[0]"},
      {"area_light", "lights[1].radiance"},
      {"moved_area_light", "lights[1].origin[0]"}}},
};
enum { CASES = sizeof cases / sizeof cases[0] };

/* The median time of an edit. */
static ty_result time_edit(const bench_session* bench, ty_scene_editor* editor, const timed_edit* edit, double* out) {
    double seconds[RUNS_MAX];
    for (int run = 0; run < bench->options->runs; ++run) {
        char value[64];
        snprintf(value, sizeof value, "%g", 0.25 + 0.005 * run);
        const ty_scene_change change = {edit->path, value};
        const double start = cli_wall_seconds();
        const ty_result result = ty_scene_editor_apply(editor, &change, 1, NULL);
        if (result != TY_OK) return result;
        seconds[run] = cli_wall_seconds() - start;
    }
    *out = bench_median(seconds, bench->options->runs);
    return TY_OK;
}

static ty_result run_edits(const bench_session* bench, const edit_case* edited, const char* path) {
    ty_scene_editor* editor = NULL;
    const double start = cli_wall_seconds();
    ty_result result = ty_scene_editor_open(bench->session->context, path, NULL, 0, &editor);
    json_open_object(bench->json, edited->name);
    if (result == TY_OK) bench_numbers(bench->json, {"load_seconds", cli_wall_seconds() - start});
    for (int i = 0; i < EDITS_MAX && edited->edits[i].name != NULL && result == TY_OK; ++i) {
        double seconds = 0;
        char name[64];
        result = time_edit(bench, editor, &edited->edits[i], &seconds);
        snprintf(name, sizeof name, "%s_seconds", edited->edits[i].name);
        if (result == TY_OK) bench_numbers(bench->json, {name, seconds});
    }
    json_close_object(bench->json);
    ty_scene_editor_close(editor);
    return result;
}

/* Writes the scene's file, whose files are named by an absolute path. */
static int write_scene(const edit_case* edited, const char* data, const char* path) {
    char* folder = realpath(data, NULL);
    FILE* file = folder != NULL ? fopen(path, "wb") : NULL;
    bool written = false;
    if (file != NULL) {
        const char* place = strstr(edited->scene, "%s");
        written = fprintf(file, "%.*s%s%s", (int)(place - edited->scene), edited->scene, folder, place + 2) > 0;
        written = fclose(file) == 0 && written;
    }
    free(folder);
    return written ? CLI_GO : cli_fail(CLI_FAILED, "%s: a scene for the bench cannot be written", path);
}

static int run_file(const bench_session* bench, const edit_case* edited) {
    char folder[BENCH_PATH_SIZE], path[BENCH_PATH_SIZE + 16];
    if (bench_make_folder(folder) != CLI_GO) return CLI_FAILED;
    snprintf(path, sizeof path, "%s/scene.json", folder);
    int status = write_scene(edited, bench->options->data, path);
    if (status == CLI_GO) {
        const ty_result result = run_edits(bench, edited, path);
        status = result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
    }
    unlink(path);
    rmdir(folder);
    return status;
}

int bench_edit(const bench_session* bench) {
    for (int i = 0; i < CASES; ++i) {
        int status = CLI_DONE;
        if (cases[i].data == NULL) {
            const ty_result result = run_edits(bench, &cases[i], cases[i].scene);
            if (result != TY_OK) status = cli_fail_running(bench->session, result);
        } else if (tools_has_data(bench->options->data, cases[i].data)) {
            status = run_file(bench, &cases[i]);
        }
        if (status != CLI_DONE) return status;
    }
    return CLI_DONE;
}
