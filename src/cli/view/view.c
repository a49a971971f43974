/* tyndall view: a scene in a window of the browser, rendered anew while it changes. */
#define _GNU_SOURCE
#include "cli/commands.h"
#include "cli/methods/help_paths.h"
#include "cli/methods/methods.h"
#include "cli/screen/screen_options.h"
#include "cli/session/ranks.h"
#include "cli/view/live.h"
#include "device/device.h"

#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct view_options {
    int32_t port, size[2];
    bool no_open, remote, no_compare;
    const char *method, *record, *tev;
    cli_list overrides;
    screen_options screen;
} view_options;

/* Opens the page in the desktop's browser, where there is a desktop. */
static void open_browser(const char* url) {
    if (getenv("DISPLAY") == NULL && getenv("WAYLAND_DISPLAY") == NULL) return;
    const pid_t child = fork();
    if (child > 0) waitpid(child, NULL, 0);
    if (child != 0) return;
    if (fork() == 0) { /* a grandchild, which nobody has to wait for */
        close(STDOUT_FILENO);
        close(STDERR_FILENO);
        execlp("xdg-open", "xdg-open", url, (char*)NULL);
    }
    _exit(0);
}

static void wait_for_interrupt(void) {
    const struct timespec tenth = {.tv_nsec = 100000000};
    while (!cli_interrupted()) nanosleep(&tenth, NULL);
}

/* Serves until an interrupt; returns the exit status. */
static int serve(cli_session* session, view_live* live, const view_options* options) {
    const view_server_def def = {.port = options->port,
                                 .remote = options->remote,
                                 .user = live,
                                 .receive = view_live_receive,
                                 .connected = view_live_connected,
                                 .image = view_live_image};
    char message[256], url[128];
    view_server* server = view_server_start(&def, message, sizeof message);
    if (server == NULL) return cli_fail(CLI_FAILED, "%s", message);
    int status = CLI_DONE;
    snprintf(url, sizeof url, "http://127.0.0.1:%d/?token=%s", (int)view_server_port(server),
             view_server_token(server));
    printf("%s\n", url);
    fflush(stdout);
    if (!view_live_start(live, server)) status = cli_fail(CLI_FAILED, "the rendering thread cannot be started");
    if (status == CLI_DONE && !session->common.quiet) fprintf(stderr, "view: Ctrl-C ends it\n");
    if (status == CLI_DONE && !options->no_open) open_browser(url);
    if (status == CLI_DONE) wait_for_interrupt();
    view_live_stop(live);
    view_server_stop(server);
    return status;
}

/* A photograph, which tyndall screen takes: by its extension, or because there is a medium for it. */
static bool is_photo(const view_options* options, const char* path) {
    static const char* const extensions[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".webp"};
    for (size_t i = 0; i < sizeof extensions / sizeof extensions[0]; ++i)
        if (cli_has_extension(path, extensions[i])) return true;
    return options->screen.medium != NULL && !cli_has_extension(path, ".json") && strncmp(path, "builtin:", 8) != 0;
}

/* Options of scenes with a photograph, and the other way round, would be without effect. */
static int check_kind(view_options* options, const cli_arguments* given) {
    const char* path = given->positional[0];
    if (!is_photo(options, path)) {
        const char* name = screen_first_given(&options->screen);
        if (name != NULL) return cli_usage_error("view", "--%s is for photographs, and %s is none", name, path);
        if (given->positional_count == 1) return CLI_GO;
        return cli_usage_error("view", "%s: distances are for photographs, and %s is none", given->positional[1], path);
    }
    const char* name = options->method != NULL        ? "method"
                       : options->size[0] > 0         ? "size"
                       : options->overrides.count > 0 ? "define"
                       : options->no_compare          ? "no-compare"
                                                      : NULL;
    if (name != NULL) return cli_usage_error("view", "--%s is for scenes, and %s is a photograph", name, path);
    return screen_check_options(&options->screen);
}

static int load_and_serve(cli_session* session, const cli_arguments* given, view_options* options) {
    const char* path = given->positional[0];
    const view_photo_def photo = {.options = &options->screen,
                                  .image = path,
                                  .distance = given->positional_count > 1 ? given->positional[1] : NULL};
    cli_tev tev = {.session = session};
    const view_live_def def = {.session = session,
                               .path = path,
                               .photo = is_photo(options, path) ? &photo : NULL,
                               .overrides = options->overrides.items,
                               .override_count = options->overrides.count,
                               .method = options->method,
                               .width = options->size[0],
                               .height = options->size[1],
                               .compare = !options->no_compare,
                               .remote = options->remote,
                               .record = options->record,
                               .tev = options->tev != NULL ? &tev : NULL};
    view_live* live = NULL;
    cli_end_on_interrupt(true);
    int status = CLI_GO;
    if (ty_context_keep_on_device(session->context) == TY_OK)
        status = view_live_open(&def, &live);
    else
        status = cli_fail(CLI_FAILED, "%s", ty_take_error(session->context));
    cli_end_on_interrupt(false);
    if (status == CLI_GO && options->tev != NULL) status = cli_tev_open(&tev, session, options->tev, path);
    if (status == CLI_GO) status = serve(session, live, options);
    view_live_close(live);
    cli_tev_close(&tev);
    return cli_session_close(session, status);
}

static bool print_words(FILE* file, const char* option) {
    if (option == NULL || strcmp(option, "method") != 0) return false;
    fprintf(file, "%s ", cli_method_auto.name);
    for (int i = 0; ty_methods[i] != NULL; ++i) fprintf(file, "%s ", ty_methods[i]->name);
    return true;
}

int cli_view(int count, char** arguments) {
    view_options options = {.screen = screen_default_options("view")};
    char methods[160];
    cli_name_methods_in("(default: that of the scene)", methods, sizeof methods);
    const cli_option own[] = {
        {"port", 0, CLI_INT, "N", "port on 127.0.0.1 (default 0: a free one)", &options.port, 0, 65535, NULL},
        {"no-open", 0, CLI_FLAG, NULL, "do not open the browser", &options.no_open, 0, 0, NULL},
        {"method", 0, CLI_TEXT, "NAME", methods, &options.method, 0, 0, NULL},
        {"size", 0, CLI_SIZE, "WxH", "pixels (default: those of the camera, within 960x540)", options.size, 0, 0, NULL},
        {"define", 'D', CLI_LIST, "KEY=VALUE", "change the scene: -D media[0].g=0.5 (again for more)",
         &options.overrides, 0, 0, NULL},
        {"no-compare", 0, CLI_FLAG, NULL, "do not path trace in the background", &options.no_compare, 0, 0, NULL},
        {"remote", 0, CLI_FLAG, NULL, "compress: JPEG while something moves, lossless at rest", &options.remote, 0, 0,
         NULL},
        {"tev", 0, CLI_TEXT, "HOST:PORT", "also show the method's images in the viewer tev", &options.tev, 0, 0, NULL},
        {"record", 0, CLI_TEXT, "FOLDER", "where the page may write images", &options.record, 0, 0, NULL},
    };
    enum { OWN = sizeof own / sizeof own[0] };
    cli_option table[OWN + SCREEN_OPTIONS];
    memcpy(table, own, sizeof own);
    screen_list_options(&options.screen, table + OWN);
    const cli_syntax syntax = {
        "view",
        "SCENE|IMAGE [DISTANCE] [options]",
        "Shows a scene, or a photograph through a medium, in the browser, live.",
        "Prints the page's address as the first line on stdout and serves it on 127.0.0.1 until Ctrl-C. Fog, lights "
        "and\n"
        "camera move in the page; any method renders them, and path converges beside it with the difference in "
        "numbers.\n"
        "The address holds a token: who has it may look and change the scene in memory. Nothing is written but images\n"
        "into FOLDER. On another machine, forward the port by ssh -L and use --remote. docs/view.md\n\n"
        "IMAGE (.exr, .hdr, .png, .jpg, .webp) needs a --medium, such as fog:50; it, DISTANCE, and the options from\n"
        "--medium on are those of 'tyndall screen', which tells of them.",
        table,
        sizeof table / sizeof table[0],
        1,
        2,
        print_words};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO) status = check_kind(&options, &given);
    if (status == CLI_GO && options.method != NULL && cli_find_method("view", options.method) == NULL)
        status = CLI_USAGE;
    if (status == CLI_GO && options.tev != NULL) status = cli_tev_check_address("view", options.tev);
    if (status == CLI_GO && options.record != NULL) status = cli_make_folder("view", options.record);
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "view", &given.common);
    if (status == CLI_GO) status = cli_ranks_open(&session);
    if (status != CLI_GO) return status;
    const char* path = is_photo(&options, given.positional[0]) ? NULL : given.positional[0];
    return cli_ranks_helps(&session) ? cli_help_paths(&session, path, &options.overrides, true)
                                     : load_and_serve(&session, &given, &options);
}
