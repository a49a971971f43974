/* Context internals: error reports and memory for all modules. */
#ifndef TY_BASE_CONTEXT_H
#define TY_BASE_CONTEXT_H

#include <tyndall/base.h>

enum { TY_THREADS_MAX = 1024 };

/* First member of every def made by its ty_default_*_def. */
#define TY_DEF_COOKIE 0x74796466u

/* First members of every def. */
typedef struct ty_def_head {
    uint32_t cookie, bytes;
} ty_def_head;

/* Formats a message, stores it for ty_take_error unless the calling thread has an unread message of this context, logs
 * it as an error, and returns result. Without a context the message is stored for ty_take_error(NULL):
 * return ty_fail(context, TY_ERROR_INPUT, "%s: ...", path); */
ty_result ty_fail(ty_context* context, ty_result result, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* Tells whether the calling thread has a message of this context that was not read. */
bool ty_has_error(const ty_context* context);
/* Logs a line without failing. */
void ty_log(ty_context* context, ty_log_level level, const char* format, ...) __attribute__((format(printf, 3, 4)));

/* Sets cookie and size of a caller's def. */
void ty_mark_def(void* def, size_t bytes);
/* Copies the library's defaults, of size bytes, into a caller's def of `bytes`, which may be smaller: that of a program
 * that was compiled against an older definition. */
void ty_init_def(void* def, size_t bytes, const void* defaults, size_t size);
/* Fails with TY_ERROR_ARGUMENT when def is NULL or was not made by its default function. */
ty_result ty_check_def(ty_context* context, const void* def, const char* default_function);
/* The size of a def that ty_check_def passes. */
size_t ty_def_bytes(const void* def);
/* Copies a caller's def over own, which holds the library's defaults and is of size bytes. Fails with
 * TY_ERROR_ARGUMENT when def is NULL, was not made by its default function or is larger than the library's. */
ty_result ty_take_def(ty_context* context, const void* def, const char* default_function, void* own, size_t size);

/* Clears own, of size bytes, and copies a caller's stats over it as far as they go; NULL is allowed. Fails with
 * TY_ERROR_ARGUMENT when they were not made by their default function. */
ty_result ty_take_stats(ty_context* context, const void* stats, const char* default_function, void* own, size_t size);
/* Copies own, of size bytes, into a caller's stats as far as they go, all but their head; NULL is allowed. */
void ty_give_stats(const void* own, size_t size, void* stats);

/* Memory aligned to 64 bytes from the context's allocator. ty_alloc_array checks the product for overflow and the total
 * of the context's arrays against the machine's memory, stores a message on failure and clears the array on request; a
 * count of 0 gives a valid pointer. */
void* ty_alloc_array(ty_context* context, size_t count, size_t element_size, bool zero);
void ty_free_array(ty_context* context, void* pointer, size_t count, size_t element_size);
/* Fails with TY_ERROR_MEMORY if a group of arrays, `bytes` in total, does not fit; called before the first allocation,
 * with the purpose for the message. */
ty_result ty_check_memory(ty_context* context, double bytes, const char* what);
/* Copy of text (NULL counts as ""); freed with ty_free_text. */
char* ty_copy_text(ty_context* context, const char* text);
void ty_free_text(ty_context* context, char* text);

/* Grows *items to hold count + 1 elements (capacity doubles); false, with a message, on allocation failure. */
bool ty_grow_array(ty_context* context, void** items, size_t* capacity, size_t count, size_t element_size);

/* The context's threads, for ty_parallel_for. */
struct ty_thread_pool* ty_context_pool(ty_context* context);

/* The name that ty_context_def.device gave. */
const char* ty_context_device_name(const ty_context* context);
/* The one object that a context keeps for a room above: the first call makes it by `open`, later ones wait for that and
 * give the same; the context's end closes it, before its threads end. A call that fails is tried again by the next. */
ty_result ty_context_slot(ty_context* context, ty_result (*open)(ty_context* context, void** out),
                          void (*close)(void* object), void** out);

/* The files that the context's arrays are mapped from (base/mapping.h). */
struct ty_mapping_ring* ty_context_mappings(ty_context* context);

struct ty_work_queue;
/* The tasks that the context's loops offer to other processes (comm/queue.h); NULL, at first: there are no
 * others. They stay the caller's. */
void ty_context_set_queue(ty_context* context, struct ty_work_queue* queue);
struct ty_work_queue* ty_context_queue(const ty_context* context);

/* Seconds of a monotonic clock, and processor seconds of the whole process. */
double ty_wall_seconds(void);
double ty_cpu_seconds(void);

#endif
