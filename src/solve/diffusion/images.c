#include "solve/diffusion/images.h"

#include <string.h>

static bool repeats(const ty_diffusion_job* job, int axis) {
    return (job->def->periodic >> axis & 1) != 0;
}

static void wrap_axis(const ty_box* box, int axis, char* origin, size_t item) {
    const ptrdiff_t steps[3] = {1, box->row, box->plane}, across = steps[axis] * box->size[axis];
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    const ptrdiff_t bytes = (ptrdiff_t)item;
    for (int32_t j = 0; j < box->size[v]; ++j)
        for (int32_t i = 0; i < box->size[u]; ++i) {
            char* first = origin + bytes * (steps[u] * i + steps[v] * j);
            memcpy(first - bytes * steps[axis], first + bytes * (across - steps[axis]), item);
            memcpy(first + bytes * across, first, item);
        }
}

void ty_diffusion_wrap(const ty_diffusion_job* job, const ty_box* box, void* origin, size_t item) {
    for (int a = 0; a < 3; ++a)
        if (repeats(job, a)) wrap_axis(box, a, origin, item);
}

void ty_diffusion_couple_images(const ty_diffusion_job* job, const ty_level* level) {
    const ty_box* box = &level->box;
    const ptrdiff_t steps[3] = {1, box->row, box->plane};
    for (int axis = 0; axis < 3; ++axis) {
        if (!repeats(job, axis)) continue;
        const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        const ptrdiff_t across = steps[axis] * box->size[axis];
        for (int32_t j = 0; j < box->size[v]; ++j)
            for (int32_t i = 0; i < box->size[u]; ++i) {
                float* first = level->g[axis] + steps[u] * i + steps[v] * j;
                if (box->size[axis] == 1) *first = 0;
                first[across] = *first;
            }
    }
}
