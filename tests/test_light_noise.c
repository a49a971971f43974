/* Noise of one light's sample as an estimate of the sum of all, when the tree of lights picks it and when its power
 * does. */
#include "light_maker.h"
#include "scene/bsdf/bsdf.k.h"
#include "scene/bsdf/tables.h"

#include <stdio.h>

typedef struct noise {
    double tree, power, dark; /* relative variances, and the share of draws that find nothing */
} noise;

/* Relative variance of one light's sample of the fluence (or irradiance) at random points, by tree and by power. */
static noise measure_noise(const ty_light_tree* tree, int32_t count, double half, bool surfaces, uint64_t* random) {
    enum { POINTS = 200 };
    noise out = {0, 0, 0};
    double power = 0;
    for (int32_t i = 0; i < count; ++i) power += (double)bounds[i].power;
    for (int point = 0; point < POINTS; ++point) {
        const ty_vec from = random_point(random, half);
        const ty_vec normal = surfaces ? random_unit(random) : ty_vec_make(0, 0, 0);
        double sum = 0, by_tree = 0, by_power = 0, found = 0;
        for (int32_t i = 0; i < count; ++i) {
            ty_light_sample sample;
            const double p = (double)ty_light_tree_probability(tree->nodes, tree->trails, i, from, normal, NULL);
            found += p;
            if (!light_sent(&views[i], from, 1.0f / 3, 1.0f / 3, &sample)) continue;
            double light = (double)sample.radiance[0];
            if (surfaces) light *= fmax(0, (double)ty_dot(sample.wi, normal));
            if (!(light > 0)) continue;
            sum += light;
            by_tree += light * light / p;
            by_power += light * light * power / (double)bounds[i].power;
        }
        if (!(sum > 0)) continue;
        out.tree += (by_tree / (sum * sum) - 1) / POINTS;
        out.power += (by_power / (sum * sum) - 1) / POINTS;
        out.dark += (1 - found) / POINTS;
    }
    return out;
}

/* The light that a point light sends to a stretch of a ray: intensity times the angle it sees it under, over distance.
 */
static double light_along(const ty_light_view* light, ty_vec origin, ty_vec direction, double leave) {
    const ty_vec to = ty_sub(light->position, origin), across = ty_cross(to, direction);
    const double nearest = (double)ty_dot(to, direction), off = sqrt((double)ty_dot(across, across));
    return (double)light->color[0] * (atan((leave - nearest) / off) + atan(nearest / off)) / off;
}

/* The same for light that lamps send to random rays. */
static noise measure_ray_noise(const ty_light_tree* tree, int32_t count, double half, uint64_t* random) {
    enum { RAYS = 200, RAY_DRAWS = 4096 };
    noise out = {0, 0, 0};
    double power = 0;
    for (int32_t i = 0; i < count; ++i) power += (double)bounds[i].power;
    for (int ray = 0; ray < RAYS; ++ray) {
        const ty_vec origin = random_point(random, half), direction = random_unit(random);
        const float leave = (float)half;
        double sum = 0, by_tree = 0, by_power = 0;
        for (int32_t i = 0; i < count; ++i) {
            const double light = light_along(&views[i], origin, direction, (double)leave);
            sum += light;
            by_power += light * light * power / (double)bounds[i].power;
        }
        for (int i = 0; i < RAY_DRAWS; ++i) {
            float u = ((float)i + 0.5f) / RAY_DRAWS, p;
            const int32_t light = ty_light_tree_sample_ray(tree->nodes, origin, direction, 0, leave, &u, &p);
            assert_true(light >= 0);
            const double value = light_along(&views[light], origin, direction, (double)leave) / (double)p;
            by_tree += value * value / RAY_DRAWS;
        }
        out.tree += (by_tree / (sum * sum) - 1) / RAYS;
        out.power += (by_power / (sum * sum) - 1) / RAYS;
    }
    return out;
}

typedef enum receiver { IN_MEDIUM, ON_SURFACE, ALONG_RAY } receiver;

static void check_noise(const char* name, const ty_light_tree* tree, int32_t count, double half, receiver where,
                        double least) {
    uint64_t random = 10;
    const noise n = where == ALONG_RAY ? measure_ray_noise(tree, count, half, &random)
                                       : measure_noise(tree, count, half, where == ON_SURFACE, &random);
    printf("%-48s relative variance %8.3f by the tree, %9.3f by power: 1/%.0f; %.3f dark\n", name, n.tree, n.power,
           n.power / n.tree, n.dark);
    if (!(n.power / n.tree > least)) fail_msg("%s: %g is not %g times as noisy as %g", name, n.power, least, n.tree);
}

/* A room of lamps; then rooms lit by panels and spots, which face all ways. */
static void trees_are_less_noisy_than_power(void** state) {
    uint64_t random = 9;
    for (int i = 0; i < 100; ++i) views[i] = random_lamp(&random, 3);
    ty_light_tree* tree = tree_of(*state, 100);
    check_noise("100 point lights, media", tree, 100, 3, IN_MEDIUM, 12);
    check_noise("100 point lights, rays", tree, 100, 3, ALONG_RAY, 10);
    check_noise("100 point lights, surfaces", tree, 100, 3, ON_SURFACE, 8);
    ty_light_tree_destroy(*state, tree);
    for (int i = 0; i < 1000; ++i) views[i] = random_lamp(&random, 10);
    tree = tree_of(*state, 1000);
    check_noise("1000 point lights, media", tree, 1000, 10, IN_MEDIUM, 25);
    check_noise("1000 point lights, rays", tree, 1000, 10, ALONG_RAY, 20);
    ty_light_tree_destroy(*state, tree);
    for (int i = 0; i < 1000; ++i) {
        views[i] = random_light(&random, i % 2 ? TY_KIND_AREA : TY_KIND_SPOT, 10);
        if (views[i].kind == TY_KIND_AREA) {
            views[i].u = ty_scale(views[i].u, 0.1f);
            views[i].v = ty_scale(views[i].v, 0.1f);
            views[i].area *= 0.01f;
        }
    }
    tree = tree_of(*state, 1000);
    check_noise("1000 spots and panels, media", tree, 1000, 10, IN_MEDIUM, 2);
    check_noise("1000 spots and panels, surfaces", tree, 1000, 10, ON_SURFACE, 10);
    ty_light_tree_destroy(*state, tree);
}

static ty_vec on_ball(double turn, double height) {
    const double radius = sqrt(fmax(0, 1 - height * height)), angle = 6.283185307179586 * turn;
    return ty_vec_make((float)(radius * cos(angle)), (float)height, (float)(radius * sin(angle)));
}

/* A ball of glowing triangles, of which any point sees but a part. */
static void glowing_meshes_are_less_noisy(void** state) {
    enum { ROWS = 50, COLUMNS = 100, COUNT = 2 * ROWS * COLUMNS };
    for (int i = 0; i < COUNT; ++i) {
        const int row = i / 2 / COLUMNS + i % 2, column = i / 2 % COLUMNS + i % 2, side = i % 2 ? -1 : 1;
        const ty_vec at = on_ball((double)column / COLUMNS, 2.0 * row / ROWS - 1);
        views[i] = lamp_at(at, 1);
        views[i].kind = TY_KIND_TRIANGLE;
        views[i].u = ty_sub(on_ball((double)column / COLUMNS, 2.0 * (row + side) / ROWS - 1), at);
        views[i].v = ty_sub(on_ball((double)(column + side) / COLUMNS, 2.0 * row / ROWS - 1), at);
        const ty_vec cross = ty_cross(views[i].u, views[i].v);
        const float length = sqrtf(ty_dot(cross, cross));
        views[i].area = 0.5f * length;
        views[i].direction = length > 0 ? ty_scale(cross, 1 / length) : at;
    }
    ty_light_tree* tree = tree_of(*state, COUNT);
    check_noise("10000 triangles of a ball, media", tree, COUNT, 4, IN_MEDIUM, 6);
    check_noise("10000 triangles of a ball, surfaces", tree, COUNT, 4, ON_SURFACE, 5);
    ty_light_tree_destroy(*state, tree);
}

/* The same where glossy surfaces reflect the light of 1000 lamps: relative variances of a lamp's sample by the tree
 * with the lobe about the mirror direction, and without it. */
static void measure_gloss_noise(const ty_light_tree* tree, int32_t count, const ty_bsdf_parameters* material,
                                double* with_lobe, double* without) {
    enum { POINTS = 200 };
    uint64_t random = 5;
    *with_lobe = *without = 0;
    for (int point = 0; point < POINTS; ++point) {
        const ty_vec from = random_point(&random, 1), normal = random_unit(&random);
        ty_vec wo = random_unit(&random);
        if (ty_dot(wo, normal) < 0) wo = ty_scale(wo, -1);
        ty_bsdf b;
        ty_bsdf_prepare(&b, material, &ty_bsdf_default_tables, normal, normal, wo);
        const ty_light_lobe lobe = {.axis = ty_mad(ty_scale(wo, -1), normal, 2 * ty_dot(wo, normal)),
                                    .alpha2 = b.alpha * b.alpha,
                                    .weight = b.probability[TY_LOBE_SPECULAR]};
        double sum = 0, by_lobe = 0, by_cosine = 0, found = 0;
        for (int32_t i = 0; i < count; ++i) {
            ty_light_sample sample;
            float factor[3];
            const double p = (double)ty_light_tree_probability(tree->nodes, tree->trails, i, from, normal, &lobe);
            const double q = (double)ty_light_tree_probability(tree->nodes, tree->trails, i, from, normal, NULL);
            found += p;
            if (!light_sent(&views[i], from, 0.5f, 0.5f, &sample) || !(ty_bsdf_evaluate(&b, sample.wi, factor) > 0))
                continue;
            const double light = (double)(sample.radiance[0] * factor[0]);
            assert_true(p > 0 && q > 0);
            sum += light;
            by_lobe += light * light / p;
            by_cosine += light * light / q;
        }
        assert_true(found < 1 + 1e-4);
        *with_lobe += (by_lobe / (sum * sum) - 1) / POINTS;
        *without += (by_cosine / (sum * sum) - 1) / POINTS;
    }
}

static void gloss_guides_the_choice_of_lights(void** state) {
    /* Measured gains: 8.5, 5.7, 4.8, 1.0. */
    static const struct {
        float metallic, roughness;
        double gain;
    } cases[] = {{1, 0.1f, 6}, {1, 0.3f, 4}, {0, 0.3f, 3.5}, {1, 0.8f, 0.9}};
    enum { COUNT = 1000 };
    uint64_t random = 11;
    for (int32_t i = 0; i < COUNT; ++i) views[i] = random_lamp(&random, 3);
    ty_light_tree* tree = tree_of(*state, COUNT);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const ty_bsdf_parameters material = {.base_color = {0.5f, 0.5f, 0.5f},
                                             .metallic = cases[i].metallic,
                                             .roughness = cases[i].roughness,
                                             .ior = 1.5f,
                                             .specular = 1,
                                             .specular_color = {1, 1, 1}};
        double with_lobe, without;
        measure_gloss_noise(tree, COUNT, &material, &with_lobe, &without);
        printf("1000 lamps, metallic %g, roughness %g: variance %.2f with the lobe, %.2f without\n",
               (double)cases[i].metallic, (double)cases[i].roughness, with_lobe, without);
        assert_true(with_lobe * cases[i].gain < without);
    }
    ty_light_tree_destroy(*state, tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_are_less_noisy_than_power),
        cmocka_unit_test(glowing_meshes_are_less_noisy),
        cmocka_unit_test(gloss_guides_the_choice_of_lights),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
