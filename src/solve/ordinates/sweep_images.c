/* Sweeps of a box that repeats: what enters by its faces is stored, and what leaves by the opposite ones is told, so
 * that the caller's iteration carries it from one sweep to the next. */
#include "solve/ordinates/sweep_state.h"

#include "base/arena.h"
#include "base/context.h"

#include <string.h>

/* Faces across an axis. */
static size_t faces_across(const ty_sweep_box* box, int axis) {
    return (size_t)box->size[axis == 0 ? 1 : 0] * (size_t)box->size[axis == 2 ? 1 : 2];
}

static bool repeats(const ty_sweep_box* box, int axis) {
    return (box->periodic >> axis & 1) != 0;
}

static void lay_out(ty_sweep* sweep, ty_arena* arena) {
    ty_sweep_box* box = &sweep->box;
    const size_t pitch = (size_t)ty_sweep_pitch(sweep);
    size_t largest = 0;
    sweep->inflow = ty_arena_take(arena, sizeof(float) * sweep->inflow_floats);
    for (int o = 0; o < 8 && repeats(box, 0); ++o)
        box->faces_x[o] = ty_arena_take(arena, sizeof(float) * pitch * faces_across(box, 0));
    for (int a = 0; a < 3; ++a)
        if (!repeats(box, a) && faces_across(box, a) > largest) largest = faces_across(box, a);
    const float* dark = ty_arena_take(arena, sizeof(float) * pitch * largest);
    const float* inflow = sweep->inflow;
    for (int a = 0; a < 3; ++a)
        for (int o = 0; o < 8; ++o) {
            box->boundary_radiance[a][o] = repeats(box, a) ? inflow : dark;
            if (repeats(box, a) && arena->base != NULL) inflow += pitch * faces_across(box, a);
        }
}

ty_result ty_sweep_repeat(ty_sweep* sweep, uint32_t axes) {
    ty_sweep_box* box = &sweep->box;
    if (axes == 0) return TY_OK;
    box->periodic = axes;
    for (int a = 0; a < 3; ++a) {
        box->patches.patches[a] = box->size[a];
        if (repeats(box, a)) sweep->inflow_floats += 8 * (size_t)ty_sweep_pitch(sweep) * faces_across(box, a);
    }
    ty_arena arena = {0};
    lay_out(sweep, &arena);
    sweep->inflow_bytes = arena.used;
    arena = (ty_arena){.base = ty_alloc_array(sweep->context, sweep->inflow_bytes, 1, true)};
    sweep->inflow_memory = arena.base;
    if (arena.base == NULL) return TY_ERROR_MEMORY;
    lay_out(sweep, &arena);
    return TY_OK;
}

void ty_sweep_free_inflow(ty_sweep* sweep) {
    if (sweep->inflow_memory != NULL) ty_free_array(sweep->context, sweep->inflow_memory, sweep->inflow_bytes, 1);
    sweep->inflow_memory = NULL;
}

float* ty_sweep_inflow(ty_sweep* sweep) {
    return sweep->inflow;
}

size_t ty_sweep_inflow_floats(const ty_sweep* sweep) {
    return sweep->inflow_floats;
}

void ty_sweep_outflow(const ty_sweep* sweep, float* out) {
    const ty_sweep_box* box = &sweep->box;
    const ptrdiff_t pitch = ty_sweep_pitch(sweep), lanes = box->lanes;
    for (int a = 0; a < 3; ++a)
        for (int o = 0; o < 8 && repeats(box, a); ++o) {
            const float* from = a == 0 ? box->faces_x[o] : a == 1 ? box->faces_y[o] : box->faces_z[o];
            const ptrdiff_t faces = (ptrdiff_t)faces_across(box, a);
            for (ptrdiff_t g = 0; g < box->groups; ++g)
                for (ptrdiff_t i = 0; i < faces; ++i, from += lanes)
                    memcpy(out + i * pitch + g * lanes, from, sizeof(float) * (size_t)lanes);
            out += faces * pitch;
        }
}

double ty_sweep_inflow_power(const ty_sweep* sweep, const float* inflow) {
    const ty_sweep_box* box = &sweep->box;
    const int32_t pitch = ty_sweep_pitch(sweep);
    double sum = 0;
    for (int a = 0; a < 3; ++a)
        for (size_t i = 0; i < 8 * faces_across(box, a) && repeats(box, a); ++i, inflow += pitch)
            for (int32_t d = 0; d < box->directions; ++d)
                sum += (double)(inflow[d] * box->partial_current_weight[a][d]);
    return sum;
}

void ty_sweep_set_passing(ty_sweep* sweep, int axis, float* const passing[2]) {
    for (int i = 0; i < 2; ++i) sweep->box.passing[i] = passing != NULL ? passing[i] : NULL;
    sweep->box.passing_axis = axis;
}
