/* The table of options that all commands share, which parsing and manual pages both read. */
#include "cli/options/options.h"

#include <string.h>

void cli_common_options(cli_common* common, cli_option options[CLI_COMMON_COUNT]) {
    const cli_option table[CLI_COMMON_COUNT] = {
        {"threads", 0, CLI_INT, "N", "threads to use (default 0: one per processor)", &common->threads, 0, 1024, NULL},
        {"seed", 0, CLI_SEED, "N", "seed of the random numbers (default: the scene's, or 0)", &common->seed, 0, 0,
         &common->seed_given},
        {"device", 0, CLI_TEXT, "cpu|host|cuda:N|auto",
         "what traces paths and marches: the processor (default), or a GPU", &common->device, 0, 0, NULL},
        {"resident", 0, CLI_INT, "MB", "most memory for paged volumes (default 0: as the operating system decides)",
         &common->resident, 0, INT32_MAX, NULL},
        {"stats", 0, CLI_TEXT, "FILE.json", "write what the run did and took", &common->stats, 0, 0, NULL},
        {"progress", 0, CLI_CHOICE, "auto|plain|json|none", "how progress is shown on stderr", &common->progress, 0, 0,
         NULL},
        {"quiet", 'q', CLI_FLAG, NULL, "no progress or closing lines, and no warnings but of states that are not safe",
         &common->quiet, 0, 0, NULL},
        {"help", 'h', CLI_FLAG, NULL, "this text", &common->help, 0, 0, NULL},
        {"version", 0, CLI_FLAG, NULL, "the version", &common->version, 0, 0, NULL},
        {"help-as", 0, CLI_CHOICE, "text|man|markdown|completion", NULL, &common->help_as, 0, 0, NULL},
        {"help-to", 0, CLI_TEXT, "FILE", NULL, &common->help_to, 0, 0, NULL},
    };
    memcpy(options, table, sizeof table);
}
