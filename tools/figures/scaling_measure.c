#define _GNU_SOURCE
#include "figures/scaling_measure.h"
#include "base/context.h"
#include "bench/command.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LIST_MAX = SCALING_ARGUMENTS_MAX + 24, SECONDS_MAX = 600, NAME_SIZE = FIGURE_PATH_SIZE + 64 };

/* A shell that appends the processor time of its rank to a file, as POSIX's times prints it, behind the command. */
static const char* const timed = "file=$1; shift; \"$@\"; status=$?; times > \"$file\"."
                                 "\"${OMPI_COMM_WORLD_RANK:-0}\"; exit $status";

ty_result scaling_open_folder(figure_run* run, char folder[FIGURE_PATH_SIZE]) {
    snprintf(folder, FIGURE_PATH_SIZE, "%s/scaling", run->options->folder);
    return cli_make_folder("figure", folder) == CLI_GO ? TY_OK : TY_ERROR_FILE;
}

static void times_path(const char* folder, int32_t rank, char out[NAME_SIZE]) {
    snprintf(out, NAME_SIZE, "%s/times.%d", folder, (int)rank);
}

/* The second line of POSIX's times has what the shell's children took, user and system: "1m2.340000s 0m0.120000s". */
static bool read_seconds(const char* folder, int32_t rank, double* out) {
    char path[NAME_SIZE];
    double minutes[4], seconds[4];
    times_path(folder, rank, path);
    FILE* file = fopen(path, "r");
    if (file == NULL) return false;
    const int count = fscanf(file, "%lfm%lfs %lfm%lfs %lfm%lfs %lfm%lfs", &minutes[0], &seconds[0], &minutes[1],
                             &seconds[1], &minutes[2], &seconds[2], &minutes[3], &seconds[3]);
    fclose(file);
    unlink(path);
    *out = 60 * (minutes[2] + minutes[3]) + seconds[2] + seconds[3];
    return count == 8;
}

static ty_result take_times(figure_run* run, const char* folder, scaling_run* out) {
    for (int32_t rank = 0; rank < out->ranks; ++rank) {
        double seconds;
        if (!read_seconds(folder, rank, &seconds))
            return ty_fail(run->session->context, TY_ERROR_FILE, "%s/times.%d cannot be read", folder, (int)rank);
        out->sum += seconds;
        out->max = seconds > out->max ? seconds : out->max;
    }
    return TY_OK;
}

typedef struct argument_texts {
    char text[SCALING_ARGUMENTS_MAX][NAME_SIZE];
} argument_texts;

static int add_command(const char** list, int count, const scaling_command* command, const char* folder, int32_t number,
                       argument_texts* texts) {
    for (int i = 0; i < SCALING_ARGUMENTS_MAX && command->arguments[i] != NULL; ++i) {
        const char* argument = command->arguments[i];
        const size_t length = strlen(argument);
        if (argument[0] == '@')
            snprintf(texts->text[i], NAME_SIZE, "%s%s", folder, argument + 1);
        else if (argument[length - 1] == '=')
            snprintf(texts->text[i], NAME_SIZE, "%s%d", argument, (int)number);
        else
            snprintf(texts->text[i], NAME_SIZE, "%s", argument);
        list[count++] = texts->text[i];
    }
    return count;
}

/* The command line: a launcher where there are several ranks, the shell, tyndall. */
static ty_result start(const char* folder, const scaling_command* command, int32_t number, int32_t ranks,
                       figure_process* out) {
    char tyndall[BENCH_COMMAND_SIZE], times[NAME_SIZE], stats[NAME_SIZE], count_text[16];
    const char* list[LIST_MAX] = {"mpirun",  "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-q", "-n",
                                  count_text};
    int count = ranks > 1 ? 8 : 0;
    argument_texts* texts = malloc(sizeof *texts);
    if (texts == NULL) return TY_ERROR_MEMORY;
    bench_find_command(tyndall);
    snprintf(count_text, sizeof count_text, "%d", (int)ranks);
    snprintf(times, sizeof times, "%s/times", folder);
    snprintf(stats, sizeof stats, "%s/stats.json", folder);
    const char* const shell[] = {"sh", "-c", timed, "sh", times, tyndall};
    for (size_t i = 0; i < sizeof shell / sizeof shell[0]; ++i) list[count++] = shell[i];
    count = add_command(list, count, command, folder, number, texts);
    const char* const last[] = {"-q", "--threads", "1", "--stats", stats};
    for (size_t i = 0; i < sizeof last / sizeof last[0]; ++i) list[count++] = last[i];
    list[count] = NULL;
    const ty_result result = figure_run_process(list, SECONDS_MAX, out);
    free(texts);
    return result;
}

ty_result scaling_measure(figure_run* run, const char* folder, const scaling_command* command, int32_t number,
                          int32_t ranks, scaling_run* out) {
    char stats[NAME_SIZE];
    figure_process process;
    *out = (scaling_run){.ranks = ranks};
    ty_result result = start(folder, command, number, ranks, &process);
    if (result != TY_OK) return result;
    if (process.status != 0)
        return ty_fail(run->session->context, TY_ERROR_FILE, "%d ranks: %s", (int)ranks, process.words);
    result = take_times(run, folder, out);
    if (result != TY_OK) return result;
    snprintf(stats, sizeof stats, "%s/stats.json", folder);
    out->stats = json_load_file(stats, 0, NULL);
    if (out->stats == NULL) return ty_fail(run->session->context, TY_ERROR_FILE, "%s cannot be read", stats);
    out->messages = json_number_value(json_object_get(out->stats, "messages"));
    out->bytes = json_number_value(json_object_get(out->stats, "message_bytes"));
    return TY_OK;
}

bool scaling_can_start(figure_run* run, const char* folder) {
    static const scaling_command command = {
        {"render", "builtin:cornell_fog", "--method", "path", "--spp", "1", "--size", "2x2", "-o", "@/start.exr"}};
    figure_process process;
    const ty_result result = start(folder, &command, 0, 2, &process);
    if (result == TY_OK && process.status == 0) return true;
    cli_progress_clear(&run->session->progress);
    run->skipped = true;
    if (process.status == 127)
        cli_fail(CLI_USAGE, "%s is skipped: there is no mpirun, which it needs", run->name);
    else
        cli_fail(CLI_USAGE, "%s is skipped: mpirun starts no two ranks: %s", run->name, process.words);
    return false;
}
