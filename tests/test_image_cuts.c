/* Interpolation between cells that surfaces keep apart. */
#include "direct_maker.h"
#include "image/march/deconvolve.h"
#include "image/march/upsample.k.h"

#include <string.h>

enum { SIDE = 11, CELLS = SIDE * SIDE * SIDE };

/* A cube of 2 m about the origin. */
static ty_scene* cube(ty_context* context) {
    ty_scene* scene = NULL;
    ty_medium_def medium = ty_default_medium_def();
    check_result(context, ty_scene_create(context, TY_AXIS_Z, &scene));
    medium.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        medium.sigma_a[a] = 1;
        medium.box_min[a] = -1;
        medium.box_max[a] = 1;
    }
    check_result(context, ty_scene_add_medium(scene, &medium));
    return scene;
}

static void add_quad(ty_scene* scene, const double origin[3], const double u[3], const double v[3]) {
    ty_shape_def quad = ty_default_shape_def();
    quad.kind = TY_SHAPE_QUAD;
    memcpy(quad.origin, origin, sizeof quad.origin);
    memcpy(quad.u, u, sizeof quad.u);
    memcpy(quad.v, v, sizeof quad.v);
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &quad));
}

typedef struct cut_case {
    direct_case made;
    ty_boundary_faces* walls;
    ty_cuts* cuts;
} cut_case;

static cut_case begin(ty_scene* scene) {
    cut_case c = {.made = direct_begin(scene, SIDE, 1, 1)};
    ty_context* context = ty_scene_context(scene);
    check_result(context, ty_boundary_faces_find(scene, c.made.medium, &c.walls));
    assert_non_null(c.walls);
    check_result(context, ty_cuts_find(context, c.walls, &c.made.medium->box, &c.cuts));
    return c;
}

static void end(cut_case* c) {
    ty_cuts_destroy(c->cuts);
    ty_boundary_faces_destroy(c->walls);
    direct_end(&c->made);
}

/* A field of one number a cell, at a point in cells; its weights are 1 in all. */
static double look(const cut_case* c, const float* values, ty_vec cells) {
    const ty_cuts_view view = ty_cuts_get_view(c->cuts);
    const ty_cell_point at = ty_cell_locate(c->made.medium->box.size, cells);
    float weight[8];
    double sum = 0, all = 0;
    ty_upsample_weights(&at, weight);
    if (view.of_cell != NULL) ty_cuts_weigh(&view, at.base, cells, weight);
    for (size_t i = 0; i < 8; ++i) {
        const size_t x = (i & 1) * at.step[0], y = (i >> 1 & 1) * at.step[1], z = (i >> 2) * at.step[2];
        sum += (double)(weight[i] * values[at.base + x + y + z]);
        all += (double)weight[i];
    }
    assert_close(all, 1, 1e-5);
    return sum;
}

static double in_metres(double cells) {
    return -1 + 2.0 / SIDE * cells;
}

/* However it is slanted, and however near the point is to it: a wall's other side is not seen from either, among
 * cells' middles. */
static void walls_keep_sides_apart(void** state) {
    uint64_t seed = 5;
    for (int n = 0; n < 12; ++n) {
        ty_scene* scene = cube(*state);
        const double a = uniform_in(&seed, -1.5, 1.5), b = uniform_in(&seed, -1.5, 1.5),
                     c = uniform_in(&seed, -0.4, 0.4);
        add_quad(scene, (const double[3]){-2, -2, c - 2 * a - 2 * b}, (const double[3]){4, 0, 4 * a},
                 (const double[3]){0, 4, 4 * b});
        cut_case made = begin(scene);
        float above[CELLS];
        for (int i = 0; i < CELLS; ++i) {
            const double x = in_metres(i % SIDE + 0.501), y = in_metres(i / SIDE % SIDE + 0.5007),
                         z = in_metres(i / (SIDE * SIDE) + 0.5004);
            above[i] = z > c + a * x + b * y ? 1.0f : 0.0f;
        }
        for (int i = 0; i < 2000; ++i) {
            const double x = uniform_in(&seed, 0.5, SIDE - 0.5), y = uniform_in(&seed, 0.5, SIDE - 0.5),
                         z = uniform_in(&seed, 0.5, SIDE - 0.5);
            const double over = in_metres(z) - c - a * in_metres(x) - b * in_metres(y);
            if (fabs(over) < 0.01) continue;
            const double seen = look(&made, above, ty_vec_make((float)x, (float)y, (float)z));
            assert_close(seen, over > 0 ? 1 : 0, 1e-4);
        }
        end(&made);
    }
}

/* Two walls with a common edge, between which one corner of the cube is cut off: three quarters are one part. */
static void corners_are_two_parts(void** state) {
    ty_scene* scene = cube(*state);
    add_quad(scene, (const double[3]){0.05, 0.03, -2}, (const double[3]){2, 0, 0}, (const double[3]){0, 0, 4});
    add_quad(scene, (const double[3]){0.05, 0.03, -2}, (const double[3]){0, 2, 0}, (const double[3]){0, 0, 4});
    cut_case made = begin(scene);
    float within[CELLS];
    uint64_t seed = 11;
    for (int i = 0; i < CELLS; ++i)
        within[i] = in_metres(i % SIDE + 0.501) > 0.05 && in_metres(i / SIDE % SIDE + 0.5007) > 0.03 ? 1.0f : 0.0f;
    for (int i = 0; i < 4000; ++i) {
        const double x = uniform_in(&seed, 0, SIDE), y = uniform_in(&seed, 0, SIDE), z = uniform_in(&seed, 0, SIDE);
        const double right = in_metres(x) - 0.05, behind = in_metres(y) - 0.03;
        if (fabs(right) < 0.01 || fabs(behind) < 0.01) continue;
        const double seen = look(&made, within, ty_vec_make((float)x, (float)y, (float)z));
        assert_close(seen, right > 0 && behind > 0 ? 1 : 0, 1e-4);
    }
    end(&made);
}

/* Where a wall ends, open faces lead around it: there, and far from it, weights are as they were. */
static void ends_of_walls_are_open(void** state) {
    ty_scene* scene = cube(*state);
    add_quad(scene, (const double[3]){0.05, -2, -2}, (const double[3]){0, 4, 0}, (const double[3]){0, 0, 2.03});
    cut_case made = begin(scene);
    float right[CELLS];
    for (int i = 0; i < CELLS; ++i) right[i] = i % SIDE >= 6 ? 1.0f : 0.0f;
    assert_close(look(&made, right, ty_vec_make(5.6f, 5, 2.5f)), 0, 1e-4);
    assert_close(look(&made, right, ty_vec_make(5.9f, 5, 2.5f)), 1, 1e-4);
    assert_close(look(&made, right, ty_vec_make(5.75f, 5, 5.6f)), 0.25, 1e-4);
    assert_close(look(&made, right, ty_vec_make(5.75f, 5, 8)), 0.25, 1e-4);
    assert_close(look(&made, right, ty_vec_make(5.9f, 5, 8)), 0.4, 1e-4);
    end(&made);
}

/* Two even halves on both sides of a wall stay even. */
static void sharp_cells_know_of_walls(void** state) {
    ty_scene* scene = cube(*state);
    add_quad(scene, (const double[3]){0.05, -2, -2}, (const double[3]){0, 4, 0}, (const double[3]){0, 0, 4});
    cut_case made = begin(scene);
    float cells[CELLS];
    const int32_t* size = made.made.medium->box.size;
    for (int i = 0; i < CELLS; ++i) cells[i] = i % SIDE < 6 ? 3.0f : 1.0f;
    check_result(*state, ty_deconvolve_means(*state, size, 1, 1, 1, made.cuts, NULL, cells));
    for (int i = 0; i < CELLS; ++i) assert_close((double)cells[i], i % SIDE < 6 ? 3 : 1, 1e-5);
    check_result(*state, ty_deconvolve_means(*state, size, 1, 1, 1, NULL, NULL, cells));
    assert_true(cells[5] > 3.2f && cells[6] < 0.8f);
    end(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(walls_keep_sides_apart, start_context, stop_context),
        cmocka_unit_test_setup_teardown(corners_are_two_parts, start_context, stop_context),
        cmocka_unit_test_setup_teardown(ends_of_walls_are_open, start_context, stop_context),
        cmocka_unit_test_setup_teardown(sharp_cells_know_of_walls, start_context, stop_context)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
