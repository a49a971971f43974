/* A headless client of `tyndall view` (docs/view_protocol.md), which it starts as a process of its own. Only
 * view_client.c includes civetweb. */
#ifndef TY_BENCH_VIEW_CLIENT_H
#define TY_BENCH_VIEW_CLIENT_H

#include "bench/bench.h"

#include <jansson.h>

typedef struct view_client view_client;

/* A frame of the method's channel as it arrived. */
typedef struct view_arrival {
    double seconds; /* of cli_wall_seconds */
    uint32_t revision;
    int32_t width, full_width;
    bool final;
    size_t bytes;
} view_arrival;

/* Starts `tyndall view` and connects. NULL after a message. arguments: of the command, ended by NULL. */
view_client* view_client_open(const char* const* arguments);
void view_client_close(view_client* client);

/* Sends a JSON text. False if the connection is lost. */
bool view_client_send(view_client* client, const char* text);
/* Waits for the next frame that comes after `after` frames, with at least a revision, and final if asked for. Returns
 * false after timeout s, or if the connection is lost or the server refused a message. */
bool view_client_wait(view_client* client, uint32_t after, uint32_t revision, bool final, double timeout,
                      view_arrival* out);
/* Writes the method's last full image as OpenEXR. */
bool view_client_fetch_image(const view_client* client, const char* path);
/* Frames of the method so far. */
uint32_t view_client_frames(view_client* client);
/* The scene's revision in the last message. */
uint32_t view_client_revision(view_client* client);
/* The server's last refusal or message about the method; "" if there is none. */
const char* view_client_complaint(view_client* client);
/* A number of the last status by two keys, "times" and "solve"; -1 if it has none. */
double view_client_status(view_client* client, const char* group, const char* key);
/* The document of the welcome; borrowed. */
const json_t* view_client_document(const view_client* client);

#endif
