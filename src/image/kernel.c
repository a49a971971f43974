/* The marcher's kernel; built once per instruction set, with TY_ISA naming it. */
#include "image/kernel.h"

#include "base/float_mode.h"
#include "base/octahedral.k.h"
#include "image/reflect.k.h"

/* A golden-ratio lattice over the pixel; a single ray goes through the center. */
static void sample_pixel(int32_t sample, int32_t spp, float* dx, float* dy) {
    const float phase = 0.5f + 0.618033989f * (float)sample;
    *dx = ((float)sample + 0.5f) / (float)spp;
    *dy = phase - floorf(phase);
}

/* End of the first step of a pixel's ray, as a fraction of a step: maximally different between neighbours (R2, Roberts
 * 2018) and between the rays of a pixel. */
static float offset_of(const ty_march_request* request, int32_t x, int32_t y, int32_t sample) {
    const double lattice_position = 0.7548776662466927 * x + 0.5698402909980532 * y + (double)sample / request->spp;
    const float value = (float)(lattice_position - floor(lattice_position)) + request->step_offset;
    return 1.0f - (value - floorf(value));
}

static void add_environment(const ty_march_request* request, ty_vec direction, const float transmittance[3],
                            float unscattered[3]) {
    const ty_light_set* lights = &request->scene->lights;
    for (int32_t i = 0; i < lights->distant_count; ++i) {
        const ty_light_view* light = &lights->lights[lights->distant[i]];
        float radiance[3];
        if (light->kind != TY_KIND_ENVIRONMENT) continue;
        ty_environment_radiance(&light->environment, direction, radiance);
        for (int c = 0; c < 3; ++c) unscattered[c] += transmittance[c] * radiance[c];
    }
}

/* Environments seen through media that scatter nearly straight on. */
static void add_blurred(const ty_march_request* request, ty_vec direction, const ty_march_light* light,
                        float multiple[3]) {
    int32_t cell[4];
    float weight[4];
    ty_octahedral_around(TY_MARCH_BLUR_CELLS, direction, cell, weight);
    for (int32_t k = 0; k < 4; ++k)
        for (int c = 0; c < 3; ++c)
            multiple[c] += (light->scaled[c] - light->transmittance[c]) * weight[k] * request->blurred[3 * cell[k] + c];
}

static void add_ray(const ty_march_request* request, ty_march_ray* ray, ty_vec direction, float offset,
                    ty_march_pixel* pixel) {
    const ty_accel* mesh = request->scene->mesh;
    const ty_vec origin = request->camera.origin;
    ty_hit hit;
    const bool hits = mesh != NULL && ty_accel_intersect(mesh, origin, direction, TY_FLOAT_MAX, &hit);
    ty_march_follow(ray, request, origin, direction, hits ? hit.distance : TY_FLOAT_MAX, offset, 1.0f);
    const ty_march_light light = ray->light;
    for (int c = 0; c < 3; ++c) {
        pixel->unscattered[c] += light.emission[c];
        pixel->single[c] += light.single[c];
        pixel->multiple[c] += light.multiple[c];
        pixel->transmittance[c] += light.transmittance[c];
    }
    if (!hits) {
        if (request->blurred != NULL) add_blurred(request, direction, &light, pixel->multiple);
        if (request->has_background != 0) add_environment(request, direction, light.transmittance, pixel->unscattered);
        return;
    }
    pixel->depth += hit.distance;
    pixel->hits += 1.0f;
    if (request->has_field != 0)
        ty_reflect(request, ray, direction, &hit, offset, light.transmittance, pixel->multiple);
}

TY_MARCH_KERNEL(TY_KERNEL_NAME(ty_march_kernel)) {
    const unsigned state = ty_flush_denormals();
    uint64_t steps = 0;
    ty_march_ray ray;
    ray.steps = 0;
    for (int32_t x = begin; x < end; ++x) {
        ty_march_pixel* pixel = &pixels[x - begin];
        memset(pixel, 0, sizeof *pixel);
        for (int32_t i = 0; i < request->spp; ++i) {
            float dx, dy;
            sample_pixel(i, request->spp, &dx, &dy);
            const ty_vec direction = ty_camera_direction(&request->camera, (float)x + dx, (float)y + dy);
            add_ray(request, &ray, direction, offset_of(request, x, y, i), pixel);
            steps += ray.steps;
        }
    }
    ty_restore_denormals(state);
    return steps;
}
