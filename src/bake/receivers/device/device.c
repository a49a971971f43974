#include "bake/receivers/device/device.h"

#include "base/context.h"
#include "bake/receivers/device/launch.h"
#include "scene/packed/packed.h"

struct ty_bake_device {
    const ty_bake_run* run;
    ty_device* device;
    ty_device_arrays arrays;
    ty_packed_scene* scene;
    const ty_program* program;
    ty_address request, sums, light, arguments;
};

static const void* as_pointer(ty_address address) {
    return (const void*)(uintptr_t)address;
}

static size_t sums_bytes(const ty_bake_run* run) {
    return (size_t)run->count * sizeof *run->sums;
}

static size_t light_bytes(const ty_bake_run* run) {
    return (size_t)run->count * (size_t)(TY_BAKE_LAYERS * 3 * run->request.terms) * sizeof *run->light;
}

static ty_result place_all(ty_bake_device* on) {
    const ty_bake_run* run = on->run;
    ty_device_arrays* arrays = &on->arrays;
    ty_bake_request own = run->request;
    const ty_result result = ty_scene_pack(on->device, run->path.scene, &run->path.view, &on->scene);
    if (result != TY_OK) return result;
    own.path.scene = as_pointer(on->scene->view);
    own.path.sobol = as_pointer(ty_device_place_constant(arrays, &run->path.sobol, sizeof run->path.sobol));
    own.receivers =
        as_pointer(ty_device_place_constant(arrays, own.receivers, (size_t)run->count * sizeof *own.receivers));
    on->request = ty_device_place_constant(arrays, &own, sizeof own);
    on->sums = ty_device_place_zeros(arrays, sums_bytes(run));
    on->light = ty_device_place_zeros(arrays, light_bytes(run));
    on->arguments = ty_device_place(arrays, NULL, sizeof(ty_bake_launch));
    on->program = run->path.view.interior_count > 1 ? &ty_program_bake_refracted : &ty_program_bake_paths;
    return arrays->result == TY_OK ? on->device->backend->load(on->device, on->program) : arrays->result;
}

ty_result ty_bake_device_create(const ty_bake_run* run, ty_bake_device** out) {
    ty_device* device = NULL;
    *out = NULL;
    ty_result result = ty_context_device(run->context, &device);
    if (result != TY_OK || device == NULL || run->def->method != TY_BAKE_PATH || run->count == 0 ||
        run->request.path.enclosed != NULL)
        return result;
    ty_bake_device* on = ty_alloc_array(run->context, 1, sizeof *on, true);
    if (on == NULL) return TY_ERROR_MEMORY;
    on->run = run;
    on->device = on->arrays.device = device;
    pthread_mutex_lock(&device->busy);
    result = place_all(on);
    pthread_mutex_unlock(&device->busy);
    if (result == TY_OK)
        *out = on;
    else
        ty_bake_device_destroy(on);
    return result;
}

void ty_bake_device_destroy(ty_bake_device* on) {
    if (on == NULL) return;
    pthread_mutex_lock(&on->device->busy);
    ty_device_free(&on->arrays);
    ty_packed_scene_destroy(on->scene);
    pthread_mutex_unlock(&on->device->busy);
    ty_free_array(on->run->context, on, 1, sizeof *on);
}

ty_result ty_bake_device_sample(ty_bake_device* on, int64_t begin, int64_t end, uint32_t first, uint32_t count) {
    const ty_bake_launch launch = {.request = as_pointer(on->request),
                                   .sums = (void*)(uintptr_t)on->sums,
                                   .light = (void*)(uintptr_t)on->light,
                                   .begin = begin,
                                   .first = first,
                                   .count = count};
    pthread_mutex_lock(&on->device->busy);
    ty_device_write(&on->arrays, on->arguments, &launch, sizeof launch);
    ty_device_launch(&on->arrays, on->program, on->arguments, end - begin);
    ty_device_wait(&on->arrays);
    pthread_mutex_unlock(&on->device->busy);
    return on->arrays.result;
}

ty_result ty_bake_device_read(ty_bake_device* on) {
    pthread_mutex_lock(&on->device->busy);
    ty_device_read(&on->arrays, on->run->sums, on->sums, sums_bytes(on->run));
    ty_device_read(&on->arrays, on->run->light, on->light, light_bytes(on->run));
    pthread_mutex_unlock(&on->device->busy);
    return on->arrays.result;
}

ty_result ty_bake_device_write_done(ty_bake_device* on) {
    pthread_mutex_lock(&on->device->busy);
    ty_device_write(&on->arrays, on->sums, on->run->sums, sums_bytes(on->run));
    pthread_mutex_unlock(&on->device->busy);
    return on->arrays.result;
}
