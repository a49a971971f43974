/* Files of impulse responses: the bytes as they are, and then as changes (exclusive or) to a true file, with and
 * without the checksum that belongs to it. Tables that are taken up answer with finite numbers or not at all. */
#include "fuzz_target.h"

#include "method/impulse/tables.h"

#include <math.h>

static void try_look(const ty_impulse* tables) {
    const ty_impulse_medium medium = {2, 1, 0.3f};
    ty_impulse_response response;
    for (int emitter = 0; emitter < 3; ++emitter)
        ty_impulse_look(tables, (ty_impulse_emitter)emitter, &medium, 0.7f, 0.4f, 64, &response);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    ty_context* context = fuzz_context(&used);
    ty_impulse_def def = ty_default_impulse_def();
    def.bounces = 1;
    ty_impulse* tables = NULL;
    if (ty_impulse_allocate(context, &def, &tables) != TY_OK) abort();
    const size_t whole = ty_impulse_file_size(tables);
    uint8_t* file = malloc(whole);
    if (file == NULL) abort();
    ty_impulse_pack(tables, file);
    if (ty_impulse_unpack(tables, bytes, size) == NULL) try_look(tables);
    bool changed = false;
    for (size_t i = 0; i < size && i < whole; ++i) {
        file[i] ^= bytes[i];
        changed = changed || bytes[i] != 0;
    }
    /* The checksum notices what it guards, and the rest is checked by itself. */
    if ((ty_impulse_unpack(tables, file, whole) == NULL) == changed) abort();
    ty_impulse_seal(file, whole);
    if (ty_impulse_unpack(tables, file, whole) == NULL) {
        for (size_t i = 0; i < tables->count; ++i)
            if (!isfinite(tables->values[i])) abort();
        try_look(tables);
    }
    ty_impulse_unpack(tables, file, size < whole ? size : whole);
    free(file);
    ty_impulse_destroy(tables);
    fuzz_finish(context, &used);
    return 0;
}
