/* Table files: a header that identifies the tables, then their values as in memory. A file that does not match is
 * rebuilt, so nothing here is an error. */
#define _POSIX_C_SOURCE 200809L
#include "io/file.h"

#include "method/impulse/tables.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Incremented when contents or construction of the tables change; tables of another version are stale. */
enum { TABLES_VERSION = 3, BYTE_ORDER_MARK = 0x01020304, PATH_SIZE = 1024 };

static const char tables_magic[8] = "tyndimpr";

typedef struct tables_header {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t size;     /* of the whole file */
    uint64_t checksum; /* of everything after it */
    double range;
    int32_t bounces, row;
} tables_header;

static const size_t checked_from = offsetof(tables_header, range);

size_t ty_impulse_file_size(const ty_impulse* tables) {
    return sizeof(tables_header) + tables->count * sizeof *tables->values;
}

static tables_header make_header(const ty_impulse* tables) {
    tables_header header;
    memset(&header, 0, sizeof header);
    memcpy(header.magic, tables_magic, sizeof header.magic);
    header.version = TABLES_VERSION;
    header.byte_order = BYTE_ORDER_MARK;
    header.size = ty_impulse_file_size(tables);
    header.range = tables->range;
    header.bounces = tables->bounces;
    header.row = tables->row;
    return header;
}

void ty_impulse_seal(uint8_t* bytes, size_t size) {
    if (size < sizeof(tables_header)) return;
    const uint64_t sum = ty_hash_bytes(TY_HASH_START, bytes + checked_from, size - checked_from);
    memcpy(bytes + offsetof(tables_header, checksum), &sum, sizeof sum);
}

void ty_impulse_pack(const ty_impulse* tables, uint8_t* bytes) {
    const tables_header header = make_header(tables);
    memcpy(bytes, &header, sizeof header);
    memcpy(bytes + sizeof header, tables->values, tables->count * sizeof *tables->values);
    ty_impulse_seal(bytes, ty_impulse_file_size(tables));
}

const char* ty_impulse_unpack(ty_impulse* tables, const uint8_t* bytes, size_t size) {
    const tables_header expected = make_header(tables);
    tables_header found;
    if (size < sizeof found) return "it is cut short";
    memcpy(&found, bytes, sizeof found);
    if (memcmp(found.magic, expected.magic, sizeof found.magic) != 0) return "it holds no impulse responses";
    if (found.version != expected.version || found.byte_order != expected.byte_order) return "it is of another version";
    if (found.size != size || size != expected.size) return "it is cut short or damaged";
    if (found.checksum != ty_hash_bytes(TY_HASH_START, bytes + checked_from, size - checked_from))
        return "it is damaged";
    if (!(found.range == expected.range) || found.bounces != expected.bounces || found.row != expected.row)
        return "it has other bounces or another range";
    memcpy(tables->values, bytes + sizeof found, tables->count * sizeof *tables->values);
    for (size_t i = 0; i < tables->count; ++i)
        if (!isfinite(tables->values[i])) return "it holds what is no number";
    return NULL;
}

/* ---- location ---- */

/* The cache folder; false: none, or its name is too long. */
static bool cache_folder(char out[PATH_SIZE]) {
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int length = -1;
    /* The XDG specification treats relative names as unset. */
    if (cache != NULL && cache[0] == '/')
        length = snprintf(out, PATH_SIZE, "%s/tyndall", cache);
    else if (home != NULL && home[0] == '/')
        length = snprintf(out, PATH_SIZE, "%s/.cache/tyndall", home);
    return length > 0 && length < PATH_SIZE;
}

void ty_impulse_path(const ty_impulse_def* def, char path[PATH_SIZE]) {
    char folder[PATH_SIZE] = "", name[64];
    path[0] = '\0';
    if (def->folder == NULL) {
        if (!cache_folder(folder)) return;
    } else if (snprintf(folder, sizeof folder, "%s", def->folder) >= PATH_SIZE) {
        return;
    }
    if (folder[0] == '\0') return;
    /* Thousandths, so that names are independent of the locale; the header holds the exact range. */
    snprintf(name, sizeof name, "impulse-%d-%ld.tables", (int)def->bounces, lround(1000 * def->range));
    if (strlen(folder) + 1 + strlen(name) >= PATH_SIZE) return;
    memcpy(path, folder, strlen(folder));
    path[strlen(folder)] = '/';
    memcpy(path + strlen(folder) + 1, name, strlen(name) + 1);
}

/* Creates the parent folders of a file; failures surface when the file is written. */
static void make_folders(const char* path) {
    char folder[PATH_SIZE];
    const size_t length = strlen(path);
    for (size_t i = 1; i < length; ++i) {
        if (path[i] != '/') continue;
        memcpy(folder, path, i);
        folder[i] = '\0';
        mkdir(folder, 0777);
    }
}

/* ---- reading and writing ---- */

bool ty_impulse_load(ty_impulse* tables, const char* path) {
    uint64_t size = 0;
    FILE* stream = ty_open_regular(path, &size);
    if (stream == NULL) return false;
    const size_t expected = ty_impulse_file_size(tables);
    const char* reason = size == expected ? NULL : "it has another size";
    uint8_t* bytes = reason == NULL ? ty_alloc_array(tables->context, expected, 1, false) : NULL;
    if (bytes != NULL) {
        reason = fread(bytes, 1, expected, stream) == expected ? ty_impulse_unpack(tables, bytes, expected)
                                                               : "reading failed";
        ty_free_array(tables->context, bytes, expected, 1);
    }
    fclose(stream);
    if (reason != NULL) ty_log(tables->context, TY_LOG_INFO, "%s is made anew: %s", path, reason);
    return bytes != NULL && reason == NULL;
}

bool ty_impulse_save(const ty_impulse* tables, const char* path) {
    const size_t size = ty_impulse_file_size(tables);
    uint8_t* bytes = ty_alloc_array(tables->context, size, 1, false);
    if (bytes == NULL) return false;
    /* Errors go to a separate context, so that a failed save does not mark this one as failed. */
    ty_context* error_context = NULL;
    const ty_context_def def = ty_default_context_def();
    bool written = false;
    if (ty_context_create(&def, &error_context) == TY_OK) {
        ty_impulse_pack(tables, bytes);
        make_folders(path);
        written = ty_write_file(error_context, path, bytes, size) == TY_OK;
        if (!written)
            ty_log(tables->context, TY_LOG_WARNING, "impulse responses are not kept: %s", ty_take_error(error_context));
    }
    ty_context_destroy(error_context);
    ty_free_array(tables->context, bytes, size, 1);
    return written;
}
