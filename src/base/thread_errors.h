/* Error messages, kept per thread and per context, as Embree and OIDN keep them. */
#ifndef TY_BASE_THREAD_ERRORS_H
#define TY_BASE_THREAD_ERRORS_H

#include <stdbool.h>
#include <stdint.h>

enum { TY_MESSAGE_SIZE = 1024 };

/* The messages of one thread. A thread that works on another's loop keeps its messages with the thread that waits for
 * the loop, which is the one that reads them. */
typedef struct ty_thread_errors ty_thread_errors;

/* The messages of the thread that the calling one works for: its own outside of loops. */
ty_thread_errors* ty_errors_current(void);
/* From here on the calling thread works for the owner of these messages; NULL: for itself. */
void ty_errors_work_for(ty_thread_errors* errors);

/* Keeps a message of a context, unless the thread has one of it that was not read. context: the number of the context,
 * which no two contexts of a process share; 0 stands for no context. */
void ty_errors_keep(uint64_t context, const char text[TY_MESSAGE_SIZE]);
/* Tells whether there is a message that was not read. */
bool ty_errors_has(uint64_t context);
/* The message, "" without one, which then counts as read. It stays valid until the thread keeps another. */
const char* ty_errors_take(uint64_t context);

#endif
