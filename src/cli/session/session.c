/* Sessions: contexts, messages, --stats, and common checks of commands. */
#define _GNU_SOURCE
#include "cli/session/session.h"
#include "cli/session/ranks.h"
#include "cli/text/text.h"
#include "cli/text/text_file.h"
#include "device/device.h"

#include <errno.h>
#include <poll.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

double cli_wall_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double cli_cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Errors are returned as results and printed by the callers. */
static void print_log(void* user, ty_log_level level, const char* text) {
    cli_session* session = user;
    if (level == TY_LOG_WARNING && !session->common.quiet) cli_progress_warn(&session->progress, text);
}

int cli_session_open(cli_session* session, const char* command, const cli_common* common) {
    *session = (cli_session){.command = command, .common = *common, .started = cli_wall_seconds()};
    session->progress = cli_progress_begin(common);
    if (common->stats != NULL) {
        const int status = cli_check_output(command, common->stats);
        if (status != CLI_GO) return status;
    }
    ty_context_def def = ty_default_context_def();
    def.threads = common->threads > 0 ? common->threads : TY_AUTO;
    def.log = print_log;
    def.log_user = session;
    def.device = common->device;
    def.resident_bytes = (int64_t)common->resident * 1000000;
    ty_device* device = NULL;
    const ty_result result = ty_context_create(&def, &session->context);
    if (result == TY_ERROR_ARGUMENT) return cli_usage_error(command, "%s", ty_take_error(NULL));
    if (result != TY_OK) return cli_fail(CLI_FAILED, "cannot start: %s", ty_result_text(result));
    if (ty_context_device(session->context, &device) != TY_OK)
        return cli_session_close(session, cli_fail(CLI_USAGE, "%s", ty_take_error(session->context)));
    cli_catch_interrupts();
    cli_catch_lost_files();
    return CLI_GO;
}

static double timeval_seconds(struct timeval time) {
    return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
}

static ty_result print_stats(ty_context* context, FILE* file, const void* user) {
    const cli_session* session = user;
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "version", ty_version());
    json_text(&json, "command", session->command);
    json_int(&json, "threads", ty_context_threads(context));
    if (session->stats != NULL) session->stats(&json, session->stats_user);
    if (session->comm != NULL) {
        const ty_comm_traffic traffic = ty_comm_get_traffic(session->comm);
        json_int(&json, "ranks", ty_comm_size(session->comm));
        json_int(&json, "messages", (int64_t)traffic.messages);
        json_int(&json, "message_bytes", (int64_t)traffic.bytes);
    }
    json_number(&json, "seconds", cli_wall_seconds() - session->started);
    json_number(&json, "cpu_seconds", timeval_seconds(usage.ru_utime) + timeval_seconds(usage.ru_stime));
    json_int(&json, "peak_memory_bytes", 1024 * (int64_t)usage.ru_maxrss);
    json_close_object(&json);
    return TY_OK;
}

int cli_session_write_stats(cli_session* session, const char* path, int status) {
    const ty_result result = cli_write_text_file(session->context, path, print_stats, session);
    return result == TY_OK ? status : cli_fail_running(session, result);
}

int cli_session_close(cli_session* session, int status) {
    cli_progress_clear(&session->progress);
    if (session->common.stats != NULL && session->context != NULL && (status == CLI_DONE || status == CLI_INTERRUPTED))
        status = cli_session_write_stats(session, session->common.stats, status);
    cli_ranks_close(session, status == CLI_INTERRUPTED ? cli_interrupt_status() : status);
    ty_context_destroy(session->context);
    return status;
}

static char last_message[1024];

int cli_fail(int status, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(last_message, sizeof last_message, format, arguments);
    va_end(arguments);
    cli_print_message(last_message);
    return status;
}

const char* cli_last_message(void) {
    return last_message;
}

static int fail_interrupted(void) {
    return cli_fail(CLI_INTERRUPTED, "interrupted by %s", cli_interrupt_name());
}

/* True if stdout is a pipe that nobody reads any more. */
static bool reader_is_gone(void) {
    struct pollfd output = {.fd = STDOUT_FILENO, .events = POLLOUT};
    return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

int cli_finish(int status) {
    static const char said[] = "interrupted";
    if (status == CLI_INTERRUPTED && strncmp(last_message, said, sizeof said - 1) != 0) fail_interrupted();
    errno = 0;
    const bool printed = fflush(stdout) == 0 && !ferror(stdout);
    const int reason = errno != 0 ? errno : EIO;
    if (status == CLI_INTERRUPTED) return cli_interrupt_status();
    if (printed || status != CLI_DONE) return status;
    if (reader_is_gone()) return CLI_NO_READER;
    return cli_fail(CLI_FAILED, "the result cannot be printed: %s", strerror(reason));
}

static int fail_with_message(cli_session* session, ty_result result, int file_status) {
    cli_progress_clear(&session->progress);
    const char* message = ty_take_error(session->context);
    if (message[0] == '\0') message = ty_result_text(result);
    switch (result) {
    case TY_CANCELLED: return fail_interrupted();
    case TY_ERROR_ARGUMENT:
    case TY_ERROR_INPUT:
    case TY_ERROR_UNSUPPORTED: return cli_fail(CLI_USAGE, "%s", message);
    case TY_ERROR_FILE: return cli_fail(file_status, "%s", message);
    default: return cli_fail(CLI_FAILED, "%s", message);
    }
}

int cli_fail_reading(cli_session* session, ty_result result) {
    return fail_with_message(session, result, CLI_USAGE);
}

int cli_fail_running(cli_session* session, ty_result result) {
    return fail_with_message(session, result, CLI_FAILED);
}

/* True for links of the system like /dev/stdout: an output would take their place, for all programs. */
static bool is_system_link(const char* folder, const char* path) {
    struct stat status;
    if (lstat(path, &status) != 0 || !S_ISLNK(status.st_mode)) return false;
    char* real = realpath(folder, NULL);
    const bool system = real != NULL && (strcmp(real, "/dev") == 0 || strncmp(real, "/proc/", 6) == 0);
    free(real);
    return system;
}

int cli_check_output(const char* command, const char* path) {
    const char* slash = strrchr(path, '/');
    char* folder = slash == NULL ? strdup(".") : slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
    if (folder == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    struct stat status;
    int result = CLI_GO;
    if (slash != NULL && slash[1] == '\0')
        result = cli_usage_error(command, "%s: is a folder; name a file", path);
    else if (stat(folder, &status) != 0)
        result = cli_usage_error(command, "%s: the folder %s: %s", path, folder, strerror(errno));
    else if (!S_ISDIR(status.st_mode))
        result = cli_usage_error(command, "%s: %s is not a folder", path, folder);
    else if (access(folder, W_OK | X_OK) != 0)
        result = cli_usage_error(command, "%s: the folder %s cannot be written to: %s", path, folder, strerror(errno));
    else if ((stat(path, &status) == 0 && !S_ISREG(status.st_mode)) || is_system_link(folder, path))
        result = cli_usage_error(command, "%s: is there already and is not a file", path);
    free(folder);
    return result;
}

int cli_make_folder(const char* command, const char* path) {
    struct stat status;
    if (mkdir(path, 0777) != 0 && errno != EEXIST)
        return cli_usage_error(command, "the folder %s cannot be made: %s", path, strerror(errno));
    if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode))
        return cli_usage_error(command, "%s is there already and is not a folder", path);
    if (access(path, W_OK | X_OK) != 0)
        return cli_usage_error(command, "the folder %s cannot be written to: %s", path, strerror(errno));
    return CLI_GO;
}

bool cli_make_temporary_folder(const char* use, char* out, size_t size) {
    const char* folder = getenv("TMPDIR");
    if (folder == NULL || folder[0] == '\0') folder = "/tmp";
    const int length = snprintf(out, size, "%s/tyndall-%s-XXXXXX", folder, use);
    if (length < 0 || (size_t)length >= size) {
        errno = ENAMETOOLONG;
        return false;
    }
    return mkdtemp(out) != NULL;
}

bool cli_has_extension(const char* path, const char* extension) {
    const size_t length = strlen(path), size = strlen(extension);
    return length > size && strcasecmp(path + length - size, extension) == 0;
}

void cli_format_bytes(double bytes, char out[24]) {
    static const char* const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    int unit = 0;
    while (bytes >= 1024 && unit < 4) {
        bytes /= 1024;
        ++unit;
    }
    snprintf(out, 24, unit == 0 ? "%.0f %s" : "%.1f %s", bytes, units[unit]);
}
