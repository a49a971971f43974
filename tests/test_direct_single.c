/* Light that scatters once, along rays: closed forms for even boxes. */
#include "direct/single.k.h"
#include "direct_maker.h"

static ty_single_view view_of(const ty_grid_medium* medium, const ty_single_light* lights, int32_t count) {
    ty_single_view view = {.lights = lights, .light_count = count};
    float lower[3], per_cell[3];
    for (int a = 0; a < 3; ++a) {
        view.size[a] = medium->box.size[a];
        lower[a] = (float)medium->box.lower[a];
        per_cell[a] = (float)(1 / medium->cell[a]);
        view.extinction[a] = medium->extinction[a];
        view.scattering[a] = medium->scattering[a];
        view.g[a] = medium->g[a];
    }
    view.lower = ty_vec_load(lower);
    view.per_cell = ty_vec_load(per_cell);
    return view;
}

static ty_single_light light_of_field(const ty_light_field* field, int32_t kind, ty_vec toward) {
    ty_single_light light = {.kind = kind, .toward = toward};
    for (int c = 0; c < 3; ++c) {
        light.fluence[c] = field->fluence[c];
        for (int a = 0; a < 3; ++a) light.flux[c][a] = field->flux[c][a];
    }
    return light;
}

static double henyey_greenstein(double mu, double g) {
    return (1 - g * g) / (12.566370614359172 * pow(1 + g * g - 2 * g * mu, 1.5));
}

static direct_case fog(ty_context* context, float g, int32_t cells) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 1, 0.5f);
    set3f(medium.g, g, g, g);
    check_result(context, ty_scene_add_medium(scene, &medium));
    direct_add_sun(scene, 0, -1, 0, 2);
    return direct_begin(scene, cells, 1, 1);
}

/* A cube under the sun: from the side depth does not change along the ray; towards the sun and away it does. */
static void cubes_under_the_sun(void** state) {
    const ty_vec down = ty_vec_make(0, -1, 0);
    for (int32_t cells = 16; cells <= 64; cells *= 4) {
        direct_case made = fog(*state, 0.6f, cells);
        ty_light_field* field = direct_light(&made, true);
        const ty_single_light light = light_of_field(field, TY_SINGLE_BEAM, down);
        const ty_single_view view = view_of(made.medium, &light, 1);
        const double allowed = 3.0 / (cells * cells);
        float radiance[3] = {0, 0, 0}, transmittance[3] = {1, 1, 1};
        ty_single_scattering(&view, ty_vec_make(-3, 0.5f / (float)cells, 0.1f), ty_vec_make(1, 0, 0), 0, 100, radiance,
                             transmittance);
        const double depth = 1.5 * (1 - 0.5 / cells);
        const double side = 2 * exp(-depth) * henyey_greenstein(0, 0.6) * -expm1(-3) / 1.5;
        assert_close(radiance[1] / side, 1, allowed + 1e-5);
        assert_close(transmittance[1], exp(-3), 1e-6);
        float above[3] = {0, 0, 0}, passed[3] = {1, 1, 1};
        ty_single_scattering(&view, ty_vec_make(0.1f, 5, 0.2f), down, 0, 100, above, passed);
        const double back = 2 * henyey_greenstein(-1, 0.6) * -expm1(-6) / 3;
        assert_close(above[0] / back, 1, 6 * allowed);
        float below[3] = {0, 0, 0};
        passed[0] = passed[1] = passed[2] = 1;
        ty_single_scattering(&view, ty_vec_make(0.1f, -5, 0.2f), ty_vec_make(0, 1, 0), 0, 100, below, passed);
        assert_close(below[2] / (2 * henyey_greenstein(1, 0.6) * 2 * exp(-3)), 1, 6 * allowed);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

/* Rays that begin inside, end inside, or pass beside. */
static void ends_cut_rays(void** state) {
    direct_case made = fog(*state, 0, 16);
    ty_light_field* field = direct_light(&made, true);
    const ty_single_light light = light_of_field(field, TY_SINGLE_BEAM, ty_vec_make(0, -1, 0));
    const ty_single_view view = view_of(made.medium, &light, 1);
    float whole[3] = {0, 0, 0}, parts[3] = {0, 0, 0}, through[3] = {1, 1, 1}, passed[3] = {1, 1, 1};
    const ty_vec origin = ty_vec_make(-2, 0.4f, -0.3f), way = ty_vec_make(0.8f, -0.36f, 0.48f);
    ty_single_scattering(&view, origin, way, 0, 100, whole, through);
    const float cuts[] = {0, 1.2f, 1.51f, 2.2f, 100};
    for (int i = 0; i < 4; ++i) ty_single_scattering(&view, origin, way, cuts[i], cuts[i + 1], parts, passed);
    assert_true(whole[0] > 0.01f);
    assert_close(parts[0] / whole[0], 1, 2e-3);
    assert_close(passed[0] / through[0], 1, 1e-5);
    float beside[3] = {0, 0, 0};
    through[0] = 1;
    ty_single_scattering(&view, ty_vec_make(-3, 1.5f, 0), ty_vec_make(1, 0, 0), 0, 100, beside, through);
    assert_true(beside[0] == 0 && through[0] == 1);
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* Without a direction of its own, isotropic scattering stays exact, and little anisotropy nearly. */
static void many_lights_together(void** state) {
    for (int i = 0; i < 2; ++i) {
        direct_case made = fog(*state, i == 0 ? 0 : 0.05f, 16);
        ty_light_field* field = direct_light(&made, true);
        const ty_single_light lights[2] = {light_of_field(field, TY_SINGLE_BEAM, ty_vec_make(0, -1, 0)),
                                           light_of_field(field, TY_SINGLE_MANY, ty_vec_make(0, 0, 0))};
        float radiance[2][3] = {{0, 0, 0}, {0, 0, 0}};
        for (int n = 0; n < 2; ++n) {
            const ty_single_view view = view_of(made.medium, &lights[n], 1);
            float through[3] = {1, 1, 1};
            ty_single_scattering(&view, ty_vec_make(-2, 0.9f, 0), ty_vec_make(0.8f, -0.6f, 0), 0, 100, radiance[n],
                                 through);
        }
        assert_close(radiance[1][0] / radiance[0][0], 1, i == 0 ? 1e-5 : 0.01);
        ty_light_field_destroy(field);
        direct_end(&made);
    }
}

/* A lamp beside a thin box: the integral along the ray by the midpoint rule. */
static void lamps_scatter_from_where_they_are(void** state) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(*state);
    ty_medium_def medium = box_medium(lower, upper, 0.01f, 0);
    set3f(medium.g, 0.7f, 0.7f, 0.7f);
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 2, 0);
    check_result(*state, ty_scene_add_medium(scene, &medium));
    check_result(*state, ty_scene_add_light(scene, &lamp));
    direct_case made = direct_begin(scene, 32, 1, 1);
    ty_light_field* field = direct_light(&made, true);
    const ty_single_light light = light_of_field(field, TY_SINGLE_LAMP, ty_vec_make(0, 2, 0));
    const ty_single_view view = view_of(made.medium, &light, 1);
    float radiance[3] = {0, 0, 0}, through[3] = {1, 1, 1};
    ty_single_scattering(&view, ty_vec_make(-4, 0.2f, 0.1f), ty_vec_make(1, 0, 0), 0, 100, radiance, through);
    double expected = 0;
    for (int i = 0; i < 2000; ++i) {
        const double x = -1 + (i + 0.5) / 1000, square = x * x + 1.8 * 1.8 + 0.01;
        const double inside = sqrt(square) * 0.8 / 1.8;
        expected += 0.01 * henyey_greenstein(-x / sqrt(square), 0.7) / square * exp(-0.01 * (inside + x + 1)) / 1000;
    }
    assert_close(radiance[0] / expected, 1, 2e-3);
    ty_light_field_destroy(field);
    direct_end(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cubes_under_the_sun),
        cmocka_unit_test(ends_cut_rays),
        cmocka_unit_test(many_lights_together),
        cmocka_unit_test(lamps_scatter_from_where_they_are),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
