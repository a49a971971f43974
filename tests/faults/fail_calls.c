/* A library to preload (LD_PRELOAD) that makes chosen calls of the C library fail, as on a full disk, a failing device
 * or with exhausted memory. Environment:
 *
 * TYNDALL_FAULT_CALL       group of calls that fail: see the list of groups below
 * TYNDALL_FAULT_AT         number of the first call of the group that fails, from 1 on; 0 (default): none
 * TYNDALL_FAULT_FOREVER=1  all later calls fail, too
 * TYNDALL_FAULT_ERROR      errno of the failure: ENOSPC, EIO, EINTR, ENOMEM, EMFILE, EAGAIN; SHORT: half the bytes are
 *                          written
 * TYNDALL_FAULT_SCOPE      main: only calls between the start and the end of main are counted; all (default)
 * TYNDALL_FAULT_FILES      regular: of calls that write, only those to regular files are counted; all (default)
 * TYNDALL_FAULT_REPORT     file that holds, at any time, also after a crash, 64-bit numbers: the failures so far, and
 *                          the number of calls of each group
 *
 * Calls that the C library makes of itself (write below fwrite, open below fopen) are not seen; malloc's all are. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

/* Groups of calls, in the order of the report. */
typedef enum call_group {
    CALL_WRITE,    /* write, pwrite, writev, pwritev */
    CALL_FWRITE,   /* fwrite */
    CALL_FFLUSH,   /* fflush */
    CALL_FCLOSE,   /* fclose */
    CALL_FSYNC,    /* fsync, fdatasync */
    CALL_RENAME,   /* rename, renameat, renameat2 */
    CALL_CLOSE,    /* close */
    CALL_OPEN,     /* open, openat, creat, mkstemp, mkostemp */
    CALL_FOPEN,    /* fopen, fdopen */
    CALL_READ,     /* read, pread, fread */
    CALL_TRUNCATE, /* ftruncate, fallocate, posix_fallocate */
    CALL_MMAP,     /* mmap */
    CALL_MALLOC,   /* malloc, calloc, realloc, posix_memalign, aligned_alloc, memalign */
    CALL_THREAD,   /* pthread_create */
    CALL_GROUPS
} call_group;

static const char* const group_names[CALL_GROUPS] = {"write",    "fwrite", "fflush", "fclose", "fsync",
                                                     "rename",   "close",  "open",   "fopen",  "read",
                                                     "truncate", "mmap",   "malloc", "thread"};

typedef struct report {
    _Atomic int64_t failures;
    _Atomic int64_t calls[CALL_GROUPS];
} report;

static report own_report;
static report* counts = &own_report;
static int faulty = -1; /* group, -1: none */
static int64_t first;   /* number of the first call that fails */
static int fault_error = EIO;
static bool forever, shortened, main_only, regular_only;
static _Atomic bool ready, in_main;

/* The next definition of a function, found once. Its address is stored as it is, for ISO C has no such conversion. */
#define NEXT(function)                                                                                                 \
    static __typeof__(function)* next;                                                                                 \
    if (next == NULL) {                                                                                                \
        void* const symbol = dlsym(RTLD_NEXT, #function);                                                              \
        memcpy(&next, &symbol, sizeof next);                                                                           \
    }

static int error_number(const char* name) {
    static const struct {
        const char* name;
        int number;
    } known[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO},       {"EINTR", EINTR},
                 {"ENOMEM", ENOMEM}, {"EMFILE", EMFILE}, {"EAGAIN", EAGAIN}};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        if (strcmp(name, known[i].name) == 0) return known[i].number;
    return EIO;
}

static bool is_set_to(const char* variable, const char* value) {
    const char* text = getenv(variable);
    return text != NULL && strcmp(text, value) == 0;
}

/* System calls without the functions that this library replaces. */
static void map_report(const char* path) {
    int (*open_file)(const char*, int, ...) = NULL;
    void* (*map)(void*, size_t, int, int, int, off_t) = NULL;
    int (*resize)(int, off_t) = NULL;
    int (*close_file)(int) = NULL;
    void* const symbols[] = {dlsym(RTLD_NEXT, "open"), dlsym(RTLD_NEXT, "mmap"), dlsym(RTLD_NEXT, "ftruncate"),
                             dlsym(RTLD_NEXT, "close")};
    memcpy(&open_file, &symbols[0], sizeof open_file);
    memcpy(&map, &symbols[1], sizeof map);
    memcpy(&resize, &symbols[2], sizeof resize);
    memcpy(&close_file, &symbols[3], sizeof close_file);
    const int file = open_file(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) return;
    if (resize(file, sizeof(report)) == 0) {
        void* pages = map(NULL, sizeof(report), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
        if (pages != MAP_FAILED) counts = pages;
    }
    close_file(file);
}

__attribute__((constructor)) static void read_environment(void) {
    const char* call = getenv("TYNDALL_FAULT_CALL");
    for (int i = 0; call != NULL && i < CALL_GROUPS; ++i)
        if (strcmp(call, group_names[i]) == 0) faulty = i;
    const char* at = getenv("TYNDALL_FAULT_AT");
    first = at != NULL ? atoll(at) : 0;
    const char* error = getenv("TYNDALL_FAULT_ERROR");
    shortened = error != NULL && strcmp(error, "SHORT") == 0;
    if (error != NULL && !shortened) fault_error = error_number(error);
    forever = is_set_to("TYNDALL_FAULT_FOREVER", "1");
    main_only = is_set_to("TYNDALL_FAULT_SCOPE", "main");
    regular_only = is_set_to("TYNDALL_FAULT_FILES", "regular");
    const char* path = getenv("TYNDALL_FAULT_REPORT");
    if (path != NULL) map_report(path);
    atomic_store(&ready, true);
}

/* Counts a call; true if it has to fail. */
static bool call_fails(call_group group) {
    if (!atomic_load(&ready) || (main_only && !atomic_load(&in_main))) return false;
    const int64_t number = 1 + atomic_fetch_add(&counts->calls[group], 1);
    if ((int)group != faulty || first == 0 || number < first || (number > first && !forever)) return false;
    atomic_fetch_add(&counts->failures, 1);
    return true;
}

static bool is_counted(int file) {
    struct stat status;
    return !regular_only || (fstat(file, &status) == 0 && S_ISREG(status.st_mode));
}

static bool write_fails(int file) {
    const int before = errno;
    const bool fails = is_counted(file) && call_fails(CALL_WRITE);
    errno = fails && !shortened ? fault_error : before;
    return fails;
}

/* Flush, close and write of a stream; messages on stderr are always let through. */
static bool stream_fails(call_group group, FILE* stream) {
    const int before = errno;
    const bool fails = stream != NULL && stream != stderr && is_counted(fileno(stream)) && call_fails(group);
    errno = fails && !shortened ? fault_error : before;
    return fails && !shortened;
}

static bool fails_with_errno(call_group group) {
    if (!call_fails(group)) return false;
    errno = fault_error;
    return true;
}

/* The error flag of a glibc stream, as a failed write sets it. */
static void set_error_flag(FILE* stream) {
    enum { ERROR_SEEN = 0x20 };
    stream->_flags |= ERROR_SEEN;
}

static size_t half(size_t size) {
    return size > 1 ? size / 2 : size;
}

ssize_t write(int file, const void* bytes, size_t size) {
    NEXT(write)
    if (!write_fails(file)) return next(file, bytes, size);
    return shortened ? next(file, bytes, half(size)) : -1;
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
    NEXT(pwrite)
    if (!write_fails(file)) return next(file, bytes, size, offset);
    return shortened ? next(file, bytes, half(size), offset) : -1;
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
    NEXT(pwrite64)
    if (!write_fails(file)) return next(file, bytes, size, offset);
    return shortened ? next(file, bytes, half(size), offset) : -1;
}

ssize_t writev(int file, const struct iovec* parts, int count) {
    NEXT(writev)
    if (!write_fails(file)) return next(file, parts, count);
    return shortened && count > 0 ? next(file, parts, count > 1 ? count / 2 : 1) : -1;
}

ssize_t pwritev(int file, const struct iovec* parts, int count, off_t offset) {
    NEXT(pwritev)
    if (!write_fails(file)) return next(file, parts, count, offset);
    return shortened && count > 0 ? next(file, parts, count > 1 ? count / 2 : 1, offset) : -1;
}

size_t fwrite(const void* bytes, size_t size, size_t count, FILE* stream) {
    NEXT(fwrite)
    if (!stream_fails(CALL_FWRITE, stream)) return next(bytes, size, count, stream);
    set_error_flag(stream);
    return 0;
}

int fflush(FILE* stream) {
    NEXT(fflush)
    if (!stream_fails(CALL_FFLUSH, stream)) return next(stream);
    set_error_flag(stream);
    return EOF;
}

/* The stream is closed, as after a failed fclose, too. */
int fclose(FILE* stream) {
    NEXT(fclose)
    if (!stream_fails(CALL_FCLOSE, stream)) return next(stream);
    const int error = errno;
    next(stream);
    errno = error;
    return EOF;
}

int fsync(int file) {
    NEXT(fsync)
    return fails_with_errno(CALL_FSYNC) ? -1 : next(file);
}

int fdatasync(int file) {
    NEXT(fdatasync)
    return fails_with_errno(CALL_FSYNC) ? -1 : next(file);
}

int rename(const char* from, const char* to) {
    NEXT(rename)
    return fails_with_errno(CALL_RENAME) ? -1 : next(from, to);
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) {
    NEXT(renameat)
    return fails_with_errno(CALL_RENAME) ? -1 : next(from_folder, from, to_folder, to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
    NEXT(renameat2)
    return fails_with_errno(CALL_RENAME) ? -1 : next(from_folder, from, to_folder, to, flags);
}

/* The descriptor is closed, as Linux does with each close that fails. */
int close(int file) {
    NEXT(close)
    if (!call_fails(CALL_CLOSE)) return next(file);
    next(file);
    errno = fault_error;
    return -1;
}

#define OPEN_MODE(flags)                                                                                               \
    mode_t mode = 0;                                                                                                   \
    if (((flags)&O_CREAT) || ((flags)&O_TMPFILE) == O_TMPFILE) {                                                       \
        va_list arguments;                                                                                             \
        va_start(arguments, flags);                                                                                    \
        mode = va_arg(arguments, mode_t);                                                                              \
        va_end(arguments);                                                                                             \
    }

int open(const char* path, int flags, ...) {
    NEXT(open)
    OPEN_MODE(flags)
    return fails_with_errno(CALL_OPEN) ? -1 : next(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    NEXT(open64)
    OPEN_MODE(flags)
    return fails_with_errno(CALL_OPEN) ? -1 : next(path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
    NEXT(openat)
    OPEN_MODE(flags)
    return fails_with_errno(CALL_OPEN) ? -1 : next(folder, path, flags, mode);
}

int openat64(int folder, const char* path, int flags, ...) {
    NEXT(openat64)
    OPEN_MODE(flags)
    return fails_with_errno(CALL_OPEN) ? -1 : next(folder, path, flags, mode);
}

int creat(const char* path, mode_t mode) {
    NEXT(creat)
    return fails_with_errno(CALL_OPEN) ? -1 : next(path, mode);
}

int mkstemp(char* pattern) {
    NEXT(mkstemp)
    return fails_with_errno(CALL_OPEN) ? -1 : next(pattern);
}

int mkostemp(char* pattern, int flags) {
    NEXT(mkostemp)
    return fails_with_errno(CALL_OPEN) ? -1 : next(pattern, flags);
}

FILE* fopen(const char* path, const char* mode) {
    NEXT(fopen)
    return fails_with_errno(CALL_FOPEN) ? NULL : next(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
    NEXT(fopen64)
    return fails_with_errno(CALL_FOPEN) ? NULL : next(path, mode);
}

FILE* fdopen(int file, const char* mode) {
    NEXT(fdopen)
    return fails_with_errno(CALL_FOPEN) ? NULL : next(file, mode);
}

ssize_t read(int file, void* bytes, size_t size) {
    NEXT(read)
    return fails_with_errno(CALL_READ) ? -1 : next(file, bytes, size);
}

ssize_t pread(int file, void* bytes, size_t size, off_t offset) {
    NEXT(pread)
    return fails_with_errno(CALL_READ) ? -1 : next(file, bytes, size, offset);
}

size_t fread(void* bytes, size_t size, size_t count, FILE* stream) {
    NEXT(fread)
    if (!fails_with_errno(CALL_READ)) return next(bytes, size, count, stream);
    set_error_flag(stream);
    return 0;
}

int ftruncate(int file, off_t size) {
    NEXT(ftruncate)
    return fails_with_errno(CALL_TRUNCATE) ? -1 : next(file, size);
}

int fallocate(int file, int mode, off_t offset, off_t size) {
    NEXT(fallocate)
    return fails_with_errno(CALL_TRUNCATE) ? -1 : next(file, mode, offset, size);
}

int posix_fallocate(int file, off_t offset, off_t size) {
    NEXT(posix_fallocate)
    return call_fails(CALL_TRUNCATE) ? fault_error : next(file, offset, size);
}

void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset) {
    NEXT(mmap)
    return fails_with_errno(CALL_MMAP) ? MAP_FAILED : next(at, size, protection, flags, file, offset);
}

void* mmap64(void* at, size_t size, int protection, int flags, int file, off64_t offset) {
    NEXT(mmap64)
    return fails_with_errno(CALL_MMAP) ? MAP_FAILED : next(at, size, protection, flags, file, offset);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*), void* argument) {
    NEXT(pthread_create)
    return call_fails(CALL_THREAD) ? EAGAIN : next(thread, attributes, body, argument);
}

/* dlsym allocates: the allocator's own names are used. */
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* block, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

static bool malloc_fails(void) {
    if (!call_fails(CALL_MALLOC)) return false;
    errno = ENOMEM;
    return true;
}

void* malloc(size_t size) {
    return malloc_fails() ? NULL : __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
    return malloc_fails() ? NULL : __libc_calloc(count, size);
}

void* realloc(void* block, size_t size) {
    return malloc_fails() ? NULL : __libc_realloc(block, size);
}

void* memalign(size_t alignment, size_t size) {
    return malloc_fails() ? NULL : __libc_memalign(alignment, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
    return malloc_fails() ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void** out, size_t alignment, size_t size) {
    void* block = call_fails(CALL_MALLOC) ? NULL : __libc_memalign(alignment, size);
    if (block == NULL) return ENOMEM;
    *out = block;
    return 0;
}

typedef int (*main_function)(int, char**, char**);
static main_function program_main;

static int counted_main(int count, char** arguments, char** environment) {
    atomic_store(&in_main, true);
    const int status = program_main(count, arguments, environment);
    atomic_store(&in_main, false);
    return status;
}

int __libc_start_main(main_function body, int count, char** arguments, void (*begin)(void), void (*end)(void),
                      void (*unload)(void), void* stack_end);

int __libc_start_main(main_function body, int count, char** arguments, void (*begin)(void), void (*end)(void),
                      void (*unload)(void), void* stack_end) {
    NEXT(__libc_start_main)
    program_main = body;
    return next(counted_main, count, arguments, begin, end, unload, stack_end);
}
