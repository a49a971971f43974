/* Weights of lights in a scene without a receiver: the brightness of each, and the frequency of its choice. */
#include "checks.h"

#include "scene/lights/light.h"

static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};

static ty_light_view panel(double height, float radiance) {
    const double origin[3] = {-0.1, height, -0.1}, u[3] = {0.2, 0, 0}, v[3] = {0, 0, 0.2};
    const float color[3] = {radiance, radiance, radiance};
    return ty_light_quad_view(origin, u, v, color);
}

/* A lamp far outside the box is as bright there as its distance allows, not as if it hung inside. */
static void far_lamps_count_by_their_distance(void** state) {
    (void)state;
    ty_light_view lights[2] = {panel(0.5, 10), panel(21, 10)};
    const float placed = ty_light_set_choice(lights, 2, lower, upper);
    assert_close(placed, 1, 1e-6);
    const double d2 = 3 * 2.0 * 2.0 / 16, outside2 = 20.0 * 20.0, power = 10 * 0.2 * 0.2;
    assert_close(lights[0].typical, power / d2, 1e-4 * power / d2);
    assert_close(lights[1].typical, power / (d2 + outside2), 1e-4 * power / outside2);
}

/* The sun and a lamp share by fluence, a tenth evenly; together they are chosen always. */
static void lights_without_a_place_share_with_the_others(void** state) {
    (void)state;
    ty_light_def sun = ty_default_light_def();
    sun.color[0] = sun.color[1] = sun.color[2] = 3;
    ty_light_view lights[2] = {panel(0.5, 10), ty_light_get_view(&sun, NULL, TY_AXIS_Y)};
    const float placed = ty_light_set_choice(lights, 2, lower, upper);
    const double lamp = 10 * 0.2 * 0.2 / 0.75;
    assert_close(placed, 0.9 * lamp / (lamp + 3) + 0.05, 1e-5);
    assert_close(lights[1].chosen, 0.9 * 3 / (lamp + 3) + 0.05, 1e-5);
    assert_close(lights[1].cumulative, 1, 1e-6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(far_lamps_count_by_their_distance),
        cmocka_unit_test(lights_without_a_place_share_with_the_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
