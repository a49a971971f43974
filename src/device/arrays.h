/* Arrays in a device's memory that a driver places together and frees together. */
#ifndef TY_DEVICE_ARRAYS_H
#define TY_DEVICE_ARRAYS_H

#include "device/device.h"

typedef struct ty_device_array {
    const void* from; /* what was copied there, where it is taken once; otherwise NULL */
    size_t bytes;
    ty_address address;
} ty_device_array;

/* After the first failure nothing more is placed: drivers place all that they need and check `result` then. */
typedef struct ty_device_arrays {
    ty_device* device;
    ty_result result;
    ty_device_array* all;
    size_t count, capacity;
    size_t bytes; /* of all */
} ty_device_arrays;

/* An array with the contents of `from`; NULL leaves them undefined. 0 for no bytes, and after a failure. */
ty_address ty_device_place(ty_device_arrays* arrays, const void* from, size_t bytes);
/* An array of zeros. */
ty_address ty_device_place_zeros(ty_device_arrays* arrays, size_t bytes);
/* An array that nothing changes on the device, such as a structure: equal ones have one copy (store.h). */
ty_address ty_device_place_constant(ty_device_arrays* arrays, const void* from, size_t bytes);
/* The same of an array that may be placed again; 0 for NULL, too. origin: as for ty_device_store_copy. */
ty_address ty_device_place_once(ty_device_arrays* arrays, const void* from, size_t bytes,
                                const ty_device_origin* origin);
/* Sets the pointer at `field` to an address. */
void ty_device_point(void* field, ty_address address);
/* Exchanges the pointer at `field`, to `count` elements of `element` bytes, for that of their one copy. */
void ty_device_take(ty_device_arrays* arrays, void* field, size_t count, size_t element);
/* The same of an array that does not change. */
void ty_device_take_from(ty_device_arrays* arrays, void* field, size_t count, size_t element,
                         const ty_device_origin* origin);
/* Copies to and from the device, and launches, in the order of calls, unless something has failed. */
void ty_device_write(ty_device_arrays* arrays, ty_address to, const void* from, size_t bytes);
void ty_device_clear(ty_device_arrays* arrays, ty_address to, size_t bytes);
void ty_device_read(ty_device_arrays* arrays, void* to, ty_address from, size_t bytes);
void ty_device_launch(ty_device_arrays* arrays, const ty_program* program, ty_address arguments, int64_t count);
void ty_device_wait(ty_device_arrays* arrays);
void ty_device_free(ty_device_arrays* arrays);

/* Target duration of one launch, seconds: short enough to cancel, and for the watchdogs of drivers. */
#define TY_DEVICE_LAUNCH_SECONDS 0.03

/* Items of the next launch after one of `items` that took some seconds: at least `min_items`, and more by steps of two,
 * as the time of items varies. */
uint32_t ty_device_next_launch(uint32_t items, double seconds, uint32_t min_items);

#endif
