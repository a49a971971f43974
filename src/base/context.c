/* Contexts: errors, logging, memory, clocks. */
#define _GNU_SOURCE
#include "base/context.h"
#include "base/mapping.h"
#include "base/thread_errors.h"
#include "base/thread_pool.h"

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

enum { ALIGNMENT = 64 };
/* Bytes of a large page, and minimum array size for rounding to whole large pages. */
enum { LARGE_PAGE = 1 << 21, LARGE = 1 << 22 };
/* Bytes of a device's name at most, with its end. */
enum { DEVICE_NAME_SIZE = 32 };

static const double mebibyte = 1048576;

struct ty_context {
    ty_context_def def;
    int32_t threads;
    uint64_t number;       /* no two contexts of a process share one; from 1 on */
    pthread_mutex_t lock;  /* of the log callback */
    double machine_memory; /* bytes */
    _Atomic size_t taken;  /* bytes of allocated arrays */
    char device[DEVICE_NAME_SIZE];
    pthread_mutex_t slot_lock; /* of the slot's making */
    void* slot;                /* NULL: none, or not asked for yet */
    void (*close_slot)(void* object);
    ty_mapping_ring mappings;
    struct ty_work_queue* queue; /* NULL: no other processes */
    ty_thread_pool pool;         /* all threads but the caller's */
    ty_pool_thread pool_threads[];
};

const char* ty_result_name(ty_result result) {
    switch (result) {
    case TY_OK: return "TY_OK";
    case TY_CANCELLED: return "TY_CANCELLED";
    case TY_ERROR_ARGUMENT: return "TY_ERROR_ARGUMENT";
    case TY_ERROR_INPUT: return "TY_ERROR_INPUT";
    case TY_ERROR_FILE: return "TY_ERROR_FILE";
    case TY_ERROR_MEMORY: return "TY_ERROR_MEMORY";
    case TY_ERROR_UNSUPPORTED: return "TY_ERROR_UNSUPPORTED";
    case TY_ERROR_INTERNAL: return "TY_ERROR_INTERNAL";
    }
    return "unknown";
}

const char* ty_result_text(ty_result result) {
    switch (result) {
    case TY_OK: return "done";
    case TY_CANCELLED: return "cancelled by the progress callback";
    case TY_ERROR_ARGUMENT: return "an argument of the call is wrong";
    case TY_ERROR_INPUT: return "the content of a file is wrong";
    case TY_ERROR_FILE: return "a file cannot be opened, read or written";
    case TY_ERROR_MEMORY: return "not enough memory";
    case TY_ERROR_UNSUPPORTED: return "not available in this build or on this machine";
    case TY_ERROR_INTERNAL: return "a library below failed unexpectedly";
    }
    return "unknown";
}

const char* ty_version(void) {
    return TY_VERSION;
}

static size_t round_up(size_t size, size_t to) {
    return (size + to - 1) / to * to;
}

void ty_mark_def(void* def, size_t bytes) {
    const ty_def_head head = {TY_DEF_COOKIE, (uint32_t)bytes};
    memcpy(def, &head, sizeof head);
}

void ty_init_def(void* def, size_t bytes, const void* defaults, size_t size) {
    memset(def, 0, bytes);
    memcpy(def, defaults, bytes < size ? bytes : size);
    ty_mark_def(def, bytes);
}

ty_result ty_check_def(ty_context* context, const void* def, const char* default_function) {
    ty_def_head head = {0, 0};
    if (def != NULL) memcpy(&head, def, sizeof head);
    if (head.cookie == TY_DEF_COOKIE && head.bytes >= sizeof head) return TY_OK;
    return ty_fail(context, TY_ERROR_ARGUMENT, "a def was not made by %s()", default_function);
}

size_t ty_def_bytes(const void* def) {
    ty_def_head head;
    memcpy(&head, def, sizeof head);
    return head.bytes;
}

ty_result ty_take_def(ty_context* context, const void* def, const char* default_function, void* own, size_t size) {
    const ty_result result = ty_check_def(context, def, default_function);
    if (result != TY_OK) return result;
    const size_t bytes = ty_def_bytes(def);
    if (bytes > size)
        return ty_fail(context, TY_ERROR_ARGUMENT,
                       "a def of %s() has %zu bytes, and this library knows %zu: the program was compiled against a "
                       "newer version",
                       default_function, bytes, size);
    memcpy(own, def, bytes);
    ty_mark_def(own, size);
    return TY_OK;
}

void ty_init_stats(void* stats, size_t bytes) {
    memset(stats, 0, bytes);
    ty_mark_def(stats, bytes);
}

static size_t min_bytes(const void* stats, size_t size) {
    const size_t bytes = ty_def_bytes(stats);
    return bytes < size ? bytes : size;
}

ty_result ty_take_stats(ty_context* context, const void* stats, const char* default_function, void* own, size_t size) {
    ty_def_head head = {TY_DEF_COOKIE, sizeof head};
    if (stats != NULL) memcpy(&head, stats, sizeof head);
    memset(own, 0, size);
    if (head.cookie != TY_DEF_COOKIE || head.bytes < sizeof head)
        return ty_fail(context, TY_ERROR_ARGUMENT, "stats were not made by %s()", default_function);
    if (stats != NULL) memcpy(own, stats, min_bytes(stats, size));
    return TY_OK;
}

void ty_give_stats(const void* own, size_t size, void* stats) {
    const size_t head = sizeof(ty_def_head);
    if (stats != NULL) memcpy((char*)stats + head, (const char*)own + head, min_bytes(stats, size) - head);
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

void ty_init_context_def(void* def, size_t bytes) {
    const ty_context_def own = {.threads = TY_AUTO};
    ty_init_def(def, bytes, &own, sizeof own);
}

/* The number of contexts that were made in this process. */
static _Atomic uint64_t contexts_made;

static size_t context_size(int32_t threads) {
    return sizeof(ty_context) + (size_t)(threads - 1) * sizeof(ty_pool_thread);
}

static ty_result check_context_def(const ty_context_def* def) {
    if (def->threads != TY_AUTO && (def->threads < 1 || def->threads > TY_THREADS_MAX))
        return ty_fail(NULL, TY_ERROR_ARGUMENT,
                       "context: threads: %d is outside [1, %d]; write TY_AUTO for one per processor", def->threads,
                       TY_THREADS_MAX);
    if ((def->alloc == NULL) != (def->free == NULL))
        return ty_fail(NULL, TY_ERROR_ARGUMENT, "context: one of alloc and free is given without the other");
    if (def->device != NULL && strlen(def->device) >= DEVICE_NAME_SIZE)
        return ty_fail(NULL, TY_ERROR_ARGUMENT, "context: device: its name is longer than %d letters",
                       DEVICE_NAME_SIZE - 1);
    if (def->resident_bytes < 0)
        return ty_fail(NULL, TY_ERROR_ARGUMENT, "context: resident_bytes: %lld is below 0",
                       (long long)def->resident_bytes);
    return TY_OK;
}

ty_result ty_context_create(const ty_context_def* def, ty_context** out) {
    if (out == NULL) return ty_fail(NULL, TY_ERROR_ARGUMENT, "ty_context_create: out is NULL");
    ty_context_def copy = ty_default_context_def();
    ty_result result = ty_take_def(NULL, def, "ty_default_context_def", &copy, sizeof copy);
    if (result == TY_OK) result = check_context_def(&copy);
    if (result != TY_OK) return result;
    if (copy.alloc == NULL) {
        copy.alloc = default_alloc;
        copy.free = default_free;
    }
    const int32_t processors = available_processors(), threads = copy.threads > 0 ? copy.threads : processors;
    ty_context* context = copy.alloc(copy.alloc_user, context_size(threads));
    if (context == NULL) return ty_fail(NULL, TY_ERROR_MEMORY, "not enough memory for a context");
    memset(context, 0, context_size(threads));
    context->number = 1 + atomic_fetch_add(&contexts_made, 1);
    context->def = copy;
    context->threads = threads;
    ty_thread_pool_create(&context->pool, context->pool_threads, threads - 1, threads <= processors);
    ty_mapping_ring_create(&context->mappings, (size_t)copy.resident_bytes);
    context->machine_memory = physical_memory();
    atomic_init(&context->taken, 0);
    pthread_mutex_init(&context->lock, NULL);
    pthread_mutex_init(&context->slot_lock, NULL);
    snprintf(context->device, sizeof context->device, "%s", copy.device != NULL ? copy.device : "cpu");
    context->def.device = context->device;
    *out = context;
    return TY_OK;
}

void ty_context_destroy(ty_context* context) {
    if (context == NULL) return;
    if (context->slot != NULL) context->close_slot(context->slot);
    pthread_mutex_destroy(&context->slot_lock);
    ty_thread_pool_destroy(&context->pool);
    ty_mapping_ring_destroy(&context->mappings);
    pthread_mutex_destroy(&context->lock);
    const ty_context_def def = context->def;
    def.free(def.alloc_user, context, context_size(context->threads));
}

/* Messages of calls that had no context are kept under 0. */
static uint64_t number_of(const ty_context* context) {
    return context != NULL ? context->number : 0;
}

const char* ty_take_error(ty_context* context) {
    return ty_errors_take(number_of(context));
}

bool ty_has_error(const ty_context* context) {
    return ty_errors_has(number_of(context));
}

int32_t ty_context_threads(const ty_context* context) {
    return context->threads;
}

const char* ty_context_device_name(const ty_context* context) {
    return context->device;
}

ty_mapping_ring* ty_context_mappings(ty_context* context) {
    return &context->mappings;
}

void ty_context_set_queue(ty_context* context, struct ty_work_queue* queue) {
    context->queue = queue;
}

struct ty_work_queue* ty_context_queue(const ty_context* context) {
    return context->queue;
}

ty_result ty_context_slot(ty_context* context, ty_result (*open)(ty_context* context, void** out),
                          void (*close)(void* object), void** out) {
    pthread_mutex_lock(&context->slot_lock);
    ty_result result = TY_OK;
    if (context->slot == NULL) result = open(context, &context->slot);
    context->close_slot = close;
    *out = context->slot;
    pthread_mutex_unlock(&context->slot_lock);
    return result;
}

ty_thread_pool* ty_context_pool(ty_context* context) {
    return &context->pool;
}

static void log_line(ty_context* context, ty_log_level level, const char* text) {
    if (context == NULL || context->def.log == NULL) return;
    pthread_mutex_lock(&context->lock);
    context->def.log(context->def.log_user, level, text);
    pthread_mutex_unlock(&context->lock);
}

ty_result ty_fail(ty_context* context, ty_result result, const char* format, ...) {
    char text[TY_MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ty_errors_keep(number_of(context), text);
    log_line(context, TY_LOG_ERROR, text);
    return result;
}

void ty_log(ty_context* context, ty_log_level level, const char* format, ...) {
    if (context->def.log == NULL) return;
    char text[TY_MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log_line(context, level, text);
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
    ty_thread_pool_run(&context->pool, (int64_t)((size + CLEARED_AT_ONCE - 1) / CLEARED_AT_ONCE), clear_part, &all);
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
