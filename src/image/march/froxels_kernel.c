/* Froxels of a view and its pixels; built once per instruction set, with TY_ISA naming it. */
#include "image/march/froxels.h"

#include "base/float_mode.h"
#include "image/march/froxels.k.h"

static void add_range(const ty_march_request* request, int32_t row, float range[2]) {
    for (int32_t column = 0; column < request->froxels.size[0]; ++column)
        for (int32_t i = 0; i < request->spp; ++i) {
            float x, y;
            ty_froxel_place(request, column, row, i, &x, &y);
            ty_froxel_add_range(request, x, y, range);
        }
}

/* The point of slices at which a column's ray samples them, as a fraction: the center for a single ray; those of
 * several are spread evenly (a Kronecker sequence). */
static float fraction_of(int32_t sample) {
    const float phase = 0.5f + 0.754877666f * (float)sample;
    return phase - floorf(phase);
}

static uint64_t fill(const ty_march_request* request, int32_t row) {
    const unsigned state = ty_flush_denormals();
    const ty_froxel_view* grid = &request->froxels;
    const size_t nodes = (size_t)grid->size[2] + 1;
    const float weight = 1.0f / (float)request->spp;
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t column = 0; column < grid->size[0]; ++column) {
        ty_froxel* froxels = grid->froxels + ((size_t)row * (size_t)grid->size[0] + (size_t)column) * nodes;
        memset(froxels, 0, nodes * sizeof *froxels);
        for (int32_t i = 0; i < request->spp; ++i) {
            float x, y;
            ty_froxel_place(request, column, row, i, &x, &y);
            ty_froxel_march(request, &ray, x, y, fraction_of(i), weight, froxels);
            steps += ray.steps;
        }
    }
    ty_restore_denormals(state);
    return steps;
}

static TY_MARCH_KERNEL(look_up) {
    const unsigned state = ty_flush_denormals();
    const ty_accel* mesh = request->scene->mesh;
    for (int32_t column = begin; column < end; ++column) {
        ty_march_pixel* pixel = &pixels[column - begin];
        memset(pixel, 0, sizeof *pixel);
        for (int32_t i = 0; i < request->spp; ++i) {
            float dx, dy;
            ty_hit hit;
            ty_march_light light;
            ty_pixel_place(i, request->spp, &dx, &dy);
            const float px = (float)column + dx, py = (float)y + dy;
            const ty_vec direction = ty_camera_direction(&request->camera, px, py);
            const bool hits =
                mesh != NULL && ty_accel_intersect(mesh, request->camera.origin, direction, TY_FLOAT_MAX, &hit);
            const float depth = hits ? hit.distance / ty_froxel_stretch(&request->camera, px, py) : TY_FLOAT_MAX;
            ty_froxel_interpolate(request, px, py, depth, &light);
            ty_pixel_add_light(request, &light, direction, hits ? &hit : NULL, pixel);
        }
    }
    ty_restore_denormals(state);
    return 0;
}

const ty_froxel_kernels TY_KERNEL_NAME(ty_froxel_kernels) = {.add_range = add_range, .fill = fill, .look_up = look_up};
