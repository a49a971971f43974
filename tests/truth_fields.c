/* Media with fields and other bounds are the media that they stand for: same numbers, same pictures. */
#include "truth_cases.h"
#include "triangle_maker.h"

enum { SIDE = 48 };

static const double tolerance = 0.004;

static ty_grid* grid_of(ty_context* context, int32_t size, const float* values, bool placed) {
    ty_grid_def def = ty_default_grid_def();
    for (int a = 0; a < 3; ++a) {
        def.size[a] = size;
        def.index_to_local.m[5 * a] = 1.0 / size;
        def.index_to_local.m[4 * a + 3] = -0.5 + 0.5 / size;
    }
    def.values = values;
    def.placed = placed;
    ty_grid* grid = NULL;
    must(context, ty_grid_create(context, &def, &grid));
    return grid;
}

static ty_grid* even_grid(ty_context* context, double value) {
    float values[8];
    for (int i = 0; i < 8; ++i) values[i] = (float)value;
    return grid_of(context, 2, values, false);
}

static ty_grid* noise_grid(ty_context* context, int32_t size, uint32_t seed, bool placed) {
    ty_noise_def def = ty_default_noise_def();
    for (int a = 0; a < 3; ++a) def.size[a] = size;
    def.kind = TY_NOISE_FBM;
    def.seed = seed;
    def.octaves = 2;
    def.sharpness = 1.5f;
    ty_grid *noise = NULL, *grid;
    must(context, ty_grid_create_noise(context, &def, &noise));
    float* values = calloc((size_t)(size * size * size), sizeof *values);
    assert_non_null(values);
    for (int32_t i = 0; i < size * size * size; ++i)
        values[i] = ty_grid_voxel(noise, i % size, i / size % size, i / size / size);
    grid = grid_of(context, size, values, placed);
    free(values);
    ty_grid_release(noise);
    return grid;
}

/* A medium in sun and sky. */
static ty_image* picture(ty_context* context, const ty_medium_def* medium, int32_t spp, uint64_t seed) {
    ty_scene* scene = new_scene(context);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2), sky = light_of(TY_LIGHT_ENVIRONMENT, 0.2);
    set3(sun.direction, -1, -1.5, -1);
    add_light(scene, &sun);
    add_light(scene, &sky);
    add_medium(scene, medium);
    set_camera(scene, 1.5, 1, 3, 22);
    commit(scene);
    ty_image* image = render(scene, SIDE, spp, seed);
    ty_scene_destroy(scene);
    return image;
}

static void same(ty_context* context, const char* name, const ty_medium_def* a, const ty_medium_def* b, int32_t spp) {
    ty_image *image = picture(context, a, spp, 1), *other = picture(context, b, spp, 2);
    for (int c = 0; c < 3; c += 2) assert_same_channel(name, image, c, other, c, tolerance);
    ty_image_destroy(image);
    ty_image_destroy(other);
}

/* ---- albedo and g ---- */

static void a_constant_albedo_field_changes_nothing(void** state) {
    ty_medium_def number = medium_cube(0.5, 2.4, 0.6, 0.3), field = medium_cube(0.5, 1, 2, 0.3);
    field.albedo_grid[0] = field.albedo_grid[1] = field.albedo_grid[2] = even_grid(*state, 0.8);
    same(*state, "albedo 0.8 as a grid", &field, &number, 192);
    ty_grid_release(field.albedo_grid[0]);
}

static void a_constant_g_field_changes_nothing(void** state) {
    ty_medium_def number = medium_cube(0.5, 3, 0.3, 0.7), field = medium_cube(0.5, 3, 0.3, -0.9);
    field.g_grid = even_grid(*state, 0.7);
    same(*state, "g 0.7 as a grid", &field, &number, 192);
    ty_grid_release(field.g_grid);
}

/* Three grids at once are three gray media. */
static void coloured_albedo_fields_are_right(void** state) {
    ty_medium_def colour = medium_cube(0.5, 4, 0, 0.2);
    for (int c = 0; c < 3; ++c) colour.albedo_grid[c] = noise_grid(*state, 8, 11 + (uint32_t)c, false);
    colour.density_grid = noise_grid(*state, 16, 5, false);
    ty_image* image = picture(*state, &colour, 256, 1);
    for (int c = 0; c < 3; ++c) {
        ty_medium_def grey = colour;
        for (int k = 0; k < 3; ++k) grey.albedo_grid[k] = colour.albedo_grid[c];
        ty_image* other = picture(*state, &grey, 256, 2 + (uint64_t)c);
        assert_same_channel("coloured albedo, one channel", image, c, other, c, tolerance);
        ty_image_destroy(other);
    }
    ty_image_destroy(image);
    ty_grid_release(colour.density_grid);
    for (int c = 0; c < 3; ++c) ty_grid_release(colour.albedo_grid[c]);
}

/* ---- transfer functions ---- */

static void linear_transfer_functions_change_nothing(void** state) {
    leave_to_full_runs();
    static const ty_transfer_point line[3] = {{0, 0, {1, 1, 1}}, {0.4f, 0.4f, {1, 1, 1}}, {1, 1, {1, 1, 1}}};
    ty_medium_def plain = medium_cube(0.5, 6, 0.6, 0.3);
    plain.density_grid = noise_grid(*state, 12, 3, false);
    ty_medium_def mapped = plain;
    mapped.transfer = line;
    mapped.transfer_count = 3;
    same(*state, "linear transfer function", &mapped, &plain, 256);
    ty_grid_release(plain.density_grid);
}

/* Steep and not monotone; with an albedo that follows. */
static const ty_transfer_point curve[5] = {{0.1f, 0, {0.2f, 0.9f, 1}},
                                           {0.3f, 6, {0.9f, 0.6f, 1}},
                                           {0.5f, 1, {0.5f, 0.2f, 1}},
                                           {0.7f, 1, {1, 0.8f, 0.5f}},
                                           {0.9f, 8, {0.3f, 1, 0.5f}}};

static double curve_at(double value, int what) {
    double y[5];
    for (int i = 0; i < 5; ++i) y[i] = (double)(what == 0 ? curve[i].density : curve[i].albedo[what - 1]);
    for (int i = 1; i < 5; ++i) {
        const double a = (double)curve[i - 1].value, b = (double)curve[i].value;
        if (value <= b) return y[i - 1] + (y[i] - y[i - 1]) * fmax(0, value - a) / (b - a);
    }
    return y[4];
}

enum { COARSE = 4, FINER = 24, FINE = COARSE * FINER };

/* The curve of a grid's trilinear value at the middles of a finer grid's cells. */
static ty_grid* resampled(ty_context* context, const ty_grid* grid, int what) {
    float* values = calloc((size_t)FINE * FINE * FINE, sizeof *values);
    assert_non_null(values);
    for (int32_t i = 0; i < FINE * FINE * FINE; ++i) {
        const int32_t at[3] = {i % FINE, i / FINE % FINE, i / FINE / FINE};
        double index[3];
        for (int a = 0; a < 3; ++a) index[a] = (at[a] + 0.5) / FINER - 0.5;
        values[i] = (float)curve_at((double)ty_grid_sample(grid, index), what);
    }
    ty_grid* fine = grid_of(context, FINE, values, false);
    free(values);
    return fine;
}

/* The function of a coarse grid is a fine grid of the function's values. */
static void curved_transfer_functions_are_right(void** state) {
    ty_medium_def mapped = medium_cube(0.5, 0.7, 0.3, 0.3);
    mapped.density_grid = noise_grid(*state, COARSE, 9, false);
    mapped.transfer = curve;
    mapped.transfer_count = 5;
    mapped.transfer_albedo = true;
    ty_medium_def fine = medium_cube(0.5, 0.5, 0.5, 0.3);
    fine.density_grid = resampled(*state, mapped.density_grid, 0);
    for (int c = 0; c < 3; ++c) fine.albedo_grid[c] = resampled(*state, mapped.density_grid, 1 + c);
    same(*state, "transfer function of a grid", &mapped, &fine, 256);
    ty_grid_release(mapped.density_grid);
    ty_grid_release(fine.density_grid);
    for (int c = 0; c < 3; ++c) ty_grid_release(fine.albedo_grid[c]);
}

/* ---- shells ---- */

static ty_closed_mesh* shell_of(ty_context* context, made_mesh* mesh) {
    ty_closed_mesh* shell = NULL;
    must(context, made_shell(context, mesh, &shell));
    made_free(mesh);
    return shell;
}

static ty_closed_mesh* cube_shell(ty_context* context, double half) {
    const double low[3] = {-half, -half, -half}, high[3] = {half, half, half};
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    return shell_of(context, &mesh);
}

static void a_box_mesh_is_a_box(void** state) {
    const ty_medium_def box = medium_cube(0.5, 3, 0.3, 0.5);
    ty_medium_def shell = medium_of(3, 0.3, 0.5);
    shell.bounds = TY_BOUNDS_SHELL;
    shell.shell = cube_shell(*state, 0.5);
    same(*state, "shell of a box", &shell, &box, 192);
    ty_closed_mesh_release(shell.shell);
}

static void a_ball_mesh_is_a_ball(void** state) {
    static const double zero[3] = {0, 0, 0};
    const ty_medium_def ball = medium_sphere(0.6, 3, 0.3, 0.5);
    ty_medium_def shell = medium_of(3, 0.3, 0.5);
    made_mesh mesh = made_nothing();
    made_add_sphere(&mesh, zero, 0.6 * 1.0004, 32);
    shell.bounds = TY_BOUNDS_SHELL;
    shell.shell = shell_of(*state, &mesh);
    same(*state, "shell of a ball", &shell, &ball, 192);
    ty_closed_mesh_release(shell.shell);
}

/* A cube in two shells, one with a hole that the other fills, half as far across as the cube. */
static void hollow_meshes_are_empty_inside(void** state) {
    static const double low[3] = {-0.5, -0.5, -0.5}, high[3] = {0.5, 0.5, 0.5};
    static const double hole_low[3] = {-0.25, -0.25, -0.25}, hole_high[3] = {0.25, 0.25, 0.25};
    const ty_medium_def box = medium_cube(0.5, 3, 0.3, 0.5), core = medium_cube(0.25, 3, 0.3, 0.5);
    ty_medium_def rind = medium_of(3, 0.3, 0.5);
    made_mesh mesh = made_nothing();
    made_add_box(&mesh, low, high);
    const int64_t first = mesh.triangles;
    made_add_box(&mesh, hole_low, hole_high);
    made_turn(&mesh, first);
    rind.bounds = TY_BOUNDS_SHELL;
    rind.shell = shell_of(*state, &mesh);
    ty_scene* scenes[2] = {new_scene(*state), new_scene(*state)};
    add_medium(scenes[0], &box);
    add_medium(scenes[1], &rind);
    add_medium(scenes[1], &core);
    ty_image* images[2];
    for (int i = 0; i < 2; ++i) {
        ty_light_def lamp = light_of(TY_LIGHT_POINT, 2); /* its equi-angular sampling crosses gaps */
        set3(lamp.position, 0.3, 1.2, 0.4);
        add_light(scenes[i], &lamp);
        set_camera(scenes[i], 1.5, 1, 3, 22);
        commit(scenes[i]);
        images[i] = render(scenes[i], SIDE, 256, 1 + (uint64_t)i);
        ty_scene_destroy(scenes[i]);
    }
    assert_same_channel("rind and core, lamp", images[1], 0, images[0], 0, 0.012);
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
    ty_closed_mesh_release(rind.shell);
}

static void meshes_cut_grids(void** state) {
    ty_medium_def box = medium_cube(0.35, 6, 0.6, 0.3);
    box.density_grid = noise_grid(*state, 16, 3, true);
    ty_medium_def shell = box;
    shell.bounds = TY_BOUNDS_SHELL;
    shell.shell = cube_shell(*state, 0.35);
    same(*state, "grid cut by a shell", &shell, &box, 192);
    ty_closed_mesh_release(shell.shell);
    ty_grid_release(box.density_grid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_albedo_field_changes_nothing),
        cmocka_unit_test(a_constant_g_field_changes_nothing),
        cmocka_unit_test(coloured_albedo_fields_are_right),
        cmocka_unit_test(linear_transfer_functions_change_nothing),
        cmocka_unit_test(curved_transfer_functions_are_right),
        cmocka_unit_test(a_box_mesh_is_a_box),
        cmocka_unit_test(a_ball_mesh_is_a_ball),
        cmocka_unit_test(hollow_meshes_are_empty_inside),
        cmocka_unit_test(meshes_cut_grids),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
