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
#include <stdint.h>
#include <string.h>
#include <unistd.h>

static const struct {
    int number;
    const char* name;
} caught[] = {{SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}};

/* The status of bad input, CLI_USAGE. */
enum { CLI_LOST_FILE = 2 };

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

/* ---- mapped files ---- */

enum { LINE_SIZE = 8192 };

/* Reads the next line of a file, cut to its room, by calls that a signal handler may make. */
static bool read_line(int descriptor, char line[LINE_SIZE]) {
    size_t length = 0;
    char letter = 0;
    while (letter != '\n' && read(descriptor, &letter, 1) == 1)
        if (length < LINE_SIZE - 1 && letter != '\n') line[length++] = letter;
    line[length] = '\0';
    return letter == '\n';
}

static uintptr_t hexadecimal(const char** text) {
    static const char digits[] = "0123456789abcdef";
    uintptr_t value = 0;
    const char* digit;
    for (; **text != '\0' && (digit = strchr(digits, **text)) != NULL; ++*text)
        value = value << 4 | (uintptr_t)(digit - digits);
    return value;
}

/* Name of the file that is mapped at an address; NULL for none. */
static const char* mapped_file(uintptr_t address, char line[LINE_SIZE]) {
    const int descriptor = open("/proc/self/maps", O_RDONLY | O_CLOEXEC);
    const char* name = NULL;
    while (descriptor >= 0 && name == NULL && read_line(descriptor, line)) {
        const char* text = line;
        const uintptr_t first = hexadecimal(&text);
        const uintptr_t last = *text == '-' ? (++text, hexadecimal(&text)) : 0;
        if (address >= first && address < last) name = strchr(line, '/');
    }
    if (descriptor >= 0) close(descriptor);
    return name;
}

static void on_lost_file(int number, siginfo_t* info, void* context) {
    char line[LINE_SIZE]; /* several threads may be here */
    const struct sigaction usual = {.sa_handler = SIG_DFL};
    const char* name = mapped_file((uintptr_t)info->si_addr, line);
    (void)context;
    if (name == NULL) {
        sigaction(number, &usual, NULL); /* the access is repeated, and ends the program */
        return;
    }
    while (atomic_exchange(&ending, true)) pause(); /* another thread ends the program */
    const char* const parts[] = {"tyndall: ", name, ": it became shorter while it was read, or its disk failed\n"};
    const char* path = atomic_load(&remove_path);
    if (path != NULL) unlink(path);
    ty_remove_unfinished_outputs();
    for (int i = 0; i < 3; ++i)
        if (write(STDERR_FILENO, parts[i], strlen(parts[i])) < 0) break;
    _exit(CLI_LOST_FILE);
}

void cli_catch_lost_files(void) {
    struct sigaction action = {.sa_sigaction = on_lost_file, .sa_flags = SA_SIGINFO};
    sigemptyset(&action.sa_mask);
    sigaction(SIGBUS, &action, NULL);
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
