/* Shared by tests of readers and writers: files in the scratch folder, optional data, a strict allocator. */
#ifndef TY_TESTS_FILES_H
#define TY_TESTS_FILES_H

#include <tyndall/io.h>

#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include <cmocka.h>

/* Counts what is allocated and refuses to go past a limit, or at the n-th allocation. */
typedef struct strict_memory {
    _Atomic size_t used; /* context's threads take memory, too */
    size_t limit;
    _Atomic int64_t until_refusal; /* negative: never */
} strict_memory;

static inline void* strict_alloc(void* user, size_t size) {
    strict_memory* memory = user;
    if (memory->until_refusal == 0 || size > memory->limit - memory->used) return NULL;
    if (memory->until_refusal > 0) --memory->until_refusal;
    void* pointer = aligned_alloc(64, (size + 63) / 64 * 64);
    if (pointer != NULL) memory->used += size;
    return pointer;
}

static inline void strict_free(void* user, void* pointer, size_t size) {
    strict_memory* memory = user;
    memory->used -= size;
    free(pointer);
}

/* device: as in ty_context_def. */
static inline ty_context* strict_device_context(strict_memory* memory, const char* device) {
    ty_context_def def = ty_default_context_def();
    def.threads = 2;
    def.device = device;
    def.alloc = strict_alloc;
    def.free = strict_free;
    def.alloc_user = memory;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

static inline ty_context* strict_context(strict_memory* memory) {
    return strict_device_context(memory, NULL);
}

/* Refuses the first allocation of some work and all after it, then the second and so on: the work fails with a message
 * and gives everything back each time, until there is enough. Returns how often it failed. */
static inline int64_t check_short_memory(ty_context* context, strict_memory* memory,
                                         ty_result (*work)(ty_context* context, void* user), void* user) {
    const size_t before = memory->used;
    for (int64_t refused = 0;; ++refused) {
        memory->until_refusal = refused;
        const ty_result result = work(context, user);
        memory->until_refusal = -1;
        assert_int_equal(memory->used, before);
        assert_int_equal(result == TY_OK, ty_take_error(context)[0] == '\0');
        if (result == TY_OK) return refused;
        assert_int_equal(result, TY_ERROR_MEMORY);
        assert_true(refused < 1000);
    }
}

/* Such work: reads a volume; user: its path. */
static inline ty_result read_volume(ty_context* context, void* user) {
    const ty_volume_def def = ty_default_volume_def();
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, user, &def, &grid);
    if (result == TY_OK) ty_grid_release(grid);
    return result;
}

/* A new file each time: rewriting one in place makes some file systems wait for the disk. */
static inline void put_file(const char* path, const void* bytes, size_t size) {
    remove(path);
    FILE* stream = fopen(path, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, size, stream), size);
    assert_int_equal(fclose(stream), 0);
}

/* The content of a file, to be freed. */
static inline uint8_t* get_file(const char* path, size_t* size) {
    FILE* stream = fopen(path, "rb");
    assert_non_null(stream);
    fseek(stream, 0, SEEK_END);
    const long length = ftell(stream);
    assert_true(length >= 0);
    rewind(stream);
    uint8_t* bytes = malloc((size_t)length + 1);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, (size_t)length, stream), length);
    fclose(stream);
    *size = (size_t)length;
    return bytes;
}

/* True if two files hold the same bytes. */
static inline void assert_file_holds(const char* path, const void* bytes, size_t size) {
    size_t found;
    uint8_t* content = get_file(path, &found);
    assert_int_equal(found, size);
    assert_memory_equal(content, bytes, size);
    free(content);
}

/* The number of temporary files in the scratch folder; they are removed. */
static inline int remove_temporary_files(void) {
    DIR* folder = opendir(".");
    assert_non_null(folder);
    int found = 0;
    for (struct dirent* entry; (entry = readdir(folder)) != NULL;)
        if (strstr(entry->d_name, ".tmp") != NULL) found += remove(entry->d_name) == 0;
    closedir(folder);
    return found;
}

/* From now on files cannot grow past size, as on a full disk; all_space undoes it. */
static inline void little_space(rlim_t size) {
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = size;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static inline void all_space(void) {
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = limit.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

/* The path of a data file that the project does not ship; skips the test when it is absent. */
static inline const char* data_path(const char* name, char path[1024]) {
    const char* folder = getenv("TYNDALL_DATA");
    snprintf(path, 1024, "%s/%s", folder != NULL ? folder : TYNDALL_DATA_DIR, name);
    FILE* stream = fopen(path, "rb");
    if (stream == NULL) {
        printf("skipped: no %s (set TYNDALL_DATA)\n", path);
        skip();
    }
    fclose(stream);
    return path;
}

/* The call failed with this result, and the message is one line that names the file and, if given, the matter. */
static inline void assert_failed(ty_context* context, ty_result result, ty_result expected, const char* path,
                                 const char* matter) {
    const char* message = ty_take_error(context);
    if (result != expected || strchr(message, '\n') != NULL || strstr(message, path) == NULL ||
        (matter != NULL && strstr(message, matter) == NULL))
        fail_msg("expected %s about %s (%s), got %s: \"%s\"", ty_result_name(expected), path,
                 matter == NULL ? "" : matter, ty_result_name(result), message);
}

#endif
