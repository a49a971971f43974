/* Renderings of a comparison, and states of paths, kept. */
#ifndef TY_CLI_COMPARE_KEEP_H
#define TY_CLI_COMPARE_KEEP_H

#include "cli/compare/comparison.h"
#include "cli/methods.h"

/* A ty_path_state_fn that keeps the last state in memory, and hands it on; user is a cli_kept_state. */
typedef struct cli_kept_state {
    void* bytes;
    size_t size;
    cli_checkpoint* checkpoint; /* NULL: memory alone */
} cli_kept_state;
bool cli_keep_state(void* user, const void* state, size_t size);

/* Sets what is known of an entry from a rendering's report, and writes its image into the folder. */
int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry);
cli_report cli_begin_report(const ty_scene* scene, const cli_method* method, uint64_t seed);

#endif
