/* The same medium in other words is the same picture: as a box or as grids of any fineness, in other units, in two
 * parts, turned. */
#include "truth.h"

#include <tyndall/io.h>

enum { SIDE = 64 };

static const double tolerance = 0.003;

static ty_image* picture(ty_scene* scene, double x, double y, double z, int32_t spp, uint64_t seed) {
    set_camera(scene, x, y, z, 22);
    commit(scene);
    ty_image* image = render(scene, SIDE, spp, seed);
    ty_scene_destroy(scene);
    return image;
}

static void add_sun_and_sky(ty_scene* scene, const double direction[3]) {
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 2), sky = light_of(TY_LIGHT_ENVIRONMENT, 0.2);
    memcpy(sun.direction, direction, sizeof sun.direction);
    add_light(scene, &sun);
    add_light(scene, &sky);
}

/* A cube of sigma_s 3/m, sigma_a 0.3/m, g 0.5, in sun and sky. The grid, if any, is handed over. */
static ty_image* cube_picture(ty_context* context, ty_grid* grid, double share, int parts, uint64_t seed) {
    static const double slanting[3] = {-1, -1.5, -1};
    ty_scene* scene = new_scene(context);
    for (int i = 0; i < parts; ++i) {
        ty_medium_def medium = medium_cube(0.5, 3 * share, 0.3 * share, 0.5);
        medium.density_grid = grid;
        add_medium(scene, &medium);
    }
    ty_grid_release(grid);
    add_sun_and_sky(scene, slanting);
    return picture(scene, 1.5, 1, 3, 128, seed);
}

static ty_grid* constant_grid(ty_context* context, int32_t n, ty_grid_type type, double value) {
    ty_grid_def def = ty_default_grid_def();
    const size_t count = (size_t)n * (size_t)n * (size_t)n;
    float* values = calloc(count, sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; ++i) values[i] = (float)value;
    for (size_t i = 0; i < count && type == TY_GRID_F16; ++i) ((uint16_t*)values)[i] = 0x3c00;
    for (int a = 0; a < 3; ++a) def.size[a] = n;
    def.type = type;
    def.values = values;
    /* Larger than the cube by far, and turned, where it is placed by itself. */
    static const double translate[3] = {-1.3, -1.1, -1.2}, rotate[3] = {4, 5, -6}, size[3] = {0.1, 0.11, 0.12};
    def.index_to_local = ty_affine_compose(translate, rotate, size);
    ty_grid* grid = NULL;
    must(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

static ty_grid* constant_vdb(ty_context* context) {
    ty_grid *grid = constant_grid(context, 24, TY_GRID_F32, 1), *placed = NULL;
    must(context, ty_vdb_write(context, grid, "density", "zip", "constant.vdb"));
    must(context, ty_vdb_read(context, "constant.vdb", "density", &placed));
    ty_grid_release(grid);
    assert_true(ty_grid_get_info(placed).placed);
    return placed;
}

static void assert_same_and_destroy(const char* name, ty_image* a, ty_image* b) {
    assert_same_channel(name, a, 0, b, 0, tolerance);
    ty_image_destroy(a);
    ty_image_destroy(b);
}

static void a_box_and_its_grid_are_alike(void** state) {
    ty_context* context = *state;
    ty_grid* none = NULL;
    const struct {
        const char* name;
        ty_grid* grid;
    } cases[] = {{"grid of 8^3", constant_grid(context, 8, TY_GRID_F32, 1)},
                 {"grid of 64^3 halves", constant_grid(context, 64, TY_GRID_F16, 1)},
                 {"VDB cut by bounds", constant_vdb(context)}};
    for (int i = 0; i < 3; ++i)
        assert_same_and_destroy(cases[i].name, cube_picture(context, cases[i].grid, 1, 1, 10 + (uint64_t)i),
                                cube_picture(context, none, 1, 1, 1));
}

static void halves_add_up(void** state) {
    ty_context* context = *state;
    ty_image* whole = cube_picture(context, NULL, 1, 1, 1);
    ty_image* halves = cube_picture(context, NULL, 0.5, 2, 20);
    assert_same_channel("two halves", halves, 0, whole, 0, tolerance);
    ty_image_destroy(halves);
    halves = cube_picture(context, constant_grid(context, 8, TY_GRID_F32, 0.5), 1, 2, 21);
    assert_same_and_destroy("two halves as grids", halves, whole);
}

static void box_and_grid_add_up(void** state) {
    static const double slanting[3] = {-1, -1.5, -1};
    ty_context* context = *state;
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = medium_cube(0.5, 1.5, 0.15, 0.5);
    add_medium(scene, &medium);
    medium.density_grid = constant_grid(context, 8, TY_GRID_F32, 1);
    add_medium(scene, &medium);
    ty_grid_release(medium.density_grid);
    add_sun_and_sky(scene, slanting);
    assert_same_and_destroy("half box, half grid", picture(scene, 1.5, 1, 3, 128, 30),
                            cube_picture(context, NULL, 1, 1, 1));
}

/* A cloud in a box of other sides, in sun and sky; all of it, or only what looks at it, turned. */
static ty_image* cloud_picture(ty_context* context, bool turned, uint64_t seed) {
    static const double none[3] = {0, 0, 0}, one[3] = {1, 1, 1}, angles[3] = {25, -40, 130};
    const ty_affine turn = ty_affine_compose(none, angles, one);
    double eye[3] = {2, 0.5, 2.5}, sun[3] = {-1, -1, 0.2}, up[3] = {0, 1, 0};
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = medium_cube(0.5, 12, 0.5, 0.6);
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 40;
    must(context, ty_grid_create_noise(context, &noise, &medium.density_grid));
    set3(medium.box_max, 0.3, 0.6, 0.7);
    if (turned) {
        medium.transform = turn;
        ty_affine_point(&turn, eye, eye);
        ty_affine_point(&turn, sun, sun);
        ty_affine_point(&turn, up, up);
    }
    add_medium(scene, &medium);
    ty_grid_release(medium.density_grid);
    add_sun_and_sky(scene, sun);
    ty_camera_def camera = ty_default_camera_def();
    memcpy(camera.position, eye, sizeof eye);
    memcpy(camera.up, up, sizeof up);
    camera.fov_y = 20;
    must(context, ty_scene_set_camera(scene, &camera));
    commit(scene);
    ty_image* image = render(scene, SIDE, 128, seed);
    ty_scene_destroy(scene);
    return image;
}

static void turning_everything_changes_nothing(void** state) {
    assert_same_and_destroy("cloud turned with its camera", cloud_picture(*state, true, 2),
                            cloud_picture(*state, false, 1));
}

/* Lengths in units of `unit` metres, coefficients per metre for a scene that is `size` times as large. */
static ty_image* scaled_picture(ty_context* context, double unit, double size, uint64_t seed) {
    char text[1500];
    const double l = size / unit;
    const int length = snprintf(
        text, sizeof text,
        "{\"tyndall\": 1, \"meters_per_unit\": %.17g,"
        " \"camera\": {\"position\": [%.17g, %.17g, %.17g], \"fov_y\": 22, \"resolution\": [64, 64]},"
        " \"media\": [{\"bounds\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]],"
        " \"density\": {\"file\": \"constant.vdb\"},"
        " \"transform\": {\"scale\": %.17g}, \"sigma_s\": %.17g, \"sigma_a\": %.17g, \"g\": 0.5}],"
        " \"lights\": [{\"type\": \"directional\", \"direction\": [-1, -1.5, -1], \"irradiance\": 2},"
        " {\"type\": \"environment\", \"radiance\": 0.2},"
        " {\"type\": \"point\", \"position\": [0, %.17g, 0], \"intensity\": %.17g}]}",
        unit, 1.5 * l, 1 * l, 3 * l, -0.5, -0.5, -0.5, 0.5, 0.5, 0.5, l, 3 / size, 0.3 / size, 0.8 * l, size * size);
    assert_true(length > 0 && (size_t)length < sizeof text);
    ty_scene* scene = NULL;
    must(context, ty_scene_parse(context, text, (size_t)length, "scaled.json", ".", NULL, 0, &scene));
    ty_image* image = render(scene, SIDE, 192, seed);
    ty_scene_destroy(scene);
    return image;
}

static void scaling_the_world_changes_nothing(void** state) {
    ty_context* context = *state;
    ty_grid_release(constant_vdb(context));
    ty_image* original = scaled_picture(context, 1, 1, 1);
    ty_image* scaled = scaled_picture(context, 1, 10, 2);
    assert_same_channel("ten times as large", scaled, 0, original, 0, tolerance);
    ty_image_destroy(scaled);
    scaled = scaled_picture(context, 10, 10, 3);
    assert_same_channel("ten times as large, units of 10 m", scaled, 0, original, 0, tolerance);
    ty_image_destroy(scaled);
    scaled = scaled_picture(context, 0.01, 1, 4);
    assert_same_and_destroy("units of 1 cm", scaled, original);
}

/* Optical depth at sigma_t 1/m by quadrature along a line, of a grid whose voxel centres `to_index` finds. */
typedef struct depth_line {
    const ty_grid* grid;
    ty_affine to_index;
    double from[3], to[3], box; /* inside a cube of this half side only; 0: anywhere */
} depth_line;

static double depth_at(const void* user, double t) {
    const depth_line* line = user;
    double point[3], index[3];
    for (int a = 0; a < 3; ++a) {
        point[a] = line->from[a] + t * (line->to[a] - line->from[a]);
        if (line->box > 0 && fabs(point[a]) > line->box) return 0;
    }
    ty_affine_point(&line->to_index, point, index);
    return (double)ty_grid_sample(line->grid, index);
}

/* Voxels are where they should be: transmittance along lines through an uneven grid that fills a box, or is placed. */
static void voxels_are_in_place(void** state) {
    enum { N = 5, LINES = 12 };
    static float values[N * N * N];
    for (int i = 0; i < N * N * N; ++i) values[i] = (float)((i * 37 % 11) * (i % 3 == 0)) / 4;
    for (int i = 0; i < 4; ++i) {
        const bool placed = i % 2 != 0, dense = i / 2 != 0;
        static const double corner[3] = {-0.4, -0.4, -0.4}, none[3] = {0, 0, 0}, cell[3] = {0.2, 0.2, 0.2};
        static const double shift[3] = {-0.5, -0.6, -0.3}, turn[3] = {10, 20, 30}, size[3] = {0.2, 0.25, 0.15};
        ty_grid_def def = ty_default_grid_def();
        for (int a = 0; a < 3; ++a) def.size[a] = N;
        def.values = values;
        def.placed = placed;
        def.index_to_local = ty_affine_compose(shift, turn, size);
        ty_medium_def medium = medium_cube(0.5, 0.7, 0.3, 0);
        must(*state, ty_grid_create(*state, &def, &medium.density_grid));
        if (placed) medium.bounds = TY_BOUNDS_NONE;
        medium.scale = dense ? 4 : 1;
        ty_scene* scene = new_scene(*state);
        add_medium(scene, &medium);
        commit(scene);
        /* The box [-0.5, 0.5]^3 in fifths: centres from -0.4 on. */
        const ty_affine map = placed ? def.index_to_local : ty_affine_compose(corner, none, cell);
        depth_line line = {.grid = medium.density_grid, .box = placed ? 0 : 0.5};
        assert_true(ty_affine_invert(&map, &line.to_index));
        double worst = 0, sum = 0, expected_sum = 0;
        for (int n = 0; n < LINES; ++n) {
            double x[4], found[3];
            even_point(n, x);
            set3(line.from, x[0] - 0.5, x[1] - 0.5, -1.5);
            set3(line.to, x[2] - 0.5, x[3] - 0.5, 1.5);
            ty_path_def path = ty_default_path_def();
            path.spp = 1 << 18;
            must(*state, ty_path_transmittance(scene, &path, line.from, line.to, found));
            double length = 0;
            for (int a = 0; a < 3; ++a) length += pow(line.to[a] - line.from[a], 2);
            const double expected =
                exp(-(double)medium.scale * sqrt(length) * ty_integrate(depth_at, &line, 0, 1, 2000));
            worst = fmax(worst, fabs(found[0] / expected - 1));
            sum += found[0];
            expected_sum += expected;
        }
        printf("transmittance of a %s grid that %s: worst of %d lines %.3f%%, mean %.5f, off by %+.3f%%\n",
               dense ? "dense" : "thin", placed ? "is placed" : "fills a box", LINES, 100 * worst, sum / LINES,
               100 * (sum / expected_sum - 1));
        assert_true(fabs(sum / expected_sum - 1) < 0.005);
        assert_true(dense || worst < 0.01);
        ty_scene_destroy(scene);
        ty_grid_release(medium.density_grid);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_are_in_place),
        cmocka_unit_test(a_box_and_its_grid_are_alike),
        cmocka_unit_test(halves_add_up),
        cmocka_unit_test(box_and_grid_add_up),
        cmocka_unit_test(turning_everything_changes_nothing),
        cmocka_unit_test(scaling_the_world_changes_nothing),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
