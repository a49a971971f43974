#include "direct/lights/discrete_light.h"

#include "base/context.h"

#include <string.h>

ty_result ty_light_parts_trim(ty_context* context, ty_light_part* items, int64_t capacity, int32_t filled,
                              ty_light_part** out, int32_t* count) {
    ty_light_part* exact = ty_alloc_array(context, (size_t)filled, sizeof *exact, false);
    if (exact != NULL) memcpy(exact, items, (size_t)filled * sizeof *exact);
    ty_free_array(context, items, (size_t)capacity, sizeof *items);
    if (exact == NULL) return TY_ERROR_MEMORY;
    *out = exact;
    *count = filled;
    return TY_OK;
}

void ty_light_parts_destroy(ty_context* context, ty_light_part* parts, int32_t count) {
    ty_free_array(context, parts, (size_t)count, sizeof *parts);
}
