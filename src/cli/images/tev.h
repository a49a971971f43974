/* A client of tev, the image viewer (github.com/Tom94/tev): shows images of a run by tev's TCP protocol.
 *
 *     cli_tev tev = {0};
 *     int status = cli_tev_open(&tev, session, "127.0.0.1:14158", "scene.exr");
 *     request.partial = cli_tev_show;     path calls it at most once a second
 *     request.partial_user = &tev;
 *     ...
 *     cli_tev_show(&tev, image);          the final image
 *     cli_tev_close(&tev);
 *
 * A program that shows images one after another, such as tyndall view, calls cli_tev_show_pixels for each of them from
 * one thread at a time: a change of size makes tev's image anew. The image stays in tev when the connection ends. */
#ifndef TY_CLI_IMAGES_TEV_H
#define TY_CLI_IMAGES_TEV_H

#include "cli/session/session.h"

typedef struct cli_tev {
    cli_session* session;
    const char *address, *name; /* of tev, HOST:PORT, and of the image there */
    int socket;                 /* 0: not connected */
    int32_t width, height;      /* of the image that tev has; 0: none */
} cli_tev;

/* CLI_GO for HOST:PORT and [IPV6]:PORT, else CLI_USAGE after a message of the command. */
int cli_tev_check_address(const char* command, const char* address);
/* Connects within two seconds: CLI_GO, or CLI_FAILED after a message. The texts stay the caller's. */
int cli_tev_open(cli_tev* tev, cli_session* session, const char* address, const char* name);
/* A ty_path_partial_fn; user is the cli_tev. Sends R, G and B of an image, or a single channel as all three. Nothing
 * once the connection is lost, of which one warning tells. Always true: the run goes on. */
bool cli_tev_show(void* user, const ty_image* image);
/* The same for interleaved pixels, 3 values each. */
void cli_tev_show_pixels(cli_tev* tev, const float* rgb, int32_t width, int32_t height);
/* Allowed where nothing was opened. */
void cli_tev_close(cli_tev* tev);

#endif
