#include "cli/view/inbox.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_MAX = 1 << 20, ACK_MAX = 256 };
enum { CONTINUATION = 0, TEXT = 1, BINARY = 2 };

static void reply_error(const view_inbox* inbox, const char* line) {
    char text[160];
    snprintf(text, sizeof text, "{\"type\": \"error\", \"text\": \"%s\"}", line);
    view_clients_send(inbox->clients, inbox->client, text);
}

static bool is_utf8(const char* text, size_t size) {
    json_t* value = json_stringn(text, size);
    json_decref(value);
    return value != NULL;
}

static bool acknowledge(const view_inbox* inbox, json_t* message) {
    json_int_t channel = -1, sequence = 0;
    return json_unpack(message, "{s:I, s:I}", "channel", &channel, "sequence", &sequence) == 0 && channel >= 0 &&
           channel < VIEW_CHANNEL_COUNT && sequence > 0 && sequence <= UINT32_MAX &&
           view_clients_acknowledge(inbox->clients, inbox->client, (view_channel)channel, (uint32_t)sequence);
}

/* Acknowledgements are the server's own; every other text is the caller's. Returns false if this is none. */
static bool take_acknowledgement(const view_inbox* inbox, const char* text, size_t size) {
    const char* type = NULL;
    json_t* message = size <= ACK_MAX ? json_loadb(text, size, 0, NULL) : NULL;
    const bool typed = message != NULL && json_unpack(message, "{s:s}", "type", &type) == 0;
    const bool is_one = typed && strcmp(type, "ack") == 0;
    if (is_one && !acknowledge(inbox, message)) reply_error(inbox, "ack: no such frame was sent");
    json_decref(message);
    return is_one;
}

static void take_text(const view_inbox* inbox, const char* text, size_t size) {
    if (!is_utf8(text, size))
        reply_error(inbox, "the message is not UTF-8");
    else if (!take_acknowledgement(inbox, text, size))
        inbox->def->receive(inbox->def->user, inbox->client, text, size);
}

void view_inbox_clear(view_inbox* inbox) {
    free(inbox->text);
    inbox->text = NULL;
    inbox->size = 0;
}

static view_verdict take_part(view_inbox* inbox, bool last, const char* data, size_t size) {
    char* longer = realloc(inbox->text, inbox->size + size + 1);
    if (longer == NULL) return VIEW_END;
    memcpy(longer + inbox->size, data, size);
    inbox->text = longer;
    inbox->size += size;
    if (!last) return VIEW_GO_ON;
    take_text(inbox, inbox->text, inbox->size);
    view_inbox_clear(inbox);
    return VIEW_GO_ON;
}

view_verdict view_inbox_take(view_inbox* inbox, int opcode, bool last, const char* data, size_t size) {
    const bool begins = opcode != CONTINUATION, open = inbox->text != NULL || inbox->skipping;
    if (opcode > BINARY || begins == open) return VIEW_END;
    if (size > TEXT_MAX - inbox->size) return VIEW_TOO_BIG;
    if (opcode == TEXT || inbox->text != NULL) return take_part(inbox, last, data, size);
    if (begins) reply_error(inbox, "binary messages are not understood");
    inbox->skipping = !last;
    return VIEW_GO_ON;
}
