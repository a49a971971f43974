#define _GNU_SOURCE
#include "cli/images/tev.h"

#include "base/kernel.h"
#include "image/image.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* Types of packets. A packet is its size in bytes (uint32), its type (uint8) and its contents; numbers are
 * little-endian, texts end in NUL. */
enum { CREATE_IMAGE = 4, UPDATE_IMAGE = 6 };

enum { CHANNELS = 3, HEAD_ROOM = 128, BAND_VALUES = 1 << 20, HOST_MAX = 255, PORT_MAX = 65535 };

static const double connect_seconds = 2, stalled_seconds = 5;

typedef struct packet {
    uint8_t* bytes;
    size_t size;
} packet;

static void put_byte(packet* to, uint8_t value) {
    to->bytes[to->size++] = value;
}

static void put_number(packet* to, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) put_byte(to, (uint8_t)(value >> (8 * i)));
}

static void put_text(packet* to, const char* text) {
    const size_t size = strlen(text) + 1;
    memcpy(to->bytes + to->size, text, size);
    to->size += size;
}

static void put_channel_names(packet* to) {
    static const char* const names[CHANNELS] = {"R", "G", "B"};
    put_number(to, CHANNELS, 4);
    for (int c = 0; c < CHANNELS; ++c) put_text(to, names[c]);
}

/* Begins a packet with room for the image's name, the head and some values. False without memory. */
static bool begin_packet(packet* to, const cli_tev* tev, int type, bool grab_focus, size_t values) {
    to->size = 0;
    to->bytes = malloc(HEAD_ROOM + strlen(tev->name) + values * sizeof(float));
    if (to->bytes == NULL) return false;
    put_number(to, 0, 4);
    put_byte(to, (uint8_t)type);
    put_byte(to, grab_focus);
    put_text(to, tev->name);
    return true;
}

/* Sends a packet and frees it. */
static bool send_packet(const cli_tev* tev, packet* from) {
    size_t sent = 0;
    const size_t size = from->size;
    from->size = 0;
    put_number(from, size, 4);
    while (sent < size) {
        const ssize_t count = send(tev->socket, from->bytes + sent, size - sent, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) break;
        sent += (size_t)count;
    }
    free(from->bytes);
    return sent == size;
}

static bool create_image(cli_tev* tev, int32_t width, int32_t height) {
    packet create;
    if (!begin_packet(&create, tev, CREATE_IMAGE, true, 0)) return false;
    put_number(&create, (uint64_t)width, 4);
    put_number(&create, (uint64_t)height, 4);
    put_channel_names(&create);
    tev->width = width;
    tev->height = height;
    return send_packet(tev, &create);
}

/* The pixels of an image: channel c of pixel i is planes[c][i * step]. */
typedef struct pixels {
    int32_t width, height;
    const float* planes[CHANNELS];
    size_t step;
} pixels;

/* Rows of all channels, one channel after another. */
static bool update_rows(const cli_tev* tev, const pixels* image, int32_t first, int32_t rows) {
    packet update;
    const size_t begin = (size_t)first * (size_t)tev->width, count = (size_t)rows * (size_t)tev->width;
    if (!begin_packet(&update, tev, UPDATE_IMAGE, false, CHANNELS * count)) return false;
    put_channel_names(&update);
    put_number(&update, 0, 4);
    put_number(&update, (uint64_t)first, 4);
    put_number(&update, (uint64_t)tev->width, 4);
    put_number(&update, (uint64_t)rows, 4);
    for (size_t c = 0; c < CHANNELS; ++c) put_number(&update, c * count, 8); /* offsets in values */
    for (int c = 0; c < CHANNELS; ++c) put_number(&update, 1, 8);            /* strides in values */
    for (int c = 0; c < CHANNELS; ++c)
        for (size_t i = 0; i < count; ++i) {
            const float value = image->planes[c][(begin + i) * image->step];
            put_number(&update, ty_bits_from_float(value), 4);
        }
    return send_packet(tev, &update);
}

static bool send_image(cli_tev* tev, const pixels* image) {
    const int32_t width = image->width, height = image->height;
    const int32_t band = BAND_VALUES / width > 0 ? BAND_VALUES / width : 1;
    if ((width != tev->width || height != tev->height) && !create_image(tev, width, height)) return false;
    for (int32_t y = 0; y < height; y += band)
        if (!update_rows(tev, image, y, y + band < height ? band : height - y)) return false;
    return true;
}

/* tev sends nothing, but the end of the connection. */
static bool is_gone(const cli_tev* tev) {
    char byte;
    return recv(tev->socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

static void show(cli_tev* tev, const pixels* image) {
    if (!is_gone(tev) && send_image(tev, image)) return;
    cli_tev_close(tev);
    if (!tev->session->common.quiet)
        cli_progress_warn(&tev->session->progress, "tev is gone: the image is not shown there any more");
}

bool cli_tev_show(void* user, const ty_image* image) {
    cli_tev* tev = user;
    pixels all = {.width = ty_image_width(image), .height = ty_image_height(image), .step = 1};
    if (tev->socket > 0 && ty_image_rgb_planes(image, all.planes)) show(tev, &all);
    return true;
}

void cli_tev_show_pixels(cli_tev* tev, const float* rgb, int32_t width, int32_t height) {
    const pixels all = {width, height, {rgb, rgb + 1, rgb + 2}, CHANNELS};
    if (tev->socket > 0) show(tev, &all);
}

/* The parts of HOST:PORT and [IPV6]:PORT. */
static bool split_address(const char* address, char host[HOST_MAX + 1], const char** port) {
    const char* colon = strrchr(address, ':');
    if (colon == NULL) return false;
    size_t size = (size_t)(colon - address);
    const bool bracketed = size > 2 && address[0] == '[' && colon[-1] == ']';
    if (bracketed) {
        ++address;
        size -= 2;
    }
    char* end;
    const long number = colon[1] >= '0' && colon[1] <= '9' ? strtol(colon + 1, &end, 10) : 0;
    if (size < 1 || size > HOST_MAX || number < 1 || number > PORT_MAX || *end != 0) return false;
    memcpy(host, address, size);
    host[size] = 0;
    *port = colon + 1;
    return bracketed || strchr(host, ':') == NULL;
}

int cli_tev_check_address(const char* command, const char* address) {
    char host[HOST_MAX + 1];
    const char* port;
    if (split_address(address, host, &port)) return CLI_GO;
    return cli_usage_error(command, "--tev: '%s' is not HOST:PORT, such as 127.0.0.1:14158", address);
}

/* Waits until a socket is connected. Returns an errno. */
static int wait_connected(int socket, double until) {
    for (;;) {
        const double left = until - cli_wall_seconds();
        struct pollfd wait = {.fd = socket, .events = POLLOUT};
        const int ready = poll(&wait, 1, left > 0 ? (int)(1e3 * left) + 1 : 0);
        if (ready < 0 && errno == EINTR) continue;
        if (ready < 0) return errno;
        if (ready == 0) return ETIMEDOUT;
        int error = 0;
        socklen_t size = sizeof error;
        return getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
    }
}

/* Connects to one of a host's addresses. Returns an errno, and the socket. */
static int connect_to(const struct addrinfo* at, double until, int* out) {
    const struct timeval stalled = {.tv_sec = (time_t)stalled_seconds};
    const int made = socket(at->ai_family, at->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, at->ai_protocol);
    if (made < 0) return errno;
    int error = connect(made, at->ai_addr, at->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) error = wait_connected(made, until);
    if (error == 0 &&
        (fcntl(made, F_SETFL, 0) < 0 || setsockopt(made, SOL_SOCKET, SO_SNDTIMEO, &stalled, sizeof stalled) < 0))
        error = errno;
    if (error != 0)
        close(made);
    else
        *out = made;
    return error;
}

int cli_tev_open(cli_tev* tev, cli_session* session, const char* address, const char* name) {
    const struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICSERV};
    const double until = cli_wall_seconds() + connect_seconds;
    char host[HOST_MAX + 1];
    const char* port;
    struct addrinfo* found;
    *tev = (cli_tev){.session = session, .address = address, .name = name};
    if (!split_address(address, host, &port)) return cli_fail(CLI_FAILED, "--tev %s: not HOST:PORT", address);
    const int unknown = getaddrinfo(host, port, &hints, &found);
    if (unknown != 0) return cli_fail(CLI_FAILED, "--tev %s: %s", address, gai_strerror(unknown));
    int error = 0;
    for (const struct addrinfo* at = found; at != NULL && tev->socket <= 0; at = at->ai_next)
        error = connect_to(at, until, &tev->socket);
    freeaddrinfo(found);
    if (tev->socket > 0) return CLI_GO;
    return cli_fail(CLI_FAILED, "--tev %s: %s; is tev running there?", address, strerror(error));
}

void cli_tev_close(cli_tev* tev) {
    if (tev->socket > 0) close(tev->socket);
    tev->socket = 0;
}
