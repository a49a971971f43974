/* Messages from clients as a queue that the rendering thread empties (docs/view_protocol.md). */
#ifndef TY_CLI_VIEW_REQUESTS_H
#define TY_CLI_VIEW_REQUESTS_H

#include <jansson.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum view_request_kind {
    VIEW_REQUEST_SET,      /* `camera` too, as changes of the document */
    VIEW_REQUEST_VIEW,     /* method, compare, paused, size, exposure */
    VIEW_REQUEST_DOCUMENT, /* the scene as text */
    VIEW_REQUEST_RECORD    /* an image into a folder */
} view_request_kind;

typedef struct view_request {
    view_request_kind kind;
    int32_t client;
    json_int_t id;   /* -1: none */
    bool moving;     /* further changes follow at once */
    bool camera;     /* made by a `camera` message */
    double received; /* s of cli_wall_seconds */
    json_t* changes; /* VIEW_REQUEST_SET: an array of {path, value} */
    json_t* message; /* the whole message */
    struct view_request* next;
} view_request;

/* Parses a message. Returns NULL after one line in `reason` that refuses it; *id is the message's if it has one, else
 * -1. meters_per_unit: the unit of lengths in the document, m, by which camera positions are divided. */
view_request* view_request_parse(const char* text, size_t length, double meters_per_unit, json_int_t* id, char* reason,
                                 size_t size);
void view_request_free(view_request* request);

/* True if the later of two requests of one client makes the earlier, not yet done, superfluous: it sets the same keys.
 */
bool view_request_replaces(const view_request* later, const view_request* earlier);

/* The path of one change, and its value as JSON text, which is freed with free(); NULL stands for a removed key. */
const char* view_change_path(const json_t* change);
char* view_change_value(const json_t* change);

#endif
