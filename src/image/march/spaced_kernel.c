/* Rows of rays several pixels apart, and of pixels; built once per instruction set, with TY_ISA naming it. */
#include "image/march/spaced.k.h"

#include "base/float_mode.h"

static uint64_t march_rays(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t row,
                           int32_t begin, int32_t end) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t i = begin; i < end; ++i) steps += ty_spaced_march(request, &ray, lattice, sample, i, row);
    ty_restore_denormals(state);
    return steps;
}

/* Surfaces that the pixels of a packet see. */
static void intersect(const ty_march_request* request, int32_t x, int32_t y, int32_t count, int32_t sample,
                      ty_vec directions[TY_PACKET], ty_hit hits[TY_PACKET]) {
    const ty_vec origin = request->camera.origin;
    ty_ray rays[TY_PACKET];
    for (int32_t i = 0; i < count; ++i) {
        const ty_vec d = directions[i] = ty_spaced_direction(request, x + i, y, sample);
        rays[i] = (ty_ray){{origin.x, origin.y, origin.z}, {d.x, d.y, d.z}, TY_FLOAT_MAX};
        hits[i].surface = -1;
    }
    if (request->scene->mesh != NULL) ty_accel_intersect_packet(request->scene->mesh, rays, count, hits);
}

static uint64_t fill_pixels(const ty_march_request* request, const ty_spaced_rays* lattice, int32_t sample, int32_t y,
                            int32_t begin, int32_t end, ty_march_pixel* pixels) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    for (int32_t first = begin; first < end; first += TY_PACKET) {
        const int32_t count = end - first < TY_PACKET ? end - first : TY_PACKET;
        ty_vec directions[TY_PACKET];
        ty_hit hits[TY_PACKET];
        intersect(request, first, y, count, sample, directions, hits);
        for (int32_t i = 0; i < count; ++i)
            steps += ty_spaced_fill(request, &ray, lattice, sample, first + i, y, directions[i],
                                    hits[i].surface >= 0 ? &hits[i] : NULL, &pixels[first - begin + i]);
    }
    ty_restore_denormals(state);
    return steps;
}

const ty_spaced_kernels TY_KERNEL_NAME(ty_spaced_kernels) = {.march = march_rays, .fill = fill_pixels};
