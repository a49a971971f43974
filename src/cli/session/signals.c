/* Signals and standard streams: interruption by the user, closed streams, and what a terminal or shell sends. */
#define _GNU_SOURCE
#include "cli/session/signals.h"
#include "cli/session/terminate.h"
#include "io/file.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

static const struct {
    int number;
    const char* name;
} caught[] = {{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}};

enum { CAUGHT_COUNT = sizeof caught / sizeof caught[0], STATUS_BASE = 128 };

/* A handler may run in any thread, and all of them ask: lock-free atomics, which a handler may use. */
static atomic_int interrupt; /* number of the first signal; 0: none */
static atomic_bool ends_at_once, silent;
static atomic_bool ending; /* a handler is about to end the program */
static _Atomic(const char*) remove_path;

static const char* name_of(int number) {
    for (int i = 0; i < CAUGHT_COUNT; ++i)
        if (caught[i].number == number) return caught[i].name;
    return caught[0].name;
}

/* Only calls that a signal handler may make. */
static void end_at_once(int number) {
    atomic_store(&ending, true);
    const char* path = atomic_load(&remove_path);
    const char* const parts[] = {"tyndall: interrupted by ", name_of(number), "\n"};
    if (path != NULL) unlink(path);
    ty_remove_unfinished_outputs();
    for (int i = 0; i < 3 && !atomic_load(&silent); ++i)
        if (write(STDERR_FILENO, parts[i], strlen(parts[i])) < 0) break;
    _exit(STATUS_BASE + number);
}

static void on_interrupt(int number) {
    const int saved = errno;
    int none = 0;
    if (atomic_load(&ends_at_once) || !atomic_compare_exchange_strong(&interrupt, &none, number)) end_at_once(number);
    errno = saved;
}

/* Opened the wrong way round, so that a program that needs the stream fails as it would with a closed one. */
static void open_closed_streams(void) {
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
        if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
        const int opened = open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);
        if (opened >= 0 && opened != descriptor) close(opened);
    }
}

void cli_start_program(void) {
    const struct sigaction ignore = {.sa_handler = SIG_IGN};
    open_closed_streams();
    cli_catch_termination();
    sigaction(SIGPIPE, &ignore, NULL);
    sigaction(SIGXFSZ, &ignore, NULL);
}

void cli_catch_interrupts(void) {
    struct sigaction action = {.sa_handler = on_interrupt, .sa_flags = SA_RESTART}, before;
    sigemptyset(&action.sa_mask);
    for (int i = 0; i < CAUGHT_COUNT; ++i) sigaddset(&action.sa_mask, caught[i].number);
    for (int i = 0; i < CAUGHT_COUNT; ++i) {
        const bool ignored = sigaction(caught[i].number, NULL, &before) == 0 && before.sa_handler == SIG_IGN;
        if (!ignored || caught[i].number != SIGHUP) sigaction(caught[i].number, &action, NULL);
    }
}

void cli_end_on_interrupt(bool at_once) {
    atomic_store(&ends_at_once, at_once);
}

void cli_silence_interrupts(void) {
    atomic_store(&silent, true);
}

bool cli_interrupted(void) {
    return atomic_load(&interrupt) != 0;
}

const char* cli_interrupt_name(void) {
    return name_of(atomic_load(&interrupt));
}

int cli_interrupt_status(void) {
    const int number = atomic_load(&interrupt);
    return STATUS_BASE + (number != 0 ? number : SIGINT);
}

void cli_remove_on_interrupt(const char* path) {
    atomic_store(&remove_path, path);
    while (path == NULL && atomic_load(&ending)) pause(); /* the caller frees the text that the handler uses */
}
