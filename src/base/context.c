/* Contexts: errors, logging, memory, clocks. */
#define _GNU_SOURCE
#include "base/context.h"
#include "base/parallel.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

enum { MESSAGE_SIZE = 1024, ALIGNMENT = 64 };
/* Bytes of a large page, and minimum array size for rounding to whole large pages. */
enum { LARGE_PAGE = 1 << 21, LARGE = 1 << 22 };

static const double mebibyte = 1048576;

struct ty_context {
    ty_context_def def;
    int32_t threads;
    pthread_mutex_t lock; /* guards message and the log callback */
    char message[MESSAGE_SIZE];
    double machine_memory; /* bytes */
    _Atomic size_t taken;  /* bytes of allocated arrays */
    ty_team team;          /* all threads but the caller's */
    ty_team_member members[];
};

const char* ty_result_name(ty_result result) {
    switch (result) {
#define TY_RESULT_NAME(code, name, text)                                                                               \
    case name: return #name;
        TY_RESULT_LIST(TY_RESULT_NAME)
#undef TY_RESULT_NAME
    }
    return "unknown";
}

const char* ty_result_text(ty_result result) {
    switch (result) {
#define TY_RESULT_TEXT(code, name, text)                                                                               \
    case name: return text;
        TY_RESULT_LIST(TY_RESULT_TEXT)
#undef TY_RESULT_TEXT
    }
    return "unknown";
}

const char* ty_version(void) {
    return TY_VERSION;
}

static size_t round_up(size_t size, size_t to) {
    return (size + to - 1) / to * to;
}

/* Large arrays use large pages where available: the first touch of small pages costs as much as the computation on
 * them. */
static void* default_alloc(void* user, size_t size) {
    (void)user;
#ifdef MADV_HUGEPAGE
    if (size >= LARGE) {
        void* pointer = aligned_alloc(LARGE_PAGE, round_up(size, LARGE_PAGE));
        if (pointer != NULL) madvise(pointer, round_up(size, LARGE_PAGE), MADV_HUGEPAGE);
        return pointer;
    }
#endif
    return aligned_alloc(ALIGNMENT, round_up(size, ALIGNMENT));
}

static void default_free(void* user, void* pointer, size_t size) {
    (void)user;
    (void)size;
    free(pointer);
}

static int32_t available_processors(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    const int count = CPU_COUNT(&set);
    return count < 1 ? 1 : count > TY_THREADS_MAX ? TY_THREADS_MAX : count;
}

/* Bytes of physical memory; infinite if unknown. */
static double physical_memory(void) {
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? (double)pages * (double)page : INFINITY;
}

ty_context_def ty_default_context_def(void) {
    return (ty_context_def){.cookie = TY_DEF_COOKIE};
}

static size_t context_size(int32_t threads) {
    return sizeof(ty_context) + (size_t)(threads - 1) * sizeof(ty_team_member);
}

ty_result ty_context_create(const ty_context_def* def, ty_context** out) {
    if (out == NULL || def == NULL || def->cookie != TY_DEF_COOKIE || def->threads < 0 ||
        def->threads > TY_THREADS_MAX || (def->alloc == NULL) != (def->free == NULL))
        return TY_ERROR_ARGUMENT;
    ty_context_def copy = *def;
    if (copy.alloc == NULL) {
        copy.alloc = default_alloc;
        copy.free = default_free;
    }
    const int32_t processors = available_processors(), threads = copy.threads > 0 ? copy.threads : processors;
    ty_context* context = copy.alloc(copy.alloc_user, context_size(threads));
    if (context == NULL) return TY_ERROR_MEMORY;
    memset(context, 0, context_size(threads));
    context->def = copy;
    context->threads = threads;
    ty_team_create(&context->team, context->members, threads - 1, threads <= processors);
    context->machine_memory = physical_memory();
    atomic_init(&context->taken, 0);
    pthread_mutex_init(&context->lock, NULL);
    *out = context;
    return TY_OK;
}

void ty_context_destroy(ty_context* context) {
    if (context == NULL) return;
    ty_team_destroy(&context->team);
    pthread_mutex_destroy(&context->lock);
    const ty_context_def def = context->def;
    def.free(def.alloc_user, context, context_size(context->threads));
}

const char* ty_last_error(const ty_context* context) {
    return context == NULL ? "" : context->message;
}

void ty_clear_error(ty_context* context) {
    if (context == NULL) return;
    pthread_mutex_lock(&context->lock);
    context->message[0] = '\0';
    pthread_mutex_unlock(&context->lock);
}

int32_t ty_context_threads(const ty_context* context) {
    return context->threads;
}

void ty_parallel_for(ty_context* context, int64_t count, ty_parallel_fn body, void* user) {
    ty_loop loop = {.body = body, .user = user, .count = count};
    atomic_init(&loop.next, 0);
    ty_team_run(&context->team, &loop);
}

ty_result ty_fail(ty_context* context, ty_result result, const char* format, ...) {
    if (context == NULL) return result;
    char text[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pthread_mutex_lock(&context->lock);
    if (context->message[0] == '\0') memcpy(context->message, text, sizeof text);
    if (context->def.log != NULL) context->def.log(context->def.log_user, TY_LOG_ERROR, text);
    pthread_mutex_unlock(&context->lock);
    return result;
}

void ty_log(ty_context* context, ty_log_level level, const char* format, ...) {
    if (context->def.log == NULL) return;
    char text[MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pthread_mutex_lock(&context->lock);
    context->def.log(context->def.log_user, level, text);
    pthread_mutex_unlock(&context->lock);
}

ty_result ty_check_def(ty_context* context, const void* def, const char* default_function) {
    uint32_t cookie = 0;
    if (def != NULL) memcpy(&cookie, def, sizeof cookie);
    if (cookie == TY_DEF_COOKIE) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "a def was not made by %s()", default_function);
}

/* The system overcommits memory and kills the process on use; larger requests are rejected here. */
static bool machine_has(const ty_context* context, double bytes) {
    return bytes + (double)atomic_load(&context->taken) <= context->machine_memory;
}

ty_result ty_check_memory(ty_context* context, double bytes, const char* what) {
    if (machine_has(context, bytes)) return TY_OK;
    return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory: %.1f MiB are needed, and the machine has %.1f MiB",
                   what, bytes / mebibyte, context->machine_memory / mebibyte);
}

typedef struct clearing {
    char* begin;
    size_t size;
} clearing;

enum { CLEARED_AT_ONCE = 1 << 20 };

static void clear_part(void* user, int64_t index, int32_t worker) {
    (void)worker;
    const clearing* all = user;
    const size_t begin = (size_t)index * CLEARED_AT_ONCE, left = all->size - begin;
    memset(all->begin + begin, 0, left < CLEARED_AT_ONCE ? left : CLEARED_AT_ONCE);
}

/* Clears memory on all threads: pages are mapped on first write. */
static void clear(ty_context* context, void* begin, size_t size) {
    clearing all = {begin, size};
    ty_parallel_for(context, (int64_t)((size + CLEARED_AT_ONCE - 1) / CLEARED_AT_ONCE), clear_part, &all);
}

void* ty_alloc_array(ty_context* context, size_t count, size_t element_size, bool zero) {
    size_t size = 0;
    void* pointer = NULL;
    const bool sane = !__builtin_mul_overflow(count, element_size, &size) && size <= (size_t)PTRDIFF_MAX - ALIGNMENT;
    if (sane && machine_has(context, (double)size))
        pointer = context->def.alloc(context->def.alloc_user, size == 0 ? 1 : size);
    if (pointer == NULL) {
        ty_fail(context, TY_ERROR_MEMORY,
                "not enough memory for %.1f MiB: %.1f MiB are in use, the machine has %.1f MiB",
                (double)count * (double)element_size / mebibyte, (double)atomic_load(&context->taken) / mebibyte,
                context->machine_memory / mebibyte);
        return NULL;
    }
    atomic_fetch_add(&context->taken, size);
    if (zero) clear(context, pointer, size);
    return pointer;
}

void ty_free_array(ty_context* context, void* pointer, size_t count, size_t element_size) {
    if (pointer == NULL) return;
    const size_t size = count * element_size;
    atomic_fetch_sub(&context->taken, size);
    context->def.free(context->def.alloc_user, pointer, size == 0 ? 1 : size);
}

char* ty_copy_text(ty_context* context, const char* text) {
    if (text == NULL) text = "";
    const size_t size = strlen(text) + 1;
    char* copy = ty_alloc_array(context, size, 1, false);
    if (copy != NULL) memcpy(copy, text, size);
    return copy;
}

void ty_free_text(ty_context* context, char* text) {
    if (text != NULL) ty_free_array(context, text, strlen(text) + 1, 1);
}

bool ty_grow_array(ty_context* context, void** items, size_t* capacity, size_t count, size_t element_size) {
    if (count < *capacity) return true;
    const size_t grown = *capacity == 0 ? 4 : 2 * *capacity;
    void* moved = ty_alloc_array(context, grown, element_size, false);
    if (moved == NULL) return false;
    if (count > 0) memcpy(moved, *items, count * element_size);
    ty_free_array(context, *items, *capacity, element_size);
    *items = moved;
    *capacity = grown;
    return true;
}

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double ty_wall_seconds(void) {
    return clock_seconds(CLOCK_MONOTONIC);
}

double ty_cpu_seconds(void) {
    return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}
