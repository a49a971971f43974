#define _GNU_SOURCE
#include "base/mapping.h"

#include "base/context.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { PATH_SIZE = 4096, LOOK_NS = 2000000, NS = 1000000000 };
/* Bytes of a mapping that are unloaded between two looks at what is in memory, at least. */
enum { UNLOADED_LEAST = 1 << 22 };
/* Bytes of an array from which on ty_alloc_large makes a file. */
enum { LARGE = 1 << 22 };

static void take_change(const struct stat* status, int64_t changed[2]) {
    changed[0] = status->st_mtim.tv_sec;
    changed[1] = status->st_mtim.tv_nsec;
}

/* Bytes of files in the process's memory; 0 if unknown. */
static size_t resident_bytes(void) {
    char text[128];
    unsigned long long all, resident, shared;
    const int descriptor = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return 0;
    const ssize_t length = read(descriptor, text, sizeof text - 1);
    close(descriptor);
    if (length <= 0) return 0;
    text[length] = '\0';
    if (sscanf(text, "%llu %llu %llu", &all, &resident, &shared) != 3) return 0;
    return (size_t)shared * (size_t)sysconf(_SC_PAGESIZE);
}

void ty_mapping_ring_create(ty_mapping_ring* ring, size_t limit) {
    *ring = (ty_mapping_ring){.limit = limit};
    pthread_mutex_init(&ring->lock, NULL);
}

void ty_mapping_ring_destroy(ty_mapping_ring* ring) {
    pthread_mutex_destroy(&ring->lock);
}

/* ---- one mapping ---- */

static void insert(ty_mapping_ring* ring, ty_mapping* mapping) {
    pthread_mutex_lock(&ring->lock);
    mapping->next = mapping->previous = mapping;
    if (ring->hand == NULL) {
        ring->hand = mapping;
        ring->offset = 0;
        ring->others = resident_bytes();
    } else {
        mapping->next = ring->hand;
        mapping->previous = ring->hand->previous;
        mapping->previous->next = mapping->next->previous = mapping;
    }
    atomic_fetch_add(&ring->count, 1);
    pthread_mutex_unlock(&ring->lock);
}

static void take_out(ty_mapping_ring* ring, ty_mapping* mapping) {
    pthread_mutex_lock(&ring->lock);
    mapping->next->previous = mapping->previous;
    mapping->previous->next = mapping->next;
    if (ring->hand == mapping) {
        ring->hand = mapping->next != mapping ? mapping->next : NULL;
        ring->offset = 0;
    }
    atomic_fetch_sub(&ring->count, 1);
    pthread_mutex_unlock(&ring->lock);
}

static ty_result make_mapping(ty_context* context, const char* path, ty_mapping** out) {
    ty_mapping* mapping = ty_alloc_array(context, 1, sizeof *mapping, true);
    if (mapping == NULL) return TY_ERROR_MEMORY;
    mapping->context = context;
    mapping->descriptor = -1;
    mapping->path = path != NULL ? ty_copy_text(context, path) : NULL;
    *out = mapping;
    if (path == NULL || mapping->path != NULL) return TY_OK;
    ty_free_array(context, mapping, 1, sizeof *mapping);
    return TY_ERROR_MEMORY;
}

static void free_mapping(ty_mapping* mapping) {
    ty_context* context = mapping->context;
    if (mapping->descriptor >= 0) close(mapping->descriptor);
    ty_free_text(context, mapping->path);
    ty_free_array(context, mapping, 1, sizeof *mapping);
}

/* The mapping of an open file of mapping->size bytes, among those of its context; on failure it is freed. */
static ty_result map(ty_mapping* mapping, int protection, const char* name, ty_mapping** out) {
    void* bytes = mmap(NULL, mapping->size, protection, MAP_SHARED, mapping->descriptor, 0);
    if (bytes == MAP_FAILED) {
        const ty_result result = ty_fail(mapping->context, TY_ERROR_FILE, "cannot map %zu bytes of %s: %s",
                                         mapping->size, name, strerror(errno));
        free_mapping(mapping);
        return result;
    }
    mapping->bytes = bytes;
    insert(ty_context_mappings(mapping->context), mapping);
    *out = mapping;
    return TY_OK;
}

ty_result ty_mapping_create(ty_context* context, size_t size, ty_mapping** out) {
    const char* folder = getenv("TMPDIR");
    char name[PATH_SIZE];
    ty_mapping* mapping = NULL;
    if (folder == NULL || folder[0] == '\0') folder = "/tmp";
    const int length = snprintf(name, sizeof name, "%s/tyndall-XXXXXX", folder);
    if (length < 0 || (size_t)length >= sizeof name)
        return ty_fail(context, TY_ERROR_FILE, "TMPDIR is longer than %zu bytes", sizeof name);
    ty_result result = make_mapping(context, NULL, &mapping);
    if (result != TY_OK) return result;
    mapping->size = size;
    mapping->descriptor = mkostemp(name, O_CLOEXEC);
    int error = mapping->descriptor >= 0 ? 0 : errno;
    if (error == 0) {
        unlink(name);
        do error = posix_fallocate(mapping->descriptor, 0, (off_t)size);
        while (error == EINTR);
    }
    if (error == 0) return map(mapping, PROT_READ | PROT_WRITE, folder, out);
    free_mapping(mapping);
    return ty_fail(context, TY_ERROR_FILE, "cannot write %zu bytes of paged arrays to %s: %s", size, folder,
                   strerror(error));
}

static ty_result open_file(ty_mapping* mapping) {
    struct stat status;
    mapping->descriptor = open(mapping->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (mapping->descriptor < 0 || fstat(mapping->descriptor, &status) != 0)
        return ty_fail(mapping->context, TY_ERROR_FILE, "cannot open %s: %s", mapping->path, strerror(errno));
    if (!S_ISREG(status.st_mode))
        return ty_fail(mapping->context, TY_ERROR_FILE, "cannot open %s: not a regular file", mapping->path);
    if (status.st_size < 1) return ty_fail(mapping->context, TY_ERROR_INPUT, "%s: empty", mapping->path);
    mapping->size = (size_t)status.st_size;
    take_change(&status, mapping->changed);
    return TY_OK;
}

ty_result ty_mapping_open(ty_context* context, const char* path, ty_mapping** out) {
    ty_mapping* mapping = NULL;
    ty_result result = make_mapping(context, path, &mapping);
    if (result != TY_OK) return result;
    result = open_file(mapping);
    if (result == TY_OK) return map(mapping, PROT_READ, path, out);
    free_mapping(mapping);
    return result;
}

void ty_mapping_close(ty_mapping* mapping) {
    if (mapping == NULL) return;
    take_out(ty_context_mappings(mapping->context), mapping);
    munmap(mapping->bytes, mapping->size);
    free_mapping(mapping);
}

/* Bytes from the begin of a mapping to the first page that may be unloaded. */
static size_t kept_pages(const ty_mapping* mapping) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    return (mapping->kept + page - 1) / page * page;
}

void ty_mapping_expect_random(ty_mapping* mapping) {
    const size_t kept = kept_pages(mapping);
    if (kept < mapping->size) madvise(mapping->bytes + kept, mapping->size - kept, MADV_RANDOM);
}

void ty_mapping_prefetch(const ty_mapping* mapping, const void* from, size_t bytes) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t offset = (size_t)((const uint8_t*)from - mapping->bytes), first = offset / page * page;
    madvise(mapping->bytes + first, offset - first + bytes, MADV_WILLNEED);
}

void ty_mapping_unload(const ty_mapping* mapping, size_t from, size_t to) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), first = (from + page - 1) / page * page;
    if (to > first) madvise(mapping->bytes + first, (to - first) / page * page, MADV_DONTNEED);
}

/* ---- all mappings of a context ---- */

void* ty_alloc_large(ty_context* context, size_t count, size_t size, bool zero) {
    ty_mapping* mapping = NULL;
    if (ty_context_mappings(context)->limit == 0 || size == 0 || count > SIZE_MAX / size || count * size < LARGE)
        return ty_alloc_array(context, count, size, zero);
    return ty_mapping_create(context, count * size, &mapping) == TY_OK ? mapping->bytes : NULL;
}

void ty_free_large(ty_context* context, void* array, size_t count, size_t size) {
    ty_mapping_ring* ring = ty_context_mappings(context);
    ty_mapping* found = NULL;
    if (array == NULL) return;
    pthread_mutex_lock(&ring->lock);
    for (ty_mapping* m = ring->hand; m != NULL && found == NULL; m = m->next != ring->hand ? m->next : NULL)
        if (m->bytes == array) found = m;
    pthread_mutex_unlock(&ring->lock);
    if (found != NULL)
        ty_mapping_close(found);
    else
        ty_free_array(context, array, count, size);
}

bool ty_mappings_are_bounded(ty_context* context) {
    const ty_mapping_ring* ring = ty_context_mappings(context);
    return ring->limit != 0 && atomic_load_explicit(&ring->count, memory_order_relaxed) > 0;
}

static size_t resident_in(const ty_mapping_ring* ring) {
    const size_t all = resident_bytes();
    return all > ring->others ? all - ring->others : 0;
}

/* Unloads the next pages, up to `wanted` bytes or the end of a mapping. Returns how many bytes of the ring were passed.
 */
static size_t advance(ty_mapping_ring* ring, size_t wanted) {
    ty_mapping* mapping = ring->hand;
    const size_t kept = kept_pages(mapping), from = ring->offset > kept ? ring->offset : kept;
    const size_t left = from < mapping->size ? mapping->size - from : 0, bytes = left < wanted ? left : wanted;
    if (bytes > 0) madvise(mapping->bytes + from, bytes, MADV_DONTNEED);
    const size_t passed = from + bytes - ring->offset;
    ring->offset = from + bytes;
    if (bytes < left) return passed;
    ring->hand = mapping->next;
    ring->offset = 0;
    return passed;
}

/* Unloads until a quarter of the limit is free, once around the ring at most. Pages in memory are taken to be spread
 * evenly. */
static void unload(ty_mapping_ring* ring) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), target = ring->limit - ring->limit / 4;
    const ty_mapping* first = ring->hand;
    size_t total = first->size, passed = 0, resident;
    for (const ty_mapping* m = first->next; m != first; m = m->next) total += m->size;
    while (passed < total && (resident = resident_in(ring)) > target) {
        const double part = (double)(resident - target) / (double)resident;
        const size_t bytes = (size_t)(part * (double)total) / page * page;
        passed += advance(ring, bytes > UNLOADED_LEAST ? bytes : UNLOADED_LEAST);
    }
}

void ty_mappings_trim(ty_context* context) {
    ty_mapping_ring* ring = ty_context_mappings(context);
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    const int64_t ns = now.tv_sec * (int64_t)NS + now.tv_nsec;
    if (ns < atomic_load_explicit(&ring->next_look, memory_order_relaxed)) return;
    if (pthread_mutex_trylock(&ring->lock) != 0) return;
    atomic_store_explicit(&ring->next_look, ns + LOOK_NS, memory_order_relaxed);
    if (ring->hand != NULL && resident_in(ring) > ring->limit) unload(ring);
    pthread_mutex_unlock(&ring->lock);
}

static ty_result check_unchanged(const ty_mapping* mapping) {
    struct stat status;
    int64_t changed[2];
    if (mapping->path == NULL || fstat(mapping->descriptor, &status) != 0) return TY_OK;
    take_change(&status, changed);
    if ((size_t)status.st_size == mapping->size && memcmp(changed, mapping->changed, sizeof changed) == 0) return TY_OK;
    return ty_fail(mapping->context, TY_ERROR_INPUT, "%s was changed while it was read", mapping->path);
}

ty_result ty_mappings_check(ty_context* context) {
    ty_mapping_ring* ring = ty_context_mappings(context);
    ty_result result = TY_OK;
    pthread_mutex_lock(&ring->lock);
    ty_mapping* mapping = ring->hand;
    while (mapping != NULL && result == TY_OK) {
        result = check_unchanged(mapping);
        mapping = mapping->next != ring->hand ? mapping->next : NULL;
    }
    pthread_mutex_unlock(&ring->lock);
    return result;
}
