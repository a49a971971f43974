/* Contexts whose work runs on a device. */
#ifndef TY_TESTS_ON_DEVICE_H
#define TY_TESTS_ON_DEVICE_H

#include "checks.h"

static inline ty_context* context_on(const char* device, int32_t threads) {
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    def.device = device;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

#endif
