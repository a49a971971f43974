/* Extinction floor near local lights. */
#include "base/context.h"
#include "base/parallel.h"
#include "method/lpv/propagate/propagate.h"

/* Extinction times the distance from a light, pi^2 / 12. The light's own rays would need 2/3: their flux r^-2 is then
 * -1 / (3 extinction) times the gradient of their fluence r^-2. The light that a fog scatters once, equal power in
 * every shell, has the fluence pi^2 / (4 r) for a flux 1 / r, which needs pi^2 / 12. */
static const float per_distance = 0.82246703f;

static bool is_local_light(const ty_light_view* light) {
    return light->kind != TY_KIND_DIRECTIONAL && light->kind != TY_KIND_ENVIRONMENT;
}

static ty_vec center_of(const ty_light_view* light) {
    if (light->kind != TY_KIND_AREA) return light->position;
    return ty_mad(light->position, ty_add(light->u, light->v), 0.5f);
}

/* A local light's intensity towards a point, unshadowed; of other lights the fluence. Sum of all channels. */
static float intensity_towards(const ty_light_view* light, ty_vec off) {
    const float color = light->color[0] + light->color[1] + light->color[2];
    if (light->kind == TY_KIND_ENVIRONMENT) return 3.0f * light->typical;
    if (light->kind == TY_KIND_SPHERE)
        return color * TY_PI * light->radius * light->radius *
               ty_light_falloff(light, ty_scale(ty_normalize(off), -1.0f));
    if (light->kind != TY_KIND_AREA) return color;
    return color * light->area * ty_maxf(0.0f, ty_dot(ty_normalize(off), light->direction));
}

typedef struct floor_job {
    ty_lattice* lattice;
    const ty_light_view* lights;
    int32_t count;
} floor_job;

/* The floor at a point, weighted by the unshadowed irradiance of local lights among all lights. */
static float extinction_floor_at(const floor_job* job, ty_vec point) {
    float sum = 0.0f, all = 0.0f;
    for (int32_t i = 0; i < job->count; ++i) {
        const ty_light_view* light = &job->lights[i];
        const ty_vec off = ty_sub(point, center_of(light));
        const float min_distance = 0.5f * job->lattice->cell,
                    square = ty_maxf(ty_dot(off, off), min_distance * min_distance);
        const bool is_local = is_local_light(light);
        const float color = intensity_towards(light, off), bright = is_local ? color / square : color;
        all += bright;
        if (is_local) sum += bright * per_distance / sqrtf(square);
    }
    return all > 0.0f ? sum / all : 0.0f;
}

static void fill_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    const floor_job* job = user;
    const ty_lattice* lattice = job->lattice;
    const int32_t* size = lattice->box.size;
    const double* lower = lattice->box.lower;
    const double cell = (double)lattice->cell;
    const float y = (float)(lower[1] + cell * ((double)(row % size[1]) + 0.5));
    const float z = (float)(lower[2] + cell * ((double)(row / size[1]) + 0.5));
    for (int32_t x = 0; x < size[0]; ++x)
        lattice->extinction_floor[row * size[0] + x] =
            extinction_floor_at(job, ty_vec_make((float)(lower[0] + cell * (x + 0.5)), y, z));
}

ty_result ty_lattice_find_extinction_floor(ty_lattice* lattice, const ty_light_view* lights, int32_t count) {
    floor_job job = {lattice, lights, count};
    bool any_local = false;
    for (int32_t i = 0; i < count; ++i) any_local = any_local || is_local_light(&lights[i]);
    if (!any_local) return TY_OK;
    lattice->extinction_floor =
        ty_alloc_array(lattice->context, lattice->cells, sizeof *lattice->extinction_floor, false);
    if (lattice->extinction_floor == NULL) return TY_ERROR_MEMORY;
    ty_parallel_flushed(lattice->context, (int64_t)lattice->box.size[1] * lattice->box.size[2], fill_row, &job);
    return TY_OK;
}
