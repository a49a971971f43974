/* Zstandard through libzstd. */
#include "io/textures/textures.h"

#include "base/context.h"

#if TYNDALL_ZSTD

#include <zstd.h>

bool ty_has_zstd(void) {
    return true;
}

size_t ty_zstd_bound(size_t size) {
    return ZSTD_compressBound(size);
}

ty_result ty_zstd_compress(ty_context* context, int32_t level, const uint8_t* bytes, size_t size, uint8_t* out,
                           size_t capacity, size_t* written) {
    *written = ZSTD_compress(out, capacity, bytes, size, level);
    if (!ZSTD_isError(*written)) return TY_OK;
    return ty_fail(context, TY_ERROR_MEMORY, "Zstandard: %s", ZSTD_getErrorName(*written));
}

#else

bool ty_has_zstd(void) {
    return false;
}

size_t ty_zstd_bound(size_t size) {
    return size;
}

ty_result ty_zstd_compress(ty_context* context, int32_t level, const uint8_t* bytes, size_t size, uint8_t* out,
                           size_t capacity, size_t* written) {
    (void)level;
    (void)bytes;
    (void)size;
    (void)out;
    (void)capacity;
    *written = 0;
    return ty_fail(context, TY_ERROR_ARGUMENT, "this build was made without Zstandard");
}

#endif
