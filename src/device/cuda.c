/* NVIDIA's GPUs through their driver's own library, libcuda.so.1, which is opened when a device is asked for: neither
 * building nor running needs anything of CUDA. Declarations are those of the CUDA Driver API's reference. */
#include "device/device.h"

#include "base/context.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

typedef int cu_result;
typedef struct cu_context* cu_context_handle;
typedef struct cu_module* cu_module_handle;
typedef struct cu_function* cu_function_handle;
typedef struct cu_event* cu_event_handle;

enum { CU_SUCCESS = 0, CU_OUT_OF_MEMORY = 2, CU_NO_DEVICE = 100, CU_INVALID_PTX = 218, CU_UNSUPPORTED_PTX = 222 };

/* Numbers of attributes and options. */
enum {
    CU_ATTRIBUTE_CLOCK_KHZ = 13,
    CU_ATTRIBUTE_PROCESSORS = 16,
    CU_ATTRIBUTE_MEMORY_CLOCK_KHZ = 36,
    CU_ATTRIBUTE_MEMORY_BUS_BITS = 37,
    CU_ATTRIBUTE_MAJOR = 75,
    CU_ATTRIBUTE_MINOR = 76,
    CU_JIT_MAX_REGISTERS = 0,
    CU_JIT_ERROR_LOG = 5,
    CU_JIT_ERROR_LOG_BYTES = 6
};

/* The oldest driver and GPU that take the PTX of the build: version 6.0 for sm_60, of CUDA 9.0. */
enum { CU_VERSION_MIN = 9000, CU_ARCHITECTURE_MIN = 60 };

/* The functions in use: X(result, name, symbol in the library, parameters). */
#define CU_FUNCTIONS(X)                                                                                                \
    X(init, "cuInit", (unsigned flags))                                                                                \
    X(version, "cuDriverGetVersion", (int* version))                                                                   \
    X(count, "cuDeviceGetCount", (int* count))                                                                         \
    X(get, "cuDeviceGet", (int* device, int number))                                                                   \
    X(name, "cuDeviceGetName", (char* name, int size, int device))                                                     \
    X(total, "cuDeviceTotalMem_v2", (size_t * bytes, int device))                                                      \
    X(attribute, "cuDeviceGetAttribute", (int* value, int attribute, int device))                                      \
    X(retain, "cuDevicePrimaryCtxRetain", (cu_context_handle * context, int device))                                   \
    X(release, "cuDevicePrimaryCtxRelease_v2", (int device))                                                           \
    X(current, "cuCtxSetCurrent", (cu_context_handle context))                                                         \
    X(synchronize, "cuCtxSynchronize", (void))                                                                         \
    X(memory, "cuMemGetInfo_v2", (size_t * free, size_t * total))                                                      \
    X(alloc, "cuMemAlloc_v2", (ty_address * out, size_t bytes))                                                        \
    X(free, "cuMemFree_v2", (ty_address address))                                                                      \
    X(write, "cuMemcpyHtoD_v2", (ty_address to, const void* from, size_t bytes))                                       \
    X(clear, "cuMemsetD8_v2", (ty_address to, unsigned char value, size_t bytes))                                      \
    X(read, "cuMemcpyDtoH_v2", (void* to, ty_address from, size_t bytes))                                              \
    X(load, "cuModuleLoadDataEx",                                                                                      \
      (cu_module_handle * out, const void* image, unsigned options, int* names, void** values))                        \
    X(unload, "cuModuleUnload", (cu_module_handle module))                                                             \
    X(function, "cuModuleGetFunction", (cu_function_handle * out, cu_module_handle module, const char* name))          \
    X(launch, "cuLaunchKernel",                                                                                        \
      (cu_function_handle function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x,               \
       unsigned block_y, unsigned block_z, unsigned shared, void* stream, void** parameters, void** extra))            \
    X(event_create, "cuEventCreate", (cu_event_handle * out, unsigned flags))                                          \
    X(event_destroy, "cuEventDestroy_v2", (cu_event_handle event))                                                     \
    X(event_record, "cuEventRecord", (cu_event_handle event, void* stream))                                            \
    X(event_wait, "cuEventSynchronize", (cu_event_handle event))                                                       \
    X(event_elapsed, "cuEventElapsedTime", (float* milliseconds, cu_event_handle from, cu_event_handle to))            \
    X(error_text, "cuGetErrorString", (cu_result code, const char** text))

#define CU_MEMBER(name, symbol, parameters) cu_result(*name) parameters;
typedef struct cu_library {
    CU_FUNCTIONS(CU_MEMBER)
} cu_library;

enum { PROGRAMS_MAX = 64, BLOCK = 64, EVENTS = 2, LOG_BYTES = 1024 };

/* Registers of a thread at most. Programs would take up to 255, with which few threads fit a multiprocessor, and these
 * cannot hide one another's waiting: measured, 64 is faster than 80, 96, 128 and all. */
enum { REGISTERS = 64 };

typedef struct loaded_program {
    const ty_program* program;
    cu_module_handle module;
    cu_function_handle function;
} loaded_program;

typedef struct cuda_device {
    ty_device device;
    void* library;
    cu_library cu;
    int number, handle;
    cu_context_handle current;
    cu_event_handle event[EVENTS]; /* before and after the last launch */
    bool launched;                 /* since `seconds` was brought up to date */
    double seconds;
    size_t program_count;
    loaded_program programs[PROGRAMS_MAX];
} cuda_device;

/* ---- errors ---- */

static ty_result fail(const cuda_device* cuda, const char* what, cu_result code) {
    const char* text = NULL;
    if (cuda->cu.error_text != NULL) cuda->cu.error_text(code, &text);
    return ty_fail(cuda->device.context, code == CU_OUT_OF_MEMORY ? TY_ERROR_MEMORY : TY_ERROR_INTERNAL,
                   "device cuda:%d: %s failed: %s (CUDA error %d)", cuda->number, what,
                   text != NULL ? text : "unknown error", code);
}

static ty_result check(const cuda_device* cuda, const char* what, cu_result code) {
    return code == CU_SUCCESS ? TY_OK : fail(cuda, what, code);
}

/* The driver keeps a current context for each thread. */
static void enter(const cuda_device* cuda) {
    cuda->cu.current(cuda->current);
}

/* ---- opening ---- */

static ty_result open_library(cuda_device* cuda) {
    ty_context* context = cuda->device.context;
    cuda->library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (cuda->library == NULL)
        return ty_fail(context, TY_ERROR_UNSUPPORTED,
                       "device cuda:%d: there is no NVIDIA driver here (libcuda.so.1 cannot be opened)", cuda->number);
    const char* missing = NULL;
#define CU_FIND(name, symbol, parameters)                                                                              \
    *(void**)&cuda->cu.name = dlsym(cuda->library, symbol);                                                            \
    if (cuda->cu.name == NULL) missing = symbol;
    CU_FUNCTIONS(CU_FIND)
    if (missing != NULL)
        return ty_fail(context, TY_ERROR_UNSUPPORTED, "device cuda:%d: the NVIDIA driver is too old: it has no %s",
                       cuda->number, missing);
    return TY_OK;
}

static ty_result start_driver(cuda_device* cuda) {
    ty_context* context = cuda->device.context;
    int version = 0, count = 0, major = 0, minor = 0;
    const cu_result code = cuda->cu.init(0);
    if (code == CU_NO_DEVICE)
        return ty_fail(context, TY_ERROR_UNSUPPORTED, "device cuda:%d: there is no GPU here", cuda->number);
    ty_result result = check(cuda, "starting the driver", code);
    if (result == TY_OK) result = check(cuda, "asking for its version", cuda->cu.version(&version));
    if (result == TY_OK) result = check(cuda, "counting GPUs", cuda->cu.count(&count));
    if (result != TY_OK) return result;
    if (version < CU_VERSION_MIN)
        return ty_fail(context, TY_ERROR_UNSUPPORTED,
                       "device cuda:%d: the NVIDIA driver is too old: it knows CUDA %d.%d, and %d.%d is needed",
                       cuda->number, version / 1000, version % 1000 / 10, CU_VERSION_MIN / 1000, 0);
    if (cuda->number >= count)
        return ty_fail(context, TY_ERROR_UNSUPPORTED, "device cuda:%d: the GPUs here are cuda:0 to cuda:%d",
                       cuda->number, count - 1);
    result = check(cuda, "opening it", cuda->cu.get(&cuda->handle, cuda->number));
    if (result != TY_OK) return result;
    cuda->cu.attribute(&major, CU_ATTRIBUTE_MAJOR, cuda->handle);
    cuda->cu.attribute(&minor, CU_ATTRIBUTE_MINOR, cuda->handle);
    if (10 * major + minor < CU_ARCHITECTURE_MIN)
        return ty_fail(context, TY_ERROR_UNSUPPORTED,
                       "device cuda:%d: its compute capability is %d.%d, and 6.0 is needed", cuda->number, major,
                       minor);
    return check(cuda, "taking its context", cuda->cu.retain(&cuda->current, cuda->handle));
}

static double attribute(const cuda_device* cuda, int number) {
    int value = 0;
    return cuda->cu.attribute(&value, number, cuda->handle) == CU_SUCCESS ? value : 0;
}

/* Single-precision lanes of a multiprocessor, by compute capability (CUDA C++ Programming Guide, arithmetic
 * instructions). */
static int lanes(int major, int minor) {
    return major == 6 && minor == 0 ? 64 : major == 7 || (major == 8 && minor == 0) ? 64 : 128;
}

static void read_properties(cuda_device* cuda) {
    ty_device_properties* own = &cuda->device.properties;
    size_t bytes = 0;
    cuda->cu.name(own->name, sizeof own->name, cuda->handle);
    cuda->cu.total(&bytes, cuda->handle);
    own->memory = (double)bytes;
    own->processors = (int32_t)attribute(cuda, CU_ATTRIBUTE_PROCESSORS);
    /* Both edges of the clock transfer data. */
    own->bandwidth =
        2 * 1e3 * attribute(cuda, CU_ATTRIBUTE_MEMORY_CLOCK_KHZ) * attribute(cuda, CU_ATTRIBUTE_MEMORY_BUS_BITS) / 8;
    own->flops = 2 * 1e3 * attribute(cuda, CU_ATTRIBUTE_CLOCK_KHZ) * own->processors *
                 lanes((int)attribute(cuda, CU_ATTRIBUTE_MAJOR), (int)attribute(cuda, CU_ATTRIBUTE_MINOR));
}

static void destroy(ty_device* device) {
    cuda_device* cuda = (cuda_device*)device;
    if (cuda->current != NULL) {
        enter(cuda);
        for (size_t i = 0; i < cuda->program_count; ++i) cuda->cu.unload(cuda->programs[i].module);
        for (int i = 0; i < EVENTS; ++i)
            if (cuda->event[i] != NULL) cuda->cu.event_destroy(cuda->event[i]);
        cuda->cu.release(cuda->handle);
    }
    if (cuda->library != NULL) dlclose(cuda->library);
    ty_free_array(device->context, device, 1, sizeof *cuda);
}

static ty_result create(ty_context* context, int32_t number, ty_device** out) {
    cuda_device* cuda = ty_alloc_array(context, 1, sizeof *cuda, true);
    if (cuda == NULL) return TY_ERROR_MEMORY;
    cuda->device = (ty_device){.backend = &ty_device_cuda, .context = context};
    cuda->number = number;
    ty_result result = open_library(cuda);
    if (result == TY_OK) result = start_driver(cuda);
    if (result == TY_OK) {
        enter(cuda);
        read_properties(cuda);
    }
    for (int i = 0; i < EVENTS && result == TY_OK; ++i)
        result = check(cuda, "making a timer", cuda->cu.event_create(&cuda->event[i], 0));
    if (result == TY_OK)
        *out = &cuda->device;
    else
        destroy(&cuda->device);
    return result;
}

/* ---- memory ---- */

static ty_result alloc_memory(ty_device* device, size_t bytes, ty_address* out) {
    const cuda_device* cuda = (const cuda_device*)device;
    const double mebibyte = 1048576;
    size_t left = 0, total = 0;
    enter(cuda);
    *out = 0;
    const cu_result code = cuda->cu.alloc(out, bytes);
    if (code != CU_OUT_OF_MEMORY) return check(cuda, "an allocation", code);
    cuda->cu.memory(&left, &total);
    return ty_fail(device->context, TY_ERROR_MEMORY,
                   "device cuda:%d: not enough memory for %.1f MiB: %.1f MiB of its %.1f MiB are free", cuda->number,
                   (double)bytes / mebibyte, (double)left / mebibyte, (double)total / mebibyte);
}

static void free_memory(ty_device* device, ty_address address) {
    const cuda_device* cuda = (const cuda_device*)device;
    enter(cuda);
    if (address != 0) cuda->cu.free(address);
}

static ty_result write_memory(ty_device* device, ty_address to, const void* from, size_t bytes) {
    const cuda_device* cuda = (const cuda_device*)device;
    enter(cuda);
    return check(cuda, "a copy to it", cuda->cu.write(to, from, bytes));
}

static ty_result clear_memory(ty_device* device, ty_address to, size_t bytes) {
    const cuda_device* cuda = (const cuda_device*)device;
    enter(cuda);
    return check(cuda, "a clearing of its memory", cuda->cu.clear(to, 0, bytes));
}

static ty_result read_memory(ty_device* device, void* to, ty_address from, size_t bytes) {
    const cuda_device* cuda = (const cuda_device*)device;
    enter(cuda);
    return check(cuda, "a copy from it", cuda->cu.read(to, from, bytes));
}

/* ---- programs ---- */

static ty_result fail_to_load(const cuda_device* cuda, const ty_program* program, cu_result code, const char* log) {
    if (code == CU_UNSUPPORTED_PTX)
        return ty_fail(cuda->device.context, TY_ERROR_UNSUPPORTED,
                       "device cuda:%d: the NVIDIA driver is too old for the program %s", cuda->number, program->name);
    if (code == CU_INVALID_PTX)
        return ty_fail(cuda->device.context, TY_ERROR_INTERNAL, "device cuda:%d: its driver refuses the program %s: %s",
                       cuda->number, program->name, log);
    return fail(cuda, "loading a program", code);
}

/* Has the driver compile a program, which it keeps between runs. */
static ty_result compile(cuda_device* cuda, const ty_program* program, char* text, loaded_program* out) {
    char log[LOG_BYTES] = "", entry[64];
    int names[3] = {CU_JIT_ERROR_LOG, CU_JIT_ERROR_LOG_BYTES, CU_JIT_MAX_REGISTERS};
    void* values[3] = {log, (void*)(uintptr_t)sizeof log, (void*)(uintptr_t)REGISTERS};
    uLongf size = (uLongf)program->ptx->inflated;
    if (uncompress((Bytef*)text, &size, program->ptx->bytes, (uLong)program->ptx->size) != Z_OK ||
        size != program->ptx->inflated)
        return ty_fail(cuda->device.context, TY_ERROR_INTERNAL, "the program %s is damaged", program->name);
    text[size] = '\0';
    const cu_result code = cuda->cu.load(&out->module, text, 3, names, values);
    if (code != CU_SUCCESS) return fail_to_load(cuda, program, code, log);
    snprintf(entry, sizeof entry, "ty_entry_%s", program->name);
    const ty_result result =
        check(cuda, "finding an entry point", cuda->cu.function(&out->function, out->module, entry));
    if (result != TY_OK) cuda->cu.unload(out->module);
    return result;
}

static const loaded_program* find_program(const cuda_device* cuda, const ty_program* program) {
    for (size_t i = 0; i < cuda->program_count; ++i)
        if (cuda->programs[i].program == program) return &cuda->programs[i];
    return NULL;
}

static ty_result load(ty_device* device, const ty_program* program) {
    cuda_device* cuda = (cuda_device*)device;
    if (find_program(cuda, program) != NULL) return TY_OK;
    if (program->ptx->bytes == NULL)
        return ty_fail(device->context, TY_ERROR_UNSUPPORTED,
                       "device cuda:%d: this build has no programs for it: clang was not there to make them",
                       cuda->number);
    if (cuda->program_count == PROGRAMS_MAX)
        return ty_fail(device->context, TY_ERROR_INTERNAL, "device cuda:%d: more than %d programs", cuda->number,
                       PROGRAMS_MAX);
    char* text = ty_alloc_array(device->context, program->ptx->inflated + 1, 1, false);
    if (text == NULL) return TY_ERROR_MEMORY;
    enter(cuda);
    loaded_program* out = &cuda->programs[cuda->program_count];
    out->program = program;
    const ty_result result = compile(cuda, program, text, out);
    if (result == TY_OK) ++cuda->program_count;
    ty_free_array(device->context, text, program->ptx->inflated + 1, 1);
    return result;
}

/* Adds the time of the last launch. */
static ty_result settle(cuda_device* cuda) {
    float milliseconds = 0;
    if (!cuda->launched) return TY_OK;
    ty_result result = check(cuda, "waiting for a program", cuda->cu.event_wait(cuda->event[1]));
    cuda->launched = false;
    if (result == TY_OK)
        result = check(cuda, "timing", cuda->cu.event_elapsed(&milliseconds, cuda->event[0], cuda->event[1]));
    cuda->seconds += 1e-3 * (double)milliseconds;
    return result;
}

static ty_result launch(ty_device* device, const ty_program* program, ty_address arguments, int64_t count) {
    cuda_device* cuda = (cuda_device*)device;
    ty_result result = load(device, program);
    enter(cuda);
    if (result == TY_OK) result = settle(cuda);
    if (result != TY_OK || count == 0) return result;
    void* parameters[2] = {&arguments, &count};
    const int64_t blocks = (count + BLOCK - 1) / BLOCK;
    if (blocks > INT32_MAX)
        return ty_fail(device->context, TY_ERROR_INTERNAL, "device cuda:%d: a launch is too large", cuda->number);
    result = check(cuda, "timing", cuda->cu.event_record(cuda->event[0], NULL));
    if (result == TY_OK)
        result = check(cuda, "starting a program",
                       cuda->cu.launch(find_program(cuda, program)->function, (unsigned)blocks, 1, 1, BLOCK, 1, 1, 0,
                                       NULL, parameters, NULL));
    if (result == TY_OK) result = check(cuda, "timing", cuda->cu.event_record(cuda->event[1], NULL));
    cuda->launched = result == TY_OK;
    return result;
}

static ty_result wait_for_all(ty_device* device) {
    cuda_device* cuda = (cuda_device*)device;
    enter(cuda);
    const ty_result result = settle(cuda);
    return result == TY_OK ? check(cuda, "waiting for it", cuda->cu.synchronize()) : result;
}

static double time_of_launches(ty_device* device) {
    cuda_device* cuda = (cuda_device*)device;
    enter(cuda);
    settle(cuda);
    const double seconds = cuda->seconds;
    cuda->seconds = 0;
    return seconds;
}

const ty_device_backend ty_device_cuda = {.name = "cuda",
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
