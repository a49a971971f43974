#include "device/arrays.h"

#include "base/context.h"
#include "device/store.h"

#include <math.h>
#include <string.h>

_Static_assert(sizeof(void*) == sizeof(ty_address), "addresses stand in the place of pointers");

/* Room for one more array. */
static bool grow(ty_device_arrays* arrays) {
    if (arrays->result == TY_OK && !ty_grow_array(arrays->device->context, (void**)&arrays->all, &arrays->capacity,
                                                  arrays->count, sizeof *arrays->all))
        arrays->result = TY_ERROR_MEMORY;
    return arrays->result == TY_OK;
}

static ty_address add(ty_device_arrays* arrays, const void* from, size_t bytes, ty_address address) {
    if (arrays->result != TY_OK) return 0;
    arrays->all[arrays->count++] = (ty_device_array){from, bytes, address};
    arrays->bytes += bytes;
    return address;
}

ty_address ty_device_place(ty_device_arrays* arrays, const void* from, size_t bytes) {
    ty_address address = 0;
    if (bytes == 0 || !grow(arrays)) return 0;
    arrays->result = ty_device_store_alloc(arrays->device, bytes, &address);
    add(arrays, NULL, bytes, address);
    if (from != NULL) ty_device_write(arrays, address, from, bytes);
    return address;
}

ty_address ty_device_place_zeros(ty_device_arrays* arrays, size_t bytes) {
    const ty_address address = ty_device_place(arrays, NULL, bytes);
    ty_device_clear(arrays, address, bytes);
    return address;
}

static ty_address place_copy(ty_device_arrays* arrays, const void* from, size_t bytes, const ty_device_origin* origin) {
    ty_address address = 0;
    if (bytes == 0 || !grow(arrays)) return 0;
    arrays->result = ty_device_store_copy(arrays->device, from, bytes, origin, &address);
    return add(arrays, NULL, bytes, address);
}

ty_address ty_device_place_constant(ty_device_arrays* arrays, const void* from, size_t bytes) {
    return place_copy(arrays, from, bytes, NULL);
}

ty_address ty_device_place_once(ty_device_arrays* arrays, const void* from, size_t bytes,
                                const ty_device_origin* origin) {
    if (from == NULL) return 0;
    for (size_t i = 0; i < arrays->count; ++i)
        if (arrays->all[i].from == from && arrays->all[i].bytes == bytes) return arrays->all[i].address;
    const ty_address address = place_copy(arrays, from, bytes, origin);
    if (address != 0) arrays->all[arrays->count - 1].from = from;
    return address;
}

void ty_device_point(void* field, ty_address address) {
    memcpy(field, &address, sizeof address);
}

void ty_device_take_from(ty_device_arrays* arrays, void* field, size_t count, size_t element,
                         const ty_device_origin* origin) {
    const void* from;
    memcpy(&from, field, sizeof from);
    ty_device_point(field, ty_device_place_once(arrays, from, count * element, origin));
}

void ty_device_take(ty_device_arrays* arrays, void* field, size_t count, size_t element) {
    ty_device_take_from(arrays, field, count, element, NULL);
}

void ty_device_write(ty_device_arrays* arrays, ty_address to, const void* from, size_t bytes) {
    if (arrays->result != TY_OK || bytes == 0) return;
    arrays->device->bytes_written += bytes;
    arrays->result = arrays->device->backend->write(arrays->device, to, from, bytes);
}

void ty_device_clear(ty_device_arrays* arrays, ty_address to, size_t bytes) {
    if (arrays->result == TY_OK && bytes > 0)
        arrays->result = arrays->device->backend->clear(arrays->device, to, bytes);
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
    for (size_t i = 0; i < arrays->count; ++i) ty_device_store_release(arrays->device, arrays->all[i].address);
    ty_device_store_end_use(arrays->device);
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
