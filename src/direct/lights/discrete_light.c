#include "direct/lights/discrete_light.h"

#include "base/context.h"

ty_result ty_discrete_light_set_create(ty_context* context, const char* what, int64_t capacity,
                                       ty_discrete_light_set* out) {
    *out = (ty_discrete_light_set){.items = NULL};
    if (capacity > INT32_MAX)
        return ty_fail(context, TY_ERROR_ARGUMENT, "%s: %lld directions and points of lights", what,
                       (long long)capacity);
    out->items = ty_alloc_array(context, (size_t)capacity, sizeof *out->items, false);
    if (out->items == NULL) return TY_ERROR_MEMORY;
    out->capacity = (int32_t)capacity;
    return TY_OK;
}

void ty_discrete_light_set_destroy(ty_context* context, ty_discrete_light_set* set) {
    ty_free_array(context, set->items, (size_t)set->capacity, sizeof *set->items);
    *set = (ty_discrete_light_set){.items = NULL};
}
