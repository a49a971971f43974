/* Locks of states: one process at a time writes the state of a render or a bake. */
#ifndef TY_CLI_SESSION_LOCK_H
#define TY_CLI_SESSION_LOCK_H

#include "cli/session/session.h"

typedef struct cli_lock {
    char* path;     /* FILE.lock; NULL: not taken */
    int descriptor; /* open and locked while the lock is held; -1: none */
} cli_lock;

/* Takes the lock of a file, which need not exist: CLI_GO, or CLI_FAILED after a message if another process holds it. A
 * program holds one lock at a time. The kernel frees the lock of a process that ended in any way, so that a lock file
 * that was left behind is taken over. On file systems without locks there is a warning, and CLI_GO. */
int cli_lock_take(cli_lock* lock, cli_session* session, const char* path);
/* Removes the lock file; nothing happens if the lock was not taken. */
void cli_lock_release(cli_lock* lock);

#endif
