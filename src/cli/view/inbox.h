/* Messages of a client: parts are put together, acknowledgements taken, texts handed on, and all else is refused. */
#ifndef TY_CLI_VIEW_INBOX_H
#define TY_CLI_VIEW_INBOX_H

#include "cli/view/clients.h"

typedef struct view_inbox {
    const view_server_def* def;
    view_clients* clients;
    int32_t client;
    bool skipping; /* parts of a message that was refused follow */
    char* text;    /* parts of a message that is not complete */
    size_t size;
} view_inbox;

typedef enum view_verdict { VIEW_END, VIEW_GO_ON, VIEW_TOO_BIG } view_verdict;

/* A part of a message: opcode as in RFC 6455, section 5.2; last: it completes the message. */
view_verdict view_inbox_take(view_inbox* inbox, int opcode, bool last, const char* data, size_t size);
void view_inbox_clear(view_inbox* inbox);

#endif
