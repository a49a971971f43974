/* Output files of a figure. */
#ifndef TY_FIGURES_OUTPUT_H
#define TY_FIGURES_OUTPUT_H

#include "figures/list.h"

/* Writes NAME.csv, NAME.json and NAME.png, each atomically. Returns CLI_DONE, or an exit status after a message. */
int figure_write(figure_run* run, const figure_entry* entry, double seconds);

/* Prints a CSV field, quoted if needed; and a comma followed by a number, or by nothing for NaN. */
void figure_write_csv_text(FILE* file, const char* text);
void figure_write_csv_number(FILE* file, double amount);
/* Prints the fields of a number as a CSV line has them. */
void figure_write_csv_fields(FILE* file, const figure_quantity* quantity);

#endif
