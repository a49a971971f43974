/* Points in JSON, from memory. */
#include "fuzz_target.h"

#include "io/points.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    size_t used = 0;
    int64_t count = 0;
    float* points = NULL;
    ty_context* context = fuzz_context(&used);
    const ty_result result = ty_points_parse(context, "fuzz.json", bytes, size, &points, &count);
    if ((result == TY_OK) != (ty_take_error(context)[0] == '\0') || (result == TY_OK && count < 1)) abort();
    for (int64_t i = 0; result == TY_OK && i < 3 * count; ++i)
        if (!isfinite(points[i])) abort();
    if (result == TY_OK) ty_points_destroy(context, points, count);
    fuzz_finish(context, &used);
    return 0;
}
