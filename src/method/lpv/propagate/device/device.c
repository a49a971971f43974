/* The light of all cells stays on the device from the first step to the last; the sums of each step are read. */
#include "method/lpv/propagate/device/device.h"

#include "base/context.h"
#include "device/arrays.h"
#include "method/lpv/propagate/device/launch.h"

#include <string.h>

struct ty_lpv_device {
    ty_lpv_propagation* propagation;
    ty_lattice lattice; /* both with the device's pointers */
    ty_lpv_propagation there;
    ty_device_arrays arrays;
    ty_address arguments[2]; /* of steps that add to the sum, and of others */
    ty_address link_functions, transmission, totals;
    const ty_program* program;
    int64_t threads;
    double* sums; /* of rows of strips, here */
    size_t sum_count;
};

static void* as_pointer(ty_address address) {
    return (void*)(uintptr_t)address;
}

static void place_lattice(ty_lpv_device* on) {
    const ty_lpv_propagation* propagation = on->propagation;
    ty_lattice* lattice = &on->lattice;
    ty_device_arrays* arrays = &on->arrays;
    for (int c = 0; c < 3; ++c)
        if (propagation->mode == TY_LPV_MODE_LINKS)
            ty_device_take(arrays, &lattice->albedo[c], lattice->cells, sizeof(float));
    on->link_functions = ty_device_place(arrays, &propagation->link_functions, sizeof propagation->link_functions);
    if (propagation->blocked_links == NULL) return;
    for (int k = 0; k < TY_LPV_LINKS; ++k) ty_device_take(arrays, &lattice->transmission[k], lattice->cells, 1);
    on->transmission = ty_device_place(arrays, lattice->transmission, sizeof lattice->transmission);
}

static void place_light(ty_lpv_device* on) {
    ty_lpv_propagation* there = &on->there;
    ty_device_arrays* arrays = &on->arrays;
    const size_t bytes = there->floats * sizeof(float);
    there->from = as_pointer(ty_device_place(arrays, there->from, bytes));
    there->to = as_pointer(ty_device_place(arrays, there->to, bytes));
    there->sum = as_pointer(ty_device_place(arrays, there->sum, bytes));
    for (int32_t c = 0; c < there->planes; ++c)
        ty_device_take(arrays, &there->factors[c], TY_LPV_BANDS_MAX * there->factor_floats, sizeof(float));
    if (there->blocked_links != NULL)
        ty_device_take(arrays, &there->blocked_links, there->blocked_link_count, sizeof *there->blocked_links);
}

/* All rows of a step, and its arguments. */
static ty_address place_step(ty_lpv_device* on, ty_address totals, ty_address sums, ty_lpv_row* rows) {
    const int32_t* size = on->lattice.box.size;
    ty_lpv_launch launch = {
        .strips = (size[1] + TY_LPV_STRIP - 1) / TY_LPV_STRIP, .sums = as_pointer(sums), .totals = as_pointer(totals)};
    ty_lpv_row row = ty_lpv_propagation_begin_row(&on->there);
    row.link_functions = as_pointer(on->link_functions);
    row.transmission = as_pointer(on->transmission);
    for (int32_t z = 0; z < size[2]; ++z)
        for (int32_t y = 0; y < size[1]; ++y) {
            ty_lpv_propagation_move_row(&on->there, y, z, &row);
            rows[z * size[1] + y] = row;
        }
    memcpy(launch.size, size, sizeof launch.size);
    launch.rows = as_pointer(ty_device_place(&on->arrays, rows, (size_t)(size[1] * size[2]) * sizeof *rows));
    return ty_device_place(&on->arrays, &launch, sizeof launch);
}

static void swap(ty_lpv_propagation* there) {
    float* done = there->from;
    there->from = there->to;
    there->to = done;
}

static ty_result place_all(ty_lpv_device* on) {
    const int32_t* size = on->lattice.box.size;
    ty_context* context = on->lattice.context;
    const size_t row_count = (size_t)(size[1] * size[2]);
    const size_t strips = (size_t)((size[1] + TY_LPV_STRIP - 1) / TY_LPV_STRIP);
    on->sum_count = 3 * TY_LPV_SUMS * (size_t)size[2] * strips;
    on->threads = 3 * (int64_t)size[2] * (int64_t)strips * size[0];
    on->sums = ty_alloc_array(context, on->sum_count, sizeof *on->sums, false);
    ty_lpv_row* rows = ty_alloc_array(context, row_count, sizeof *rows, false);
    if (on->sums == NULL || rows == NULL) {
        ty_free_array(context, rows, row_count, sizeof *rows);
        return TY_ERROR_MEMORY;
    }
    place_lattice(on);
    place_light(on);
    const ty_address sums = ty_device_place(&on->arrays, NULL, TY_LPV_SUMS * (size_t)on->threads * sizeof(float));
    on->totals = ty_device_place(&on->arrays, NULL, on->sum_count * sizeof *on->sums);
    for (int i = 0; i < 2; ++i) {
        on->there.adds = i == 0;
        on->arguments[i] = place_step(on, on->totals, sums, rows);
        swap(&on->there);
    }
    ty_free_array(context, rows, row_count, sizeof *rows);
    on->program = on->lattice.terms == 4 ? &ty_program_lpv_two : &ty_program_lpv_three;
    if (on->arrays.result == TY_OK)
        on->arrays.result = on->arrays.device->backend->load(on->arrays.device, on->program);
    if (on->arrays.result == TY_OK)
        on->arrays.result = on->arrays.device->backend->load(on->arrays.device, &ty_program_lpv_sums);
    return on->arrays.result;
}

ty_result ty_lpv_device_create(ty_lpv_propagation* propagation, ty_lpv_device** out) {
    ty_context* context = propagation->lattice->context;
    ty_device* device = NULL;
    *out = NULL;
    ty_result result = ty_context_device(context, &device);
    if (result != TY_OK || device == NULL) return result;
    ty_lpv_device* on = ty_alloc_array(context, 1, sizeof *on, true);
    if (on == NULL) return TY_ERROR_MEMORY;
    on->propagation = propagation;
    on->lattice = *propagation->lattice;
    on->there = *propagation;
    on->there.lattice = &on->lattice;
    on->arrays.device = device;
    pthread_mutex_lock(&device->busy);
    result = place_all(on);
    if (result == TY_OK)
        *out = on;
    else
        ty_lpv_device_destroy(on);
    return result;
}

void ty_lpv_device_destroy(ty_lpv_device* on) {
    if (on == NULL) return;
    ty_context* context = on->lattice.context;
    ty_device* device = on->arrays.device;
    ty_device_free(&on->arrays);
    pthread_mutex_unlock(&device->busy);
    ty_free_array(context, on->sums, on->sum_count, sizeof *on->sums);
    ty_free_array(context, on, 1, sizeof *on);
}

ty_result ty_lpv_device_step(ty_lpv_device* on, bool adds, ty_lpv_sums* out) {
    const ty_address arguments = on->arguments[adds ? 0 : 1];
    *out = (ty_lpv_sums){.arrived = {0}};
    double* const of[TY_LPV_SUMS] = {[TY_LPV_ARRIVED] = out->arrived,
                                     [TY_LPV_SIZE] = out->size,
                                     [TY_LPV_GOES_ON] = out->goes_on,
                                     [TY_LPV_BLOCKED] = out->blocked,
                                     [TY_LPV_LEFT] = out->left};
    ty_device_launch(&on->arrays, on->program, arguments, on->threads);
    ty_device_launch(&on->arrays, &ty_program_lpv_sums, arguments, (int64_t)on->sum_count);
    ty_device_read(&on->arrays, on->sums, on->totals, on->sum_count * sizeof *on->sums);
    if (on->arrays.result != TY_OK) return on->arrays.result;
    swap(&on->there);
    const size_t each = on->sum_count / (3 * TY_LPV_SUMS);
    for (size_t i = 0; i < on->sum_count; ++i) of[i / (3 * each)][i / each % 3] += on->sums[i];
    return TY_OK;
}

ty_result ty_lpv_device_finish(ty_lpv_device* on) {
    ty_lpv_propagation* propagation = on->propagation;
    const size_t bytes = propagation->floats * sizeof(float);
    ty_device_read(&on->arrays, propagation->from, (ty_address)(uintptr_t)on->there.from, bytes);
    ty_device_read(&on->arrays, propagation->sum, (ty_address)(uintptr_t)on->there.sum, bytes);
    return on->arrays.result;
}
