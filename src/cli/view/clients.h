/* The viewer's clients: messages waiting for each, and a thread each that sends it. Knows nothing of the connection
 * but three calls, which may block; all calls here return at once, but view_clients_remove and view_clients_close. */
#ifndef TY_CLI_VIEW_CLIENTS_H
#define TY_CLI_VIEW_CLIENTS_H

#include "cli/view/server.h"
#include "cli/view/shared_frame.h"

typedef struct view_clients view_clients;

/* Writing to a connection. Each call returns false if it is lost. */
typedef struct view_wire {
    bool (*text)(void* connection, const char* text, size_t size);
    /* One binary message of two parts. */
    bool (*binary)(void* connection, const void* head, size_t head_size, const void* body, size_t body_size);
    /* Says goodbye; the connection ends when the other side answers. */
    bool (*goodbye)(void* connection, int code, const char* reason);
} view_wire;

/* Codes of goodbyes (RFC 6455, section 7.4.1). */
enum { VIEW_BYE_AWAY = 1001, VIEW_BYE_REFUSED = 1008, VIEW_BYE_TOO_BIG = 1009, VIEW_BYE_FULL = 1013 };

/* Returns NULL without memory. */
view_clients* view_clients_create(const view_wire* wire);
/* After the last client was removed; NULL is allowed. */
void view_clients_destroy(view_clients* clients);

/* A place for a connection, which is sent nothing yet. Returns its number, from 1; 0: all places are taken, or there is
 * no memory. */
int32_t view_clients_add(view_clients* clients, void* connection);
/* Starts to send: what was queued for the client, then the last frames and the last status. accepted false: only what
 * was queued and goodbye. Returns false without a thread. */
bool view_clients_start(view_clients* clients, int32_t id, bool accepted);
/* Says goodbye after the current message, and nothing then; a client that has ended is left as it is. The reason lives
 * as long as the client. */
void view_clients_end(view_clients* clients, int32_t id, int bye, const char* reason);
/* Ends the client's thread, after its current message, and frees the place: nothing is sent any more. Returns whether
 * goodbye was said. */
bool view_clients_remove(view_clients* clients, int32_t id);
/* Says goodbye to all and waits for at most some seconds until they are removed. */
void view_clients_close(view_clients* clients, double seconds);
/* Number of clients that are sent frames. */
int32_t view_clients_count(view_clients* clients);
/* False if the client was said goodbye to, or is lost. */
bool view_clients_alive(view_clients* clients, int32_t id);

/* As view_server_show, view_server_tell and view_server_send. show takes the frame over. */
void view_clients_show(view_clients* clients, view_channel channel, view_shared_frame* frame);
void view_clients_tell(view_clients* clients, view_slot slot, const char* text);
void view_clients_send(view_clients* clients, int32_t id, const char* text);
/* The client has shown a frame. Returns false if it was not sent such a one. */
bool view_clients_acknowledge(view_clients* clients, int32_t id, view_channel channel, uint32_t sequence);

#endif
