/* Output files of a figure. */
#ifndef TY_FIGURES_OUTPUT_H
#define TY_FIGURES_OUTPUT_H

#include "figures/list.h"

/* Writes NAME.csv, NAME.json and NAME.png, each atomically. Returns CLI_DONE, or an exit status after a message. */
int figure_write(figure_run* run, const figure_entry* entry, double seconds);

/* Prints a CSV field, quoted if needed; and a comma followed by a number, or by nothing for NaN. */
void figure_write_csv_text(FILE* file, const char* text);
void figure_write_csv_number(FILE* file, double amount);
/* Prints a number for figures and summary, as a CSV line and as members of a JSON object. */
void figure_write_csv_fields(FILE* file, const figure_quantity* quantity);
void figure_write_json_fields(json_writer* json, const figure_quantity* quantity);

#endif
