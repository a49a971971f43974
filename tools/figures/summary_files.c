/* summary.csv, .json and .md, index.md and index.html of a folder of figures. */
#define _GNU_SOURCE
#include "figures/output.h"
#include "figures/index_page.h"
#include "figures/summary_words.h"
#include "cli/text.h"
#include "cli/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* ---- JSON ---- */

static void write_json_quantity(json_writer* json, const figure_quantity* q) {
    json_open_object(json, NULL);
    figure_write_json_fields(json, q);
    if (!isnan(q->tolerance) && !isnan(q->measured)) json_bool(json, "within", figure_is_within(q));
    json_close_object(json);
}

static void write_json_outcome(json_writer* json, const figure_outcome* outcome) {
    json_open_object(json, NULL);
    json_text(json, "figure", outcome->entry->name);
    json_text(json, "paper", figure_papers[outcome->entry->paper].citation);
    json_text(json, "number", outcome->entry->number);
    json_text(json, "title", outcome->entry->title);
    json_text(json, "state", figure_state_name(outcome->state));
    if (outcome->message[0] != '\0') json_text(json, "reason", outcome->message);
    if (figure_is_there(outcome)) {
        json_text(json, "version", outcome->version);
        json_bool(json, "quick", outcome->quick);
        json_number(json, "seconds", outcome->seconds);
        json_int(json, "checked", (int64_t)outcome->checked);
        json_int(json, "within", (int64_t)outcome->within);
        json_int(json, "compared", (int64_t)outcome->compared);
        json_open_array(json, "expected");
        for (size_t i = 0; i < outcome->count; ++i)
            if (!isnan(outcome->quantities[i].expected)) write_json_quantity(json, &outcome->quantities[i]);
        json_close_array(json);
    }
    json_close_object(json);
}

static ty_result print_json(ty_context* context, FILE* file, const void* user) {
    const figure_summary* summary = user;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "version", ty_version());
    json_int(&json, "threads", ty_context_threads(context));
    json_open_array(&json, "figures");
    for (int i = 0; i < figure_entry_count; ++i)
        if (figure_is_listed(&summary->outcomes[i])) write_json_outcome(&json, &summary->outcomes[i]);
    json_close_array(&json);
    json_close_object(&json);
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

static void print_md_figure(FILE* file, const figure_outcome* outcome) {
    const figure_entry* entry = outcome->entry;
    char title[FIGURE_TITLE_SIZE];
    figure_full_title(entry, title);
    fprintf(file, "\n### %s\n\n", title);
    if (!figure_is_there(outcome)) {
        fprintf(file, "%s: %s", entry->name, figure_state_name(outcome->state));
        if (outcome->message[0] != '\0') fputs(". ", file);
        cli_print_markdown(file, outcome->message);
        fputc('\n', file);
        return;
    }
    fprintf(file, "![%s](%s.png)\n\n[%s.csv](%s.csv), [%s.json](%s.json): %zu numbers, %.3g s%s.\n", entry->name,
            entry->name, entry->name, entry->name, entry->name, entry->name, outcome->count, outcome->seconds,
            outcome->quick ? ", with --quick" : "");
    if (outcome->checked + outcome->compared == 0) return;
    fputs("\n| what | expected | measured | within |\n|---|---|---|---|\n", file);
    print_md_groups(file, outcome, "");
}

static ty_result print_index_md(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const figure_summary* summary = user;
    fprintf(file,
            "# Papers' figures, made anew by Tyndall %s\n\n"
            "| figure | paper | state | within tolerance | seconds |\n|---|---|---|---|---|\n",
            ty_version());
    for (int i = 0; i < figure_entry_count; ++i) {
        const figure_outcome* outcome = &summary->outcomes[i];
        char within[FIGURE_WORDS_SIZE];
        if (!figure_is_listed(outcome)) continue;
        figure_describe_outcome(outcome, within);
        fprintf(file, "| %s | %s%s%s | %s | %s |", outcome->entry->name, figure_papers[outcome->entry->paper].method,
                outcome->entry->number[0] != '\0' ? ", " : "", outcome->entry->number,
                figure_state_name(outcome->state), within);
        if (figure_is_there(outcome)) fprintf(file, " %.3g", outcome->seconds);
        fputs(" |\n", file);
    }
    for (int paper = 0; paper < FIGURE_PAPERS; ++paper) {
        if (!figure_has_paper(summary, paper)) continue;
        fprintf(file, "\n## %s\n", figure_papers[paper].method);
        if (figure_papers[paper].citation[0] != '\0') fprintf(file, "\n%s.\n", figure_papers[paper].citation);
        for (int i = 0; i < figure_entry_count; ++i)
            if ((int)figure_entries[i].paper == paper && figure_is_listed(&summary->outcomes[i]))
                print_md_figure(file, &summary->outcomes[i]);
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
    if (result == TY_OK) result = write_one(session, summary, "summary.json", print_json);
    if (result == TY_OK) result = write_one(session, summary, "summary.md", print_summary_md);
    if (result == TY_OK) result = write_one(session, summary, "index.md", print_index_md);
    if (result == TY_OK) result = write_one(session, summary, "index.html", figure_print_index_page);
    return result;
}
