#define _GNU_SOURCE
#include "bench/view_client.h"
#include "bench/command.h"

#include <civetweb.h>
#include <jansson.h>

#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

enum { HEADER = 64, RING = 256, ARGUMENTS_MAX = 32, SOCKETS_MAX = 256 };

struct view_client {
    pid_t child;
    struct mg_connection* connection;
    int port;
    char token[64];
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    view_arrival arrivals[RING]; /* the last frames of the method */
    uint32_t frames, revision;
    json_t *welcome, *status;
    char complaint[512];
    bool closed;
};

/* ---- arrivals, on the connection's thread ---- */

static uint32_t read_u32(const char* at) {
    const unsigned char* b = (const unsigned char*)at;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static uint32_t read_u16(const char* at) {
    const unsigned char* b = (const unsigned char*)at;
    return b[0] | (uint32_t)b[1] << 8;
}

static void acknowledge(struct mg_connection* connection, int channel, uint32_t sequence) {
    char text[80];
    const int length =
        snprintf(text, sizeof text, "{\"type\":\"ack\",\"channel\":%d,\"sequence\":%u}", channel, sequence);
    mg_websocket_client_write(connection, MG_WEBSOCKET_OPCODE_TEXT, text, (size_t)length);
}

static void take_frame(view_client* client, struct mg_connection* connection, const char* data, size_t size) {
    if (size < HEADER || memcmp(data, "TYF1", 4) != 0) return;
    acknowledge(connection, data[4], read_u32(data + 8));
    if (data[4] != 0) return;
    pthread_mutex_lock(&client->mutex);
    client->arrivals[client->frames++ % RING] = (view_arrival){.seconds = cli_wall_seconds(),
                                                               .revision = read_u32(data + 12),
                                                               .width = (int32_t)read_u16(data + 16),
                                                               .full_width = (int32_t)read_u16(data + 20),
                                                               .final = read_u32(data + 36) == 1,
                                                               .bytes = size};
    pthread_cond_broadcast(&client->changed);
    pthread_mutex_unlock(&client->mutex);
}

/* Takes over the message. Under the mutex. */
static void take_message(view_client* client, json_t* message) {
    const char* type = json_string_value(json_object_get(message, "type"));
    const json_t* revision = json_object_get(message, "revision");
    if (json_is_integer(revision)) client->revision = (uint32_t)json_integer_value(revision);
    json_t** kept = NULL;
    if (type != NULL && strcmp(type, "welcome") == 0) kept = &client->welcome;
    if (type != NULL && strcmp(type, "status") == 0) kept = &client->status;
    const char* text = json_string_value(json_object_get(message, kept != NULL ? "message" : "text"));
    if (text != NULL && text[0] != '\0') snprintf(client->complaint, sizeof client->complaint, "%s", text);
    if (kept == NULL) {
        json_decref(message);
    } else {
        json_decref(*kept);
        *kept = message;
    }
}

static int on_data(struct mg_connection* connection, int flags, char* data, size_t size, void* user) {
    view_client* client = user;
    const int opcode = flags & 15;
    if (opcode == MG_WEBSOCKET_OPCODE_BINARY) take_frame(client, connection, data, size);
    if (opcode == MG_WEBSOCKET_OPCODE_TEXT) {
        pthread_mutex_lock(&client->mutex);
        take_message(client, json_loadb(data, size, 0, NULL));
        pthread_cond_broadcast(&client->changed);
        pthread_mutex_unlock(&client->mutex);
    }
    return 1;
}

static void on_close(const struct mg_connection* connection, void* user) {
    (void)connection;
    view_client* client = user;
    pthread_mutex_lock(&client->mutex);
    client->closed = true;
    pthread_cond_broadcast(&client->changed);
    pthread_mutex_unlock(&client->mutex);
}

/* ---- the process ---- */

/* Starts the command; its first line, the page's address, goes to url. */
static bool start(view_client* client, const char* const* arguments, char* url, int size) {
    char path[BENCH_COMMAND_SIZE];
    const char* list[ARGUMENTS_MAX] = {path, "view", "--no-open", "-q"};
    int count = 4, pipes[2];
    for (; *arguments != NULL && count < ARGUMENTS_MAX - 1; ++arguments) list[count++] = *arguments;
    bench_find_command(path);
    if (pipe(pipes) != 0) return false;
    client->child = fork();
    if (client->child == 0) {
        dup2(pipes[1], STDOUT_FILENO);
        close(pipes[0]);
        close(pipes[1]);
        execvp(path, (char* const*)(uintptr_t)list);
        _exit(127);
    }
    close(pipes[1]);
    FILE* out = fdopen(pipes[0], "r");
    const bool read = out != NULL && fgets(url, size, out) != NULL;
    if (out != NULL) fclose(out);
    return client->child > 0 && read;
}

/* civetweb's client lets small messages wait for the acknowledgement of those before, up to 40 ms, as no browser does.
 * Its socket is the one that is connected to the port. */
static void send_at_once(int port) {
    const int on = 1;
    for (int socket = 3; socket < SOCKETS_MAX; ++socket) {
        struct sockaddr_in peer;
        socklen_t size = sizeof peer;
        if (getpeername(socket, (struct sockaddr*)&peer, &size) == 0 && peer.sin_family == AF_INET &&
            ntohs(peer.sin_port) == port)
            setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    }
}

static bool connect_to(view_client* client, const char* url) {
    char path[256], origin[64], error[256];
    if (sscanf(url, "http://127.0.0.1:%d/?token=%63s", &client->port, client->token) != 2) return false;
    const int port = client->port;
    snprintf(path, sizeof path, "/live?token=%s", client->token);
    snprintf(origin, sizeof origin, "http://127.0.0.1:%d", port);
    client->connection =
        mg_connect_websocket_client("127.0.0.1", port, 0, error, sizeof error, path, origin, on_data, on_close, client);
    if (client->connection != NULL) send_at_once(port);
    return client->connection != NULL;
}

/* Waits until the condition holds, the connection is lost, or the time is over. Under the mutex. */
static bool wait_until(view_client* client, const struct timespec* until) {
    return !client->closed && pthread_cond_timedwait(&client->changed, &client->mutex, until) != ETIMEDOUT;
}

static struct timespec time_in(double seconds) {
    struct timespec at;
    clock_gettime(CLOCK_REALTIME, &at);
    at.tv_nsec += (long)(1e9 * fmod(seconds, 1));
    at.tv_sec += (time_t)seconds + at.tv_nsec / 1000000000;
    at.tv_nsec %= 1000000000;
    return at;
}

static bool wait_for_welcome(view_client* client) {
    const struct timespec until = time_in(60);
    pthread_mutex_lock(&client->mutex);
    while (client->welcome == NULL && wait_until(client, &until)) continue;
    const bool welcome = client->welcome != NULL;
    pthread_mutex_unlock(&client->mutex);
    return welcome;
}

view_client* view_client_open(const char* const* arguments) {
    char url[256];
    view_client* client = calloc(1, sizeof *client);
    if (client == NULL) {
        cli_fail(CLI_FAILED, "not enough memory");
        return NULL;
    }
    pthread_mutex_init(&client->mutex, NULL);
    pthread_cond_init(&client->changed, NULL);
    mg_init_library(0);
    if (start(client, arguments, url, sizeof url) && connect_to(client, url) && wait_for_welcome(client)) return client;
    cli_fail(CLI_FAILED, "bench view: 'tyndall view' does not start, or refuses the client");
    view_client_close(client);
    return NULL;
}

void view_client_close(view_client* client) {
    if (client->connection != NULL) mg_close_connection(client->connection);
    if (client->child > 0) {
        kill(client->child, SIGINT);
        waitpid(client->child, NULL, 0);
    }
    mg_exit_library();
    json_decref(client->welcome);
    json_decref(client->status);
    pthread_cond_destroy(&client->changed);
    pthread_mutex_destroy(&client->mutex);
    free(client);
}

/* ---- messages ---- */

bool view_client_send(view_client* client, const char* text) {
    return mg_websocket_client_write(client->connection, MG_WEBSOCKET_OPCODE_TEXT, text, strlen(text)) > 0;
}

/* The first frame after `after` that fits. Under the mutex. */
static bool find(const view_client* client, uint32_t after, uint32_t revision, bool final, view_arrival* out) {
    if (client->frames > RING && after < client->frames - RING) after = client->frames - RING;
    for (uint32_t i = after; i < client->frames; ++i) {
        const view_arrival* arrival = &client->arrivals[i % RING];
        if (arrival->revision < revision || (final && !arrival->final)) continue;
        *out = *arrival;
        return true;
    }
    return false;
}

bool view_client_wait(view_client* client, uint32_t after, uint32_t revision, bool final, double timeout,
                      view_arrival* out) {
    const struct timespec until = time_in(timeout);
    pthread_mutex_lock(&client->mutex);
    bool found = find(client, after, revision, final, out);
    while (!found && client->complaint[0] == '\0' && wait_until(client, &until))
        found = find(client, after, revision, final, out);
    pthread_mutex_unlock(&client->mutex);
    return found;
}

bool view_client_fetch_image(const view_client* client, const char* path) {
    char error[256], bytes[4096];
    struct mg_connection* connection = mg_download(
        "127.0.0.1", client->port, 0, error, sizeof error,
        "GET /image.exr?token=%s&channel=method HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n\r\n",
        client->token, client->port);
    if (connection == NULL) return false;
    bool written = mg_get_response_info(connection)->status_code == 200;
    FILE* file = written ? fopen(path, "wb") : NULL;
    int count = 0;
    while (file != NULL && (count = mg_read(connection, bytes, sizeof bytes)) > 0)
        fwrite(bytes, 1, (size_t)count, file);
    mg_close_connection(connection);
    written = file != NULL && count == 0 && ferror(file) == 0;
    return file != NULL && fclose(file) == 0 && written;
}

uint32_t view_client_frames(view_client* client) {
    pthread_mutex_lock(&client->mutex);
    const uint32_t frames = client->frames;
    pthread_mutex_unlock(&client->mutex);
    return frames;
}

uint32_t view_client_revision(view_client* client) {
    pthread_mutex_lock(&client->mutex);
    const uint32_t revision = client->revision;
    pthread_mutex_unlock(&client->mutex);
    return revision;
}

const char* view_client_complaint(view_client* client) {
    return client->complaint;
}

double view_client_status(view_client* client, const char* group, const char* key) {
    pthread_mutex_lock(&client->mutex);
    const json_t* value = json_object_get(json_object_get(client->status, group), key);
    const double number = json_is_number(value) ? json_number_value(value) : -1;
    pthread_mutex_unlock(&client->mutex);
    return number;
}

const json_t* view_client_document(const view_client* client) {
    return json_object_get(client->welcome, "document");
}
