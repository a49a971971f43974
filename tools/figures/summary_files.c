/* summary.csv, summary.md and index.html of a folder of figures. */
#define _GNU_SOURCE
#include "figures/output.h"
#include "figures/index_page.h"
#include "figures/summary_words.h"
#include "cli/text/text.h"
#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>

/* ---- CSV ---- */

static void write_csv_start(FILE* file, const figure_outcome* outcome) {
    figure_write_csv_text(file, outcome->entry->name);
    fputc(',', file);
    figure_write_csv_text(file, figure_papers[outcome->entry->paper].method);
    fputc(',', file);
    figure_write_csv_text(file, outcome->entry->number);
    fprintf(file, ",%s", figure_state_name(outcome->state));
    figure_write_csv_number(file, figure_is_there(outcome) ? outcome->seconds : NAN);
    fputc(',', file);
}

static void write_csv_quantity(FILE* file, const figure_quantity* q) {
    figure_write_csv_fields(file, q);
    fprintf(file, ",%s\n", isnan(q->tolerance) || isnan(q->measured) ? "" : figure_is_within(q) ? "yes" : "no");
}

static ty_result print_csv(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const figure_summary* summary = user;
    fputs("figure,paper,number,state,seconds,item,quantity,unit,measured,expected,tolerance,within\n", file);
    for (int i = 0; i < figure_entry_count; ++i) {
        const figure_outcome* outcome = &summary->outcomes[i];
        if (!figure_is_listed(outcome)) continue;
        if (outcome->checked + outcome->compared == 0) {
            write_csv_start(file, outcome);
            fputs(",,,,,,\n", file);
        }
        for (size_t q = 0; q < outcome->count; ++q) {
            if (isnan(outcome->quantities[q].expected)) continue;
            write_csv_start(file, outcome);
            write_csv_quantity(file, &outcome->quantities[q]);
        }
    }
    return TY_OK;
}

/* ---- Markdown ---- */

static void print_md_groups(FILE* file, const figure_outcome* outcome, const char* first_cell) {
    figure_group group;
    for (size_t i = 0; figure_get_group(outcome, i, &group); ++i) {
        char expected[FIGURE_WORDS_SIZE], measured[FIGURE_WORDS_SIZE], within[FIGURE_WORDS_SIZE] = "";
        figure_describe_expected(&group, expected);
        figure_describe_measured(&group, measured);
        if (group.checked) figure_describe_within(group.within, group.unknown, group.count, within);
        fprintf(file, "|%s ", first_cell);
        if (group.count == 1 && group.first->item[0] != '\0') {
            cli_print_markdown(file, group.first->item);
            fputs(": ", file);
        }
        cli_print_markdown(file, group.first->name);
        fprintf(file, " | %s | %s | %s", expected, measured, within);
        if (group.out[0] != '\0') {
            fputs(" (", file);
            cli_print_markdown(file, group.out);
            fputc(')', file);
        }
        fputs(" |\n", file);
    }
}

/* The table for docs/figures.md. */
static ty_result print_summary_md(ty_context* context, FILE* file, const void* user) {
    const figure_summary* summary = user;
    bool quick = false;
    for (int i = 0; i < figure_entry_count; ++i) quick = quick || summary->outcomes[i].quick;
    fprintf(file, "Version %s, %d threads.%s\n", ty_version(), ty_context_threads(context),
            quick ? " Those marked were made with --quick: too coarse to keep to tolerances." : "");
    for (int paper = 0; paper < FIGURE_PAPERS; ++paper) {
        if (!figure_has_paper(summary, paper)) continue;
        fprintf(file,
                "\n### %s\n\n| figure | paper | what | expected | measured | within |\n|---|---|---|---|---|---|\n",
                figure_papers[paper].method);
        for (int i = 0; i < figure_entry_count; ++i) {
            const figure_outcome* outcome = &summary->outcomes[i];
            char cells[128], within[FIGURE_WORDS_SIZE];
            if ((int)figure_entries[i].paper != paper || !figure_is_listed(outcome)) continue;
            figure_describe_outcome(outcome, within);
            snprintf(cells, sizeof cells, " %s%s | %s |", figure_entries[i].name, outcome->quick ? " (--quick)" : "",
                     figure_entries[i].number);
            if (!figure_is_there(outcome)) {
                fprintf(file, "|%s %s | | | |\n", cells, figure_state_name(outcome->state));
            } else if (outcome->checked + outcome->compared == 0) {
                fprintf(file, "|%s %s | nothing | %zu numbers | |\n", cells, figure_entries[i].title, outcome->count);
            }
            print_md_groups(file, outcome, cells);
        }
    }
    return TY_OK;
}

/* ---- writing ---- */

static ty_result write_one(cli_session* session, const figure_summary* summary, const char* name, cli_print_fn print) {
    char* path = NULL;
    if (asprintf(&path, "%s/%s", summary->folder, name) < 0) return TY_ERROR_MEMORY;
    const ty_result result = cli_write_text_file(session->context, path, print, summary);
    free(path);
    return result;
}

ty_result figure_write_summary(cli_session* session, const figure_summary* summary) {
    ty_result result = write_one(session, summary, "summary.csv", print_csv);
    if (result == TY_OK) result = write_one(session, summary, "summary.md", print_summary_md);
    if (result == TY_OK) result = write_one(session, summary, "index.html", figure_print_index_page);
    return result;
}
