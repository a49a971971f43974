/* Direct light under odd circumstances: memory that runs out, callers that cancel, planes that colours share, beams
 * that pass together, boxes of few cells. */
#include "direct_maker.h"
#include "effort.h"
#include "ledger.h"

static const double lower[3] = {-1, 0.5, -2}, upper[3] = {1, 2.5, 1};

/* A cloud, a board, and lights of every kind. */
static ty_result fill_scene(ty_scene* scene, ty_grid* grid, bool gray) {
    ty_medium_def cloud = box_medium(lower, upper, 2, 0.5f);
    if (!gray) set3f(cloud.sigma_s, 1, 2, 4);
    cloud.density_grid = grid;
    ty_light_def sun = ty_default_light_def(), lamp = sun, area = sun, sky = sun;
    set3(sun.direction, 1, -2, 0.5);
    set3f(sun.color, 3, 2, 1);
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0.2, 1.4, -0.3);
    area.kind = TY_LIGHT_AREA;
    set3(area.position, -0.5, 3, 0);
    set3(area.u, 1, 0, 0);
    set3(area.v, 0, 0, 1);
    sky.kind = TY_LIGHT_ENVIRONMENT;
    ty_shape_def board = quad_shape((const double[3][3]){{-0.5, 2.7, -1}, {0, 0, 1}, {1, 0, 0}});
    const ty_light_def* const lights[] = {&sun, &lamp, &area, &sky};
    ty_result result = ty_scene_add_medium(scene, &cloud);
    for (int i = 0; i < 4 && result == TY_OK; ++i) result = ty_scene_add_light(scene, lights[i]);
    if (result == TY_OK) result = ty_scene_add_shape(scene, &board);
    return result;
}

static ty_scene* busy_scene(ty_context* context, bool gray, int32_t voxels) {
    ty_scene* scene = make_scene(context);
    ty_grid* grid = direct_noise(context, voxels, voxels, voxels * 3 / 2, 7);
    check_result(context, fill_scene(scene, grid, gray));
    ty_grid_release(grid);
    return scene;
}

/* ---- memory ---- */

static ty_result light_medium(const ty_scene* scene, const ty_grid_medium* medium) {
    const ty_discretize_def def = {.environment = 4, .surface = 2};
    ty_discrete_light_set sources = {.items = NULL};
    ty_light_field* field = NULL;
    ty_grid_medium* coarse = NULL;
    float* planes[3] = {NULL, NULL, NULL};
    ty_collimated_power power;
    for (int c = 0; c < 3; ++c) planes[c] = calloc(medium->cells, sizeof(float));
    ty_result result = ty_discretize_lights(scene, &def, &sources);
    if (result == TY_OK) result = ty_light_field_create(medium, true, &field);
    if (result == TY_OK) result = ty_uncollided_add(scene, medium, NULL, sources.items, sources.count, field);
    if (result == TY_OK) result = ty_uncollided_transmittance(scene, medium, NULL, sources.items, planes, &power);
    if (result == TY_OK) result = ty_grid_medium_resize(medium, (const int32_t[3]){3, 4, 5}, &coarse);
    for (int c = 0; c < 3; ++c) free(planes[c]);
    ty_grid_medium_destroy(coarse);
    ty_light_field_destroy(field);
    ty_discrete_light_set_destroy(ty_scene_context(scene), &sources);
    return result;
}

static ty_result all_of_it(ty_context* context) {
    const float densities[8] = {1, 0, 2, 1, 0.5f, 1, 0, 3};
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = 2;
    def.values = densities;
    ty_scene* scene = NULL;
    ty_grid* grid = NULL;
    ty_grid_medium* medium = NULL;
    ty_grid_box box;
    ty_result result = ty_scene_create(context, TY_AXIS_Y, &scene);
    if (result == TY_OK) result = ty_grid_create(context, &def, &grid);
    if (result == TY_OK) result = fill_scene(scene, grid, false);
    if (result == TY_OK) result = ty_scene_commit(scene);
    if (result == TY_OK) result = ty_grid_box_fit(scene, 6, &box);
    if (result == TY_OK) result = ty_grid_medium_create(scene, &box, &medium);
    if (result == TY_OK) result = light_medium(scene, medium);
    ty_grid_medium_destroy(medium);
    ty_grid_release(grid);
    ty_scene_destroy(scene);
    return result;
}

static void every_failed_allocation_is_reported(void** state) {
    (void)state;
    check_failed_allocations(all_of_it);
}

/* ---- progress ---- */

typedef struct listener {
    double last;
    int calls, cancel_at; /* -1: never */
} listener;

static bool listen(void* user, const ty_progress* progress) {
    listener* l = user;
    assert_true(progress->fraction >= l->last && progress->fraction <= 1);
    assert_string_equal(progress->stage, "direct light");
    l->last = progress->fraction;
    return ++l->calls != l->cancel_at;
}

static void progress_is_told_and_can_cancel(void** state) {
    const int32_t voxels = fewer_under_sanitizers(60, 2); /* much work, for several reports */
    direct_case made = direct_begin(busy_scene(*state, false, voxels), voxels * 3 / 2, 64, 20);
    ty_light_field* field = NULL;
    check_result(*state, ty_light_field_create(made.medium, true, &field));
    listener listening = {.cancel_at = -1}, cancelling = {.cancel_at = 1};
    check_result(*state, ty_uncollided_add_with_progress(made.scene, made.medium, NULL, made.sources.items,
                                                         made.sources.count, field, listen, &listening));
    assert_true(listening.calls > 1 && listening.last > 0.3);
    assert_int_equal(ty_uncollided_add_with_progress(made.scene, made.medium, NULL, made.sources.items,
                                                     made.sources.count, field, listen, &cancelling),
                     TY_CANCELLED);
    assert_int_equal(cancelling.calls, 1);
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* ---- planes and beams ---- */

static void colors_share_a_plane(void** state) {
    static const float color[3] = {3, 2, 1};
    ty_light_field *fields[2] = {NULL, NULL}, *refused = NULL;
    direct_case made = direct_begin(busy_scene(*state, true, 10), 15, 1, 1);
    assert_int_equal(made.sources.items[0].kind, TY_DISCRETE_DIRECTIONAL);
    check_result(*state, ty_light_field_create(made.medium, true, &fields[0]));
    check_result(*state, ty_light_field_create_shared(made.medium, true, color, &fields[1]));
    assert_null(fields[1]->fluence[1]);
    for (int i = 0; i < 2; ++i)
        check_result(*state, ty_uncollided_add(made.scene, made.medium, NULL, made.sources.items, 1, fields[i]));
    for (size_t i = 0; i < made.medium->cells; ++i)
        for (int c = 0; c < 3; ++c) {
            const float expected = fields[0]->fluence[c][i];
            assert_close(fields[1]->fluence[0][i] * color[c], expected, 1e-6 * (double)expected);
            for (int a = 0; a < 3; ++a)
                assert_close(fields[1]->flux[0][a][i] * color[c], fields[0]->flux[c][a][i], 1e-6 * (double)expected);
        }
    direct_case chromatic = direct_begin(busy_scene(*state, false, 10), 15, 1, 1);
    assert_int_equal(ty_light_field_create_shared(chromatic.medium, true, color, &refused), TY_ERROR_ARGUMENT);
    assert_error(*state, "a coloured medium");
    for (int i = 0; i < 2; ++i) ty_light_field_destroy(fields[i]);
    direct_end(&chromatic);
    direct_end(&made);
}

/* Sources one by one bring what they bring together. */
static void beams_that_pass_together_are_apart(void** state) {
    direct_case made = direct_begin(busy_scene(*state, false, 14), 21, 150, 3);
    ty_light_field *together = direct_light(&made, true), *apart = NULL;
    check_result(*state, ty_light_field_create(made.medium, true, &apart));
    for (int32_t i = 0; i < made.sources.count; ++i)
        check_result(*state, ty_uncollided_add(made.scene, made.medium, NULL, &made.sources.items[i], 1, apart));
    for (size_t i = 0; i < made.medium->cells; ++i)
        for (int c = 0; c < 3; ++c) {
            const double expected = (double)apart->fluence[c][i];
            assert_true(expected > 0);
            assert_close(together->fluence[c][i], expected, 1e-5 * expected);
            for (int a = 0; a < 3; ++a) assert_close(together->flux[c][a][i], apart->flux[c][a][i], 1e-5 * expected);
        }
    ty_light_field_destroy(together);
    ty_light_field_destroy(apart);
    direct_end(&made);
}

/* ---- boxes ---- */

/* Rows, columns, layers and single cells are met; what they hold is no more than what comes without a medium. */
static void boxes_of_few_cells_are_met(void** state) {
    static const int32_t sizes[][3] = {{1, 1, 1}, {1, 7, 3}, {33, 1, 2}, {2, 3, 1}, {1, 1, 40}, {5, 9, 4}};
    ty_scene* scene = busy_scene(*state, false, 8);
    const ty_discretize_def def = {.environment = 20, .surface = 3};
    ty_discrete_light_set sources;
    check_result(*state, ty_scene_commit(scene));
    check_result(*state, ty_discretize_lights(scene, &def, &sources));
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        ty_grid_box box;
        ty_grid_medium* medium = NULL;
        ty_light_field *field = NULL, *clear = NULL;
        memcpy(box.lower, lower, sizeof lower);
        memcpy(box.upper, upper, sizeof upper);
        memcpy(box.size, sizes[i], sizeof box.size);
        check_result(*state, ty_grid_medium_create(scene, &box, &medium));
        check_result(*state, ty_light_field_create(medium, true, &field));
        check_result(*state, ty_light_field_create(medium, false, &clear));
        check_result(*state, ty_uncollided_add(scene, medium, NULL, sources.items, sources.count, field));
        for (int c = 0; c < 3; ++c) memset(medium->extinction[c], 0, medium->cells * sizeof(float));
        check_result(*state, ty_uncollided_add(scene, medium, NULL, sources.items, sources.count, clear));
        for (size_t cell = 0; cell < medium->cells; ++cell)
            for (int c = 0; c < 3; ++c)
                assert_true(field->fluence[c][cell] > 0 && field->fluence[c][cell] < clear->fluence[c][cell]);
        ty_light_field_destroy(field);
        ty_light_field_destroy(clear);
        ty_grid_medium_destroy(medium);
    }
    ty_discrete_light_set_destroy(*state, &sources);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_failed_allocation_is_reported),
        cmocka_unit_test(progress_is_told_and_can_cancel),
        cmocka_unit_test(colors_share_a_plane),
        cmocka_unit_test(beams_that_pass_together_are_apart),
        cmocka_unit_test(boxes_of_few_cells_are_met),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
