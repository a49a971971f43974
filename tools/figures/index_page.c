/* A page that shows a folder of figures. */
#include "figures/index_page.h"

#include "figures/summary_words.h"
#include "cli/text/text.h"

static const char head[] =
    "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Papers' figures, made "
    "anew</title>\n<style>\n"
    ":root{color-scheme:light dark}\n"
    "body{font:16px/1.5 system-ui,sans-serif;margin:0 auto;max-width:70rem;padding:1.5rem}\n"
    "h2{margin-top:3rem;border-bottom:1px solid #8886}\nh3{margin-top:2.5rem}\n"
    "figure{margin:1rem 0}\nimg{max-width:100%;height:auto;background:#fff;border:1px solid #8884}\n"
    ".wide{overflow-x:auto}\ntable{border-collapse:collapse;font-size:.92rem}\n"
    "th,td{text-align:left;padding:.2rem .9rem .2rem 0;border-bottom:1px solid #8884;vertical-align:top}\n"
    ".no{color:#b3261e;font-weight:600}\n@media(prefers-color-scheme:dark){.no{color:#ff8a80}}\n"
    "</style>\n</head>\n<body>\n";

static void print_cell(FILE* file, const char* text) {
    fputs("<td>", file);
    cli_print_html(file, text);
    fputs("</td>", file);
}

/* A table cell, highlighted if a number is beyond its tolerance. */
static void print_within(FILE* file, const char* text, bool all, const char* out) {
    fputs(all ? "<td>" : "<td class=\"no\">", file);
    cli_print_html(file, text);
    if (out[0] != '\0') {
        fputs(" (", file);
        cli_print_html(file, out);
        fputc(')', file);
    }
    fputs("</td>", file);
}

static void print_overview(FILE* file, const figure_summary* summary) {
    fputs("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"All figures\"><table>\n<thead><tr>"
          "<th>figure</th><th>paper</th><th></th><th>state</th><th>within tolerance</th><th>seconds</th></tr></thead>\n"
          "<tbody>\n",
          file);
    for (int i = 0; i < figure_entry_count; ++i) {
        const figure_outcome* outcome = &summary->outcomes[i];
        const figure_entry* entry = &figure_entries[i];
        char within[FIGURE_WORDS_SIZE];
        if (!figure_is_listed(outcome)) continue;
        figure_describe_outcome(outcome, within);
        fprintf(file, "<tr><td><a href=\"#%s\">%s</a></td>", entry->name, entry->name);
        print_cell(file, figure_papers[entry->paper].method);
        print_cell(file, entry->number);
        print_within(file, figure_state_name(outcome->state), outcome->state != FIGURE_FAILED, "");
        print_within(file, within, outcome->within + outcome->unknown == outcome->checked, "");
        if (figure_is_there(outcome))
            fprintf(file, "<td>%.3g</td></tr>\n", outcome->seconds);
        else
            fputs("<td></td></tr>\n", file);
    }
    fputs("</tbody></table></div>\n", file);
}

static void print_groups(FILE* file, const figure_outcome* outcome) {
    figure_group group;
    if (outcome->checked + outcome->compared == 0) return;
    fprintf(file,
            "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Numbers of %s\"><table>\n<thead><tr>"
            "<th>what</th><th>expected</th><th>measured</th><th>within</th></tr></thead>\n<tbody>\n",
            outcome->entry->name);
    for (size_t i = 0; figure_get_group(outcome, i, &group); ++i) {
        char words[FIGURE_WORDS_SIZE];
        fputs("<tr><td>", file);
        if (group.count == 1) {
            cli_print_html(file, group.first->item);
            fputs(": ", file);
        }
        cli_print_html(file, group.first->name);
        fputs("</td>", file);
        figure_describe_expected(&group, words);
        print_cell(file, words);
        figure_describe_measured(&group, words);
        print_cell(file, words);
        words[0] = '\0';
        if (group.checked) figure_describe_within(group.within, group.unknown, group.count, words);
        print_within(file, words, !group.checked || group.within + group.unknown == group.count, group.out);
        fputs("</tr>\n", file);
    }
    fputs("</tbody></table></div>\n", file);
}

static void print_figure(FILE* file, const figure_outcome* outcome) {
    const char* name = outcome->entry->name;
    char title[FIGURE_TITLE_SIZE];
    figure_full_title(outcome->entry, title);
    fprintf(file, "<section id=\"%s\">\n<h3>", name);
    cli_print_html(file, title);
    fputs("</h3>\n", file);
    if (figure_is_there(outcome)) {
        fprintf(file, "<figure><a href=\"%s.png\"><img src=\"%s.png\" loading=\"lazy\" alt=\"", name, name);
        cli_print_html(file, title);
        fputs(". ", file);
        cli_print_html(file, outcome->caption);
        fputs("\"></a></figure>\n", file);
        print_groups(file, outcome);
        fprintf(file, "<p><a href=\"%s.csv\">%s.csv</a>, <a href=\"%s.json\">%s.json</a>: %zu numbers, %.3g s%s.</p>\n",
                name, name, name, name, outcome->count, outcome->seconds, outcome->quick ? ", with --quick" : "");
    } else {
        fprintf(file, "<p>%s %s. ", name, figure_state_name(outcome->state));
        cli_print_html(file, outcome->message);
        fputs("</p>\n", file);
    }
    fputs("</section>\n", file);
}

ty_result figure_print_index_page(ty_context* context, FILE* file, const void* user) {
    const figure_summary* summary = user;
    fputs(head, file);
    fprintf(file,
            "<h1>Papers' figures, reproduced</h1>\n<p>Tyndall %s, %d threads. Numbers without an expected value "
            "are for inspection; those with a tolerance are checked.</p>\n",
            ty_version(), ty_context_threads(context));
    print_overview(file, summary);
    for (int paper = 0; paper < FIGURE_PAPERS; ++paper) {
        if (!figure_has_paper(summary, paper)) continue;
        fputs("<h2>", file);
        cli_print_html(file, figure_papers[paper].method);
        fputs("</h2>\n<p>", file);
        cli_print_html(file, figure_papers[paper].citation);
        fputs("</p>\n", file);
        for (int i = 0; i < figure_entry_count; ++i)
            if ((int)figure_entries[i].paper == paper && figure_is_listed(&summary->outcomes[i]))
                print_figure(file, &summary->outcomes[i]);
    }
    fputs("</body>\n</html>\n", file);
    return TY_OK;
}
