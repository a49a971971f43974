/* Pixels that outlines of emitters cross. */
#include "method/path/outlines.h"

#include "base/context.h"
#include "base/luminance.k.h"
#include "scene/surfaces/accel.h"

enum { RAYS = 16 };
static const uint64_t finding_seed = 0x27d4eb2f165667c5u;

static bool emits(const ty_light_set* lights) {
    bool found = false;
    for (int32_t i = 0; i < lights->count; ++i) {
        const int32_t kind = lights->lights[i].kind;
        found = found || kind == TY_KIND_AREA || kind == TY_KIND_SPHERE || kind == TY_KIND_TRIANGLE;
    }
    return found;
}

/* Luminance of the emission that a ray of the camera meets. */
static float seen_emission(const ty_path_run* run, float x, float y) {
    const ty_camera_view* camera = &run->request.camera;
    const ty_vec direction = ty_camera_direction(camera, x, y);
    ty_hit hit;
    ty_surface_look look;
    if (!ty_accel_intersect(run->view.mesh, camera->origin, direction, TY_FLOAT_MAX, &hit)) return 0;
    ty_surface_evaluate_color(&run->view.surfaces[hit.surface], &hit, direction, &look);
    return ty_luminance(look.emission[0], look.emission[1], look.emission[2]);
}

static void find_in_row(void* user, int64_t row, int32_t worker) {
    (void)worker;
    ty_path_run* run = user;
    const int32_t* crop = run->request.crop;
    const int64_t y = crop[1] + row;
    for (int32_t column = 0; column < crop[2]; ++column) {
        const int64_t x = crop[0] + column;
        const uint64_t number = (uint64_t)(y * run->request.width + x);
        float lowest = TY_FLOAT_MAX, highest = 0;
        for (uint32_t i = 0; i < RAYS; ++i) {
            ty_sampler random = ty_sampler_begin(&run->sobol, run->request.seed ^ finding_seed, number, i);
            const float dx = ty_sobol_next(&random), dy = ty_sobol_next(&random);
            const float emission = seen_emission(run, (float)x + dx, (float)y + dy);
            lowest = ty_minf(lowest, emission);
            highest = ty_maxf(highest, emission);
        }
        run->outlines[row * crop[2] + column] = highest > lowest;
    }
}

ty_result ty_path_prepare_outlines(ty_path_run* run) {
    if (run->request.kind != TY_PATH_PIXELS || run->request.camera.sampled != 0 || run->view.mesh == NULL ||
        run->view.interior_count > 0 || !emits(&run->view.lights))
        return TY_OK;
    run->outlines = ty_alloc_array(run->context, (size_t)run->item_count, 1, true);
    if (run->outlines == NULL) return TY_ERROR_MEMORY;
    run->request.outlines = run->outlines;
    return TY_OK;
}

void ty_path_find_outlines(ty_path_run* run) {
    if (run->outlines == NULL || run->has_outlines) return;
    run->has_outlines = true;
    ty_parallel_for(run->context, run->request.crop[3], find_in_row, run);
}
