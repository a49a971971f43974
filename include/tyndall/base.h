/* Tyndall: results, contexts, progress. Apache-2.0.
 *
 * Everything hangs off a ty_context; there are no globals. Fallible calls return a ty_result and hand
 * results out by pointer; on failure nothing is handed out and the context keeps the first message. */
#ifndef TYNDALL_BASE_H
#define TYNDALL_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Marks what the library exports. */
#if defined(__GNUC__)
#define TY_API __attribute__((visibility("default")))
#else
#define TY_API
#endif

/* The version of these headers. */
#define TY_VERSION "0.1.0"
#define TY_VERSION_MAJOR 0 /* of TY_VERSION */
#define TY_VERSION_MINOR 1 /* of TY_VERSION */
#define TY_VERSION_PATCH 0 /* of TY_VERSION */

/* In a field of a def: the library chooses, as the field's words say. */
#define TY_AUTO (-1)

/* code, name, text */
#define TY_RESULT_LIST(X)                                                                                              \
    X(0, TY_OK, "done")                                                                                                \
    X(1, TY_CANCELLED, "cancelled by the progress callback; what was handed out is a valid partial result")            \
    X(2, TY_ERROR_ARGUMENT, "an argument of the call is wrong")                                                        \
    X(3, TY_ERROR_INPUT, "the content of a file is wrong")                                                             \
    X(4, TY_ERROR_FILE, "a file cannot be opened, read or written")                                                    \
    X(5, TY_ERROR_MEMORY, "not enough memory")                                                                         \
    X(6, TY_ERROR_UNSUPPORTED, "not available in this build or on this machine")                                       \
    X(7, TY_ERROR_INTERNAL, "a library below failed unexpectedly")

/* What a fallible call returns; TY_RESULT_LIST has the words. */
typedef enum ty_result {
/* One of the list. */
#define TY_RESULT_ENUM(code, name, text) name = code,
    TY_RESULT_LIST(TY_RESULT_ENUM)
#undef TY_RESULT_ENUM
} ty_result;

/* The name of a result ("TY_ERROR_INPUT"); "unknown" for any other number. */
TY_API const char* ty_result_name(ty_result result);
/* What a result means ("the content of a file is wrong"); "unknown" for any other number. */
TY_API const char* ty_result_text(ty_result result);

/* The version of the library that runs ("0.1.0"). */
TY_API const char* ty_version(void);

/* Threads, memory and messages: what everything else is made with. */
typedef struct ty_context ty_context;

/* How much a logged line matters. */
typedef enum ty_log_level { TY_LOG_INFO = 0, TY_LOG_WARNING = 1, TY_LOG_ERROR = 2 } ty_log_level;

/* Called with one finished line without a newline. May be called from any thread, one call at a time; it must not call
 * back into the context. */
typedef void (*ty_log_fn)(void* user, ty_log_level level, const char* text);

/* size > 0; returns memory aligned to 64 bytes, or NULL. May be called from several threads at once, as may the
 * function below. */
typedef void* (*ty_alloc_fn)(void* user, size_t size);
/* pointer as returned by the allocation, with the same size. */
typedef void (*ty_free_fn)(void* user, void* pointer, size_t size);

/* What a context is made of; made by ty_default_context_def. */
typedef struct ty_context_def {
    uint32_t cookie;   /* set by ty_default_context_def; checked */
    uint32_t bytes;    /* set by ty_default_context_def: size of the struct that the program was compiled with */
    int32_t threads;   /* threads for long work, 1..1024; TY_AUTO (default): one per available processor */
    ty_log_fn log;     /* default NULL: warnings and errors are only kept, not printed */
    void* log_user;    /* default NULL */
    ty_alloc_fn alloc; /* default NULL: aligned_alloc; alloc and free are given together */
    ty_free_fn free;   /* default NULL: free */
    void* alloc_user;  /* default NULL */
} ty_context_def;

/* Fills in a def of `bytes` bytes; ty_default_context_def calls it. Every def has such a function, so that fields can
 * be added at its end: a program that was compiled against a smaller struct goes on to work, and new fields have their
 * defaults. */
TY_API void ty_init_context_def(void* def, size_t bytes);
/* A def with every field at its default. */
static inline ty_context_def ty_default_context_def(void) {
    ty_context_def def;
    ty_init_context_def(&def, sizeof def);
    return def;
}

/* Errors: TY_ERROR_ARGUMENT (def not made by its default function, or a field out of range), TY_ERROR_MEMORY. */
TY_API ty_result ty_context_create(const ty_context_def* def, ty_context** out);
/* Everything made with the context must be destroyed before. NULL is allowed. */
TY_API void ty_context_destroy(ty_context* context);

/* The first message since the context was created or cleared, "" if there is none:
 * "scene.json:14: media[0].g: 1.2 is outside (-1, 1)". Valid until the next call with this context. */
TY_API const char* ty_last_error(const ty_context* context);
/* Forgets the message. */
TY_API void ty_clear_error(ty_context* context);

/* The number of threads long work uses. */
TY_API int32_t ty_context_threads(const ty_context* context);

/* What long work reports. */
typedef struct ty_progress {
    const char* stage; /* "path", "fluence", ... */
    double fraction;   /* of the whole work, 0..1 */
    double seconds;    /* since the work began */
    double remaining;  /* seconds, estimated; negative while unknown */
    uint64_t done;     /* samples per pixel finished in full; 0 in work that is not counted in them */
    uint64_t total;    /* samples per pixel asked for; 0 if only time or error bounds the work, or it has none */
} ty_progress;

/* Called about ten times a second, from one thread at a time. Return false to cancel: the work then stops
 * within a few milliseconds and returns TY_CANCELLED with a valid partial result. */
typedef bool (*ty_progress_fn)(void* user, const ty_progress* progress);

/* The body of a parallel loop: works on one index; worker is in [0, threads) and no other has it meanwhile. */
typedef void (*ty_parallel_fn)(void* user, int64_t index, int32_t worker);
/* Runs body(user, index, worker) for every index in [0, count) over the context's threads. Which thread takes which
 * index is not fixed, so a body writes only what its index owns. The context's threads start with its first loop and
 * end with the context; a loop that begins while another runs, from its body or from another thread, runs in the
 * calling thread alone, as worker 0. */
TY_API void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user);

#ifdef __cplusplus
}
#endif
#endif
