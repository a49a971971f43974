/* What a figure leaves in its folder. */
#ifndef TY_CLI_FIGURES_OUTPUT_H
#define TY_CLI_FIGURES_OUTPUT_H

#include "cli/figures/list.h"

/* NAME.csv, NAME.json and NAME.png, each whole or not at all. Returns CLI_DONE, or an exit status after a message. */
int figure_write(figure_run* run, const figure_entry* entry, double seconds);

/* A field of CSV, quoted where it must be; a comma and a number, or nothing after it for NaN. */
void figure_write_csv_text(FILE* file, const char* text);
void figure_write_csv_number(FILE* file, double amount);
/* What both this and the summary say of a number, on a line of CSV and within an object of JSON. */
void figure_write_csv_fields(FILE* file, const figure_quantity* quantity);
void figure_write_json_fields(json_writer* json, const figure_quantity* quantity);

#endif
