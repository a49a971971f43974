/* tyndall-figure: reproduction of figures and tables from papers. */
#define _POSIX_C_SOURCE 200809L
#include "figures/judge.h"
#include "figures/output.h"
#include "figures/summary.h"
#include "cli/text/text.h"
#include "cli/text/text_file.h"

#include <stdlib.h>
#include <string.h>

enum { FIGURES_MAX = 128 };

static bool wanted(const figure_entry* figure, const char* name) {
    const size_t length = strlen(name);
    return strcmp(name, "all") == 0 || strcmp(name, figure->name) == 0 ||
           (strncmp(name, figure->name, length) == 0 && figure->name[length] == '-');
}

static int count_wanted(const char* name) {
    int count = 0;
    for (int i = 0; i < figure_entry_count; ++i) count += wanted(&figure_entries[i], name) ? 1 : 0;
    return count;
}

static int unknown_figure(const char* name) {
    const char* names[FIGURES_MAX];
    for (int i = 0; i < figure_entry_count; ++i) names[i] = figure_entries[i].name;
    const char* nearest = cli_nearest(name, names, figure_entry_count);
    if (nearest != NULL)
        return cli_usage_error("figure", "unknown figure '%s'; did you mean '%s'? 'tyndall figure list' lists all",
                               name, nearest);
    return cli_usage_error("figure", "unknown figure '%s'; 'tyndall figure list' lists all", name);
}

static int print_list(void) {
    for (int i = 0; i < figure_entry_count; ++i) {
        char title[FIGURE_TITLE_SIZE];
        figure_full_title(&figure_entries[i], title);
        cli_print_text(stdout, figure_entries[i].name, 18);
        printf(" %s\n", title);
    }
    return CLI_DONE;
}

/* ---- making ---- */

/* Makes and writes one figure, with a message. */
static void make_figure(cli_session* session, const figure_options* options, figure_outcome* outcome) {
    const figure_entry* entry = outcome->entry;
    const double started = cli_wall_seconds();
    figure_run run = {.session = session, .options = options, .name = entry->name};
    ty_result result = plot_create_page(session->context, &run.page);
    if (result == TY_OK) result = entry->make(&run);
    if (result == TY_OK && run.incomplete) result = TY_ERROR_MEMORY;
    cli_progress_clear(&session->progress);
    const double seconds = cli_wall_seconds() - started;
    int status = result != TY_OK ? cli_fail_running(session, result) : CLI_DONE;
    if (status == CLI_DONE && !run.skipped) status = figure_write(&run, entry, seconds);
    outcome->status = status;
    outcome->state = status == CLI_INTERRUPTED ? FIGURE_LEFT
                     : status != CLI_DONE      ? FIGURE_FAILED
                     : run.skipped             ? FIGURE_SKIPPED
                                               : FIGURE_MADE;
    if (outcome->state == FIGURE_FAILED || outcome->state == FIGURE_SKIPPED)
        snprintf(outcome->message, sizeof outcome->message, "%s", cli_last_message());
    if (outcome->state == FIGURE_MADE && !session->common.quiet)
        printf("wrote %s/%s.png, .csv and .json (%.1f s)\n", options->folder, entry->name, seconds);
    free(run.quantities);
    plot_free_page(&run.page);
}

static void make_wanted(cli_session* session, const figure_options* options, const char* name,
                        figure_summary* summary) {
    const int count = count_wanted(name);
    int index = 0;
    for (int i = 0; i < figure_entry_count; ++i) {
        figure_outcome* outcome = &summary->outcomes[i];
        outcome->entry = &figure_entries[i];
        if (!wanted(outcome->entry, name)) continue;
        if (cli_interrupted()) {
            outcome->state = FIGURE_LEFT;
            outcome->status = CLI_INTERRUPTED;
        } else if (options->keep && figure_can_keep(session, options, outcome->entry->name)) {
            outcome->state = FIGURE_KEPT;
        } else {
            char stage[64];
            snprintf(stage, sizeof stage, "figure %s", outcome->entry->name);
            if (count > 1)
                cli_progress_step(&session->progress, stage, index, count, cli_wall_seconds() - session->started);
            make_figure(session, options, outcome);
            fflush(stdout);
        }
        ++index;
    }
}

/* ---- results ---- */

static int count_state(const figure_summary* summary, figure_state state) {
    int count = 0;
    for (int i = 0; i < figure_entry_count; ++i) count += summary->outcomes[i].state == state ? 1 : 0;
    return count;
}

static void print_outcome(const figure_summary* summary, double seconds) {
    size_t checked = 0, within = 0, unknown = 0;
    for (int i = 0; i < figure_entry_count; ++i) {
        const figure_outcome* outcome = &summary->outcomes[i];
        if (outcome->state != FIGURE_MADE && outcome->state != FIGURE_KEPT) continue;
        checked += outcome->checked;
        within += outcome->within;
        unknown += outcome->unknown;
    }
    printf("%d made, %d kept, %d skipped, %d failed in %.0f s; %zu of %zu numbers within their tolerance, %zu below "
           "the noise; see %s/index.html\n",
           count_state(summary, FIGURE_MADE), count_state(summary, FIGURE_KEPT), count_state(summary, FIGURE_SKIPPED),
           count_state(summary, FIGURE_FAILED), seconds, within, checked, unknown, summary->folder);
    for (int i = 0; i < figure_entry_count; ++i)
        if (summary->outcomes[i].state == FIGURE_FAILED)
            printf("failed: %s: %s\n", figure_entries[i].name, summary->outcomes[i].message);
}

/* True if all requested figures were skipped, which is an error. */
static int exit_status_of(const figure_summary* summary, int asked) {
    for (int i = 0; i < figure_entry_count; ++i)
        if (summary->outcomes[i].state == FIGURE_LEFT) return CLI_INTERRUPTED;
    for (int i = 0; i < figure_entry_count; ++i)
        if (summary->outcomes[i].state == FIGURE_FAILED) return asked == 1 ? summary->outcomes[i].status : CLI_FAILED;
    return count_state(summary, FIGURE_SKIPPED) == asked ? CLI_USAGE : CLI_DONE;
}

/* Checks the figures of this call. CLI_FAILED, after messages, for numbers beyond their tolerance other than known
 * misses. */
static int check_numbers(cli_session* session, const figure_summary* summary) {
    size_t misses = 0;
    for (int i = 0; i < figure_entry_count; ++i) {
        const figure_outcome* outcome = &summary->outcomes[i];
        if (outcome->state == FIGURE_MADE || outcome->state == FIGURE_KEPT) misses += figure_judge(session, outcome);
    }
    if (misses == 0) return CLI_DONE;
    return cli_fail(CLI_FAILED, "%zu number%s beyond %s tolerance, and no known miss%s", misses,
                    misses == 1 ? " is" : "s are", misses == 1 ? "its" : "their", misses == 1 ? "" : "es");
}

static int make_figures(cli_session* session, const figure_options* options, const char* name) {
    const int asked = count_wanted(name);
    figure_summary summary = {.folder = options->folder,
                              .outcomes = calloc((size_t)figure_entry_count, sizeof *summary.outcomes)};
    if (summary.outcomes == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    make_wanted(session, options, name, &summary);
    int status = exit_status_of(&summary, asked);
    ty_result result = figure_read_summary(session, &summary);
    if (result == TY_OK && asked > 1) result = figure_write_summary(session, &summary);
    if (result != TY_OK)
        status = cli_fail_running(session, result);
    else if (asked > 1 && !session->common.quiet)
        print_outcome(&summary, cli_wall_seconds() - session->started);
    const int numbers = result == TY_OK ? check_numbers(session, &summary) : CLI_DONE;
    if (status == CLI_DONE) status = numbers;
    figure_free_summary(&summary);
    return status;
}

/* ---- the command ---- */

/* The text of --help about figures; the caller frees it. NULL: no memory. */
static char* list_figures(void) {
    cli_text details;
    if (!cli_text_open(&details)) return NULL;
    FILE* text = details.file;
    fputs(
        "Writes DIR/NAME.png, and what was measured and, where it is known, expected as DIR/NAME.csv and .json.\n"
        "'all' makes all, the first word of a name those of a paper, and 'list' lists them. More than one get\n"
        "DIR/index.html, summary.md and summary.csv besides: what is expected and what was measured.\n"
        "Those that fail or lack data hinder no others: 0 if any was made and none failed, 1 if one failed, 2 if all\n"
        "lacked data. A number beyond its tolerance that is no known miss is a failure, too, in figures of their own\n"
        "size and samples: not with --quick, --size or --spp.\n\nfigures:",
        text);
    for (int i = 0; i < figure_entry_count; ++i) {
        char title[FIGURE_TITLE_SIZE];
        figure_full_title(&figure_entries[i], title);
        fprintf(text, "\n  %-18s %s", figure_entries[i].name, title);
    }
    return cli_text_close(&details);
}

static int run(const figure_options* options, const cli_arguments* given) {
    const char* name = given->positional[0];
    cli_session session;
    if (strcmp(name, "list") == 0) return print_list();
    if (count_wanted(name) == 0) return unknown_figure(name);
    if (options->folder == NULL) return cli_usage_error("figure", "where to? Give -o DIR");
    int status = cli_make_folder("figure", options->folder);
    if (status == CLI_GO) status = cli_session_open(&session, "figure", &given->common);
    return status == CLI_GO ? cli_session_close(&session, make_figures(&session, options, name)) : status;
}

static bool print_words(FILE* file, const char* option) {
    if (option != NULL) return false;
    fputs("all list ", file);
    for (int i = 0; i < figure_entry_count; ++i) fprintf(file, "%s ", figure_entries[i].name);
    return true;
}

static int make(int count, char** arguments) {
    figure_options options = {.data = getenv("TYNDALL_DATA"), .latency = 2e-6, .bandwidth = 1e10};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "DIR", "the folder to write to; made if it is missing", &options.folder, 0, 0, NULL},
        {"size", 0, CLI_SIZE, "WxH", "pixels of the pictures (default: the figure's choice)", options.size, 0, 0, NULL},
        {"spp", 0, CLI_INT, "N", "samples per pixel of path-traced pictures (default: the figure's choice)",
         &options.samples, 1, 1 << 24, NULL},
        {"quick", 0, CLI_FLAG, NULL, "small pictures and few samples", &options.quick, 0, 0, NULL},
        {"keep", 0, CLI_FLAG, NULL, "leave figures that this version made with these options before", &options.keep, 0,
         0, NULL},
        {"latency", 0, CLI_REAL, "S", "of a message between ranks in the model of scaling, seconds (default 2e-6)",
         &options.latency, 0, 1, NULL},
        {"bandwidth", 0, CLI_REAL, "B", "of messages between ranks there, bytes a second (default 1e10)",
         &options.bandwidth, 1, 1e15, NULL},
        {"data", 0, CLI_TEXT, "DIR", "third-party images and volumes (default: the environment variable TYNDALL_DATA)",
         &options.data, 0, 0, NULL},
    };
    char* details = list_figures();
    if (details == NULL) return cli_fail(CLI_FAILED, "not enough memory");
    const cli_syntax syntax = {"figure",
                               "NAME|all|list -o DIR",
                               "Makes figures and tables of papers anew.",
                               details,
                               table,
                               sizeof table / sizeof table[0],
                               1,
                               1,
                               print_words};
    cli_arguments given;
    const int status = cli_parse(&syntax, count, arguments, &given);
    free(details);
    return status == CLI_GO ? run(&options, &given) : status;
}

int main(int count, char** arguments) {
    cli_start_program();
    return cli_finish(make(count - 1, arguments + 1));
}
