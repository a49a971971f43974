/* Light on cells that scatters once. */
#include "direct/single/single.k.h"
#include "direct_maker.h"

enum { CELLS = 16 };

static ty_light_fluence light_of_field(const ty_light_field* field, int32_t kind, ty_vec toward) {
    ty_light_fluence light = {.kind = kind, .anchor = toward};
    for (int c = 0; c < 3; ++c) {
        light.fluence[c] = field->fluence[c];
        for (int a = 0; a < 3; ++a) light.flux[c][a] = field->flux[c][a];
    }
    return light;
}

static double henyey_greenstein(double mu, double g) {
    return (1 - g * g) / (12.566370614359172 * pow(1 + g * g - 2 * g * mu, 1.5));
}

/* A cube of edge 2 m about the origin, under a sun of 2 W m^-2, or a lamp of 1 W sr^-1 at (0, 2, 0). */
static direct_case fog(ty_context* context, ty_light_kind kind) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 0.1f, 0);
    check_result(context, ty_scene_add_medium(scene, &medium));
    ty_light_def lamp = ty_default_light_def();
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0, 2, 0);
    if (kind == TY_LIGHT_POINT)
        check_result(context, ty_scene_add_light(scene, &lamp));
    else
        direct_add_sun(scene, 0, -1, 0, 2);
    return direct_begin(scene, CELLS, 1, 1);
}

/* Light that a point scatters along a direction. */
static float scattered(const ty_light_fluence* light, ty_vec point, ty_vec way, float g) {
    static const int32_t size[3] = {CELLS, CELLS, CELLS};
    const float per_cell = CELLS / 2.0f, gs[3] = {g, g, g};
    const ty_vec cells = ty_scale(ty_add(point, ty_vec_make(1, 1, 1)), per_cell);
    const ty_cell_point at = ty_cell_locate(size, cells);
    static const float whole[TY_FLUENCE_COUNT][3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    static const ty_forward_fit none = {.bands = 0};
    ty_single_radiance sent = {{0}, {0}, {0}};
    ty_single_scattered(light, point, &at, way, whole, gs, NULL, &none, &sent);
    assert_true(sent.again[1] == 0 && sent.aside[1] == 0);
    return sent.first[1];
}

static void beams_keep_their_phase_function(void** state) {
    direct_case made = fog(*state, TY_LIGHT_DIRECTIONAL);
    ty_light_field* field = direct_light(&made, true);
    const ty_light_fluence sun = light_of_field(field, TY_FLUENCE_DIRECTIONAL, ty_vec_make(0, -1, 0));
    for (int i = 0; i < 5; ++i) {
        const float y = -0.8f + 0.4f * (float)i, g = -0.8f + 0.4f * (float)i;
        const double fluence = 2 * exp(-0.1 * (1 - (double)y));
        const ty_vec way = ty_vec_make(0.6f, -0.8f, 0);
        assert_close((double)scattered(&sun, ty_vec_make(0.1f, y, -0.3f), way, g),
                     fluence * henyey_greenstein(0.8, (double)g), 1e-4);
    }
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* Without a direction of its own, isotropic scattering stays exact, and little anisotropy nearly. */
static void many_lights_together(void** state) {
    direct_case made = fog(*state, TY_LIGHT_DIRECTIONAL);
    ty_light_field* field = direct_light(&made, true);
    const ty_light_fluence sun = light_of_field(field, TY_FLUENCE_DIRECTIONAL, ty_vec_make(0, -1, 0));
    const ty_light_fluence many = light_of_field(field, TY_FLUENCE_P1, ty_vec_make(0, 0, 0));
    const ty_vec point = ty_vec_make(0.2f, 0.3f, 0.4f), way = ty_vec_make(-0.8f, 0.6f, 0);
    assert_close((double)(scattered(&many, point, way, 0) / scattered(&sun, point, way, 0)), 1, 1e-5);
    assert_close((double)(scattered(&many, point, way, 0.05f) / scattered(&sun, point, way, 0.05f)), 1, 0.01);
    /* More than there is cannot be taken away. */
    assert_true(scattered(&many, point, ty_vec_make(0, 1, 0), 0.9f) == 0);
    ty_light_field_destroy(field);
    direct_end(&made);
}

static void lamps_scatter_from_where_they_are(void** state) {
    direct_case made = fog(*state, TY_LIGHT_POINT);
    ty_light_field* field = direct_light(&made, true);
    const ty_light_fluence lamp = light_of_field(field, TY_FLUENCE_POINT, ty_vec_make(0, 2, 0));
    const double x = 0.4, y = -0.3, z = 0.2, square = x * x + (2 - y) * (2 - y) + z * z, length = sqrt(square);
    const double inside = length * (1 - y) / (2 - y), fluence = exp(-0.1 * inside) / square;
    const float found = scattered(&lamp, ty_vec_make((float)x, (float)y, (float)z), ty_vec_make(1, 0, 0), 0.7f);
    assert_close((double)found / (fluence * henyey_greenstein(x / length, 0.7)), 1, 5e-3);
    ty_light_field_destroy(field);
    direct_end(&made);
}

/* A beam in a medium of mean cosine g, behind the optical depth tau of scattering. */
static ty_forward forward_behind(double tau, double g) {
    return (ty_forward){(float)exp(-tau), (float)exp(-tau * (1 - g)), (float)exp(-tau * (1 - g * g)), 1};
}

/* Moments 0, 1 and 2 of what scatters once more are those of the small-angle solution: R, g R and g^2 S. */
static void lobes_keep_moments(void** state) {
    (void)state;
    const double depths[] = {0.01, 1, 6}, cosines[] = {0, 0.3, 0.9};
    for (int i = 0; i < 9; ++i) {
        const double g = cosines[i % 3];
        const ty_forward light = forward_behind(depths[i / 3], g);
        double moment[3] = {0, 0, 0};
        const int steps = 200000;
        for (int s = 0; s < steps; ++s) {
            const double mu = -1 + (s + 0.5) * 2 / steps, legendre[3] = {1, mu, 1.5 * mu * mu - 0.5};
            const float sum =
                ty_forward_unscattered(light, (float)mu, (float)g) + ty_forward_scattered(light, (float)mu, (float)g);
            for (int l = 0; l < 3; ++l) moment[l] += (double)sum * legendre[l] * 12.566370614359172 / steps;
        }
        assert_close(moment[0], (double)light.phi_order_l, 2e-3 * (double)light.phi_order_l);
        assert_close(moment[1], g * (double)light.phi_order_l, 2e-3 * (double)light.phi_order_l);
        assert_close(moment[2], g * g * (double)light.phi_next_order, 2e-3 * (double)light.phi_order_l);
    }
}

/* In thin media lobes are light that scattered once, with the phase function of two scatterings towards the eye. */
static void thin_lobes_are_double_scattering(void** state) {
    (void)state;
    const ty_forward light = forward_behind(1e-3, 0.6);
    for (int i = 0; i < 5; ++i) {
        const double mu = -1 + i * 0.5, uniform = (1 - 0.6) * 1e-3 / 12.566370614359172;
        /* Its isotropic part belongs to the diffuse light. */
        const double expected = 1e-3 * henyey_greenstein(mu, 0.36) - uniform;
        assert_close((double)ty_forward_scattered(light, (float)mu, 0.6f), expected, 0.01 * 1e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beams_keep_their_phase_function),   cmocka_unit_test(many_lights_together),
        cmocka_unit_test(lamps_scatter_from_where_they_are), cmocka_unit_test(lobes_keep_moments),
        cmocka_unit_test(thin_lobes_are_double_scattering),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
