/* Scenes that come one after another on stdin, each solved from the light of the one before. */
#define _GNU_SOURCE
#include "cli/render/render.h"

#include "cli/session/ranks.h"

#include <stdlib.h>
#include <string.h>

int render_check_more(const render_options* options) {
    if (options->frames_text != NULL || options->part_text != NULL || options->resume)
        return cli_usage_error("render", "--more is of scenes from stdin, without --frames, --part and --resume");
    if (options->png != NULL || options->denoised_png != NULL)
        return cli_usage_error("render", "--more writes the images that stdin names, and no PNG beside them");
    return CLI_GO;
}

/* The images of one command. */
typedef struct more {
    cli_session* session;
    render_options options;
    const ty_method* method; /* of the first scene */
    void* light;             /* of the image before; NULL: none */
    cli_tev tev;
} more;

/* Trials by time would choose other methods for other images. */
static int choose_method(more* m, const ty_scene* scene) {
    const ty_render_settings settings = ty_scene_render_settings(scene);
    if (m->method != NULL) return CLI_GO;
    m->method = cli_find_method("render", m->options.method != NULL ? m->options.method : settings.method);
    if (m->method == NULL) return CLI_USAGE;
    if (m->method == &cli_method_auto)
        return cli_fail(CLI_USAGE, "--more: which method? Method auto may choose another for each image");
    m->options.method = m->method->name;
    return CLI_GO;
}

/* Renders one scene; returns the exit status. stats: a file, or NULL. */
static int render_one(more* m, const char* scene_path, const char* stats) {
    cli_checkpoint none = {.session = m->session};
    cli_report report = {.method = "", .complete = false};
    ty_scene* scene = NULL;
    const double begun = cli_wall_seconds();
    const ty_result result =
        ty_scene_load(m->session->context, scene_path, m->options.overrides.items, m->options.overrides.count, &scene);
    int status = result == TY_OK ? choose_method(m, scene) : cli_fail_reading(m->session, result);
    if (status == CLI_GO) {
        report.load_seconds = cli_wall_seconds() - begun;
        status = render_scene(m->session, scene, &m->options, &none, m->options.tev != NULL ? &m->tev : NULL, &report);
    }
    m->session->stats = render_report_stats;
    m->session->stats_user = &report;
    if (stats != NULL && status == CLI_DONE) status = cli_session_write_stats(m->session, stats, status);
    m->session->stats = NULL;
    ty_scene_destroy(scene);
    return status;
}

static void tell(int status) {
    if (status == CLI_DONE)
        printf("done\n");
    else
        printf("failed %s\n", cli_last_message());
    fflush(stdout);
}

/* Renders what a line asks for. */
static int render_line(more* m, char* line) {
    line[strcspn(line, "\r\n")] = '\0';
    const char* scene = strtok(line, "\t");
    const char* output = strtok(NULL, "\t");
    const char* stats = strtok(NULL, "\t");
    if (output == NULL) return cli_fail(CLI_USAGE, "--more: a line of stdin is not a scene, a tab and an image");
    if (!cli_has_extension(output, ".exr") && !cli_has_extension(output, ".png"))
        return cli_fail(CLI_USAGE, "%s: the extension is not .exr or .png", output);
    m->options.output = output;
    return render_one(m, scene, stats);
}

/* An interrupt ends the program while it waits. */
static bool next_line(char** line, size_t* capacity) {
    if (cli_interrupted()) return false;
    cli_end_on_interrupt(true);
    const bool is_there = getline(line, capacity, stdin) > 0;
    cli_end_on_interrupt(false);
    return is_there;
}

int render_more(cli_session* session, const char* path, render_options* options) {
    more m = {.session = session, .options = *options, .tev = {.session = session}};
    char* line = NULL;
    size_t capacity = 0;
    if (session->comm != NULL)
        return cli_session_close(session, cli_usage_error("render", "--more is of one process, without mpirun"));
    m.options.light = &m.light;
    int status = options->tev != NULL ? cli_tev_open(&m.tev, session, options->tev, options->output) : CLI_GO;
    if (status == CLI_GO) {
        status = render_one(&m, path, session->common.stats);
        tell(status);
    }
    while (m.method != NULL && next_line(&line, &capacity)) {
        status = render_line(&m, line);
        tell(status);
    }
    if (m.light != NULL) m.method->destroy(m.light);
    free(line);
    cli_tev_close(&m.tev);
    session->common.stats = NULL;
    return cli_session_close(session, cli_interrupted() ? CLI_INTERRUPTED : status);
}
