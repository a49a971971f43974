/* The methods that render scenes: one table for all commands. */
#ifndef TY_CLI_METHODS_H
#define TY_CLI_METHODS_H

#include "cli/checkpoint.h"
#include "cli/report.h"

/* What commands ask of every method. What is for one method alone it finds in the scene's ty_render_settings. */
typedef struct cli_request {
    int32_t spp;
    bool samples; /* whether it is spp that is asked for, which method auto then takes as a wish for path */
    uint64_t seed;
    double seconds, error;      /* bounds on the work, 0: none */
    int32_t width, height;      /* 0: the camera's resolution */
    int32_t crop[4];            /* x, y, width, height; 0: the whole frame */
    uint32_t aovs;              /* TY_AOV_... */
    cli_checkpoint* checkpoint; /* where states come from and go to; NULL: nowhere */
    double checkpoint_seconds;
} cli_request;

typedef struct cli_method {
    const char* name;
    const char* summary;
    uint32_t aovs; /* the channels it knows */
    bool crops;    /* whether it can render a part of the frame */
    /* Whether it is made for the scene; NULL: for all of them. */
    ty_result (*check)(const ty_scene* scene);
    /* Renders, and fills in what the report says of the run: path, own_seconds, screen, fld, pop, lpv, dom. Results as
     * of ty_path_render, but for TY_CANCELLED with *out NULL when a part is no picture. */
    ty_result (*render)(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                        cli_report* report);
} cli_method;

extern const cli_method cli_method_auto, cli_method_path, cli_method_screen, cli_method_fld, cli_method_cda,
    cli_method_pop, cli_method_lpv, cli_method_dom;

/* NULL, after a message that names the known ones, if there is none of that name. */
const cli_method* cli_find_method(const char* command, const char* name);
/* One after the other; NULL past the last. */
const cli_method* cli_method_at(int index);
/* Whether the method can do what is asked: CLI_GO, or CLI_USAGE after a message. */
int cli_check_request(cli_session* session, const ty_scene* scene, const cli_method* method,
                      const cli_request* request);

/* What the defs of all methods but path take from a request: their fields have the same names. */
#define CLI_TAKE_REQUEST(def, session, request)                                                                        \
    do {                                                                                                               \
        (def).seed = (request)->seed;                                                                                  \
        (def).width = (request)->width;                                                                                \
        (def).height = (request)->height;                                                                              \
        (def).aovs = (request)->aovs & ~(uint32_t)TY_AOV_SAMPLES;                                                      \
        (def).progress = cli_progress_report;                                                                          \
        (def).progress_user = &(session)->progress;                                                                    \
    } while (0)

/* What paths are traced with: the request, the scene's settings, the session's progress. */
ty_path_def cli_path_def(cli_session* session, const ty_scene* scene, const cli_request* request);

#endif
