/* --resume: the state of a render in a file beside its image. */
#ifndef TY_CLI_SESSION_CHECKPOINT_H
#define TY_CLI_SESSION_CHECKPOINT_H

#include "cli/session/lock.h"

typedef struct cli_checkpoint {
    cli_session* session;
    char* path;     /* OUTPUT.state */
    cli_lock lock;  /* held while the checkpoint is open */
    uint8_t* bytes; /* state of an earlier run; NULL: none */
    size_t size;
    uint64_t written; /* bytes of the state that this run wrote; 0: none yet */
    bool warned;
} cli_checkpoint;

/* Takes the lock of OUTPUT.state, so that no other process writes it, removes temporary files that killed processes
 * left of it, and reads it if it exists: CLI_GO, or an exit status after a message. Either way the caller closes the
 * checkpoint, which frees the lock. */
int cli_checkpoint_open(cli_checkpoint* checkpoint, cli_session* session, const char* output);
void cli_checkpoint_close(cli_checkpoint* checkpoint);

/* A ty_path_state_fn; user is the cli_checkpoint. A state that cannot be written causes one warning, and rendering goes
 * on. */
bool cli_checkpoint_write(void* user, const void* state, size_t size);
/* The same for ty_path_def.state_change: appends to the state that was written last. False if there is none, or it
 * cannot be appended to. */
bool cli_checkpoint_append(void* user, const void* changes, size_t size);

#endif
