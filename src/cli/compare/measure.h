/* Differences from the reference, and its noise. */
#ifndef TY_CLI_COMPARE_MEASURE_H
#define TY_CLI_COMPARE_MEASURE_H

#include "cli/compare/comparison.h"

/* Sets the difference and noise of an entry and of its intermediate images: CLI_GO, or an exit status after a message.
 */
int cli_measure_entry(cli_session* session, const cli_comparison* comparison, cli_compared* entry);

/* The minimum and maximum samples per pixel from a reference's samples channel; false without one. */
bool cli_sample_range(const ty_image* reference, double* min_samples, double* max_samples);

/* The noise of the reference in the pixels that another image has, too. */
cli_noise cli_measure_noise(const ty_image* reference, const ty_image* other);

#endif
