/* Messages lie in the thread's own storage, so that a thread that runs out of memory can still say so, and nothing is
 * left behind when the thread ends. */
#include "base/thread_errors.h"

#include <pthread.h>
#include <string.h>

/* A thread keeps unread messages of this many contexts; one more takes the place of the oldest. */
enum { CONTEXTS_AT_ONCE = 4 };

typedef struct message {
    uint64_t context;
    uint64_t age; /* of the thread's messages, counted from 1 on; 0: this one was never written */
    bool unread;
    char text[TY_MESSAGE_SIZE];
} message;

struct ty_thread_errors {
    pthread_mutex_t lock; /* several threads that work on one loop may fail at once */
    uint64_t count;
    message messages[CONTEXTS_AT_ONCE];
};

static _Thread_local ty_thread_errors own_errors = {.lock = PTHREAD_MUTEX_INITIALIZER};
static _Thread_local ty_thread_errors* waiting_errors; /* of the thread that waits for the current loop */

ty_thread_errors* ty_errors_current(void) {
    return waiting_errors != NULL ? waiting_errors : &own_errors;
}

void ty_errors_work_for(ty_thread_errors* errors) {
    waiting_errors = errors;
}

static message* find_unread(ty_thread_errors* errors, uint64_t context) {
    for (int i = 0; i < CONTEXTS_AT_ONCE; ++i)
        if (errors->messages[i].unread && errors->messages[i].context == context) return &errors->messages[i];
    return NULL;
}

/* Read messages go first, and then unread ones, the oldest of them first. */
static message* find_room(ty_thread_errors* errors) {
    message* best = &errors->messages[0];
    for (int i = 1; i < CONTEXTS_AT_ONCE; ++i) {
        message* other = &errors->messages[i];
        if (other->unread == best->unread ? other->age < best->age : best->unread) best = other;
    }
    return best;
}

void ty_errors_keep(uint64_t context, const char text[TY_MESSAGE_SIZE]) {
    ty_thread_errors* errors = ty_errors_current();
    pthread_mutex_lock(&errors->lock);
    if (find_unread(errors, context) == NULL) {
        message* kept = find_room(errors);
        kept->context = context;
        kept->age = ++errors->count;
        kept->unread = true;
        memcpy(kept->text, text, TY_MESSAGE_SIZE);
    }
    pthread_mutex_unlock(&errors->lock);
}

bool ty_errors_has(uint64_t context) {
    ty_thread_errors* errors = ty_errors_current();
    pthread_mutex_lock(&errors->lock);
    const bool has = find_unread(errors, context) != NULL;
    pthread_mutex_unlock(&errors->lock);
    return has;
}

const char* ty_errors_take(uint64_t context) {
    ty_thread_errors* errors = ty_errors_current();
    pthread_mutex_lock(&errors->lock);
    message* kept = find_unread(errors, context);
    if (kept != NULL) kept->unread = false;
    pthread_mutex_unlock(&errors->lock);
    return kept != NULL ? kept->text : "";
}
