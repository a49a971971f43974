/* Shared by tests of src/direct: scenes of one medium, and their light on a grid. */
#ifndef TY_TESTS_DIRECT_MAKER_H
#define TY_TESTS_DIRECT_MAKER_H

#include "checks.h"
#include "direct/lights/discretize.h"
#include "direct/uncollided/uncollided.h"

typedef struct direct_case {
    ty_scene* scene;
    ty_grid_medium* medium;
    ty_discrete_light_set sources;
} direct_case;

static inline void check_result(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

/* Takes over a scene with everything in it: commits it, and cuts its media into cells, `longest` along the longest
 * side. */
static inline direct_case direct_begin(ty_scene* scene, int32_t longest, int32_t beams, int32_t points) {
    ty_context* context = ty_scene_context(scene);
    direct_case made = {.scene = scene};
    ty_grid_box box;
    ty_discretize_def def = ty_default_discretize_def();
    def.environment = beams;
    def.surface = points;
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_grid_box_fit(scene, longest, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &made.medium));
    check_result(context, ty_discretize_lights(scene, &def, &made.sources));
    return made;
}

static inline void direct_end(direct_case* made) {
    ty_discrete_light_set_destroy(ty_scene_context(made->scene), &made->sources);
    ty_grid_medium_destroy(made->medium);
    ty_scene_destroy(made->scene);
}

/* All sources together. */
static inline ty_light_field* direct_light(const direct_case* made, bool with_flux) {
    ty_light_field* field = NULL;
    ty_context* context = ty_scene_context(made->scene);
    check_result(context, ty_light_field_create(made->medium, with_flux, &field));
    check_result(context,
                 ty_uncollided_add(made->scene, made->medium, NULL, made->sources.items, made->sources.count, field));
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

/* Walls in the faces of a box but for its upper one along z. */
static inline void direct_add_walls(ty_scene* scene, const double lower[3], const double upper[3]) {
    for (int face = 0; face < 5; ++face) {
        const int a = face / 2, b = (a + 1) % 3, c = (a + 2) % 3;
        ty_shape_def wall = ty_default_shape_def();
        memcpy(wall.origin, lower, sizeof wall.origin);
        wall.origin[a] = face % 2 == 0 ? lower[a] : upper[a];
        set3(wall.u, 0, 0, 0);
        set3(wall.v, 0, 0, 0);
        wall.u[b] = upper[b] - lower[b];
        wall.v[c] = upper[c] - lower[c];
        check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &wall));
    }
}

/* Distance within the open face of such a box at which light that gets to a point comes in, m; less than 0: it does
 * not. */
static inline double direct_through_opening(const double lower[3], const double upper[3], const double point[3],
                                            const double toward[3]) {
    double within = INFINITY;
    const double far = (upper[2] - point[2]) / toward[2];
    for (int a = 0; a < 2; ++a) {
        const double at = point[a] + far * toward[a];
        within = fmin(within, fmin(at - lower[a], upper[a] - at));
    }
    return within;
}

static inline void direct_add_sun(ty_scene* scene, double x, double y, double z, float irradiance) {
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, x, y, z);
    set3f(sun.color, irradiance, irradiance, irradiance);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &sun));
}

#endif
