#include "cli/view/access.h"

#include <stdio.h>
#include <string.h>
#include <sys/random.h>

enum { RANDOM_BYTES = (VIEW_TOKEN_SIZE - 1) / 2, HTTP_PORT = 80 };

bool view_access_make_token(char token[VIEW_TOKEN_SIZE]) {
    uint8_t bytes[RANDOM_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != RANDOM_BYTES) return false;
    for (int i = 0; i < RANDOM_BYTES; ++i) snprintf(token + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

bool view_access_is_token(const char* text, const char token[VIEW_TOKEN_SIZE]) {
    unsigned differences = 0;
    if (strlen(text) != VIEW_TOKEN_SIZE - 1) return false;
    for (int i = 0; i < VIEW_TOKEN_SIZE - 1; ++i) differences |= (unsigned)(text[i] ^ token[i]);
    return differences == 0;
}

/* True for "127.0.0.1:PORT" and "localhost:PORT"; without the port if that is allowed. */
static bool is_address(const char* text, int32_t port, bool portless) {
    static const char* const names[] = {"127.0.0.1", "localhost"};
    for (int i = 0; i < 2; ++i) {
        char address[32];
        snprintf(address, sizeof address, "%s:%d", names[i], (int)port);
        if (strcmp(text, address) == 0 || (portless && strcmp(text, names[i]) == 0)) return true;
    }
    return false;
}

bool view_access_is_host(const char* host, int32_t port) {
    return host != NULL && is_address(host, port, true); /* some clients that are no browsers leave the port out */
}

bool view_access_is_origin(const char* origin, int32_t port) {
    static const char scheme[] = "http://";
    if (origin == NULL) return true;
    return strncmp(origin, scheme, sizeof scheme - 1) == 0 &&
           is_address(origin + sizeof scheme - 1, port, port == HTTP_PORT);
}
