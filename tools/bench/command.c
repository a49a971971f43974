/* The program tyndall, for what runs it as a process of its own. */
#define _GNU_SOURCE
#include "bench/command.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

void bench_find_command(char out[BENCH_COMMAND_SIZE]) {
    static const char* const places[] = {"tyndall", "../../bin/tyndall", "../../../bin/tyndall"};
    char own[BENCH_COMMAND_SIZE - 64];
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    own[length > 0 ? length : 0] = '\0';
    char* slash = strrchr(own, '/');
    if (slash != NULL) *slash = '\0';
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        snprintf(out, BENCH_COMMAND_SIZE, "%s/%s", own, places[i]);
        if (access(out, X_OK) == 0) return;
    }
    snprintf(out, BENCH_COMMAND_SIZE, "tyndall");
}
