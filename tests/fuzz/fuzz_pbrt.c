/* Scenes of pbrt: whatever the bytes, the reader must refuse them with a message or write a scene file, and leak
 * nothing. No files may be named, and memory is capped. */
#define FUZZ_MEMORY (1 << 22)
#include "fuzz_language.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_language(TY_LANGUAGE_PBRT, bytes, size);
}
