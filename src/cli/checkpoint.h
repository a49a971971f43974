/* --resume: the state of a render in a file beside its image. */
#ifndef TY_CLI_CHECKPOINT_H
#define TY_CLI_CHECKPOINT_H

#include "cli/session.h"

typedef struct cli_checkpoint {
    cli_session* session;
    char* path;     /* of the state */
    uint8_t* bytes; /* what an earlier run left; NULL: nothing */
    size_t size;
    bool warned;
} cli_checkpoint;

/* Reads OUTPUT.state if it is there: CLI_GO, or an exit status after a message. Either way the checkpoint is to be
 * closed. */
int cli_checkpoint_open(cli_checkpoint* checkpoint, cli_session* session, const char* output);
void cli_checkpoint_close(cli_checkpoint* checkpoint);

/* A ty_path_state_fn; user is the cli_checkpoint. A state that cannot be written is warned of once, and the work goes
 * on. */
bool cli_checkpoint_write(void* user, const void* state, size_t size);

#endif
