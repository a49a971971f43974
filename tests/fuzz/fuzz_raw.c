/* Raw volumes: a layout (type, three sides, byte order, offset), then the file's bytes, which go through a file in
 * memory. */
#include "fuzz_target.h"

#include <tyndall/io.h>

#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { LAYOUT_SIZE = 16, SIDE_MAX = 20 };

static ty_volume_def layout_of(const uint8_t* bytes) {
    static const char* const types[] = {"int8",  "uint8",  "int16", "uint16", "int32", "uint32",
                                        "int64", "uint64", "half",  "float",  "double"};
    ty_volume_def def = ty_default_volume_def();
    snprintf(def.raw_type, sizeof def.raw_type, "%s", types[bytes[0] % (sizeof types / sizeof types[0])]);
    for (int a = 0; a < 3; ++a) def.raw_size[a] = bytes[1 + a] % (SIDE_MAX + 1);
    def.raw_big_endian = (bytes[4] & 1) != 0;
    def.component = bytes[5] % 3;
    for (int a = 0; a < 3; ++a) def.raw_spacing[a] = (bytes[4] >> (1 + a) & 1) != 0 ? 0.5 : 0;
    int64_t offset;
    memcpy(&offset, bytes + 8, sizeof offset);
    def.raw_offset = (bytes[4] & 16) != 0 ? -1 : offset;
    return def;
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    if (size < LAYOUT_SIZE) return 0;
    const int file = memfd_create("fuzz.raw", MFD_CLOEXEC);
    const size_t length = size - LAYOUT_SIZE;
    if (file < 0 || write(file, bytes + LAYOUT_SIZE, length) != (ssize_t)length) abort();
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    const ty_volume_def def = layout_of(bytes);
    ty_grid* grid = NULL;
    const ty_result result = ty_volume_read(context, path, &def, &grid);
    if ((result == TY_OK) != (grid != NULL) || (result == TY_OK) != (ty_take_error(context)[0] == '\0')) abort();
    ty_grid_release(grid);
    fuzz_finish(context, &used);
    close(file);
    return 0;
}
