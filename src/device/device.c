#include "device/device.h"

#include "base/context.h"
#include "device/store.h"

#include <stdlib.h>
#include <string.h>

static const ty_device_backend* const backends[] = {&ty_device_host, &ty_device_cuda};

enum { NUMBER_MAX = 1023 };

/* Uses that idle memory outlasts: an image takes at most four, of its media, its surfaces and both halves of paths. */
enum { KEEP = 8 };

/* The backend of a name such as "cuda:1", and the number in it, by default 0; NULL for other names. */
static const ty_device_backend* find_backend(const char* name, int32_t* number) {
    const size_t length = strcspn(name, ":");
    for (size_t i = 0; i < sizeof backends / sizeof *backends; ++i) {
        if (strlen(backends[i]->name) != length || strncmp(backends[i]->name, name, length) != 0) continue;
        *number = 0;
        if (name[length] == '\0') return backends[i];
        const char* digits = name + length + 1;
        const size_t count = strspn(digits, "0123456789");
        if (count == 0 || count > 4 || digits[count] != '\0') return NULL;
        *number = (int32_t)strtol(digits, NULL, 10);
        return *number <= NUMBER_MAX ? backends[i] : NULL;
    }
    return NULL;
}

static ty_result open_by(const ty_device_backend* backend, ty_context* context, int32_t number, ty_device** out) {
    const ty_result result = backend->create(context, number, out);
    if (result == TY_OK) pthread_mutex_init(&(*out)->busy, NULL);
    return result;
}

/* A device that cannot be opened is none to "auto". */
static ty_result open_automatically(ty_context* context, ty_device** out) {
    if (open_by(&ty_device_cuda, context, 0, out) != TY_OK) {
        ty_take_error(context);
        *out = NULL;
    }
    return TY_OK;
}

ty_result ty_device_open(ty_context* context, const char* name, ty_device** out) {
    int32_t number;
    *out = NULL;
    if (strcmp(name, "cpu") == 0) return TY_OK;
    if (strcmp(name, "auto") == 0) return open_automatically(context, out);
    const ty_device_backend* backend = find_backend(name, &number);
    if (backend == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "device: \"%s\" is none of cpu, host, cuda:N and auto", name);
    return open_by(backend, context, number, out);
}

void ty_device_close(ty_device* device) {
    if (device == NULL) return;
    ty_device_store_close(device);
    pthread_mutex_destroy(&device->busy);
    device->backend->destroy(device);
}

static void close_slot(void* device) {
    ty_device_close(device);
}

static ty_result open_slot(ty_context* context, void** out) {
    ty_device* device = NULL;
    const ty_result result = ty_device_open(context, ty_context_device_name(context), &device);
    *out = device;
    return result;
}

ty_result ty_context_device(ty_context* context, ty_device** out) {
    void* device = NULL;
    const ty_result result = ty_context_slot(context, open_slot, close_slot, &device);
    *out = device;
    return result;
}

ty_result ty_context_keep_on_device(ty_context* context) {
    ty_device* device = NULL;
    const ty_result result = ty_context_device(context, &device);
    if (result != TY_OK || device == NULL) return result;
    pthread_mutex_lock(&device->busy);
    device->keep = KEEP;
    pthread_mutex_unlock(&device->busy);
    return TY_OK;
}
