/* Programs as processes of their own, whose crash or endless loop harms no other. */
#define _GNU_SOURCE
#include "figures/process.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* In the child: messages go to a pipe, and the processor time is bounded. */
static void become(const char* const* list, int32_t seconds_max, int messages) {
    const int nothing = open("/dev/null", O_RDWR);
    const struct rlimit seconds = {(rlim_t)seconds_max, (rlim_t)seconds_max + 5};
    setrlimit(RLIMIT_CPU, &seconds);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(messages, STDERR_FILENO);
    execvp(list[0], (char* const*)(uintptr_t)list);
    _exit(127);
}

/* Reads all of a pipe; the first line is kept. */
static void read_words(int from, char words[FIGURE_WORDS_SIZE]) {
    static const char program[] = "tyndall: ";
    FILE* file = fdopen(from, "r");
    char line[1024] = "";
    words[0] = '\0';
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        if (words[0] != '\0') continue;
        const size_t skipped = strncmp(line, program, sizeof program - 1) == 0 ? sizeof program - 1 : 0;
        line[strcspn(line, "\n")] = '\0';
        snprintf(words, FIGURE_WORDS_SIZE, "%.*s", FIGURE_WORDS_SIZE - 1, line + skipped);
    }
    if (file != NULL)
        fclose(file);
    else
        close(from);
}

static double seconds_of(const struct timeval* time) {
    return (double)time->tv_sec + 1e-6 * (double)time->tv_usec;
}

ty_result figure_run_process(const char* const* list, int32_t seconds_max, figure_process* out) {
    int pipes[2], status = 0;
    struct rusage used;
    if (pipe(pipes) != 0) return TY_ERROR_MEMORY;
    const pid_t child = fork();
    if (child == 0) {
        close(pipes[0]);
        become(list, seconds_max, pipes[1]);
    }
    close(pipes[1]);
    read_words(pipes[0], out->words);
    if (child < 0 || wait4(child, &status, 0, &used) != child) return TY_ERROR_MEMORY;
    out->status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    out->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    out->seconds = seconds_of(&used.ru_utime) + seconds_of(&used.ru_stime);
    return figure_check_interrupt();
}
