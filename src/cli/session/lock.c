/* Locks of states: one process at a time writes the state of a render or a bake. */
#define _GNU_SOURCE
#include "cli/session/lock.h"
#include "cli/session/signals.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* True if the path still names the open file: its last holder removes it, perhaps just before this process locks it. */
static bool is_named(int descriptor, const char* path) {
    struct stat open_file, named;
    return fstat(descriptor, &open_file) == 0 && stat(path, &named) == 0 && open_file.st_ino == named.st_ino &&
           open_file.st_dev == named.st_dev;
}

/* An open and locked descriptor, or -1 with the reason in errno. */
static int open_locked(const char* path) {
    for (;;) {
        const int descriptor = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
        if (descriptor < 0 && errno == EINTR) continue;
        if (descriptor < 0) return -1;
        if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
            const int reason = errno;
            if (reason != EWOULDBLOCK) unlink(path); /* this file system has no locks */
            close(descriptor);
            errno = reason;
            return -1;
        }
        if (is_named(descriptor, path)) return descriptor;
        close(descriptor);
    }
}

/* Process number of the holder as it wrote it; 0: unknown. */
static long read_holder(const char* path) {
    char text[24] = "";
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    const ssize_t length = descriptor >= 0 ? read(descriptor, text, sizeof text - 1) : 0;
    if (descriptor >= 0) close(descriptor);
    return length > 0 ? strtol(text, NULL, 10) : 0;
}

static void write_holder(int descriptor) {
    char text[24];
    const int length = snprintf(text, sizeof text, "%ld\n", (long)getpid());
    if (ftruncate(descriptor, 0) == 0 && write(descriptor, text, (size_t)length) < 0) errno = 0;
}

/* A lock that cannot be had for another reason than a holder. */
static int fail_locking(cli_session* session, const char* path, int reason) {
    if (reason != ENOLCK && reason != ENOTSUP && reason != ENOSYS && reason != EINVAL)
        return cli_fail(CLI_FAILED, "cannot write %s: %s", path, strerror(reason));
    cli_progress_warn(&session->progress, "this file system has no locks; let no other process use this state");
    return CLI_GO;
}

int cli_lock_take(cli_lock* lock, cli_session* session, const char* path) {
    char* name = NULL;
    *lock = (cli_lock){.descriptor = -1};
    if (asprintf(&name, "%s.lock", path) < 0) return cli_fail(CLI_FAILED, "not enough memory");
    lock->descriptor = open_locked(name);
    if (lock->descriptor >= 0) {
        write_holder(lock->descriptor);
        lock->path = name;
        cli_remove_on_interrupt(name);
        return CLI_GO;
    }
    int status = CLI_GO;
    const int reason = errno;
    const long holder = reason == EWOULDBLOCK ? read_holder(name) : 0;
    if (reason != EWOULDBLOCK)
        status = fail_locking(session, name, reason);
    else if (holder > 0)
        status = cli_fail(CLI_FAILED, "%s: in use by another tyndall, process %ld", path, holder);
    else
        status = cli_fail(CLI_FAILED, "%s: in use by another tyndall", path);
    free(name);
    return status;
}

void cli_lock_release(cli_lock* lock) {
    if (lock->path == NULL) return;
    cli_remove_on_interrupt(NULL);
    unlink(lock->path);
    close(lock->descriptor);
    free(lock->path);
    *lock = (cli_lock){.descriptor = -1};
}
