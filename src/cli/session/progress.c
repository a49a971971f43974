/* Display of progress. */
#define _GNU_SOURCE
#include "cli/session/progress.h"
#include "cli/session/signals.h"
#include "cli/text/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

cli_progress cli_progress_begin(const cli_common* common) {
    cli_progress progress = {.mode = (cli_progress_mode)common->progress};
    if (progress.mode == CLI_AUTO) {
        progress.mode = CLI_PLAIN;
        progress.updating = isatty(STDERR_FILENO) == 1;
    }
    if (common->quiet) progress.mode = CLI_NONE;
    return progress;
}

void cli_progress_clear(cli_progress* progress) {
    if (progress->line_open) fputs("\r\033[K", stderr);
    progress->line_open = false;
}

void cli_progress_warn(cli_progress* progress, const char* text) {
    cli_progress_clear(progress);
    fputs("tyndall: warning: ", stderr);
    cli_print_text(stderr, text, 0);
    putc('\n', stderr);
}

/* "1:05", "2:03:00"; "?" while unknown. */
static void format_time(double seconds, char* out, size_t size) {
    if (seconds < 0 || seconds > 360000) {
        snprintf(out, size, "?");
        return;
    }
    const int whole = (int)(seconds + 0.5);
    if (whole >= 3600)
        snprintf(out, size, "%d:%02d:%02d", whole / 3600, whole / 60 % 60, whole % 60);
    else
        snprintf(out, size, "%d:%02d", whole / 60, whole % 60);
}

static void format_line(const ty_progress* report, char* out, size_t size) {
    char elapsed[24], remaining[24], samples[64];
    format_time(report->seconds, elapsed, sizeof elapsed);
    format_time(report->remaining, remaining, sizeof remaining);
    if (report->total > 0)
        snprintf(samples, sizeof samples, " %" PRIu64 " of %" PRIu64 " spp,", report->done, report->total);
    else
        snprintf(samples, sizeof samples, " %" PRIu64 " spp,", report->done);
    if (report->done == 0 && report->total == 0) samples[0] = '\0'; /* work without a count of samples */
    snprintf(out, size, "%s: %3.0f%%,%s %s gone, %s left", report->stage, 100 * report->fraction, samples, elapsed,
             remaining);
}

static void report_json(const ty_progress* report) {
    fprintf(stderr,
            "{\"stage\": \"%s\", \"fraction\": %.4f, \"seconds\": %.3f, \"remaining\": %.3f, \"done\": %" PRIu64
            ", \"total\": %" PRIu64 "}\n",
            report->stage, report->fraction, report->seconds, report->remaining, report->done, report->total);
}

/* Permanent lines: one at the start of a stage, then at least two seconds and two percent (JSON: half a second) apart.
 */
static bool line_is_due(cli_progress* progress, const ty_progress* report) {
    const bool json = progress->mode == CLI_JSON;
    const bool new_stage = strncmp(progress->stage, report->stage, sizeof progress->stage - 1) != 0;
    const bool finished = report->fraction >= 1 && progress->last_fraction < 1;
    const double waited = report->seconds - progress->last_seconds;
    const double advanced = report->fraction - progress->last_fraction;
    const bool due = json ? waited >= 0.5 : waited >= 2 && (advanced >= 0.02 || waited >= 30);
    if (!new_stage && !finished && !due) return false;
    snprintf(progress->stage, sizeof progress->stage, "%s", report->stage);
    progress->last_seconds = report->seconds;
    progress->last_fraction = report->fraction;
    return true;
}

/* The updating line changes ten times a second. */
static bool update_is_due(cli_progress* progress, const ty_progress* report) {
    const double waited = report->seconds - progress->last_seconds;
    if (progress->line_open && waited >= 0 && waited < 0.1) return false;
    progress->last_seconds = report->seconds;
    return true;
}

bool cli_progress_report(void* user, const ty_progress* report) {
    cli_progress* progress = user;
    char line[160];
    if (progress->mode == CLI_JSON) {
        if (line_is_due(progress, report)) report_json(report);
    } else if (progress->mode == CLI_PLAIN && progress->updating && update_is_due(progress, report)) {
        format_line(report, line, sizeof line);
        fprintf(stderr, "\r%s\033[K", line);
        progress->line_open = true;
    } else if (progress->mode == CLI_PLAIN && !progress->updating && line_is_due(progress, report)) {
        format_line(report, line, sizeof line);
        fprintf(stderr, "%s\n", line);
    }
    return !cli_interrupted();
}

void cli_progress_step(cli_progress* progress, const char* stage, int index, int count, double seconds) {
    char gone[24];
    cli_progress_clear(progress);
    if (progress->mode == CLI_JSON)
        fprintf(stderr,
                "{\"stage\": \"%s\", \"fraction\": %.4f, \"seconds\": %.3f, \"remaining\": -1, \"done\": %d, "
                "\"total\": %d}\n",
                stage, (double)index / count, seconds, index, count);
    if (progress->mode != CLI_PLAIN) return;
    format_time(seconds, gone, sizeof gone);
    fprintf(stderr, "%s (%d of %d), %s gone\n", stage, index + 1, count, gone);
}
