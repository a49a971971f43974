/* The processor as a device: the entry points as they are for other devices, block by block. Tests and sanitizers see
 * by it what a device does. */
#include "device/device.h"

#include "base/context.h"

#include <string.h>

/* Indices of one block. */
enum { BLOCK = 64 };

/* In front of each allocation: its size, for the free. */
enum { HEAD = 256 };

typedef struct host_device {
    ty_device device;
    double seconds; /* of launches since ty_device_backend.time */
} host_device;

static ty_result create(ty_context* context, int32_t number, ty_device** out) {
    if (number != 0) return ty_fail(context, TY_ERROR_UNSUPPORTED, "device host:%d: there is host:0 alone", number);
    host_device* host = ty_alloc_array(context, 1, sizeof *host, true);
    if (host == NULL) return TY_ERROR_MEMORY;
    host->device = (ty_device){.backend = &ty_device_host, .context = context};
    memcpy(host->device.properties.name, "this processor", sizeof "this processor");
    host->device.properties.processors = ty_context_threads(context);
    *out = &host->device;
    return TY_OK;
}

static void destroy(ty_device* device) {
    ty_free_array(device->context, device, 1, sizeof(host_device));
}

/* Each allocation is one of its own, so that the address sanitizer knows its end. */
static ty_result alloc_memory(ty_device* device, size_t bytes, ty_address* out) {
    unsigned char* memory = ty_alloc_array(device->context, bytes + HEAD, 1, false);
    if (memory == NULL) return TY_ERROR_MEMORY;
    memcpy(memory, &bytes, sizeof bytes);
    *out = (ty_address)(uintptr_t)(memory + HEAD);
    return TY_OK;
}

static void* pointer(ty_address address) {
    return (void*)(uintptr_t)address;
}

static void free_memory(ty_device* device, ty_address address) {
    if (address == 0) return;
    unsigned char* memory = (unsigned char*)pointer(address) - HEAD;
    size_t bytes;
    memcpy(&bytes, memory, sizeof bytes);
    ty_free_array(device->context, memory, bytes + HEAD, 1);
}

static ty_result write_memory(ty_device* device, ty_address to, const void* from, size_t bytes) {
    (void)device;
    memcpy(pointer(to), from, bytes);
    return TY_OK;
}

static ty_result clear_memory(ty_device* device, ty_address to, size_t bytes) {
    (void)device;
    memset(pointer(to), 0, bytes);
    return TY_OK;
}

static ty_result read_memory(ty_device* device, void* to, ty_address from, size_t bytes) {
    (void)device;
    memcpy(to, pointer(from), bytes);
    return TY_OK;
}

static ty_result load(ty_device* device, const ty_program* program) {
    (void)device;
    (void)program;
    return TY_OK;
}

typedef struct launched {
    const ty_program* program;
    const void* arguments;
    int64_t count;
} launched;

static void run_block(void* user, int64_t block, int32_t worker) {
    (void)worker;
    const launched* all = user;
    const int64_t begin = block * BLOCK, end = begin + BLOCK < all->count ? begin + BLOCK : all->count;
    all->program->host(all->arguments, begin, end);
}

static ty_result launch(ty_device* device, const ty_program* program, ty_address arguments, int64_t count) {
    launched all = {program, pointer(arguments), count};
    const double begun = ty_wall_seconds();
    ty_parallel_for(device->context, (count + BLOCK - 1) / BLOCK, run_block, &all);
    ((host_device*)device)->seconds += ty_wall_seconds() - begun;
    return TY_OK;
}

static ty_result wait_for_all(ty_device* device) {
    (void)device;
    return TY_OK;
}

static double time_of_launches(ty_device* device) {
    const double seconds = ((host_device*)device)->seconds;
    ((host_device*)device)->seconds = 0;
    return seconds;
}

const ty_device_backend ty_device_host = {.name = "host",
                                          .create = create,
                                          .destroy = destroy,
                                          .alloc = alloc_memory,
                                          .free = free_memory,
                                          .write = write_memory,
                                          .clear = clear_memory,
                                          .read = read_memory,
                                          .load = load,
                                          .launch = launch,
                                          .wait = wait_for_all,
                                          .time = time_of_launches};
