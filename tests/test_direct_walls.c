/* Surfaces as walls between cells: which faces they close, what they are made of, and the light on them. */
#include "direct_maker.h"
#include "direct/surfaces/boundary_faces.h"

#include <string.h>

/* A cube of 2 m about the origin. */
static ty_scene* fog_cube(ty_context* context, double sigma) {
    ty_scene* scene = NULL;
    ty_medium_def medium = ty_default_medium_def();
    check_result(context, ty_scene_create(context, TY_AXIS_Z, &scene));
    for (int c = 0; c < 3; ++c) medium.sigma_a[c] = (float)(sigma * (c + 1));
    medium.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        medium.box_min[a] = -1;
        medium.box_max[a] = 1;
    }
    check_result(context, ty_scene_add_medium(scene, &medium));
    return scene;
}

static void add_quad(ty_scene* scene, const double origin[3], const double u[3], const double v[3], float albedo) {
    ty_shape_def quad = ty_default_shape_def();
    quad.kind = TY_SHAPE_QUAD;
    memcpy(quad.origin, origin, sizeof quad.origin);
    memcpy(quad.u, u, sizeof quad.u);
    memcpy(quad.v, v, sizeof quad.v);
    for (int c = 0; c < 3; ++c) quad.albedo[c] = albedo;
    check_result(ty_scene_context(scene), ty_scene_add_shape(scene, &quad));
}

static ty_boundary_faces* find(const direct_case* made) {
    ty_boundary_faces* walls = NULL;
    check_result(ty_scene_context(made->scene), ty_boundary_faces_find(made->scene, made->medium, &walls));
    return walls;
}

/* Which cells open faces lead to from the first one. */
static void flood(const ty_boundary_faces* walls, uint8_t* reached) {
    const int32_t* size = walls->size;
    const int32_t steps[3] = {1, size[0], size[0] * size[1]};
    bool more = true;
    reached[0] = 1;
    while (more) {
        more = false;
        for (int32_t i = 0; i < size[0] * size[1] * size[2]; ++i) {
            const int32_t at[3] = {i % size[0], i / size[0] % size[1], i / steps[2]};
            for (int face = 0; face < 6 && reached[i] != 0; ++face) {
                const int a = face / 2, up = face & 1, next = up != 0 ? i + steps[a] : i - steps[a];
                if ((walls->closed[i] >> face & 1) != 0 || at[a] == (up != 0 ? size[a] - 1 : 0)) continue;
                more = more || reached[next] == 0;
                reached[next] = 1;
            }
        }
    }
}

static void nothing_but_surfaces_closes_faces(void** state) {
    ty_scene* scene = fog_cube(*state, 1);
    direct_case made = direct_begin(scene, 6, 1, 1);
    assert_null(find(&made));
    direct_end(&made);
}

/* However thin and slanted, a surface leaves no way from one side of it to the other. */
static void walls_have_no_holes(void** state) {
    uint64_t seed = 3;
    for (int n = 0; n < 12; ++n) {
        ty_scene* scene = fog_cube(*state, 1);
        const double a = uniform_in(&seed, -1.5, 1.5), b = uniform_in(&seed, -1.5, 1.5),
                     c = uniform_in(&seed, -0.4, 0.4);
        add_quad(scene, (const double[3]){-2, -2, c - 2 * a - 2 * b}, (const double[3]){4, 0, 4 * a},
                 (const double[3]){0, 4, 4 * b}, 0.5f);
        direct_case made = direct_begin(scene, 11, 1, 1);
        ty_boundary_faces* walls = find(&made);
        uint8_t reached[11 * 11 * 11] = {0};
        flood(walls, reached);
        for (int32_t i = 0; i < 11 * 11 * 11; ++i) {
            const double x = -1 + 2.0 / 11 * (i % 11 + 0.501), y = -1 + 2.0 / 11 * (i / 11 % 11 + 0.5007),
                         z = -1 + 2.0 / 11 * (i / 121 + 0.5004), first = -1 + 1.0 / 11;
            const bool above = z > c + a * x + b * y;
            if (above != (first > c + a * first + b * first)) assert_int_equal(reached[i], 0);
        }
        ty_boundary_faces_destroy(walls);
        direct_end(&made);
    }
}

static void sides_are_of_their_surfaces(void** state) {
    ty_scene* scene = fog_cube(*state, 0);
    add_quad(scene, (const double[3]){-2, -2, 0.1}, (const double[3]){4, 0, 0}, (const double[3]){0, 4, 0}, 0.25f);
    direct_case made = direct_begin(scene, 5, 1, 1);
    ty_boundary_faces* walls = find(&made);
    assert_int_equal(walls->count, 50);
    assert_int_equal(walls->first[25], 50);
    for (int32_t i = 0; i < walls->count; ++i) {
        const ty_boundary_side* side = &walls->sides[i];
        const bool upper = walls->face[i] == 5; /* of the cells below, whose middles are at z = 0 */
        assert_true(upper || walls->face[i] == 4);
        assert_close((double)side->normal.z, upper ? -1 : 1, 1e-6);
        assert_close((double)side->position.z, 0.1, 1e-4);
        assert_close((double)side->depth, upper ? 0.25 : 0.75, 2e-3);
        assert_close((double)side->albedo[1], 0.25, 1e-6);
        assert_close((double)side->staircase_factor, 1, 1e-6);
    }
    ty_boundary_faces_destroy(walls);
    direct_end(&made);
}

/* Stairs that stand for a surface look as it does: what they send and what comes back from others of theirs. */
static void stairs_look_like_their_surface(void** state) {
    (void)state;
    for (float stairs = 1; stairs < 1.8f; stairs += 0.1f)
        for (float albedo = 0; albedo <= 1; albedo += 0.25f) {
            const ty_boundary_side wall = {.staircase_factor = stairs};
            float of_stairs, share;
            ty_staircase_albedo(&wall, albedo, &of_stairs, &share);
            const float met = 1 - 1 / stairs;
            /* In light 1 the surface sends its albedo; stairs get 1 or what others send. */
            assert_close((double)(of_stairs * (1 - met + met * albedo)), (double)albedo, 1e-5);
            /* Its emission is seen as 1. */
            assert_close((double)(share + of_stairs * met), 1, 1e-5);
        }
}

/* A beam and a lamp on a floor, through a medium. */
static void light_on_walls(void** state) {
    ty_scene* scene = fog_cube(*state, 0.5);
    add_quad(scene, (const double[3]){-2, -2, -1}, (const double[3]){4, 0, 0}, (const double[3]){0, 4, 0}, 0.5f);
    /* Half of it is in a roof's shadow. */
    add_quad(scene, (const double[3]){0.4, -4, 0.9}, (const double[3]){4, 0, 0}, (const double[3]){0, 8, 0}, 0.5f);
    ty_light_def sun = ty_default_light_def(), lamp = ty_default_light_def();
    sun.kind = TY_LIGHT_DIRECTIONAL;
    lamp.kind = TY_LIGHT_POINT;
    for (int c = 0; c < 3; ++c) sun.color[c] = lamp.color[c] = (float)(c + 1);
    sun.direction[0] = 0;
    sun.direction[1] = 0.6;
    sun.direction[2] = -0.8;
    lamp.position[0] = lamp.position[1] = 0;
    lamp.position[2] = 0.2;
    check_result(*state, ty_scene_add_light(scene, &sun));
    check_result(*state, ty_scene_add_light(scene, &lamp));
    direct_case made = direct_begin(scene, 8, 1, 1);
    ty_boundary_faces* walls = find(&made);
    float* sums = calloc((size_t)walls->count * 6, sizeof *sums);
    float *irradiance[3], *forward[3], *half[3];
    for (int c = 0; c < 3; ++c) {
        irradiance[c] = sums + walls->count * c;
        forward[c] = sums + walls->count * (3 + c);
        half[c] = malloc(made.medium->cells * sizeof(float));
        for (size_t i = 0; i < made.medium->cells; ++i) half[c][i] = 0.5f * made.medium->extinction[c][i];
    }
    ty_boundary_irradiance_add(scene, walls, made.medium, half, made.sources.items, made.sources.count, irradiance,
                               forward);
    int seen = 0;
    for (int32_t i = 0; i < walls->count; ++i) {
        const ty_boundary_side* side = &walls->sides[i];
        if (!((double)side->position.z < -0.9 && side->normal.z > 0)) continue;
        const double x = (double)side->position.x, y = (double)side->position.y, square = x * x + y * y + 1.44;
        const double into = y - 1.5 < -1 ? (y + 1) / 0.6 : 2 / 0.8;
        for (int c = 0; c < 3; ++c) {
            const double sigma = 0.5 * (c + 1), to_lamp = sqrt(square);
            double wanted = (c + 1) * exp(-0.5 * sigma * to_lamp) * 1.2 / (square * to_lamp);
            double ahead = wanted - (c + 1) * exp(-sigma * to_lamp) * 1.2 / (square * to_lamp);
            if (x < 0.4) {
                wanted += (c + 1) * exp(-0.5 * sigma * into) * 0.8;
                ahead += (c + 1) * (exp(-0.5 * sigma * into) - exp(-sigma * into)) * 0.8;
            }
            assert_close((double)irradiance[c][i], wanted, 2e-3 * wanted);
            assert_close((double)forward[c][i], ahead, 2e-3 * wanted);
        }
        ++seen;
    }
    assert_int_equal(seen, 64);
    for (int c = 0; c < 3; ++c) free(half[c]);
    free(sums);
    ty_boundary_faces_destroy(walls);
    direct_end(&made);
}

/* Cells in a solid are dark; those in a room with a lamp in it are not. */
static void solids_are_dark(void** state) {
    for (int lit = 0; lit < 2; ++lit) {
        ty_scene* scene = fog_cube(*state, 1);
        ty_shape_def box = ty_default_shape_def();
        ty_light_def lamp = ty_default_light_def();
        box.kind = TY_SHAPE_BOX;
        for (int a = 0; a < 3; ++a) {
            box.origin[a] = -0.55;
            box.u[a] = 0.45;
            lamp.position[a] = lit != 0 ? 0.1 : 0.7;
        }
        check_result(*state, ty_scene_add_shape(scene, &box));
        lamp.kind = TY_LIGHT_POINT;
        check_result(*state, ty_scene_add_light(scene, &lamp));
        direct_case made = direct_begin(scene, 9, 1, 1);
        ty_boundary_faces* walls = find(&made);
        uint8_t dark[9 * 9 * 9];
        check_result(*state,
                     ty_unlit_cells_find(scene, walls, made.medium, made.sources.items, made.sources.count, dark));
        for (int32_t i = 0; i < 9 * 9 * 9; ++i) {
            const int32_t at[3] = {i % 9, i / 9 % 9, i / 81};
            bool inside = true; /* cells whose middles are */
            for (int a = 0; a < 3; ++a) inside = inside && at[a] >= 2 && at[a] <= 6;
            assert_int_equal(dark[i], inside && lit == 0);
        }
        ty_boundary_faces_destroy(walls);
        direct_end(&made);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_but_surfaces_closes_faces, start_context, stop_context),
        cmocka_unit_test_setup_teardown(walls_have_no_holes, start_context, stop_context),
        cmocka_unit_test_setup_teardown(sides_are_of_their_surfaces, start_context, stop_context),
        cmocka_unit_test(stairs_look_like_their_surface),
        cmocka_unit_test_setup_teardown(light_on_walls, start_context, stop_context),
        cmocka_unit_test_setup_teardown(solids_are_dark, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
