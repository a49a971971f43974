/* The viewer's HTTP and WebSocket server, on 127.0.0.1 alone. Only server.c includes civetweb. docs/view_protocol.md.
 */
#ifndef TY_CLI_VIEW_SERVER_H
#define TY_CLI_VIEW_SERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cli/view/frame.h"

typedef struct view_server view_server;

enum { VIEW_TOKEN_SIZE = 33, VIEW_CLIENTS_MAX = 8 };

typedef struct view_server_def {
    int32_t port; /* 0: a free one */
    bool remote;  /* JPEG while moving, deflated halves at rest */
    void* user;
    /* A text message of a client, called on its thread. It replies, or refuses in one line, by view_server_send. */
    void (*receive)(void* user, int32_t client, const char* text, size_t size);
    /* A client is connected, before its first message: it is sent the welcome. Returns false to refuse it. */
    bool (*connected)(void* user, int32_t client);
    /* The last full image of a channel as the bytes of an OpenEXR file, freed with free(); false: there is none. */
    bool (*image)(void* user, view_channel channel, uint8_t** bytes, size_t* size);
} view_server_def;

/* Starts to listen. Returns NULL after one line into message (of size bytes), for example when the port is taken. */
view_server* view_server_start(const view_server_def* def, char* message, size_t size);
/* Closes all connections and joins all threads; NULL is allowed. */
void view_server_stop(view_server* server);
int32_t view_server_port(const view_server* server);
/* 32 hexadecimal digits. */
const char* view_server_token(const view_server* server);
/* Number of connected clients. */
int32_t view_server_clients(const view_server* server);

/* Gives all clients a frame, which is copied. A client that has not yet been sent the last one of the channel gets this
 * one instead. Encoding is done once per codec, by the first client's thread that sends it. Never blocks on a client. A
 * client that connects later gets the last frame of each channel, and the last status, after its welcome. */
void view_server_show(view_server* server, const view_frame* frame);
/* Gives all clients a JSON text, which is copied; of two texts of the same slot, not yet sent, the later replaces the
 * earlier. Never blocks on a client. */
typedef enum view_slot { VIEW_SLOT_SCENE, VIEW_SLOT_STATUS, VIEW_SLOT_COUNT } view_slot;
void view_server_tell(view_server* server, view_slot slot, const char* text);
/* Queues a JSON text for one client. A client with more than 256 unsent texts is disconnected. */
void view_server_send(view_server* server, int32_t client, const char* text);

#endif
