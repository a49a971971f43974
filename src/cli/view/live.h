/* Live rendering: one thread edits the scene as clients ask, renders it by the method they chose, coarsely while
 * something moves and fully at rest, and then path traces it for comparison. */
#ifndef TY_CLI_VIEW_LIVE_H
#define TY_CLI_VIEW_LIVE_H

#include "cli/images/tev.h"
#include "cli/view/photo.h"
#include "cli/view/server.h"

#include <tyndall/base.h>

typedef struct view_live view_live;

typedef struct view_live_def {
    cli_session* session;
    const char* path;            /* of the scene file, or builtin:NAME; of the photograph */
    const view_photo_def* photo; /* NULL: a scene, to which the members up to `compare` belong */
    const char* const* overrides;
    int32_t override_count;
    const char* method;    /* NULL: the scene's */
    int32_t width, height; /* 0: the camera's resolution, within 960 x 540 */
    bool compare;          /* path runs in the background */
    bool remote;
    const char* record; /* folder for recorded images; NULL: none */
    cli_tev* tev;       /* is shown the method's images, too; NULL: none */
} view_live_def;

/* Reads the scene or the photograph. CLI_GO, or an exit status after a message. */
int view_live_open(const view_live_def* def, view_live** out);
/* Ends the thread, before the server stops. */
void view_live_stop(view_live* live);
/* Frees all; NULL is allowed. The server must have been stopped. */
void view_live_close(view_live* live);

/* Callbacks of the server, whose user is the view_live. */
void view_live_receive(void* user, int32_t client, const char* text, size_t size);
bool view_live_connected(void* user, int32_t client);
bool view_live_image(void* user, view_channel channel, uint8_t** bytes, size_t* size);

/* Starts the thread, which shows its images on the server. */
bool view_live_start(view_live* live, view_server* server);

#endif
