/* tyndall render: options, one image, and sequences of images. */
#ifndef TY_CLI_RENDER_RENDER_H
#define TY_CLI_RENDER_RENDER_H

#include "cli/images/tev.h"
#include "cli/methods/methods.h"
#include "cli/options/options.h"

enum { RENDER_SPP_MAX = 1 << 24 };

/* The key of an image's metadata that tells the command it is a frame of. */
#define RENDER_KEY "tyndall.sequence"

typedef struct render_options {
    const char *output, *png, *denoised_png, *aov, *method, *tev, *frames_text, *part_text;
    bool more; /* further scenes come on stdin */
    uint32_t aovs;
    int32_t spp, size[2], crop[4];
    double time, error, exposure, checkpoint;
    int denoiser;
    bool denoiser_given, spp_given, exposure_given, checkpoint_given, chain_given, resume, denoise;
    int32_t frames[3], chain; /* first and last frame, step */
    int32_t part[2];          /* I of N; N 0: all */
    const char* key;          /* of a sequence's images; NULL: none */
    void** light;             /* of the frame before, and then of this one, as in cli_request; NULL: none */
    cli_list overrides;
} render_options;

/* Renders and writes the scene; returns the exit status. tev may be NULL. */
int render_scene(cli_session* session, const ty_scene* scene, render_options* options, cli_checkpoint* checkpoint,
                 cli_tev* tev, cli_report* report);

/* For the session's stats; user is the cli_report. */
void render_report_stats(json_writer* json, const void* user);

/* ---- more.c ---- */

/* Takes --more: CLI_GO, or CLI_USAGE after a message. */
int render_check_more(const render_options* options);
/* Renders the scene at path, and then those that the lines of stdin name, and closes the session. Returns the exit
 * status. */
int render_more(cli_session* session, const char* path, render_options* options);

/* ---- sequence.c ---- */

/* Takes --frames: CLI_GO, or CLI_USAGE after a message. */
int render_check_sequence(render_options* options);
/* Renders the frames, and closes the session; on ranks other than 0 those that rank 0 lends. Returns the exit status.
 */
int render_sequence(cli_session* session, const char* path, render_options* options);

#endif
