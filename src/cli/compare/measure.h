/* Differences from the reference, and its noise. */
#ifndef TY_CLI_COMPARE_MEASURE_H
#define TY_CLI_COMPARE_MEASURE_H

#include "cli/compare/comparison.h"

/* Sets the difference and noise of an entry and of what it was on its way: CLI_GO, or an exit status after a message.
 */
int cli_measure_entry(cli_session* session, const cli_comparison* comparison, cli_compared* entry);

/* Samples of the pixels with the fewest and with the most, by a reference's channel of samples; false without one. */
bool cli_sample_range(const ty_image* reference, double* fewest, double* most);

/* The noise of the reference where another image has pixels, too. */
cli_noise cli_measure_noise(const ty_image* reference, const ty_image* other);

#endif
