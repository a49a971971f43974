/* tyndall bench edit: time from a change of a scene that is shown to the committed scene, beside loading it. */
#include "bench/bench.h"
#include "io/scenes/scene_editor.h"
#include "scenes/scenes.h"

#include <stdio.h>

enum { RUNS_MAX = 99, EDITS_MAX = 6 };

/* A change of one number. */
typedef struct timed_edit {
    const char *name, *path;
} timed_edit;

typedef struct edit_case {
    const char *name, *scene; /* builtin:NAME, or a file of scenes/tools */
    const char *key, *data;   /* value that names a file of third-party data, and that file; NULL: none */
    timed_edit edits[EDITS_MAX];
} edit_case;

static const edit_case cases[] = {
    {"cloud of noise",
     "builtin:cloud_sun",
     NULL,
     NULL,
     {{"coefficient", "media[0].g"},
      {"camera", "camera.exposure"},
      {"light", "lights[0].irradiance"},
      {"noise", "media[0].density.noise.coverage"}}},
    {"cloud of a file",
     "bench_edit_cloud",
     "media[0].density.file",
     DISNEY_CLOUD_FILE,
     {{"coefficient", "media[0].g"},
      {"camera", "camera.exposure"},
      {"light", "lights[0].scale"},
      {"sun", "lights[0].sky.sun_direction[0]"}}},
    {"sponza",
     "bench_edit_sponza",
     "geometry[0].file",
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

static ty_result run_edits(const bench_session* bench, const edit_case* edited, const char* path,
                           const char* const* overrides, int32_t override_count) {
    ty_scene_editor* editor = NULL;
    const double start = cli_wall_seconds();
    ty_result result = ty_scene_editor_open(bench->session->context, path, overrides, override_count, &editor);
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

static int run_file(const bench_session* bench, const edit_case* edited) {
    bench_scene_file file;
    const int status = bench_write_scene(bench->options, edited->scene, edited->key, edited->data, &file);
    if (status != CLI_GO) return status;
    const char* const overrides[] = {file.override};
    const ty_result result = run_edits(bench, edited, file.path, overrides, 1);
    bench_remove_scene(&file);
    return result == TY_OK ? CLI_DONE : cli_fail_running(bench->session, result);
}

int bench_edit(const bench_session* bench) {
    for (int i = 0; i < CASES; ++i) {
        int status = CLI_DONE;
        if (cases[i].data == NULL) {
            const ty_result result = run_edits(bench, &cases[i], cases[i].scene, NULL, 0);
            if (result != TY_OK) status = cli_fail_running(bench->session, result);
        } else if (tools_has_data(bench->options->data, cases[i].data)) {
            status = run_file(bench, &cases[i]);
        }
        if (status != CLI_DONE) return status;
    }
    return CLI_DONE;
}
