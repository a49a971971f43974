/* Writing figures. */
#define _GNU_SOURCE
#include "figures/output.h"

#include "cli/text/text_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The inputs of the output files. */
typedef struct figure_text {
    figure_run* run;
    const figure_entry* entry;
    char title[FIGURE_TITLE_SIZE];
    double seconds;
} figure_text;

void figure_write_csv_text(FILE* file, const char* text) {
    const bool quoted = strpbrk(text, ",\"\n") != NULL;
    if (quoted) fputc('"', file);
    for (const char* c = text; *c != '\0'; ++c) {
        if (*c == '"') fputc('"', file);
        fputc(*c, file);
    }
    if (quoted) fputc('"', file);
}

void figure_write_csv_number(FILE* file, double amount) {
    if (isfinite(amount))
        fprintf(file, ",%.9g", amount);
    else
        fputc(',', file);
}

void figure_write_csv_fields(FILE* file, const figure_quantity* quantity) {
    figure_write_csv_text(file, quantity->item);
    fputc(',', file);
    figure_write_csv_text(file, quantity->name);
    fputc(',', file);
    figure_write_csv_text(file, quantity->unit);
    figure_write_csv_number(file, quantity->measured);
    figure_write_csv_number(file, quantity->expected);
    figure_write_csv_number(file, quantity->tolerance);
}

static ty_result print_csv(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const figure_text* text = user;
    fputs("item,quantity,unit,measured,expected,tolerance\n", file);
    for (size_t i = 0; i < text->run->count; ++i) {
        figure_write_csv_fields(file, &text->run->quantities[i]);
        fputc('\n', file);
    }
    return TY_OK;
}

static void write_quantity(json_writer* json, const figure_quantity* quantity) {
    json_open_object(json, NULL);
    json_text(json, "item", quantity->item);
    json_text(json, "name", quantity->name);
    json_text(json, "unit", quantity->unit);
    json_number(json, "measured", quantity->measured);
    if (!isnan(quantity->expected)) json_number(json, "expected", quantity->expected);
    if (!isnan(quantity->tolerance)) json_number(json, "tolerance", quantity->tolerance);
    json_close_object(json);
}

static ty_result print_json(ty_context* context, FILE* file, const void* user) {
    const figure_text* text = user;
    const figure_options* options = text->run->options;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_text(&json, "figure", text->run->name);
    json_text(&json, "title", text->title);
    json_text(&json, "paper", figure_papers[text->entry->paper].citation);
    json_text(&json, "number", text->entry->number);
    json_text(&json, "caption", text->run->caption);
    json_text(&json, "version", ty_version());
    json_int(&json, "threads", ty_context_threads(context));
    json_bool(&json, "quick", options->quick);
    json_numbers(&json, "size", (const double[]){options->size[0], options->size[1]}, 2);
    json_int(&json, "spp", options->samples);
    json_numbers(&json, "network", (const double[]){options->latency, options->bandwidth}, 2);
    json_unsigned(&json, "seed", text->run->session->common.seed);
    json_bool(&json, "data", options->data != NULL && access(options->data, R_OK) == 0);
    json_number(&json, "seconds", text->seconds);
    json_open_array(&json, "quantities");
    for (size_t i = 0; i < text->run->count; ++i) write_quantity(&json, &text->run->quantities[i]);
    json_close_array(&json);
    json_close_object(&json);
    return TY_OK;
}

/* Writes a file of the figure; print NULL: the page. */
static ty_result write_file(const figure_text* text, const char* extension, cli_print_fn print) {
    char* path = NULL;
    if (asprintf(&path, "%s/%s%s", text->run->options->folder, text->run->name, extension) < 0) return TY_ERROR_MEMORY;
    const ty_result result = print != NULL ? cli_write_text_file(text->run->session->context, path, print, text)
                                           : plot_write_page(&text->run->page, text->title, text->run->caption, path);
    free(path);
    return result;
}

int figure_write(figure_run* run, const figure_entry* entry, double seconds) {
    figure_text text = {.run = run, .entry = entry, .seconds = seconds};
    figure_full_title(entry, text.title);
    ty_result result = write_file(&text, ".png", NULL);
    if (result == TY_OK) result = write_file(&text, ".csv", print_csv);
    if (result == TY_OK) result = write_file(&text, ".json", print_json);
    return result == TY_OK ? CLI_DONE : cli_fail_running(run->session, result);
}
