/* A cube of Rayleigh, two-lobe and Mie scattering against brute-force references of the project's own: images, and the
 * fluxes through the faces. */
#include "truth_cases.h"

#include <tyndall/dom.h>

/* The references' noise on blocks, absolute: .0007, .0038 and .021 of means of .0265, .0114 and .0040. */
typedef struct phase_case {
    const char* name;
    double block_noise, tolerance; /* relative */
    int32_t spp;                   /* in full */
    double guide;                  /* mean cosine of the rays' directions about the beam */
    double flux[3];                /* through the bottom, the top and each side, W */
} phase_case;

static const phase_case cases[] = {
    {"phase_rayleigh", 0.003, 0.003, 1024, 0.0, {0.065764, 0.255679, 0.127009}},
    {"phase_two_lobe", 0.03, 0.005, 4096, 0.8, {0.321935, 0.079851, 0.105070}},
    {"phase_mie10", 0.15, 0.008, 8192, 0.95, {0.453324, 0.038622, 0.081806}},
};

enum { CASES = sizeof cases / sizeof cases[0] };

static bool has_reference(const phase_case* c) {
    char file[96], path[1024];
    snprintf(file, sizeof file, "reference/materials/%s.json", c->name);
    FILE* stream = fopen(data_path(file, path), "rb");
    if (stream != NULL) fclose(stream);
    if (stream == NULL) printf("skipped: there is no %s\n", path);
    return stream != NULL;
}

static void images_agree(void** state) {
    for (int i = 0; i < CASES; ++i) {
        char name[96];
        snprintf(name, sizeof name, "materials/%s", cases[i].name);
        if (!has_reference(&cases[i])) continue;
        check_reference_image(*state, name, ".own.exr", 64, cases[i].tolerance * (in_full() ? 1 : 5),
                              cases[i].block_noise, fewer(cases[i].spp, 16));
    }
}

static void fluxes_agree(void** state) {
    static const int faces[3] = {2, 3, 4}; /* -y, +y, -z */
    const int64_t count = in_full() ? 1 << 19 : 1 << 15;
    double* rays = new_numbers(6 * count);
    double* weights = new_numbers(count);
    double* radiance = new_numbers(3 * count);
    for (int i = 0; i < CASES; ++i) {
        char file[96], path[1024];
        if (!has_reference(&cases[i])) continue;
        snprintf(file, sizeof file, "reference/materials/%s.json", cases[i].name);
        ty_scene* scene = NULL;
        must(*state, ty_scene_load(*state, data_path(file, path), NULL, 0, &scene));
        for (int f = 0; f < 3; ++f) {
            for (int64_t n = 0; n < count; ++n) weights[n] = cube_ray(n, faces[f], cases[i].guide, rays + 6 * n);
            radiance_along(scene, count, rays, 16, 0, radiance, NULL);
            for (int64_t n = 0; n < count; ++n) weights[n] *= radiance[3 * n];
            snprintf(file, sizeof file, "%s, flux through face %d", cases[i].name, faces[f]);
            assert_close(file, estimate_of(weights, count, 1), cases[i].flux[f], in_full() ? 0.015 : 0.05);
        }
        ty_scene_destroy(scene);
    }
    free(rays);
    free(weights);
    free(radiance);
}

/* dom by the functions' Legendre moments: by powers of the mean cosine, its means are 1.006, 1.028 and 1.43. */
static void dom_takes_the_moments(void** state) {
    static const double expected[CASES] = {0.9995, 1.012, 1.057}, tolerance[CASES] = {0.004, 0.01, 0.02};
    for (int i = 0; i < CASES; ++i) {
        char file[96], path[1024];
        if (!has_reference(&cases[i])) continue;
        ty_scene* scene = NULL;
        ty_image *image = NULL, *reference = NULL;
        snprintf(file, sizeof file, "reference/materials/%s.json", cases[i].name);
        must(*state, ty_scene_load(*state, data_path(file, path), NULL, 0, &scene));
        snprintf(file, sizeof file, "reference/materials/%s.own.exr", cases[i].name);
        must(*state, ty_image_read(*state, data_path(file, path), &reference));
        ty_dom_def def = ty_default_dom_def();
        def.width = def.height = 64;
        must(*state, ty_dom_render(scene, &def, &image, NULL));
        ty_difference blocks;
        must(*state, ty_image_compare(*state, image, reference, BLOCK_SIDE, &blocks));
        printf("%-16s by dom: mean ratio %.4f, expected %.4f +- %.4f\n", cases[i].name, blocks.mean_ratio[3],
               expected[i], tolerance[i]);
        if (!(fabs(blocks.mean_ratio[3] - expected[i]) <= tolerance[i]))
            fail_msg("%s: mean ratio %g", cases[i].name, blocks.mean_ratio[3]);
        ty_image_destroy(image);
        ty_image_destroy(reference);
        ty_scene_destroy(scene);
    }
}

/* Overlapping media of droplets, of a table, and of lobes that differ per channel, which absorb nothing, vanish in
 * light that is the same from everywhere. */
static void media_vanish_in_a_furnace(void** state) {
    static const double cosines[3] = {1, 0, -1}, values[3] = {9, 1, 4};
    const float color[3] = {0.7f, 1, 0.4f};
    ty_scene* scene = new_scene(*state);
    ty_medium_def media[3] = {medium_cube(1, 3, 0, 0), medium_sphere(1.1, 2, 0, 0), medium_cube(0.7, 2, 0, 0)};
    for (int i = 0; i < 3; ++i) media[i].phase_count = 1;
    media[0].phase[0] = (ty_phase_lobe){.kind = TY_PHASE_MIE, .weight = {1, 1, 1}, .diameter = 10};
    media[1].phase[0] =
        (ty_phase_lobe){.kind = TY_PHASE_TABLE, .weight = {1, 1, 1}, .cosines = cosines, .values = values, .count = 3};
    media[2].phase_count = 2;
    media[2].phase[0] = (ty_phase_lobe){.kind = TY_PHASE_FOURNIER_FORAND, .weight = {1, 2, 3}, .backscatter = 0.0183};
    media[2].phase[1] = (ty_phase_lobe){.kind = TY_PHASE_DRAINE, .weight = {3, 2, 1}, .alpha = 1};
    for (int i = 0; i < 3; ++i) add_medium(scene, &media[i]);
    add_furnace_light(scene, color, true);
    set_camera(scene, 0, 0, 4, 40);
    commit(scene);
    assert_furnace("droplets, a table, water", scene, color, in_full() ? 64 : 24, 1024);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_agree),
        cmocka_unit_test(fluxes_agree),
        cmocka_unit_test(dom_takes_the_moments),
        cmocka_unit_test(media_vanish_in_a_furnace),
    };
    return cmocka_run_group_tests(tests, truth_start, truth_stop);
}
