/* Programs and modules that come with this program. */
#define _GNU_SOURCE
#include "cli/session/session.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

bool cli_find_beside(const char* name, int mode, char* out, size_t size) {
    static const char* const folders[] = {".", TYNDALL_TOOLS_FOLDER};
    enum { PATH_SIZE = 4096 };
    char own[PATH_SIZE];
    const ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length <= 0) return false;
    own[length] = '\0';
    *strrchr(own, '/') = '\0';
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; ++i) {
        const int needed = snprintf(out, size, "%s/%s/%s", own, folders[i], name);
        if (needed > 0 && (size_t)needed < size && access(out, mode) == 0) return true;
    }
    return false;
}
