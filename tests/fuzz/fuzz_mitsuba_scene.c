/* Scenes of Mitsuba: as fuzz_pbrt. */
#define FUZZ_MEMORY (1 << 22)
#include "fuzz_language.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    return fuzz_language(TY_LANGUAGE_MITSUBA, bytes, size);
}
