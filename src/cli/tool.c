/* Commands that are separate programs, built from tools/: tyndall-bench and tyndall-figure. */
#define _GNU_SOURCE
#include "cli/commands.h"
#include "cli/session/session.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, ARGUMENTS_MAX = 1024 };

/* The path of a command's program: in the folder of this program, as in a build, or in the folder of an installation.
 * False: not found. */
static bool find_tool(const char* command, char out[PATH_SIZE]) {
    static const char* const folders[] = {".", TYNDALL_TOOLS_FOLDER};
    char own[PATH_SIZE];
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length <= 0) return false;
    own[length] = '\0';
    *strrchr(own, '/') = '\0';
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; ++i) {
        const int size = snprintf(out, PATH_SIZE, "%s/%s/tyndall-%s", own, folders[i], command);
        if (size < PATH_SIZE && access(out, X_OK) == 0) return true;
    }
    return false;
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
