/* Methods and requests of commands: the methods of the library (method/method.h), and auto. */
#ifndef TY_CLI_METHODS_METHODS_H
#define TY_CLI_METHODS_METHODS_H

#include "cli/session/checkpoint.h"
#include "cli/methods/report.h"
#include "method/registry.h"

/* A request common to all methods. Options of single methods come from the scene. */
typedef struct cli_request {
    int32_t spp;
    bool samples; /* spp was given explicitly, which makes method auto choose path */
    uint64_t seed;
    double seconds, error;      /* limits of time and noise, 0: none */
    int32_t width, height;      /* 0: the camera's resolution */
    int32_t crop[4];            /* x, y, width, height; 0: the whole frame */
    uint32_t aovs;              /* TY_AOV_... */
    cli_checkpoint* checkpoint; /* source and destination of states; NULL: none */
    double checkpoint_seconds;
    ty_path_partial_fn partial; /* receives images that are not finished, of method path; NULL: none */
    void* partial_user;
    void** light; /* as in ty_render_request */
} cli_request;

/* The method that chooses one of the others for a scene; cli_render_method alone renders it. */
extern const ty_method cli_method_auto;

/* The method of a name; NULL, after a message that lists the methods, if there is none. */
const ty_method* cli_find_method(const char* command, const char* name);
/* Prints "auto, path, ... or dom", followed by a text. */
void cli_name_methods_in(const char* text, char* out, size_t size);
/* CLI_GO if the method supports the request, else CLI_USAGE after a message. */
int cli_check_request(cli_session* session, const ty_scene* scene, const ty_method* method, const cli_request* request);

/* Renders, and fills in the measurements of the report. Results as of ty_method.render. */
ty_result cli_render_method(cli_session* session, const ty_scene* scene, const ty_method* method,
                            const cli_request* request, ty_image** out, cli_report* report);

/* The def of the path tracer from the request, the scene's options and the session's progress. Errors: those of
 * ty_method_options. */
ty_result cli_path_def(cli_session* session, const ty_scene* scene, const cli_request* request, ty_path_def* def);

/* Chooses a method for the scene, and renders with it, or with path where the chosen one refuses. */
ty_result cli_render_auto(cli_session* session, const ty_scene* scene, const cli_request* request, ty_image** out,
                          cli_report* report);

#endif
