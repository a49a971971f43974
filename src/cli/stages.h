/* What a rendering's time went into. */
#ifndef TY_CLI_STAGES_H
#define TY_CLI_STAGES_H

#include "cli/report.h"

enum { CLI_STAGES_MAX = 16 };

typedef struct cli_stage {
    const char* name; /* "march"; a literal */
    double seconds;
} cli_stage;

/* The parts that a method's own stats have, in their order; how many. None of them is within another. */
int cli_fld_stages(const ty_fld_stats* fld, cli_stage out[CLI_STAGES_MAX]);
int cli_pop_stages(const ty_pop_stats* pop, cli_stage out[CLI_STAGES_MAX]);
int cli_lpv_stages(const ty_lpv_stats* lpv, cli_stage out[CLI_STAGES_MAX]);
int cli_dom_stages(const ty_dom_stats* dom, cli_stage out[CLI_STAGES_MAX]);

/* All that a rendering did, whichever method it was: what paths took, the method's stages, and what is left. */
int cli_report_stages(const cli_report* report, cli_stage out[CLI_STAGES_MAX]);

#endif
