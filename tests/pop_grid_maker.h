/* Shared by tests of ordinates' grids. */
#ifndef TY_TESTS_POP_GRID_MAKER_H
#define TY_TESTS_POP_GRID_MAKER_H

#include "base/context.h"
#include "direct_maker.h"
#include "method/pop/published/propagate.h"

/* A scene of one box, and an ordinate's light in it. */
typedef struct pop_case {
    ty_scene* scene;
    ty_grid_medium* medium;
    ty_pop_def def;
    ty_pop_light light;
    ty_pop_propagation_stats propagation;
    int32_t iterations;
    float* scratch;
    float eye[3];
} pop_case;

static inline ty_discrete_light parallel_light(double x, double y, double z) {
    ty_discrete_light ordinate = {.kind = TY_DISCRETE_DIRECTIONAL, .color = {1, 1, 1}, .mean_cosine = 1};
    ordinate.direction = ty_normalize(ty_vec_make((float)x, (float)y, (float)z));
    return ordinate;
}

static inline ty_discrete_light point_light(double x, double y, double z) {
    ty_discrete_light ordinate = {.kind = TY_DISCRETE_POINT, .color = {1, 1, 1}, .mean_cosine = 1};
    ordinate.position = ty_vec_make((float)x, (float)y, (float)z);
    ordinate.direction = ty_vec_make(0, 0, 1);
    return ordinate;
}

/* The unit cube. */
static inline ty_medium_def pop_cube(double sigma_s, double sigma_a, double g) {
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
    ty_medium_def medium = box_medium(low, high, (float)sigma_s, (float)sigma_a);
    for (int c = 0; c < 3; ++c) medium.g[c] = (float)g;
    return medium;
}

/* Takes over the scene, with all in it. */
static inline pop_case pop_begin(ty_scene* scene, const ty_discrete_light* ordinate, ty_pop_mode mode,
                                 int32_t resolution, int32_t iterations) {
    pop_case made = {.scene = scene, .iterations = iterations, .eye = {0.3f, 0.4f, 5}};
    ty_context* context = ty_scene_context(scene);
    ty_grid_box box;
    check_result(context, ty_scene_commit(scene));
    check_result(context, ty_grid_box_fit(scene, resolution, &box));
    check_result(context, ty_grid_medium_create(scene, &box, &made.medium));
    made.def = (ty_pop_def){.resolution = resolution, .residuum = 0.1};
    made.def.mode = mode;
    made.light.ordinate = *ordinate;
    made.light.floats = mode == TY_POP_MODE_SPLIT ? TY_POP_CELL_FLOATS : TY_POP_CELL_FLOATS_PROPAGATED;
    ty_pop_grid_fit(&box, ordinate, resolution, &made.light.grid);
    const ty_pop_grid* grid = &made.light.grid;
    const int32_t planes = made.medium->planes;
    made.light.accumulated = calloc(ty_pop_accumulated_floats(grid, made.light.floats), sizeof(float));
    made.light.lobes = calloc(ty_pop_lobe_floats(grid, &made.def, planes, iterations), sizeof(float));
    made.scratch = calloc(ty_pop_scratch_floats(grid, &made.def, planes) + 1, sizeof(float));
    assert_true(made.light.accumulated != NULL && made.light.lobes != NULL && made.scratch != NULL);
    return made;
}

static inline void pop_run(pop_case* made) {
    if (made->def.mode == TY_POP_MODE_SPLIT)
        ty_pop_sweep(made->scene, made->medium, made->eye, &made->light);
    else
        ty_pop_propagate(made->scene, &made->def, made->medium, made->eye, made->iterations, made->scratch,
                         &made->light, &made->propagation);
}

static inline void pop_end(pop_case* made) {
    ty_grid_medium_destroy(made->medium);
    ty_scene_destroy(made->scene);
    free(made->light.accumulated);
    free(made->light.lobes);
    free(made->scratch);
}

static inline size_t pop_cells(const ty_pop_grid* grid) {
    return (size_t)grid->size[0] * (size_t)grid->size[1] * (size_t)grid->size[2];
}

/* The floats of a cell of `accumulated`. */
static inline const float* pop_accumulated(const ty_pop_light* light, int32_t i, int32_t j, int32_t k) {
    const int32_t ghosts = ty_pop_ghost_width(&light->grid), row = light->grid.size[0] + 2 * ghosts;
    const int32_t rows = light->grid.size[1] + 2 * ghosts;
    return light->accumulated +
           (size_t)light->floats *
               ((size_t)(i + ghosts) + (size_t)row * ((size_t)(j + ghosts) + (size_t)rows * (size_t)k));
}

/* One of its floats, in split mode without the weight that it is multiplied by. */
static inline double pop_value(const ty_pop_light* light, int32_t i, int32_t j, int32_t k, int number) {
    const float* accumulated = pop_accumulated(light, i, j, k);
    return (double)accumulated[number] /
           (light->mode == TY_POP_MODE_SPLIT ? (double)accumulated[TY_POP_CELL_WEIGHT] : 1);
}

#endif
