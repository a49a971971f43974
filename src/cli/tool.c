/* Commands that are separate programs, built from tools/: tyndall-bench and tyndall-figure. */
#define _GNU_SOURCE
#include "cli/commands.h"
#include "cli/session/session.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, ARGUMENTS_MAX = 1024 };

static bool find_tool(const char* command, char out[PATH_SIZE]) {
    char name[64];
    snprintf(name, sizeof name, "tyndall-%s", command);
    return cli_find_beside(name, X_OK, out, PATH_SIZE);
}

bool cli_has_tool(const char* command) {
    char path[PATH_SIZE];
    return find_tool(command, path);
}

/* Replaces this process by the program; returns an exit status, after a message, only on failure. */
static int run_tool(const char* command, int count, char** arguments) {
    char path[PATH_SIZE];
    char* list[ARGUMENTS_MAX + 2] = {path};
    if (!find_tool(command, path))
        return cli_fail(CLI_USAGE, "tyndall-%s is not installed, which 'tyndall %s' runs", command, command);
    if (count > ARGUMENTS_MAX) return cli_usage_error(command, "there are more than %d arguments", ARGUMENTS_MAX);
    for (int i = 0; i < count; ++i) list[i + 1] = arguments[i];
    fflush(stdout);
    execv(path, list);
    return cli_fail(CLI_FAILED, "cannot run %s: %s", path, strerror(errno));
}

int cli_figure(int count, char** arguments) {
    return run_tool("figure", count, arguments);
}

int cli_bench(int count, char** arguments) {
    return run_tool("bench", count, arguments);
}
