/* Access to the viewer's server: tokens, and the addresses that browsers name. */
#ifndef TY_CLI_VIEW_ACCESS_H
#define TY_CLI_VIEW_ACCESS_H

#include <stdbool.h>
#include <stdint.h>

#include "cli/view/server.h"

/* Makes a token of 32 hexadecimal digits from the system's random numbers. Returns false if there are none. */
bool view_access_make_token(char token[VIEW_TOKEN_SIZE]);
/* In a time that does not depend on how much of the text is right. */
bool view_access_is_token(const char* text, const char token[VIEW_TOKEN_SIZE]);
/* True for 127.0.0.1:PORT and localhost:PORT, with or without the port. NULL is none of them. */
bool view_access_is_host(const char* host, int32_t port);
/* True for NULL, since only browsers send an origin, and for http:// before one of the hosts. */
bool view_access_is_origin(const char* origin, int32_t port);

#endif
