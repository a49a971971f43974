/* Discrete ordinates between surfaces, against path tracing. */
#include "truth_scene.h"

#include <tyndall/dom.h>

static void fluence_of(ty_context* context, const char* g) {
    const char* overrides[] = {g, getenv("EXTRA") != NULL ? getenv("EXTRA") : "render.spp=4"};
    ty_scene* scene = NULL;
    must(context, ty_scene_load(context, "builtin:fog_cornell", overrides, 2, &scene));
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    static const int32_t size[3] = {8, 8, 8};
    static double truth[1536], bare[1536], fluence[1536], uncollided[1536];
    ty_path_def path = ty_default_path_def();
    path.spp = getenv("SPP")?atoi(getenv("SPP")):1600;
    must(context, ty_path_fluence(scene, &path, lower, upper, size, truth, bare, NULL));
    ty_dom_def def = ty_default_dom_def();
    ty_dom* light = NULL;
    must(context, ty_dom_solve(scene, &def, &light, NULL));
    must(context, ty_dom_fluence(light, lower, upper, size, fluence, uncollided));
    for (int z = 7; z >= 0; --z) {
        double sum[4] = {0};
        for (int i = 0; i < 64; ++i) {
            const int at = 3 * (z * 64 + i) + 1;
            sum[0] += truth[at];
            sum[1] += bare[at];
            sum[2] += fluence[at];
            sum[3] += uncollided[at];
        }
        printf("z %d: %.3f %.3f (bare %.3f %.3f, scattered %.3f %.3f) ratio %.3f; ", z, sum[0], sum[2], sum[1], sum[3],
               sum[0] - sum[1], sum[2] - sum[3], sum[2] / sum[0]);
        double up = 0, n = 0;
        for (int i = 0; i < 64; ++i) {
            const double point[3] = {-0.875 + 0.25 * (i % 8), -0.875 + 0.25 * (i / 8), -0.875 + 0.25 * z};
            const float ways[6] = {0, 0, 1, 0, 0, -1};
            float radiance[6];
            must(context, ty_dom_radiance(light, point, ways, 2, radiance));
            up += (double)radiance[1];
            n += (double)radiance[4];
        }
        printf("up %.4f down %.4f\n", up / 64, n / 64);
    }
    ty_dom_destroy(light);
    ty_scene_destroy(scene);
}

static void fluences(void** state) {
    fluence_of(*state, "media[0].g=0");
    fluence_of(*state, "media[0].g=0.3");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(fluences)};
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
