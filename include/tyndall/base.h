/// @file base.h
/// Results, contexts, progress, parallel loops.
///
/// Every object belongs to a `ty_context`; there is no global state that a caller sees. A call that can fail returns a
/// `ty_result` and stores its result through a pointer. After a failure nothing is stored, and ty_take_error() tells in
/// one sentence what was wrong. Apache-2.0.
#ifndef TYNDALL_BASE_H
#define TYNDALL_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Marks the symbols that the library exports.
#if defined(__GNUC__)
#define TY_API __attribute__((visibility("default")))
#else
#define TY_API
#endif

/// The version of these headers.
#define TY_VERSION "0.1.0"
/// The first number of TY_VERSION.
#define TY_VERSION_MAJOR 0
/// The second number of TY_VERSION.
#define TY_VERSION_MINOR 1
/// The third number of TY_VERSION.
#define TY_VERSION_PATCH 0

/// A value of some fields of definitions: the library chooses, as the comment of the field tells.
#define TY_AUTO (-1)

/// The outcome of a call that can fail.
typedef enum ty_result {
    TY_OK = 0,                ///< The call did its work.
    TY_CANCELLED = 1,         ///< The progress callback cancelled the call. An object that was stored all the same is a
                              ///< valid partial result.
    TY_ERROR_ARGUMENT = 2,    ///< An argument of the call is wrong.
    TY_ERROR_INPUT = 3,       ///< The content of a file is wrong.
    TY_ERROR_FILE = 4,        ///< A file cannot be opened, read or written.
    TY_ERROR_MEMORY = 5,      ///< There is not enough memory.
    TY_ERROR_UNSUPPORTED = 6, ///< This build or this machine lacks a feature that the call needs.
    TY_ERROR_INTERNAL = 7     ///< A library that Tyndall uses failed unexpectedly.
} ty_result;

/// The name of a result, such as "TY_ERROR_INPUT"; "unknown" for any other number.
TY_API const char* ty_result_name(ty_result result);
/// The meaning of a result, such as "the content of a file is wrong"; "unknown" for any other number.
TY_API const char* ty_result_text(ty_result result);

/// The version of the library that runs, such as "0.1.0".
TY_API const char* ty_version(void);

/// The threads, the memory and the log that all objects are made with.
typedef struct ty_context ty_context;

/// The severity of a line in the log.
typedef enum ty_log_level {
    TY_LOG_INFO = 0,    ///< A note about normal work.
    TY_LOG_WARNING = 1, ///< The work goes on, with a result that the caller may not expect.
    TY_LOG_ERROR = 2    ///< A call fails.
} ty_log_level;

/// Receives one line of the log, without a newline. It is called from any thread, but by one thread at a time, and must
/// not call back into the context.
typedef void (*ty_log_fn)(void* user, ty_log_level level, const char* text);

/// Allocates `size` > 0 bytes, aligned to 64, or returns NULL. Several threads may call it at once.
typedef void* (*ty_alloc_fn)(void* user, size_t size);
/// Frees memory from the matching ty_alloc_fn; `size` is the size that was asked for. Several threads may call it at
/// once.
typedef void (*ty_free_fn)(void* user, void* pointer, size_t size);

/// The options of a context. Create it with ty_default_context_def().
typedef struct ty_context_def {
    uint32_t cookie;    ///< Set by ty_default_context_def() and checked.
    uint32_t bytes;     ///< Set by ty_default_context_def() to the size of the structure, and checked.
    int32_t threads;    ///< Number of threads for long work, 1..1024; TY_AUTO (default): one per available processor.
    ty_log_fn log;      ///< Receiver of the log; default NULL: warnings and errors are not printed.
    void* log_user;     ///< Passed on to `log`; default NULL.
    ty_alloc_fn alloc;  ///< Default NULL: aligned_alloc. `alloc` and `free` are given together.
    ty_free_fn free;    ///< Default NULL: free.
    void* alloc_user;   ///< Passed on to `alloc` and `free`; default NULL.
    const char* device; ///< The device for methods that docs/device.md lists: "cpu" (also by the default NULL), "host",
                        ///< "cuda:N" for GPU number N, or "auto": cuda:0 where there is one, else cpu. It is copied,
                        ///< and opened by the first call that uses it, which fails if it cannot be.
    int64_t resident_bytes; ///< Most bytes of paged grids (TY_GRID_PAGED) in the process's memory, which is looked at
                            ///< between the bodies of parallel loops; default 0: as the operating system decides.
} ty_context_def;

/// Sets the `bytes` bytes of a ty_context_def to the defaults. Each definition has such a function, and a default
/// function that calls it with the size that the program was compiled with, so that later versions of the library can
/// add fields at the end: an older program goes on to work, with the defaults of the new fields.
TY_API void ty_init_context_def(void* def, size_t bytes);
/// A definition with all fields at their defaults.
static inline ty_context_def ty_default_context_def(void) {
    ty_context_def def;
    ty_init_context_def(&def, sizeof def);
    return def;
}

/// Sets the `bytes` bytes of a structure of statistics, such as ty_path_stats, to 0, and notes its size in it. Each
/// such structure has a default function that calls this one with the size that the program was compiled with, so that
/// later versions of the library can add fields at the end: a call fills in the fields that both the program and the
/// library know.
TY_API void ty_init_stats(void* stats, size_t bytes);

/// Creates a context. When it fails, ty_take_error(NULL) tells why.
/// Errors: TY_ERROR_ARGUMENT (a wrong definition, or a field out of range), TY_ERROR_MEMORY.
TY_API ty_result ty_context_create(const ty_context_def* def, ty_context** out);
/// Destroys a context; NULL is allowed. Every object of the context must have been destroyed before.
TY_API void ty_context_destroy(ty_context* context);

/// The message of the first call that failed in this thread with this context since the message was last taken, such as
/// "scene.json:14: media[0].g: 1.2 is outside (-1, 1)"; "" if no call failed. Taking the message clears it. The text
/// belongs to the calling thread and is valid until this thread's next call into the library. NULL gives the message of
/// a call without a context, such as a failed ty_context_create().
///
/// Each thread has its own messages, and a thread keeps those of its last four contexts. A call that works on many
/// threads leaves its message with the thread that made the call.
TY_API const char* ty_take_error(ty_context* context);

/// The number of threads that long work uses.
TY_API int32_t ty_context_threads(const ty_context* context);

/// The state of long work.
typedef struct ty_progress {
    const char* stage; ///< Name of the current stage, such as "path" or "fluence".
    double fraction;   ///< Fraction of the whole work that is done, 0..1.
    double seconds;    ///< Time since the work began, s.
    double remaining;  ///< Estimate of the time to go, s; negative while unknown.
    uint64_t done;     ///< Samples per pixel that are complete; 0 in work that is not counted in samples.
    uint64_t total;    ///< Samples per pixel in all; 0 in work without samples, or bounded by time or error alone.
} ty_progress;

/// Receives the progress of long work about fifty times a second, from one thread at a time. A return value of false
/// cancels the work: it stops within a few milliseconds and returns TY_CANCELLED.
typedef bool (*ty_progress_fn)(void* user, const ty_progress* progress);

/// The body of a parallel loop: it works on one index. `worker` is in [0, threads), and no other body that runs at the
/// same time has the same one.
typedef void (*ty_parallel_fn)(void* user, int64_t index, int32_t worker);
/// Calls body(user, index, worker) for every index in [0, count), on the threads of the context. The distribution of
/// indices over threads is not fixed, so a body must only write to memory that its index owns. A loop that begins while
/// another one of the context runs, from its body or from another thread, runs on the calling thread alone, as worker
/// 0.
TY_API void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user);

#ifdef __cplusplus
}
#endif
#endif
