/* Stored images of a comparison and resume states of the path tracer. */
#ifndef TY_CLI_COMPARE_KEEP_H
#define TY_CLI_COMPARE_KEEP_H

#include "cli/compare/comparison.h"
#include "cli/methods/methods.h"

/* A ty_path_state_fn that stores the last state in memory and forwards it; user is a cli_stored_state. */
typedef struct cli_stored_state {
    void* bytes;
    size_t size;
    cli_checkpoint* checkpoint; /* NULL: memory only */
} cli_stored_state;
bool cli_keep_state(void* user, const void* state, size_t size);

/* Sets an entry's fields from a rendering's report, and writes its image into the folder. */
int cli_keep_rendering(cli_session* session, const cli_comparison* comparison, const cli_report* report,
                       cli_compared* entry);
cli_report cli_begin_report(const ty_scene* scene, const ty_method* method, uint64_t seed);

#endif
