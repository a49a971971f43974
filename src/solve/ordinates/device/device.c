#include "solve/ordinates/device/device.h"

#include "base/context.h"
#include "device/arrays.h"
#include "solve/ordinates/device/launch.h"

#include <string.h>

struct ty_sweep_device {
    ty_context* context;
    const ty_sweep_box* box;
    ty_device* device;
    ty_device_arrays arrays;
    ty_ordinates_launch launch;
    ty_address arguments, faces[3], emission, moments, fixups;
    size_t columns, cells;
    size_t face_floats[3]; /* of all octants and directions */
    size_t largest_face;
    float* face; /* floats of the largest face, here */
};

static void* as_pointer(ty_address address) {
    return (void*)(uintptr_t)address;
}

static size_t moment_bytes(const ty_sweep_device* on) {
    return on->cells * (size_t)on->box->terms * sizeof(float);
}

/* Cells of the faces across an axis. */
static size_t face_cells(const ty_sweep_box* box, int axis) {
    return (size_t)box->size[axis == 0 ? 1 : 0] * (size_t)box->size[axis == 2 ? 1 : 2];
}

/* ---- memory ---- */

static void set_sizes(ty_sweep_device* on) {
    const ty_sweep_box* box = on->box;
    on->columns = face_cells(box, 0);
    on->cells = on->columns * (size_t)box->size[0];
    for (int a = 0; a < 3; ++a) {
        on->face_floats[a] = 8 * face_cells(box, a) * (size_t)box->directions;
        if (on->face_floats[a] > on->largest_face) on->largest_face = on->face_floats[a];
    }
}

static void place_tables(ty_sweep_device* on) {
    const ty_sweep_box* box = on->box;
    ty_device_arrays* arrays = &on->arrays;
    ty_ordinates_launch* launch = &on->launch;
    const size_t pitch = (size_t)box->groups * (size_t)box->lanes;
    *launch = (ty_ordinates_launch){.size = {box->size[0], box->size[1], box->size[2]},
                                    .directions = box->directions,
                                    .terms = box->terms,
                                    .bands = 2 * box->even - box->terms,
                                    .even = box->even,
                                    .odd_begin = (box->even + box->lanes - 1) / box->lanes * box->lanes,
                                    .pitch = (int32_t)pitch,
                                    .padded = box->padded,
                                    .order = box->order,
                                    .extinction = box->extinction};
    ty_device_take(arrays, &launch->order, (size_t)box->terms, sizeof *launch->order);
    ty_device_take(arrays, &launch->extinction, on->cells, sizeof *launch->extinction);
    for (int a = 0; a < 3; ++a)
        launch->two_mu_over_h[a] =
            as_pointer(ty_device_place_constant(arrays, box->two_mu_over_h[a], pitch * sizeof(float)));
    for (int i = 0; i < 4; ++i) {
        const size_t harmonics = (size_t)box->terms * pitch, weighted = (size_t)box->padded * pitch;
        launch->y_lm[i] = as_pointer(ty_device_place_constant(arrays, box->y_lm[i], harmonics * sizeof(float)));
        launch->weighted_y_lm[i] =
            as_pointer(ty_device_place_constant(arrays, box->weighted_y_lm[i], weighted * sizeof(float)));
    }
}

static void place_all(ty_sweep_device* on) {
    ty_device_arrays* arrays = &on->arrays;
    ty_ordinates_launch* launch = &on->launch;
    place_tables(on);
    for (int a = 0; a < 3; ++a) {
        on->faces[a] = ty_device_place(arrays, NULL, on->face_floats[a] * sizeof(float));
        launch->faces[a] = as_pointer(on->faces[a]);
    }
    launch->psi = as_pointer(ty_device_place(arrays, NULL, on->face_floats[0] * sizeof(float)));
    on->emission = ty_device_place(arrays, NULL, moment_bytes(on));
    on->moments = ty_device_place(arrays, NULL, moment_bytes(on));
    on->arguments = ty_device_place(arrays, NULL, sizeof *launch);
    launch->emission = as_pointer(on->emission);
    launch->moments = as_pointer(on->moments);
}

ty_result ty_sweep_device_create(ty_context* context, const ty_sweep_box* box, ty_sweep_device** out) {
    ty_device* device = NULL;
    *out = NULL;
    ty_result result = ty_context_device(context, &device);
    if (result != TY_OK || device == NULL) return result;
    ty_sweep_device* on = ty_alloc_array(context, 1, sizeof *on, true);
    if (on == NULL) return TY_ERROR_MEMORY;
    on->context = context;
    on->box = box;
    on->device = on->arrays.device = device;
    set_sizes(on);
    on->face = ty_alloc_array(context, on->largest_face, sizeof *on->face, false);
    if (on->face == NULL) on->arrays.result = TY_ERROR_MEMORY;
    pthread_mutex_lock(&device->busy);
    place_all(on);
    pthread_mutex_unlock(&device->busy);
    result = on->arrays.result;
    if (result == TY_OK)
        *out = on;
    else
        ty_sweep_device_destroy(on);
    return result;
}

void ty_sweep_device_destroy(ty_sweep_device* on) {
    if (on == NULL) return;
    pthread_mutex_lock(&on->device->busy);
    ty_device_free(&on->arrays);
    pthread_mutex_unlock(&on->device->busy);
    if (on->face != NULL) ty_free_array(on->context, on->face, on->largest_face, sizeof *on->face);
    ty_free_array(on->context, on, 1, sizeof *on);
}

/* ---- one sweep ---- */

/* Radiance that enters across an axis; in a dark surrounding nothing is copied. */
static void begin_faces(ty_sweep_device* on, int axis) {
    const ty_sweep_box* box = on->box;
    const size_t pitch = (size_t)box->groups * (size_t)box->lanes, directions = (size_t)box->directions;
    const int32_t wide = box->size[axis == 0 ? 1 : 0], high = box->size[axis == 2 ? 1 : 2];
    if (box->patches.across[0] == NULL) {
        ty_device_clear(&on->arrays, on->faces[axis], on->face_floats[axis] * sizeof(float));
        return;
    }
    float* to = on->face;
    for (int o = 0; o < 8; ++o)
        for (int32_t v = 0; v < high; ++v)
            for (int32_t u = 0; u < wide; ++u, to += directions) {
                const int32_t at[3] = {axis == 0 ? 0 : u, axis == 0 ? u : axis == 1 ? 0 : v, axis == 2 ? 0 : v};
                const size_t patch = (size_t)ty_boundary_patch(&box->patches, box->whole, axis, at);
                memcpy(to, box->boundary_radiance[axis][o] + patch * pitch, directions * sizeof *to);
            }
    ty_device_write(&on->arrays, on->faces[axis], on->face, on->face_floats[axis] * sizeof(float));
}

/* Power that leaves across an axis, W. */
static double leaving_across(ty_sweep_device* on, int axis) {
    const ty_sweep_box* box = on->box;
    const size_t directions = (size_t)box->directions;
    double sum = 0;
    ty_device_read(&on->arrays, on->face, on->faces[axis], on->face_floats[axis] * sizeof(float));
    if (on->arrays.result != TY_OK) return 0;
    for (size_t d = 0; d < directions; ++d) {
        double radiance = 0;
        for (size_t i = d; i < on->face_floats[axis]; i += directions) radiance += (double)on->face[i];
        sum += radiance * (double)box->partial_current_weight[axis][d];
    }
    return sum;
}

static double count_fixups(ty_sweep_device* on, const uint32_t* counts) {
    double sum = 0;
    for (size_t i = 0; i < on->face_floats[0]; ++i) sum += counts[i];
    return sum;
}

static double read_fixups(ty_sweep_device* on) {
    uint32_t* counts = ty_alloc_array(on->context, on->face_floats[0], sizeof *counts, false);
    if (counts == NULL) {
        on->arrays.result = TY_ERROR_MEMORY;
        return 0;
    }
    ty_device_read(&on->arrays, counts, on->fixups, on->face_floats[0] * sizeof *counts);
    const double sum = on->arrays.result == TY_OK ? count_fixups(on, counts) : 0;
    ty_free_array(on->context, counts, on->face_floats[0], sizeof *counts);
    return sum;
}

static void run_planes(ty_sweep_device* on) {
    const ty_sweep_box* box = on->box;
    ty_device_arrays* arrays = &on->arrays;
    ty_ordinates_launch* launch = &on->launch;
    const int32_t planes = box->size[0] + box->size[1] + box->size[2] - 2;
    for (launch->plane = 0; launch->plane < planes && arrays->result == TY_OK; ++launch->plane) {
        ty_device_write(arrays, on->arguments, launch, sizeof *launch);
        ty_device_launch(arrays, &ty_program_ordinates_sweep, on->arguments,
                         8 * (int64_t)on->columns * box->directions);
        ty_device_launch(arrays, &ty_program_ordinates_moments, on->arguments, 8 * (int64_t)on->columns * box->terms);
    }
    ty_device_wait(arrays);
}

ty_result ty_sweep_device_run(ty_sweep_device* on, const float* emission, float* moments, double* leaving,
                              double* fixups) {
    ty_device_arrays* arrays = &on->arrays;
    pthread_mutex_lock(&on->device->busy);
    for (int a = 0; a < 3; ++a) begin_faces(on, a);
    if (fixups != NULL && on->fixups == 0)
        on->fixups = ty_device_place(arrays, NULL, on->face_floats[0] * sizeof(uint32_t));
    on->launch.fixups = fixups != NULL ? as_pointer(on->fixups) : NULL;
    if (fixups != NULL) ty_device_clear(arrays, on->fixups, on->face_floats[0] * sizeof(uint32_t));
    ty_device_write(arrays, on->emission, emission, moment_bytes(on));
    ty_device_clear(arrays, on->moments, moment_bytes(on));
    run_planes(on);
    ty_device_read(arrays, moments, on->moments, moment_bytes(on));
    if (leaving != NULL) *leaving = leaving_across(on, 0) + leaving_across(on, 1) + leaving_across(on, 2);
    if (fixups != NULL) *fixups = read_fixups(on);
    pthread_mutex_unlock(&on->device->busy);
    return arrays->result;
}
