/* Context internals: error reports and memory for all modules. */
#ifndef TY_BASE_CONTEXT_H
#define TY_BASE_CONTEXT_H

#include <tyndall/base.h>

enum { TY_THREADS_MAX = 1024 };

/* First member of every def made by its ty_default_*_def. */
#define TY_DEF_COOKIE 0x74796466u

/* Formats a message, stores it if it is the first, logs it as an error, and returns result:
 * return ty_fail(context, TY_ERROR_INPUT, "%s: ...", path); */
ty_result ty_fail(ty_context* context, ty_result result, const char* format, ...) __attribute__((format(printf, 3, 4)));
/* Logs a line without failing. */
void ty_log(ty_context* context, ty_log_level level, const char* format, ...) __attribute__((format(printf, 3, 4)));

/* Fails with TY_ERROR_ARGUMENT when def is NULL or was not made by its default function. */
ty_result ty_check_def(ty_context* context, const void* def, const char* default_function);

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

/* Seconds of a monotonic clock, and processor seconds of the whole process. */
double ty_wall_seconds(void);
double ty_cpu_seconds(void);

#endif
