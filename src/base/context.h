/* The context's insides and how every room reports errors and takes memory. */
#ifndef TY_BASE_CONTEXT_H
#define TY_BASE_CONTEXT_H

#include <tyndall/base.h>

enum { TY_THREADS_MAX = 1024 };

/* Every def made by its ty_default_*_def starts with this. */
#define TY_DEF_COOKIE 0x74796466u

/* Formats a message, keeps it if it is the first, logs it as an error, and returns result:
 * return ty_fail(context, TY_ERROR_INPUT, "%s: ...", path); */
ty_result ty_fail(ty_context* context, ty_result result, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* Logs a line without failing. */
void ty_log(ty_context* context, ty_log_level level, const char* format, ...) __attribute__((format(printf, 3, 4)));

/* Fails with TY_ERROR_ARGUMENT when def is NULL or was not made by its default function. */
ty_result ty_check_def(ty_context* context, const void* def, const char* default_function);

/* Memory aligned to 64 bytes from the context's allocator. ty_alloc_array checks the product for overflow and that the
 * context's arrays together fit the machine's memory, keeps a message on failure and may be asked for zeros; a count of
 * 0 gives a valid pointer. */
void* ty_alloc_array(ty_context* context, size_t count, size_t element_size, bool zero);
void ty_free_array(ty_context* context, void* pointer, size_t count, size_t element_size);
/* Fails with TY_ERROR_MEMORY when several arrays that belong together, bytes in all, will not fit: before the first is
 * taken, and naming what they are for. */
ty_result ty_check_memory(ty_context* context, double bytes, const char* what);
/* A copy of text (NULL counts as ""); freed with ty_free_text. */
char* ty_copy_text(ty_context* context, const char* text);
void ty_free_text(ty_context* context, char* text);

/* Grows *items to hold count + 1 elements (capacity doubles); false, with a message, when memory is short. */
bool ty_grow_array(ty_context* context, void** items, size_t* capacity, size_t count, size_t element_size);

/* The context's threads, for ty_parallel_for. */
struct ty_thread_pool* ty_context_pool(ty_context* context);

/* Seconds of a monotonic clock, and processor seconds of the whole process. */
double ty_wall_seconds(void);
double ty_cpu_seconds(void);

#endif
