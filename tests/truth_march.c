/* The marcher against path tracing: the same light, once it is given on cells. */
#include "effort.h"
#include "march_maker.h"

enum { SIDE = 48, VOXELS = 48, COARSE = 16, BLOCK = 8 };

/* A cube of noise about the origin under the light of `def`. */
static ty_scene* cloud(ty_context* context, const float sigma_s[3], float g, const ty_light_def* light) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_camera_def camera = ty_default_camera_def();
    ty_medium_def medium = box_medium(lower, upper, 0, 0.2f);
    ty_noise_def noise = ty_default_noise_def();
    noise.kind = TY_NOISE_CLOUD;
    noise.size[0] = noise.size[1] = noise.size[2] = VOXELS;
    noise.frequency = 3;
    set3(camera.position, 2, 1.5, 4);
    camera.fov_y = 34;
    set3f(medium.sigma_s, sigma_s[0], sigma_s[1], sigma_s[2]);
    set3f(medium.g, g, g, g);
    check_result(context, ty_grid_create_noise(context, &noise, &medium.density_grid));
    check_result(context, ty_scene_add_medium(scene, &medium));
    check_result(context, ty_scene_set_camera(scene, &camera));
    check_result(context, ty_scene_add_light(scene, light));
    ty_grid_release(medium.density_grid);
    return scene;
}

static ty_image* path_image(const ty_scene* scene, int32_t spp, int32_t depth) {
    ty_image* image = NULL;
    ty_path_def def = ty_default_path_def();
    def.width = def.height = SIDE;
    def.spp = spp;
    def.max_depth = depth;
    def.aovs = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE;
    check_result(ty_scene_context(scene), ty_path_render(scene, &def, &image, NULL));
    return image;
}

/* Difference of an image's layer from that of another, over blocks of pixels. */
static ty_difference layer_difference(ty_context* context, const ty_image* image, const ty_image* truth,
                                      const char* layer, int32_t block) {
    ty_image* layers[2] = {NULL, NULL};
    ty_difference difference;
    check_result(context, ty_image_create_layer(context, image, layer, &layers[0]));
    check_result(context, ty_image_create_layer(context, truth, layer, &layers[1]));
    check_result(context, ty_image_compare(context, layers[0], layers[1], block, &difference));
    print_message("%-14s %.5f %.4f\n", layer, difference.mean_ratio[3], difference.relative_rmse[3]);
    for (int i = 0; i < 2; ++i) ty_image_destroy(layers[i]);
    return difference;
}

static ty_light_fluence light_on_cells(const direct_case* made, ty_light_field* field) {
    ty_light_fluence light = ty_light_fluence_of(&made->sources.items[0]);
    for (int c = 0; c < 3; ++c) light.fluence[c] = field->fluence[c];
    return light;
}

/* One scattering of a beam and of a lamp, of every colour its own. */
static void single_scattering(void** state) {
    static const float sigma_s[3] = {1.5f, 3, 6};
    for (int kind = 0; kind < 2; ++kind) {
        ty_light_def def = ty_default_light_def();
        set3(def.direction, -1, -1, -0.4);
        if (kind == 1) {
            def.kind = TY_LIGHT_POINT;
            set3(def.position, 1.5, 1.5, 0.5);
        }
        direct_case made = direct_begin(cloud(*state, sigma_s, 0.6f, &def), 2 * VOXELS, 1, 1);
        ty_light_field* field = direct_light(&made, false);
        const ty_light_fluence light = light_on_cells(&made, field);
        ty_march_def march = march_def(SIDE, SIDE);
        march.spp = 16;
        march.light_box = made.medium->box;
        march.lights = &light;
        march.light_count = 1;
        march.aovs = TY_AOV_TRANSMITTANCE | TY_AOV_SINGLE;
        ty_image *image = march_image(made.scene, &march, NULL), *truth = path_image(made.scene, fewer(2048, 2), 1);
        const ty_difference passed = layer_difference(*state, image, truth, "transmittance", BLOCK);
        const ty_difference single = layer_difference(*state, image, truth, "single", BLOCK);
        assert_close(passed.mean_ratio[3], 1, 1e-3);
        assert_true(passed.relative_rmse[3] < 2e-3);
        for (int c = 0; c < 3; ++c) assert_close(single.mean_ratio[c], 1, 0.01);
        assert_true(single.relative_rmse[3] < 0.03);
        ty_image_destroy(image);
        ty_image_destroy(truth);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

/* A field from path-traced fluence on coarse cells. */
typedef struct traced_field {
    float* planes[3];
    double *fluence, *uncollided;
    ty_grid_medium* coarse;
    ty_source_field field;
} traced_field;

static void trace_field(const direct_case* made, int32_t spp, traced_field* out) {
    static const int32_t size[3] = {COARSE, COARSE, COARSE};
    enum { CELLS = COARSE * COARSE * COARSE };
    ty_context* context = ty_scene_context(made->scene);
    ty_path_def def = ty_default_path_def();
    def.spp = spp;
    out->fluence = malloc(3 * CELLS * sizeof(double));
    out->uncollided = malloc(3 * CELLS * sizeof(double));
    check_result(context, ty_grid_medium_resize(made->medium, size, &out->coarse));
    check_result(context, ty_path_fluence(made->scene, &def, out->coarse->box.lower, out->coarse->box.upper, size,
                                          out->fluence, out->uncollided, NULL));
    out->field = (ty_source_field){.box = out->coarse->box, .term_count = 1, .guide = out->coarse->extinction[0]};
    for (int c = 0; c < 3; ++c) {
        out->planes[c] = malloc(CELLS * sizeof(float));
        for (int i = 0; i < CELLS; ++i)
            out->planes[c][i] = (float)((out->fluence[3 * i + c] - out->uncollided[3 * i + c]) / 12.566370614359172);
        out->field.terms[c][0] = out->planes[c];
    }
}

static void free_field(traced_field* traced) {
    for (int c = 0; c < 3; ++c) free(traced->planes[c]);
    free(traced->fluence);
    free(traced->uncollided);
    ty_grid_medium_destroy(traced->coarse);
}

/* Light that scattered more than once, from cells of three voxels: guided by density it is nearer to the truth than
 * plain. */
static void multiple_scattering(void** state) {
    static const float sigma_s[3] = {8, 8, 8};
    ty_light_def sun = ty_default_light_def();
    set3(sun.direction, -1, -1, -0.4);
    direct_case made = direct_begin(cloud(*state, sigma_s, 0, &sun), VOXELS, 1, 1);
    traced_field traced;
    trace_field(&made, fewer(300, 2), &traced);
    ty_image* truth = path_image(made.scene, 256, 0);
    ty_difference multiple[2];
    for (int guided = 0; guided < 2; ++guided) {
        ty_march_def march = march_def(SIDE, SIDE);
        march.spp = 16;
        march.field = &traced.field;
        march.aovs = TY_AOV_MULTIPLE;
        if (guided == 0) march.bilateral_sigma = 0;
        ty_image* image = march_image(made.scene, &march, NULL);
        multiple[guided] = layer_difference(*state, image, truth, "multiple", BLOCK);
        ty_image_destroy(image);
    }
    assert_close(multiple[1].mean_ratio[3], 1, 0.04);
    assert_true(multiple[1].relative_rmse[3] < 0.09);
    assert_true(multiple[1].relative_rmse[3] < 0.7 * multiple[0].relative_rmse[3]);
    ty_image_destroy(truth);
    free_field(&traced);
    direct_end(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_scattering),
        cmocka_unit_test(multiple_scattering),
    };
    return cmocka_run_group_tests_name("march and path", tests, start_context, stop_context);
}
