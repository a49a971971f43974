/* Media inside smooth dielectrics, solved on cells: a ball of index 1.33 under uniform light and in the sun. */
#include "checks.h"
#include "scene/scene.h"
#include "solve/diffusion/fresnel_boundary.h"
#include "solve/enclosed/enclosed.h"

#define PI 3.141592653589793
#define IOR 1.33

typedef struct ball {
    float scattering, absorption, g;
    bool sun; /* else uniform light of radiance 1 */
} ball;

static ty_scene* make_ball(ty_context* context, const ball* b) {
    ty_scene* scene;
    ty_medium_def medium = ty_default_medium_def();
    ty_shape_def shape = ty_default_shape_def();
    ty_light_def light = ty_default_light_def();
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    medium.bounds = TY_BOUNDS_SPHERE;
    medium.sphere_radius = shape.radius = 0.5;
    shape.kind = TY_SHAPE_SPHERE;
    shape.gloss.specular = shape.gloss.transmission = 1;
    shape.gloss.ior = (float)IOR;
    shape.gloss.roughness = 0;
    shape.gloss.solid = true;
    for (int c = 0; c < 3; ++c) {
        medium.sigma_s[c] = b->scattering;
        medium.sigma_a[c] = b->absorption * (float)c;
        medium.g[c] = b->g;
    }
    light.kind = b->sun ? TY_LIGHT_DIRECTIONAL : TY_LIGHT_ENVIRONMENT;
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_shape(scene, &shape), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &light), TY_OK);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    return scene;
}

static ty_enclosed* solve(const ty_scene* scene, bool diffusion, ty_enclosed_stats* stats) {
    ty_enclosed_def def = ty_default_enclosed_def();
    ty_enclosed* enclosed;
    def.diffusion = diffusion;
    assert_true(ty_enclosed_exists(scene));
    assert_int_equal(ty_enclosed_solve(scene, &def, &enclosed, stats), TY_OK);
    assert_true(stats->converged);
    assert_int_equal(stats->interiors, 1);
    for (int c = 0; c < 3; c += 2)
        print_message(
            "%s: entering %.4f, absorbed %.4f, leaving %.4f, balance %.1e; %d sweeps, %d sides, %.3f + %.3f s\n",
            diffusion ? "diffusion" : "ordinates", stats->entering[c], stats->absorbed[c], stats->leaving[c],
            (stats->absorbed[c] + stats->leaving[c]) / stats->entering[c] - 1, (int)stats->sweeps, (int)stats->sides,
            stats->entering_seconds, stats->solve_seconds);
    return enclosed;
}

/* Without absorption, uniform light is inside as it is outside, over n^2: white milk and its boundary are invisible. */
static void white_milk_is_invisible(void** state) {
    static const ball balls[] = {{20, 0, 0.7f, false}, {4, 0, 0, false}, {200, 0, 0.7f, false}};
    for (size_t i = 0; i < 2 * sizeof balls / sizeof *balls; ++i) {
        ty_enclosed_stats stats;
        ty_scene* scene = make_ball(*state, &balls[i / 2]);
        ty_enclosed* enclosed = solve(scene, i % 2 != 0, &stats);
        const ty_enclosed_field* field = &ty_enclosed_fields(enclosed)[1];
        const double entering = PI * (1 - 2 * ty_fresnel_moments_of(1 / IOR).c1) * PI;
        assert_close(stats.entering[0], entering, 0.02 * entering);
        uint64_t random = 3;
        double mean = 0;
        for (int k = 0; k < 400; ++k) {
            float out[3];
            const double r = k < 200 ? 0.49 : 0.3;
            const double z = uniform_in(&random, -1, 1), turn = uniform_in(&random, 0, 2 * PI);
            const double rho = sqrt(1 - z * z);
            const ty_vec n = ty_vec_make((float)(rho * cos(turn)), (float)(rho * sin(turn)), (float)z);
            ty_enclosed_radiance(field, ty_scale(n, (float)r), n, out);
            mean += (double)out[0] / (200 * IOR * IOR);
            if (k % 200 != 199) continue;
            print_message("radiance at %g m: %.4f\n", r, mean);
            mean = 0;
        }
        ty_enclosed_destroy(enclosed);
        ty_scene_destroy(scene);
    }
}

static void energy_is_kept(void** state) {
    static const ball balls[] = {{20, 0.1f, 0.7f, true}, {20, 0.1f, 0.7f, false}, {3, 0.5f, 0, true}};
    for (size_t i = 0; i < 2 * sizeof balls / sizeof *balls; ++i) {
        ty_enclosed_stats stats;
        ty_scene* scene = make_ball(*state, &balls[i / 2]);
        ty_enclosed* enclosed = solve(scene, i % 2 != 0, &stats);
        for (int c = 0; c < 3; ++c) assert_close((stats.absorbed[c] + stats.leaving[c]) / stats.entering[c], 1, 1e-3);
        ty_enclosed_destroy(enclosed);
        ty_scene_destroy(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(white_milk_is_invisible, start_context, stop_context),
        cmocka_unit_test_setup_teardown(energy_is_kept, start_context, stop_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
