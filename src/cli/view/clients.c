#define _GNU_SOURCE
#include "cli/view/clients.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TEXTS_MAX = 256, UNDER_WAY_MAX = 2 };

typedef struct view_client view_client;

struct view_client {
    view_client* next;
    view_clients* all;
    int32_t id;
    void* connection;
    pthread_t thread;
    pthread_cond_t work;
    bool started;  /* there is a thread */
    bool flushing; /* goodbye follows the queued texts */
    bool ended;    /* nothing more is sent */
    int bye;       /* the code of the goodbye; 0: none */
    const char* reason;
    char* texts[TEXTS_MAX];
    int first_text, text_count;
    char* slots[VIEW_SLOT_COUNT];
    view_shared_frame* frames[VIEW_CHANNEL_COUNT];
    uint32_t sent[VIEW_CHANNEL_COUNT], shown[VIEW_CHANNEL_COUNT]; /* sequence numbers */
    int last_channel;
};

struct view_clients {
    view_wire wire;
    pthread_mutex_t lock; /* of everything below and of all clients */
    pthread_cond_t removed;
    view_client* first;
    int32_t last_id;
    view_shared_frame* frames[VIEW_CHANNEL_COUNT]; /* the last ones, for those who come later */
    char* status;
};

/* The next message of a client: a text, or a frame of a sequence number. */
typedef struct parcel {
    char* text;
    view_shared_frame* frame;
    uint32_t sequence;
} parcel;

view_clients* view_clients_create(const view_wire* wire) {
    view_clients* clients = calloc(1, sizeof *clients);
    pthread_condattr_t monotonic;
    if (clients == NULL) return NULL;
    clients->wire = *wire;
    pthread_mutex_init(&clients->lock, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&clients->removed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return clients;
}

void view_clients_destroy(view_clients* clients) {
    if (clients == NULL) return;
    for (int c = 0; c < VIEW_CHANNEL_COUNT; ++c) view_shared_frame_release(clients->frames[c]);
    pthread_cond_destroy(&clients->removed);
    pthread_mutex_destroy(&clients->lock);
    free(clients->status);
    free(clients);
}

static view_client* find(view_clients* clients, int32_t id) {
    view_client* client = clients->first;
    while (client != NULL && client->id != id) client = client->next;
    return client;
}

static int32_t count_open(const view_clients* clients) {
    int32_t count = 0;
    for (const view_client* client = clients->first; client != NULL; client = client->next)
        count += !client->ended && !client->flushing;
    return count;
}

/* Ends a client; its thread says goodbye, unless the code is 0. */
static void end(view_client* client, int bye, const char* reason) {
    if (client->ended) return;
    client->ended = true;
    client->bye = bye;
    client->reason = reason;
    pthread_cond_signal(&client->work);
}

int32_t view_clients_add(view_clients* clients, void* connection) {
    view_client* client = calloc(1, sizeof *client);
    if (client == NULL) return 0;
    pthread_cond_init(&client->work, NULL);
    client->all = clients;
    client->connection = connection;
    pthread_mutex_lock(&clients->lock);
    const bool full = count_open(clients) >= VIEW_CLIENTS_MAX;
    if (!full) {
        client->id = ++clients->last_id;
        client->next = clients->first;
        clients->first = client;
    }
    const int32_t id = client->id;
    pthread_mutex_unlock(&clients->lock);
    if (full) {
        pthread_cond_destroy(&client->work);
        free(client);
    }
    return id;
}

static bool take_frame(view_client* client, parcel* next) {
    for (int i = 1; i <= VIEW_CHANNEL_COUNT; ++i) {
        const int channel = (client->last_channel + i) % VIEW_CHANNEL_COUNT;
        if (client->frames[channel] == NULL) continue;
        if (client->sent[channel] - client->shown[channel] >= UNDER_WAY_MAX) continue;
        *next = (parcel){.frame = client->frames[channel], .sequence = ++client->sent[channel]};
        client->frames[channel] = NULL;
        client->last_channel = channel;
        return true;
    }
    return false;
}

/* Takes the next message out of the mailboxes. Returns false if there is none that may be sent now. */
static bool take(view_client* client, parcel* next) {
    if (client->text_count > 0) {
        *next = (parcel){.text = client->texts[client->first_text]};
        client->first_text = (client->first_text + 1) % TEXTS_MAX;
        --client->text_count;
        return true;
    }
    if (client->flushing) {
        end(client, VIEW_BYE_REFUSED, "refused");
        return false;
    }
    for (int slot = 0; slot < VIEW_SLOT_COUNT; ++slot) {
        if (client->slots[slot] == NULL) continue;
        *next = (parcel){.text = client->slots[slot]};
        client->slots[slot] = NULL;
        return true;
    }
    return take_frame(client, next);
}

static bool write_frame(const view_client* client, const parcel* next) {
    uint8_t head[VIEW_HEADER_BYTES];
    size_t size;
    const uint8_t* message = view_shared_frame_message(next->frame, &size);
    if (message == NULL) return false;
    memcpy(head, message, sizeof head);
    view_frame_number(head, next->sequence);
    return client->all->wire.binary(client->connection, head, sizeof head, message + sizeof head, size - sizeof head);
}

static bool deliver(const view_client* client, parcel* next) {
    const bool written = next->text != NULL ? client->all->wire.text(client->connection, next->text, strlen(next->text))
                                            : write_frame(client, next);
    free(next->text);
    view_shared_frame_release(next->frame);
    return written;
}

static void* send_messages(void* user) {
    view_client* client = user;
    view_clients* clients = client->all;
    pthread_mutex_lock(&clients->lock);
    while (!client->ended) {
        parcel next;
        if (!take(client, &next)) {
            if (!client->ended) pthread_cond_wait(&client->work, &clients->lock);
            continue;
        }
        pthread_mutex_unlock(&clients->lock);
        const bool written = deliver(client, &next);
        pthread_mutex_lock(&clients->lock);
        if (!written) {
            client->ended = true;
            client->bye = 0;
        }
    }
    pthread_mutex_unlock(&clients->lock);
    if (client->bye != 0) clients->wire.goodbye(client->connection, client->bye, client->reason);
    return NULL;
}

bool view_clients_start(view_clients* clients, int32_t id, bool accepted) {
    pthread_mutex_lock(&clients->lock);
    view_client* client = find(clients, id);
    client->flushing = !accepted;
    for (int c = 0; c < VIEW_CHANNEL_COUNT; ++c)
        if (client->frames[c] == NULL) client->frames[c] = view_shared_frame_keep(clients->frames[c]);
    if (client->slots[VIEW_SLOT_STATUS] == NULL && clients->status != NULL)
        client->slots[VIEW_SLOT_STATUS] = strdup(clients->status);
    client->started = pthread_create(&client->thread, NULL, send_messages, client) == 0;
    if (!client->started) end(client, 0, NULL);
    const bool started = client->started;
    pthread_mutex_unlock(&clients->lock);
    return started;
}

static void free_client(view_client* client) {
    for (int i = 0; i < client->text_count; ++i) free(client->texts[(client->first_text + i) % TEXTS_MAX]);
    for (int slot = 0; slot < VIEW_SLOT_COUNT; ++slot) free(client->slots[slot]);
    for (int c = 0; c < VIEW_CHANNEL_COUNT; ++c) view_shared_frame_release(client->frames[c]);
    pthread_cond_destroy(&client->work);
    free(client);
}

void view_clients_end(view_clients* clients, int32_t id, int bye, const char* reason) {
    pthread_mutex_lock(&clients->lock);
    view_client* client = find(clients, id);
    if (client != NULL) end(client, bye, reason);
    pthread_mutex_unlock(&clients->lock);
}

bool view_clients_remove(view_clients* clients, int32_t id) {
    view_clients_end(clients, id, 0, NULL);
    pthread_mutex_lock(&clients->lock);
    view_client* client = find(clients, id);
    pthread_mutex_unlock(&clients->lock);
    if (client == NULL) return false;
    if (client->started) pthread_join(client->thread, NULL);
    const bool goodbye = client->started && client->bye != 0;
    pthread_mutex_lock(&clients->lock);
    view_client** link = &clients->first;
    while (*link != client) link = &(*link)->next;
    *link = client->next;
    pthread_cond_broadcast(&clients->removed);
    pthread_mutex_unlock(&clients->lock);
    free_client(client);
    return goodbye;
}

void view_clients_close(view_clients* clients, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    const double at = (double)until.tv_nsec * 1e-9 + seconds;
    until.tv_sec += (time_t)at;
    until.tv_nsec = (long)((at - (double)(time_t)at) * 1e9);
    pthread_mutex_lock(&clients->lock);
    for (view_client* client = clients->first; client != NULL; client = client->next)
        end(client, VIEW_BYE_AWAY, "tyndall ends");
    while (clients->first != NULL && pthread_cond_timedwait(&clients->removed, &clients->lock, &until) == 0) {
    }
    pthread_mutex_unlock(&clients->lock);
}

int32_t view_clients_count(view_clients* clients) {
    pthread_mutex_lock(&clients->lock);
    const int32_t count = count_open(clients);
    pthread_mutex_unlock(&clients->lock);
    return count;
}

bool view_clients_alive(view_clients* clients, int32_t id) {
    pthread_mutex_lock(&clients->lock);
    const view_client* client = find(clients, id);
    const bool alive = client != NULL && !client->ended;
    pthread_mutex_unlock(&clients->lock);
    return alive;
}

void view_clients_show(view_clients* clients, view_channel channel, view_shared_frame* frame) {
    pthread_mutex_lock(&clients->lock);
    for (view_client* client = clients->first; client != NULL; client = client->next) {
        view_shared_frame_release(client->frames[channel]);
        client->frames[channel] = view_shared_frame_keep(frame);
        pthread_cond_signal(&client->work);
    }
    view_shared_frame* before = clients->frames[channel];
    clients->frames[channel] = frame;
    pthread_mutex_unlock(&clients->lock);
    view_shared_frame_release(before);
}

void view_clients_tell(view_clients* clients, view_slot slot, const char* text) {
    pthread_mutex_lock(&clients->lock);
    for (view_client* client = clients->first; client != NULL; client = client->next) {
        free(client->slots[slot]);
        client->slots[slot] = strdup(text);
        pthread_cond_signal(&client->work);
    }
    if (slot == VIEW_SLOT_STATUS) {
        free(clients->status);
        clients->status = strdup(text);
    }
    pthread_mutex_unlock(&clients->lock);
}

void view_clients_send(view_clients* clients, int32_t id, const char* text) {
    pthread_mutex_lock(&clients->lock);
    view_client* client = find(clients, id);
    if (client != NULL && !client->ended) {
        char* copy = client->text_count < TEXTS_MAX ? strdup(text) : NULL;
        if (copy == NULL) {
            end(client, VIEW_BYE_TOO_BIG, "too many unsent texts");
        } else {
            client->texts[(client->first_text + client->text_count++) % TEXTS_MAX] = copy;
            pthread_cond_signal(&client->work);
        }
    }
    pthread_mutex_unlock(&clients->lock);
}

bool view_clients_acknowledge(view_clients* clients, int32_t id, view_channel channel, uint32_t sequence) {
    pthread_mutex_lock(&clients->lock);
    view_client* client = find(clients, id);
    const bool known = client != NULL && sequence >= 1 && sequence <= client->sent[channel];
    if (known && sequence > client->shown[channel]) {
        client->shown[channel] = sequence;
        pthread_cond_signal(&client->work);
    }
    pthread_mutex_unlock(&clients->lock);
    return known;
}
