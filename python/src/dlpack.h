/* The structures of DLPack's binary interface, version 0 (https://dmlc.github.io/dlpack/latest/c_api.html). */
#ifndef TYNDALL_PYTHON_DLPACK_H
#define TYNDALL_PYTHON_DLPACK_H

#include <stdint.h>

enum { DL_CPU = 1, DL_CUDA_HOST = 3 };          /* kinds of devices whose memory the host reads */
enum { DL_INT = 0, DL_UINT = 1, DL_FLOAT = 2 }; /* codes of types */

typedef struct DLDevice {
    int32_t device_type, device_id;
} DLDevice;

typedef struct DLDataType {
    uint8_t code, bits;
    uint16_t lanes;
} DLDataType;

typedef struct DLTensor {
    void* data;
    DLDevice device;
    int32_t ndim;
    DLDataType dtype;
    int64_t* shape;
    int64_t* strides; /* in elements; NULL: C order */
    uint64_t byte_offset;
} DLTensor;

typedef struct DLManagedTensor {
    DLTensor dl_tensor;
    void* manager_ctx;
    void (*deleter)(struct DLManagedTensor* self); /* NULL: none */
} DLManagedTensor;

#endif
