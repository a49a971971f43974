/* Runs the viewer's server for test_view_protocol.py, which gives commands by stdin and reads lines on stdout.
 * usage: view_host PORT local|remote */
#define _GNU_SOURCE
#include "cli/view/page_files.h"
#include "cli/view/server.h"

#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const view_page_file view_page_files[] = {
    {"index.html", "<!doctype html><script src=a.js></script>", 41}, {"a.js", "let a = 1", 9}, {NULL, NULL, 0}};

static view_server* server;
static pthread_mutex_t starting = PTHREAD_MUTEX_INITIALIZER;

/* The server, for its own threads, which can run before view_server_start has returned. */
static view_server* started(void) {
    pthread_mutex_lock(&starting);
    view_server* found = server;
    pthread_mutex_unlock(&starting);
    return found;
}

static void receive(void* user, int32_t client, const char* text, size_t size) {
    char reply[160];
    (void)user;
    if (size == 5 && memcmp(text, "flood", 5) == 0)
        for (int i = 0; i < 100000; ++i) view_server_send(started(), client, "{\"type\": \"flood\"}");
    snprintf(reply, sizeof reply, "{\"type\": \"echo\", \"size\": %zu}", size);
    view_server_send(started(), client, reply);
}

static atomic_bool refuse_next;

static bool connected(void* user, int32_t client) {
    char text[64];
    const bool accepted = !atomic_exchange(&refuse_next, false);
    (void)user;
    snprintf(text, sizeof text, "{\"type\": \"%s\", \"client\": %d}", accepted ? "welcome" : "error", (int)client);
    view_server_send(started(), client, text);
    return accepted;
}

static bool image(void* user, view_channel channel, uint8_t** bytes, size_t* size) {
    (void)user;
    if (channel == VIEW_CHANNEL_PATH) return false;
    *size = 1000000;
    *bytes = malloc(*size);
    memset(*bytes, 'x', *size);
    return true;
}

/* Values that the test knows as well; the first ones are beyond half floats. */
static float pixel(size_t i) {
    static const float edges[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 65519, 6e-8f, -2e-8f, 1.00048828125f, -0.0f};
    return i < sizeof edges / sizeof edges[0] ? edges[i] : (float)((i * 37) % 1009) / 256 - 0.5f;
}

static void show(int channel, unsigned revision, int width, int height, bool moving) {
    const size_t count = 3 * (size_t)width * (size_t)height;
    float* rgb = malloc(count * sizeof *rgb);
    for (size_t i = 0; i < count; ++i) rgb[i] = pixel(i);
    const view_frame frame = {.channel = (view_channel)channel,
                              .revision = revision,
                              .width = width,
                              .height = height,
                              .full_width = 2 * width,
                              .full_height = 2 * height,
                              .rgb = rgb,
                              .spp = 1.5f,
                              .latency = 2.5f,
                              .exposure = -1,
                              .final = !moving,
                              .moving = moving};
    view_server_show(server, &frame);
    free(rgb);
}

static void obey(const char* line) {
    int channel, width, height, moving, count;
    unsigned revision;
    char text[256];
    if (sscanf(line, "show %d %u %d %d %d", &channel, &revision, &width, &height, &moving) == 5)
        show(channel, revision, width, height, moving != 0);
    else if (sscanf(line, "run %d %d %d", &count, &width, &height) == 3)
        for (int i = 1; i <= count; ++i) show(VIEW_CHANNEL_METHOD, (unsigned)i, width, height, false);
    else if (sscanf(line, "tell %d %255[^\n]", &channel, text) == 2)
        view_server_tell(server, (view_slot)channel, text);
    else if (strcmp(line, "refuse\n") == 0)
        refuse_next = true;
    printf("clients %d\n", (int)view_server_clients(server));
    fflush(stdout);
}

int main(int count, char** arguments) {
    char line[512];
    const bool remote = count > 2 && strcmp(arguments[2], "remote") == 0;
    const view_server_def def = {.port = count > 1 ? atoi(arguments[1]) : 0,
                                 .remote = remote,
                                 .receive = receive,
                                 .connected = connected,
                                 .image = image};
    struct sigaction action;
    pthread_mutex_lock(&starting);
    server = view_server_start(&def, line, sizeof line);
    pthread_mutex_unlock(&starting);
    if (server == NULL) {
        printf("error %s\n", line);
        return 1;
    }
    printf("port %d token %s\n", (int)view_server_port(server), view_server_token(server));
    fflush(stdout);
    while (fgets(line, sizeof line, stdin) != NULL) obey(line);
    view_server_stop(server);
    sigaction(SIGPIPE, NULL, &action);
    printf("stopped, SIGPIPE %s\n", action.sa_handler == SIG_IGN ? "ignored" : "not ignored");
    return 0;
}
