/* Contexts whose work runs on a device. */
#ifndef TY_TESTS_ON_DEVICE_H
#define TY_TESTS_ON_DEVICE_H

#include "checks.h"
#include "files.h"

#include "device/device.h"

#include <tyndall/io.h>

static inline ty_context* context_on(const char* device, int32_t threads) {
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    def.device = device;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

/* A scene in a context of its own, on the host backend, which has no memory but what is counted. */
static inline ty_scene* strict_scene_on_host(strict_memory* memory, const char* path) {
    ty_context* context = strict_device_context(memory, "host");
    ty_device* device = NULL;
    ty_scene* scene = NULL;
    assert_int_equal(ty_context_device(context, &device), TY_OK);
    assert_int_equal(ty_scene_load(context, path, NULL, 0, &scene), TY_OK);
    return scene;
}

#endif
