#include "method/path/device.h"

#include "base/context.h"
#include "method/path/outlines.h"
#include "method/path/trace/device_launch.h"
#include "scene/packed/packed.h"

#include <string.h>

/* Arrays in the device's memory. */
enum { SOBOL, RAYS, OUTLINES, REQUEST, ODD_REQUEST, SUMS, AOV_SUMS, VERTICES, ARGUMENTS, ARRAYS };

struct ty_path_device {
    const ty_path_run* run;
    ty_device* device;
    ty_device_arrays arrays;
    ty_packed_scene* scene;
    const ty_program* program;
    ty_address array[ARRAYS];
    ty_path_sums* sums; /* of all items, here */
    ty_path_aov_sums* aov_sums;
    uint64_t* vertices;
};

static const void* as_pointer(ty_address address) {
    return (const void*)(uintptr_t)address;
}

/* A request with the device's pointers. */
static ty_address place_request(ty_path_device* on, const ty_path_request* request) {
    ty_path_request own = *request;
    own.scene = as_pointer(on->scene->view);
    own.sobol = as_pointer(on->array[SOBOL]);
    own.rays = as_pointer(on->array[RAYS]);
    own.outlines = as_pointer(on->array[OUTLINES]);
    return ty_device_place(&on->arrays, &own, sizeof own);
}

/* from: NULL for sums of no samples. */
static ty_address place_sums(ty_path_device* on, const void* from, size_t bytes) {
    return from != NULL ? ty_device_place(&on->arrays, from, bytes) : ty_device_place_zeros(&on->arrays, bytes);
}

static ty_result place_items(ty_path_device* on) {
    const ty_path_run* run = on->run;
    const size_t count = (size_t)run->item_count;
    on->sums = ty_alloc_array(run->context, count, sizeof *on->sums, false);
    on->vertices = ty_alloc_array(run->context, count, sizeof *on->vertices, true);
    if (run->aov_sums != NULL) on->aov_sums = ty_alloc_array(run->context, count, sizeof *on->aov_sums, false);
    if (on->sums == NULL || on->vertices == NULL || (run->aov_sums != NULL && on->aov_sums == NULL))
        return TY_ERROR_MEMORY;
    bool resumed = false;
    for (size_t i = 0; i < count; ++i) {
        on->sums[i] = run->items[i].sums;
        resumed = resumed || run->items[i].count > 0;
    }
    on->array[SUMS] = place_sums(on, resumed ? on->sums : NULL, count * sizeof *on->sums);
    on->array[VERTICES] = place_sums(on, NULL, count * sizeof *on->vertices);
    if (run->aov_sums != NULL)
        on->array[AOV_SUMS] = place_sums(on, resumed ? run->aov_sums : NULL, count * sizeof *run->aov_sums);
    return on->arrays.result;
}

static ty_result place_all(ty_path_device* on, const ty_path_request* odd) {
    const ty_path_run* run = on->run;
    ty_device_arrays* arrays = &on->arrays;
    ty_result result = ty_scene_pack(on->device, run->scene, &run->view, &on->scene);
    if (result != TY_OK) return result;
    on->array[SOBOL] = ty_device_place_constant(arrays, &run->sobol, sizeof run->sobol);
    if (run->request.rays != NULL)
        on->array[RAYS] =
            ty_device_place(arrays, run->request.rays, 6 * (size_t)run->item_count * sizeof *run->request.rays);
    if (run->outlines != NULL)
        on->array[OUTLINES] = ty_device_place_constant(arrays, run->outlines, (size_t)run->item_count);
    on->array[REQUEST] = place_request(on, &run->request);
    on->array[ODD_REQUEST] = place_request(on, odd);
    on->array[ARGUMENTS] = ty_device_place(arrays, NULL, sizeof(ty_path_launch));
    result = place_items(on);
    if (result != TY_OK) return result;
    on->program = on->scene->glossy ? &ty_program_path_glossy : &ty_program_path_diffuse;
    return on->device->backend->load(on->device, on->program);
}

ty_result ty_path_device_create(ty_path_run* run, const ty_path_request* odd, ty_path_device** out) {
    ty_device* device = NULL;
    *out = NULL;
    ty_result result = ty_context_device(run->context, &device);
    if (result != TY_OK || device == NULL || run->guide != NULL || run->request.enclosed != NULL ||
        run->view.periodic.axes != 0 || run->request.kind == TY_PATH_COLUMNS)
        return result;
    ty_path_device* on = ty_alloc_array(run->context, 1, sizeof *on, true);
    if (on == NULL) return TY_ERROR_MEMORY;
    on->run = run;
    on->device = on->arrays.device = device;
    ty_path_find_outlines(run);
    pthread_mutex_lock(&device->busy);
    result = place_all(on, odd);
    if (result == TY_OK)
        *out = on;
    else
        ty_path_device_destroy(on);
    return result;
}

void ty_path_device_destroy(ty_path_device* on) {
    if (on == NULL) return;
    ty_context* context = on->run->context;
    const size_t count = (size_t)on->run->item_count;
    ty_device_free(&on->arrays);
    ty_packed_scene_destroy(on->scene);
    pthread_mutex_unlock(&on->device->busy);
    ty_free_array(context, on->sums, count, sizeof *on->sums);
    ty_free_array(context, on->vertices, count, sizeof *on->vertices);
    ty_free_array(context, on->aov_sums, count, sizeof *on->aov_sums);
    ty_free_array(context, on, 1, sizeof *on);
}

const char* ty_path_device_kind(const ty_path_device* on) {
    return on->device->backend->name;
}

ty_result ty_path_device_trace(ty_path_device* on, bool odd, int64_t begin, int64_t end, uint32_t first,
                               uint32_t count) {
    const ty_path_launch launch = {.request = as_pointer(on->array[odd ? ODD_REQUEST : REQUEST]),
                                   .sums = (void*)(uintptr_t)on->array[SUMS],
                                   .aov_sums = (void*)(uintptr_t)on->array[AOV_SUMS],
                                   .vertices = (void*)(uintptr_t)on->array[VERTICES],
                                   .begin = begin,
                                   .first_sample = first,
                                   .count = count};
    ty_device_write(&on->arrays, on->array[ARGUMENTS], &launch, sizeof launch);
    ty_device_launch(&on->arrays, on->program, on->array[ARGUMENTS], end - begin);
    ty_device_wait(&on->arrays);
    return on->arrays.result;
}

ty_result ty_path_device_read(ty_path_device* on, const ty_path_sums** sums, const ty_path_aov_sums** aov_sums,
                              uint64_t* vertices) {
    const size_t count = (size_t)on->run->item_count;
    ty_device_read(&on->arrays, on->sums, on->array[SUMS], count * sizeof *on->sums);
    if (on->aov_sums != NULL)
        ty_device_read(&on->arrays, on->aov_sums, on->array[AOV_SUMS], count * sizeof *on->aov_sums);
    ty_device_read(&on->arrays, on->vertices, on->array[VERTICES], count * sizeof *on->vertices);
    const ty_result result = on->arrays.result;
    *vertices = 0;
    for (size_t i = 0; i < count && result == TY_OK; ++i) *vertices += on->vertices[i];
    *sums = on->sums;
    *aov_sums = on->aov_sums;
    return result;
}
