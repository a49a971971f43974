/* Media that glow: emission against closed forms and quadrature, and Kirchhoff's law. */
#include "truth_cases.h"

static const double tolerance = 0.003;

/* A cube about the origin that absorbs and glows. */
static ty_medium_def glowing_cube(double half, double sigma_a, double emission) {
    ty_medium_def def = medium_cube(half, 0, sigma_a, 0);
    gray(def.emission, emission);
    return def;
}

/* A grid over a medium's bounds, whose values depend on z alone. */
static ty_grid* column_grid(ty_context* context, int32_t size, double (*value)(double z)) {
    ty_grid_def def = ty_default_grid_def();
    float* values = calloc((size_t)size, sizeof *values);
    assert_non_null(values);
    def.size[0] = def.size[1] = 1;
    def.size[2] = size;
    for (int32_t i = 0; i < size; ++i) values[i] = (float)value((i + 0.5) / size);
    def.values = values;
    ty_grid* grid = NULL;
    must(context, ty_grid_create(context, &def, &grid));
    free(values);
    return grid;
}

/* Radiance of the scene along -z, all three channels. */
static void along_z(ty_scene* scene, int32_t spp, estimate out[3]) {
    enum { ITEMS = 64 };
    double rays[6 * ITEMS], radiance[3 * ITEMS];
    for (int i = 0; i < ITEMS; ++i) {
        set3(rays + 6 * i, 0.1, -0.05, 4);
        set3(rays + 6 * i + 3, 0, 0, -1);
    }
    radiance_along(scene, ITEMS, rays, spp, 0, radiance, NULL);
    for (int c = 0; c < 3; ++c) out[c] = estimate_of(radiance + c, ITEMS, 3);
}

/* ---- homogeneous: in closed form ---- */

static void boxes_emit_as_they_should(void** state) {
    static const double depths[] = {1e-7, 1e-6, 1e-5, 1e-3, 0.02, 0.05, 0.7, 5, 40};
    for (int i = 0; i < 9; ++i) {
        ty_scene* scene = new_scene(*state);
        ty_medium_def box = glowing_cube(0.5, 1, 1);
        rgb(box.sigma_a, depths[i], 2 * depths[i], 0);
        rgb(box.emission, 3, 0.5, 7);
        add_medium(scene, &box);
        commit(scene);
        estimate found[3];
        along_z(scene, 4, found);
        assert_close("box", found[0], -3 * expm1(-depths[i]), 1e-5);
        assert_close("box", found[1], -0.5 * expm1(-2 * depths[i]), 1e-5);
        assert_true(found[2].mean == 0);
        ty_scene_destroy(scene);
    }
}

/* Layers from z = 1 down to -1, as two boxes that overlap: each stretch glows by the mean of its media, weighted by
 * absorption. */
static void overlapping_media_add_their_emission(void** state) {
    ty_scene* scene = new_scene(*state);
    ty_medium_def near = glowing_cube(1, 0.8, 2), far = glowing_cube(1, 1.5, 0.5);
    near.box_min[2] = -0.25;
    far.box_max[2] = 0.5;
    add_medium(scene, &near);
    add_medium(scene, &far);
    ty_light_def sky = light_of(TY_LIGHT_ENVIRONMENT, 0.3);
    add_light(scene, &sky);
    commit(scene);
    estimate found[3];
    along_z(scene, 16, found);
    const double a = exp(-0.8 * 0.5), b = exp(-2.3 * 0.75), c = exp(-1.5 * 0.75);
    const double both = (0.8 * 2 + 1.5 * 0.5) / 2.3;
    assert_close("overlapping boxes", found[0], 2 * (1 - a) + a * (both * (1 - b) + b * (0.5 * (1 - c) + c * 0.3)),
                 1e-5);
    ty_scene_destroy(scene);
}

/* Light that an endless slab sends to a board under it, per pi times its emission, by the cosine of its direction. */
static double slab_flux(const void* user, double mu) {
    return -2 * mu * expm1(-*(const double*)user / mu);
}

static void emission_lights_the_floor(void** state) {
    static const double center[3] = {0, 0, 0}, u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
    ty_scene* scene = new_scene(*state);
    ty_medium_def slab = glowing_cube(1e4, 0.6, 3);
    slab.box_min[2] = 0;
    slab.box_max[2] = 1;
    const ty_shape_def board = square_shape(center, u, v, 1, 0.5);
    add_medium(scene, &slab);
    add_shape(scene, &board);
    commit(scene);
    estimate found[3];
    along_z(scene, 4096, found);
    const double depth = 0.6, flux = ty_integrate(slab_flux, &depth, 0, 1, 64);
    assert_close("board under a slab", found[0], -3 * expm1(-depth) + exp(-depth) * 0.5 * 3 * flux, tolerance);
    ty_scene_destroy(scene);
}

/* ---- grids: by quadrature ---- */

static double ramp(double z) {
    return z;
}

static double uneven(double z) {
    return 0.5 + 0.5 * sin(9 * z);
}

/* A column of cells seen from above, z from 1 down to 0. */
typedef struct column {
    double sigma; /* absorption at density 1, 1/m */
    double (*emission)(double z);
    const ty_grid* grid; /* of the density */
} column;

static double sampled(const ty_grid* grid, double z) {
    const double index[3] = {0, 0, z * ty_grid_get_info(grid).size[2] - 0.5};
    return (double)ty_grid_sample(grid, index);
}

static double column_density(const void* user, double z) {
    const column* c = user;
    return sampled(c->grid, z);
}

static double column_glow(const void* user, double z) {
    const column* c = user;
    const double depth = c->sigma * ty_integrate(column_density, c, z, 1, 24);
    return c->sigma * column_density(c, z) * c->emission(z) * exp(-depth);
}

static double three(double z) {
    (void)z;
    return 3;
}

/* Emission of a grid's density, behind homogeneous fog that absorbs. */
static void emission_follows_the_density(void** state) {
    ty_grid* grid = column_grid(*state, 24, uneven);
    ty_scene* scene = new_scene(*state);
    ty_medium_def cube = glowing_cube(0.5, 2.5, 3), fog = medium_cube(0.5, 0, 0.4, 0);
    cube.density_grid = grid;
    fog.box_min[2] = 1;
    fog.box_max[2] = 2;
    add_medium(scene, &cube);
    add_medium(scene, &fog);
    commit(scene);
    estimate found[3];
    along_z(scene, 1 << 15, found);
    const column c = {.sigma = 2.5, .emission = three, .grid = grid};
    assert_close("uneven density behind fog", found[0], exp(-0.4) * ty_integrate(column_glow, &c, 0, 1, 96), tolerance);
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

/* Colours in one medium whose grid varies: the mixture of channels must not tint what glows. */
static void coloured_grids_emit_their_colours(void** state) {
    ty_grid* grid = column_grid(*state, 24, uneven);
    ty_scene* scene = new_scene(*state);
    ty_medium_def cube = glowing_cube(0.5, 1, 3);
    cube.density_grid = grid;
    rgb(cube.sigma_a, 0.5, 2.5, 6);
    add_medium(scene, &cube);
    commit(scene);
    estimate found[3];
    along_z(scene, 1 << 15, found);
    for (int i = 0; i < 3; ++i) {
        const column c = {.sigma = (double[]){0.5, 2.5, 6}[i], .emission = three, .grid = grid};
        assert_close("coloured grid", found[i], ty_integrate(column_glow, &c, 0, 1, 96), tolerance);
    }
    ty_scene_destroy(scene);
    ty_grid_release(grid);
}

static double constant_half(double z) {
    (void)z;
    return 0.5;
}

/* The same temperature everywhere: ty_blackbody times what a box absorbs. */
static void a_constant_temperature_emits_its_black_body(void** state) {
    static const double depths[] = {0.2, 3};
    for (int i = 0; i < 2; ++i) {
        ty_grid* grid = column_grid(*state, 8, constant_half);
        ty_scene* scene = new_scene(*state);
        ty_medium_def cube = medium_cube(0.5, 0, depths[i], 0);
        cube.temperature_grid = grid;
        cube.kelvin[0] = 1000;
        cube.kelvin[1] = 3000;
        cube.emission_scale = 0.25f;
        add_medium(scene, &cube);
        commit(scene);
        estimate found[3];
        float black[3];
        along_z(scene, 1 << 14, found);
        ty_blackbody(2000, black);
        for (int c = 0; c < 3; ++c)
            assert_close("black body of 2000 K", found[c], -0.25 * (double)black[c] * expm1(-depths[i]), tolerance);
        ty_scene_destroy(scene);
        ty_grid_release(grid);
    }
}

static const ty_grid* ramp_grid;

static double ramp_emission(double z) {
    float black[3];
    ty_blackbody(800 + 2200 * sampled(ramp_grid, z), black);
    return (double)black[0] + 2;
}

/* A ramp of temperature, plus emission of its own, in a density that varies as well. */
static void a_ramp_of_temperature_is_integrated(void** state) {
    ty_grid *density = column_grid(*state, 24, uneven), *temperature = column_grid(*state, 40, ramp);
    ty_scene* scene = new_scene(*state);
    ty_medium_def cube = glowing_cube(0.5, 2, 2);
    cube.density_grid = density;
    cube.temperature_grid = temperature;
    cube.kelvin[0] = 800;
    cube.kelvin[1] = 3000;
    add_medium(scene, &cube);
    commit(scene);
    estimate found[3];
    along_z(scene, 1 << 14, found);
    ramp_grid = temperature;
    const column c = {.sigma = 2, .emission = ramp_emission, .grid = density};
    assert_close("ramp of temperature", found[0], ty_integrate(column_glow, &c, 0, 1, 96), tolerance);
    ty_scene_destroy(scene);
    ty_grid_release(density);
    ty_grid_release(temperature);
}

/* ---- an isothermal furnace: whatever it absorbs and scatters, everything looks alike ---- */

static const float warm[3] = {0.5f, 2, 1.25f};

static ty_grid* noise_grid(ty_context* context, uint32_t seed) {
    ty_noise_def def = ty_default_noise_def();
    for (int a = 0; a < 3; ++a) def.size[a] = 24;
    def.kind = TY_NOISE_FBM;
    def.seed = seed;
    ty_grid* grid = NULL;
    must(context, ty_grid_create_noise(context, &def, &grid));
    return grid;
}

static void check_isothermal(ty_context* context, const char* name, bool density, bool fields, bool sampled_light) {
    ty_scene* scene = new_scene(context);
    ty_medium_def body = medium_cube(1, 1.5, 0.7, 0.6);
    rgb(body.sigma_s, 3, 0.5, 1);
    rgb(body.sigma_a, 0.2, 1, 2);
    memcpy(body.emission, warm, sizeof warm);
    if (density) body.density_grid = noise_grid(context, 1);
    if (density) body.scale = 3;
    if (fields) {
        for (int c = 0; c < 3; ++c) body.albedo_grid[c] = noise_grid(context, 2 + (uint32_t)c);
        body.g_grid = noise_grid(context, 5);
    }
    add_medium(scene, &body);
    ty_medium_def ball = medium_sphere(0.8, 0.5, 1, -0.3);
    ball.sphere_center[0] = 0.6;
    memcpy(ball.emission, warm, sizeof warm);
    add_medium(scene, &ball);
    add_furnace_light(scene, warm, sampled_light);
    set_camera(scene, 2, -6, 1, 30);
    commit(scene);
    assert_furnace(name, scene, warm, 24, 1024);
    ty_scene_destroy(scene);
    ty_grid_release(body.density_grid);
    for (int c = 0; c < 3; ++c) ty_grid_release(body.albedo_grid[c]);
    ty_grid_release(body.g_grid);
}

static void an_isothermal_enclosure_is_black(void** state) {
    check_isothermal(*state, "isothermal, homogeneous", false, false, false);
    check_isothermal(*state, "isothermal, homogeneous, map", false, false, true);
    check_isothermal(*state, "isothermal, density", true, false, false);
    check_isothermal(*state, "isothermal, albedo and g", false, true, false);
    check_isothermal(*state, "isothermal, all fields, map", true, true, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_emit_as_they_should),
        cmocka_unit_test(overlapping_media_add_their_emission),
        cmocka_unit_test(emission_lights_the_floor),
        cmocka_unit_test(emission_follows_the_density),
        cmocka_unit_test(coloured_grids_emit_their_colours),
        cmocka_unit_test(a_constant_temperature_emits_its_black_body),
        cmocka_unit_test(a_ramp_of_temperature_is_integrated),
        cmocka_unit_test(an_isothermal_enclosure_is_black),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
