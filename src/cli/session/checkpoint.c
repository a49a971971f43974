/* --resume: the state of a render in a file beside its image. */
#define _GNU_SOURCE
#include "cli/session/checkpoint.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* True for STATE.PID-N.tmp, the name under which a process writes a state, if no such process runs. */
static bool is_left_behind(const char* name, const char* state) {
    const size_t length = strlen(state);
    long process = 0;
    int number = 0, end = 0;
    if (strncmp(name, state, length) != 0) return false;
    if (sscanf(name + length, ".%ld-%d.tmp%n", &process, &number, &end) != 2 || end == 0) return false;
    return name[length + (size_t)end] == '\0' && process > 0 && kill((pid_t)process, 0) != 0 && errno == ESRCH;
}

/* States are large, and each kill while one is written leaves one. */
static void remove_left_behind(const char* path) {
    const char* slash = strrchr(path, '/');
    char* folder = slash == NULL ? strdup(".") : strndup(path, (size_t)(slash - path) + 1);
    DIR* directory = folder != NULL ? opendir(folder) : NULL;
    const struct dirent* entry;
    while (directory != NULL && (entry = readdir(directory)) != NULL)
        if (is_left_behind(entry->d_name, slash == NULL ? path : slash + 1))
            unlinkat(dirfd(directory), entry->d_name, 0);
    if (directory != NULL) closedir(directory);
    free(folder);
}

int cli_checkpoint_open(cli_checkpoint* checkpoint, cli_session* session, const char* output) {
    *checkpoint = (cli_checkpoint){.session = session};
    if (asprintf(&checkpoint->path, "%s.state", output) < 0) {
        checkpoint->path = NULL;
        return cli_fail(CLI_FAILED, "not enough memory");
    }
    int status = cli_check_output(session->command, checkpoint->path);
    if (status == CLI_GO) status = cli_lock_take(&checkpoint->lock, session, checkpoint->path);
    if (status != CLI_GO) return status;
    remove_left_behind(checkpoint->path);
    if (access(checkpoint->path, F_OK) != 0 && errno == ENOENT) return CLI_GO;
    const ty_result result =
        ty_bytes_read(session->context, checkpoint->path, PTRDIFF_MAX, &checkpoint->bytes, &checkpoint->size);
    return result == TY_OK ? CLI_GO : cli_fail_reading(session, result);
}

void cli_checkpoint_close(cli_checkpoint* checkpoint) {
    ty_bytes_destroy(checkpoint->session->context, checkpoint->bytes, checkpoint->size);
    cli_lock_release(&checkpoint->lock);
    free(checkpoint->path);
}

/* Also with -q: who asked for a state counts on it. */
static void warn_once(cli_checkpoint* checkpoint, const char* message) {
    if (!checkpoint->warned) cli_progress_warn(&checkpoint->session->progress, message);
    checkpoint->warned = true;
}

bool cli_checkpoint_write(void* user, const void* state, size_t size) {
    cli_checkpoint* checkpoint = user;
    if (ty_bytes_write(checkpoint->session->context, checkpoint->path, state, size) == TY_OK)
        checkpoint->written = size;
    else
        warn_once(checkpoint, ty_take_error(checkpoint->session->context));
    return true;
}

/* Appends to a file that still has the size that this process gave it; sets errno on failure. */
static bool append(const char* path, uint64_t size, const uint8_t* bytes, size_t count) {
    struct stat status;
    const int descriptor = open(path, O_WRONLY | O_APPEND | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) return false;
    bool good = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && (uint64_t)status.st_size == size;
    int reason = good ? 0 : ESTALE;
    while (good && count > 0) {
        const ssize_t done = write(descriptor, bytes, count);
        if (done < 0 && errno == EINTR) continue;
        good = done > 0;
        if (!good) reason = done < 0 ? errno : EIO;
        if (good) bytes += done;
        if (good) count -= (size_t)done;
    }
    if (close(descriptor) != 0 && good) {
        good = false;
        reason = errno;
    }
    errno = reason;
    return good;
}

bool cli_checkpoint_append(void* user, const void* changes, size_t size) {
    cli_checkpoint* checkpoint = user;
    if (checkpoint->written == 0) return false;
    if (append(checkpoint->path, checkpoint->written, changes, size)) {
        checkpoint->written += size;
        return true;
    }
    char message[512];
    snprintf(message, sizeof message, "cannot write %.400s: %s", checkpoint->path, strerror(errno));
    checkpoint->written = 0;
    warn_once(checkpoint, message);
    return false;
}
