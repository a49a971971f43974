/* Devices that run kernels beside the processor: a table of functions for each kind (docs/device.md). */
#ifndef TY_DEVICE_DEVICE_H
#define TY_DEVICE_DEVICE_H

#include "device/program.h"

#include <tyndall/base.h>

#include <pthread.h>

typedef struct ty_device ty_device;
typedef struct ty_device_piece ty_device_piece;

/* The functions of a kind of device. All calls of one device come from one thread at a time. */
typedef struct ty_device_backend {
    const char* name; /* as in "cuda:0" */
    /* Opens device `number`. Errors: TY_ERROR_UNSUPPORTED where there is none, TY_ERROR_MEMORY. */
    ty_result (*create)(ty_context* context, int32_t number, ty_device** out);
    void (*destroy)(ty_device* device);
    /* `bytes` > 0 of memory, aligned to 64. Errors: TY_ERROR_MEMORY, with a message that names the device's memory. */
    ty_result (*alloc)(ty_device* device, size_t bytes, ty_address* out);
    void (*free)(ty_device* device, ty_address address);
    ty_result (*write)(ty_device* device, ty_address to, const void* from, size_t bytes);
    /* Sets all bits to 0. */
    ty_result (*clear)(ty_device* device, ty_address to, size_t bytes);
    /* Waits for what was launched. */
    ty_result (*read)(ty_device* device, void* to, ty_address from, size_t bytes);
    /* Loads a program, so that its first launch takes no longer than others. */
    ty_result (*load)(ty_device* device, const ty_program* program);
    /* Runs a program for indices [0, count), after everything before it. `arguments` is in the device's memory. */
    ty_result (*launch)(ty_device* device, const ty_program* program, ty_address arguments, int64_t count);
    ty_result (*wait)(ty_device* device);
    /* Seconds that the device took for its launches since the last call. Waits for them. */
    double (*time)(ty_device* device);
} ty_device_backend;

/* Properties for people and for benches; 0: unknown. */
typedef struct ty_device_properties {
    char name[128];
    double memory;    /* bytes */
    double bandwidth; /* of its memory, bytes per second */
    double flops;     /* single precision, one multiply-add counted as two, per second */
    int32_t processors;
} ty_device_properties;

/* Where an array comes from that does not change, so that a device that has it need not compare its contents: the array
 * at an address is the same as long as `version` is. */
typedef struct ty_device_origin {
    uint64_t version;
    void (*release)(void* owner); /* NULL: the version alone tells */
    void* (*retain)(void* owner);
    void* owner; /* is retained while the device has the array, so that its address is not used anew */
} ty_device_origin;

/* First member of each backend's device. */
struct ty_device {
    const ty_device_backend* backend;
    ty_context* context;
    ty_device_properties properties;
    pthread_mutex_t busy;    /* held by the thread whose calls these are */
    uint64_t bytes_written;  /* copied to it, all in all */
    int32_t keep;            /* uses that idle memory outlasts (store.h) */
    uint64_t uses;           /* so far: sets of arrays that were placed and freed */
    ty_device_piece* pieces; /* memory in use and idle */
    size_t piece_count, piece_capacity;
};

extern const ty_device_backend ty_device_host, ty_device_cuda;

/* Devices that can be named: "cpu" (NULL, the processor by its own kernels), "host", "cuda" or "cuda:N", "auto" (cuda:0
 * if it can be opened, otherwise NULL). Errors: TY_ERROR_ARGUMENT for other names, and those of create. */
ty_result ty_device_open(ty_context* context, const char* name, ty_device** out);
void ty_device_close(ty_device* device);

/* The device of a context, by ty_context_def.device, opened by the first call; NULL: none. */
ty_result ty_context_device(ty_context* context, ty_device** out);

/* Lets a context's device, where it has one, keep scenes and other arrays in its memory for renders to come: what did
 * not change is not copied again. Errors: those of ty_context_device. */
ty_result ty_context_keep_on_device(ty_context* context);

#endif
