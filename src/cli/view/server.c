#define _GNU_SOURCE
#include "cli/view/server.h"

#include "cli/view/access.h"
#include "cli/view/clients.h"
#include "cli/view/inbox.h"
#include "cli/view/page_files.h"

#include <arpa/inet.h>
#include <civetweb.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { OPCODE = 0x0f, FINAL = 0x80, LENGTH_16 = 126, LENGTH_64 = 127 };

struct view_server {
    view_server_def def;
    char token[VIEW_TOKEN_SIZE], cookie[32], headers[640], log[256];
    atomic_int port; /* 0 until the server is ready */
    atomic_bool stopped;
    struct mg_context* context;
    view_clients* clients;
};

/* The state of a WebSocket. */
typedef struct visit {
    view_inbox inbox; /* client 0: there was no place */
    bool accepted;    /* it is listened to */
} visit;

/* Answers to requests. */

static view_server* server_of(const struct mg_connection* connection) {
    return mg_get_user_data(mg_get_context(connection));
}

/* Sends a whole answer; more are further headers, each with its line end. Returns the status. */
static int answer(struct mg_connection* connection, int status, const char* type, const char* more, const void* body,
                  size_t size) {
    const char* method = mg_get_request_info(connection)->request_method;
    mg_printf(connection, "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\nConnection: close\r\n%s%s\r\n",
              status, mg_get_response_code_text(connection, status), type, size, server_of(connection)->headers, more);
    if (method == NULL || strcmp(method, "HEAD") != 0) mg_write(connection, body, size);
    return status;
}

static int refuse(struct mg_connection* connection, int status, const char* reason) {
    char line[256];
    const int size = snprintf(line, sizeof line, "%.250s\n", reason);
    return answer(connection, status, "text/plain; charset=utf-8", "", line, (size_t)size);
}

static int answer_error(struct mg_connection* connection, int status, const char* message) {
    refuse(connection, status, message);
    return 0;
}

/* A token in the address counts alone; a page that is loaded again may have one in its cookie. */
static bool has_token(const struct mg_connection* connection) {
    const view_server* server = server_of(connection);
    const char* query = mg_get_request_info(connection)->query_string;
    const char* cookies = mg_get_header(connection, "Cookie");
    char token[VIEW_TOKEN_SIZE + 1] = "";
    int found = query != NULL ? mg_get_var(query, strlen(query), "token", token, sizeof token) : -1;
    if (found == -1 && cookies != NULL) found = mg_get_cookie(cookies, server->cookie, token, sizeof token);
    return found >= 0 && view_access_is_token(token, server->token);
}

static const char* type_of(const char* name) {
    static const char* const types[][2] = {{".html", "text/html; charset=utf-8"},
                                           {".css", "text/css; charset=utf-8"},
                                           {".js", "text/javascript; charset=utf-8"},
                                           {".svg", "image/svg+xml"}};
    const char* extension = strrchr(name, '.');
    for (size_t i = 0; extension != NULL && i < sizeof types / sizeof types[0]; ++i)
        if (strcmp(extension, types[i][0]) == 0) return types[i][1];
    return "application/octet-stream";
}

static int answer_file(struct mg_connection* connection, const char* name, const char* more) {
    for (const view_page_file* file = view_page_files; file->name != NULL; ++file)
        if (strcmp(file->name, name) == 0) return answer(connection, 200, type_of(name), more, file->text, file->size);
    return refuse(connection, 404, "there is no such page");
}

static int answer_page(struct mg_connection* connection) {
    const view_server* server = server_of(connection);
    char cookie[160];
    snprintf(cookie, sizeof cookie, "Set-Cookie: %s=%s; HttpOnly; SameSite=Strict; Path=/\r\n", server->cookie,
             server->token);
    return answer_file(connection, "index.html", cookie);
}

static int answer_image(struct mg_connection* connection) {
    static const char* const names[VIEW_CHANNEL_COUNT] = {"method", "path"};
    const view_server* server = server_of(connection);
    const char* query = mg_get_request_info(connection)->query_string;
    char name[16] = "";
    int channel = 0;
    if (query != NULL) mg_get_var(query, strlen(query), "channel", name, sizeof name);
    while (channel < VIEW_CHANNEL_COUNT && strcmp(name, names[channel]) != 0) ++channel;
    if (channel == VIEW_CHANNEL_COUNT) return refuse(connection, 404, "channel is method or path");
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (!server->def.image(server->def.user, (view_channel)channel, &bytes, &size))
        return refuse(connection, 404, "there is no image yet");
    const int status = answer(connection, 200, "image/x-exr", "", bytes, size);
    free(bytes);
    return status;
}

/* Every request comes here first. Returns 0 for a WebSocket, which the library goes on with, else the status that was
 * answered. */
static int answer_request(struct mg_connection* connection) {
    const int32_t port = atomic_load(&server_of(connection)->port);
    const struct mg_request_info* info = mg_get_request_info(connection);
    const char* path = info->local_uri != NULL ? info->local_uri : "";
    if (!view_access_is_host(mg_get_header(connection, "Host"), port))
        return refuse(connection, 403, "the Host is not that of this server");
    if (!view_access_is_origin(mg_get_header(connection, "Origin"), port))
        return refuse(connection, 403, "the Origin is not that of this server");
    if (strcmp(info->request_method, "GET") != 0 && strcmp(info->request_method, "HEAD") != 0)
        return refuse(connection, 405, "the methods are GET and HEAD");
    const bool page = strcmp(path, "/") == 0, live = strcmp(path, "/live") == 0;
    const bool image = strcmp(path, "/image.exr") == 0;
    if (!page && !live && !image)
        return strcmp(path, "/index.html") != 0 && path[0] == '/' ? answer_file(connection, path + 1, "")
                                                                  : refuse(connection, 404, "there is no such page");
    if (!has_token(connection))
        return refuse(connection, 403, "the token is missing or wrong; open the address that tyndall view printed");
    if (live) return 0;
    return page ? answer_page(connection) : answer_image(connection);
}

/* WebSockets. */

static bool write_text(void* connection, const char* text, size_t size) {
    return mg_websocket_write(connection, MG_WEBSOCKET_OPCODE_TEXT, text, size) == (int)size;
}

/* The introduction of a message (RFC 6455, section 5.2). Returns its size. */
static size_t put_introduction(uint8_t* to, int opcode, size_t size) {
    to[0] = (uint8_t)(FINAL | opcode);
    const bool wide = size > UINT16_MAX;
    const int bytes = size < LENGTH_16 ? 0 : wide ? 8 : 2;
    to[1] = (uint8_t)(bytes == 0 ? (int)size : wide ? LENGTH_64 : LENGTH_16);
    for (int i = 0; i < bytes; ++i) to[2 + i] = (uint8_t)((uint64_t)size >> (8 * (bytes - 1 - i)));
    return 2 + (size_t)bytes;
}

static bool write_binary(void* connection, const void* head, size_t head_size, const void* body, size_t body_size) {
    uint8_t first[10 + VIEW_HEADER_BYTES];
    size_t size = put_introduction(first, MG_WEBSOCKET_OPCODE_BINARY, head_size + body_size);
    memcpy(first + size, head, head_size);
    size += head_size;
    mg_lock_connection(connection);
    const bool done =
        mg_write(connection, first, size) == (int)size && mg_write(connection, body, body_size) == (int)body_size;
    mg_unlock_connection(connection);
    return done;
}

static bool write_goodbye(void* connection, int code, const char* reason) {
    char bytes[2 + 123] = {(char)(code >> 8), (char)code};
    const int length = snprintf(bytes + 2, sizeof bytes - 2, "%s", reason);
    return mg_websocket_write(connection, MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE, bytes, 2 + (size_t)length) > 0;
}

static const view_wire wire = {write_text, write_binary, write_goodbye};

static void on_ready(struct mg_connection* connection, void* user) {
    static const char full[] = "{\"type\": \"error\", \"text\": \"all places are taken; close another page\"}";
    view_server* server = user;
    visit* state = calloc(1, sizeof *state);
    const int32_t id = state != NULL ? view_clients_add(server->clients, connection) : 0;
    mg_set_user_connection_data(connection, state);
    if (id == 0) {
        write_text(connection, full, sizeof full - 1);
        write_goodbye(connection, VIEW_BYE_FULL, "all places are taken");
        return;
    }
    state->inbox = (view_inbox){.def = &server->def, .clients = server->clients, .client = id};
    state->accepted = server->def.connected(server->def.user, id);
    state->accepted = view_clients_start(server->clients, id, state->accepted) && state->accepted;
}

static void on_close(const struct mg_connection* connection, void* user) {
    view_server* server = user;
    visit* state = mg_get_user_connection_data(connection);
    if (state == NULL) return;
    view_clients_remove(server->clients, state->inbox.client);
    view_inbox_clear(&state->inbox);
    free(state);
}

/* Returns 0 to end the connection. */
static int on_data(struct mg_connection* connection, int flags, char* data, size_t size, void* user) {
    view_server* server = user;
    visit* state = mg_get_user_connection_data(connection);
    const int opcode = flags & OPCODE;
    if (opcode == MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE) { /* the answer is the last frame (RFC 6455, section 5.5.1) */
        const bool refused = state == NULL || state->inbox.client == 0;
        if (!refused && !view_clients_remove(server->clients, state->inbox.client))
            mg_websocket_write(connection, opcode, data, size < 2 ? 0 : 2);
        return 0;
    }
    if (state == NULL || state->inbox.client == 0 || !view_clients_alive(server->clients, state->inbox.client))
        return 0;
    if (!state->accepted) return 1;
    const view_verdict verdict = view_inbox_take(&state->inbox, opcode, (flags & FINAL) != 0, data, size);
    if (verdict == VIEW_TOO_BIG)
        view_clients_end(server->clients, state->inbox.client, VIEW_BYE_TOO_BIG, "a message has at most 1 MB");
    return verdict == VIEW_GO_ON;
}

/* Start and end. */

/* Keeps what the library would print: at the start it tells why it cannot listen. */
static int keep_log(const struct mg_connection* connection, const char* message) {
    view_server* server = server_of(connection);
    if (server != NULL && atomic_load(&server->port) == 0 && server->log[0] == 0)
        snprintf(server->log, sizeof server->log, "%s", message);
    return 1;
}

static void make_headers(view_server* server, int port) {
    snprintf(server->cookie, sizeof server->cookie, "tyndall_%d", port);
    snprintf(server->headers, sizeof server->headers,
             "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
             "Cross-Origin-Resource-Policy: same-origin\r\n"
             "Content-Security-Policy: default-src 'self'; connect-src 'self' ws://127.0.0.1:%d ws://localhost:%d; "
             "img-src 'self' blob: data:; style-src 'self'; frame-ancestors 'none'; base-uri 'none'; "
             "form-action 'none'\r\n",
             port, port);
}

/* The library's threads are to receive no signals: their waits would end with an error. */
static struct mg_context* start_context(view_server* server) {
    char address[32];
    snprintf(address, sizeof address, "127.0.0.1:%d", (int)server->def.port);
    const char* options[] = {"listening_ports",
                             address,
                             "num_threads",
                             "24",
                             "tcp_nodelay",
                             "1",
                             "request_timeout_ms",
                             "10000",
                             "websocket_timeout_ms",
                             "3000",
                             "enable_websocket_ping_pong",
                             "yes",
                             "enable_auth_domain_check",
                             "no",
                             "enable_directory_listing",
                             "no",
                             NULL};
    const struct mg_callbacks callbacks = {
        .begin_request = answer_request, .http_error = answer_error, .log_message = keep_log};
    struct mg_init_data init = {&callbacks, server, options};
    struct mg_error_data error = {0};
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    struct mg_context* context = mg_start2(&init, &error);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return context;
}

static view_server* fail_start(view_server* server) {
    view_clients_destroy(server->clients);
    free(server);
    return NULL;
}

view_server* view_server_start(const view_server_def* def, char* message, size_t size) {
    view_server* server = calloc(1, sizeof *server);
    struct mg_server_port port;
    if (server == NULL || (server->clients = view_clients_create(&wire)) == NULL) {
        free(server);
        snprintf(message, size, "out of memory");
        return NULL;
    }
    server->def = *def;
    if (!view_access_make_token(server->token)) {
        snprintf(message, size, "the system has no random numbers for a token");
        return fail_start(server);
    }
    mg_init_library(0);
    server->context = start_context(server);
    if (server->context == NULL || mg_get_server_ports(server->context, 1, &port) != 1) {
        const char* reason = strrchr(server->log, '(');
        snprintf(message, size, "cannot listen on 127.0.0.1:%d: %.*s", (int)def->port,
                 reason != NULL ? (int)strcspn(reason + 1, ")") : 27,
                 reason != NULL ? reason + 1 : "the server does not start");
        mg_stop(server->context);
        mg_exit_library();
        return fail_start(server);
    }
    make_headers(server, port.port);
    mg_set_websocket_handler(server->context, "/live$", NULL, on_ready, on_data, on_close, server);
    atomic_store(&server->port, port.port);
    return server;
}

/* The library looks at its listening socket every two seconds to see whether it is to end; connections wake it. */
static void* wake_listener(void* user) {
    view_server* server = user;
    const struct timespec pause = {.tv_nsec = 10 * 1000 * 1000};
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                                        .sin_port = htons((uint16_t)atomic_load(&server->port))};
    while (!atomic_load(&server->stopped)) {
        const int client = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        nanosleep(&pause, NULL);
        if (client < 0) continue;
        connect(client, (const struct sockaddr*)&address, sizeof address);
        close(client);
    }
    return NULL;
}

void view_server_stop(view_server* server) {
    pthread_t waker;
    if (server == NULL) return;
    view_clients_close(server->clients, 0.5);
    const bool wakes = pthread_create(&waker, NULL, wake_listener, server) == 0;
    mg_stop(server->context);
    atomic_store(&server->stopped, true);
    if (wakes) pthread_join(waker, NULL);
    mg_exit_library();
    view_clients_destroy(server->clients);
    free(server);
}

int32_t view_server_port(const view_server* server) {
    return atomic_load(&server->port);
}

const char* view_server_token(const view_server* server) {
    return server->token;
}

int32_t view_server_clients(const view_server* server) {
    return view_clients_count(server->clients);
}

void view_server_show(view_server* server, const view_frame* frame) {
    const view_codec codec = !server->def.remote ? VIEW_CODEC_HALF
                             : frame->moving     ? VIEW_CODEC_JPEG
                                                 : VIEW_CODEC_DEFLATE;
    view_shared_frame* shared = view_shared_frame_create(frame, codec);
    if (shared != NULL) view_clients_show(server->clients, frame->channel, shared);
}

void view_server_tell(view_server* server, view_slot slot, const char* text) {
    view_clients_tell(server->clients, slot, text);
}

void view_server_send(view_server* server, int32_t client, const char* text) {
    view_clients_send(server->clients, client, text);
}
