#include "device/arrays.h"

#include "base/context.h"

#include <math.h>
#include <string.h>

_Static_assert(sizeof(void*) == sizeof(ty_address), "addresses stand in the place of pointers");

ty_address ty_device_place(ty_device_arrays* arrays, const void* from, size_t bytes) {
    const ty_device_backend* backend = arrays->device->backend;
    ty_address address = 0;
    if (arrays->result != TY_OK || bytes == 0) return 0;
    if (!ty_grow_array(arrays->device->context, (void**)&arrays->all, &arrays->capacity, arrays->count,
                       sizeof *arrays->all)) {
        arrays->result = TY_ERROR_MEMORY;
        return 0;
    }
    arrays->result = backend->alloc(arrays->device, bytes, &address);
    if (arrays->result != TY_OK) return 0;
    arrays->all[arrays->count++] = (ty_device_array){NULL, bytes, address};
    arrays->bytes += bytes;
    if (from != NULL) arrays->result = backend->write(arrays->device, address, from, bytes);
    return address;
}

ty_address ty_device_place_once(ty_device_arrays* arrays, const void* from, size_t bytes) {
    if (from == NULL) return 0;
    for (size_t i = 0; i < arrays->count; ++i)
        if (arrays->all[i].from == from && arrays->all[i].bytes == bytes) return arrays->all[i].address;
    const ty_address address = ty_device_place(arrays, from, bytes);
    if (address != 0) arrays->all[arrays->count - 1].from = from;
    return address;
}

void ty_device_point(void* field, ty_address address) {
    memcpy(field, &address, sizeof address);
}

void ty_device_take(ty_device_arrays* arrays, void* field, size_t count, size_t element) {
    const void* from;
    memcpy(&from, field, sizeof from);
    ty_device_point(field, ty_device_place_once(arrays, from, count * element));
}

void ty_device_write(ty_device_arrays* arrays, ty_address to, const void* from, size_t bytes) {
    if (arrays->result == TY_OK && bytes > 0)
        arrays->result = arrays->device->backend->write(arrays->device, to, from, bytes);
}

void ty_device_read(ty_device_arrays* arrays, void* to, ty_address from, size_t bytes) {
    if (arrays->result == TY_OK && bytes > 0)
        arrays->result = arrays->device->backend->read(arrays->device, to, from, bytes);
}

void ty_device_launch(ty_device_arrays* arrays, const ty_program* program, ty_address arguments, int64_t count) {
    if (arrays->result == TY_OK)
        arrays->result = arrays->device->backend->launch(arrays->device, program, arguments, count);
}

void ty_device_wait(ty_device_arrays* arrays) {
    if (arrays->result == TY_OK) arrays->result = arrays->device->backend->wait(arrays->device);
}

void ty_device_free(ty_device_arrays* arrays) {
    for (size_t i = 0; i < arrays->count; ++i) arrays->device->backend->free(arrays->device, arrays->all[i].address);
    ty_free_array(arrays->device->context, arrays->all, arrays->capacity, sizeof *arrays->all);
    arrays->all = NULL;
    arrays->count = arrays->capacity = arrays->bytes = 0;
}

uint32_t ty_device_next_launch(uint32_t items, double seconds, uint32_t min_items) {
    if (seconds < 0.5 * TY_DEVICE_LAUNCH_SECONDS) return items < 1 << 30 ? 2 * items : items;
    if (seconds < 2 * TY_DEVICE_LAUNCH_SECONDS) return items;
    const uint32_t fewer = (uint32_t)(items * fmax(TY_DEVICE_LAUNCH_SECONDS / seconds, 0.0625));
    return fewer > min_items ? fewer : min_items;
}
