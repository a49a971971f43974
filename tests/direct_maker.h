/* What tests of src/direct share: scenes of one medium, and their light on a grid. */
#ifndef TY_TESTS_DIRECT_MAKER_H
#define TY_TESTS_DIRECT_MAKER_H

#include "checks.h"
#include "direct/uncollided.h"

typedef struct direct_case {
    ty_scene* scene;
    ty_grid_medium* medium;
    ty_source* sources;
    int32_t source_count;
} direct_case;

static inline void check_result(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_last_error(context));
}

/* Takes over a scene with everything in it: commits it, and cuts its media into cells, `longest` along the longest
 * side. */
static inline direct_case direct_begin(ty_scene* scene, int32_t longest, int32_t beams, int32_t points) {
    ty_context* context = ty_scene_context(scene);
    direct_case made = {.scene = scene};
    ty_grid_box box;
    ty_source_def def = ty_default_source_def();
    def.environment = beams;
    def.surface = points;
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_grid_box_fit(scene, longest, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &made.medium));
    check_result(context, ty_sources_create(scene, &def, &made.sources, &made.source_count));
    return made;
}

static inline void direct_end(direct_case* made) {
    ty_sources_destroy(ty_scene_context(made->scene), made->sources, made->source_count);
    ty_grid_medium_destroy(made->medium);
    ty_scene_destroy(made->scene);
}

/* All sources together. */
static inline ty_light_field* direct_light(const direct_case* made, bool with_flux) {
    ty_light_field* field = NULL;
    ty_context* context = ty_scene_context(made->scene);
    check_result(context, ty_light_field_create(made->medium, with_flux, &field));
    check_result(context, ty_uncollided_add(made->scene, made->medium, NULL, made->sources, made->source_count, field));
    return field;
}

/* A box of random densities, a quarter of them 0. */
static inline ty_grid* direct_noise(ty_context* context, int32_t nx, int32_t ny, int32_t nz, uint64_t seed) {
    const size_t count = (size_t)nx * (size_t)ny * (size_t)nz;
    float* values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; ++i) values[i] = (float)fmax(0, uniform_in(&seed, -0.5, 1.5));
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = nx;
    def.size[1] = ny;
    def.size[2] = nz;
    def.values = values;
    ty_grid* grid = NULL;
    check_result(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

static inline void direct_add_sun(ty_scene* scene, double x, double y, double z, float irradiance) {
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, x, y, z);
    set3f(sun.color, irradiance, irradiance, irradiance);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &sun));
}

#endif
