/* Experiments of more than one truth test: slabs, cubes, images of other renderers, white furnaces. */
#ifndef TY_TESTS_TRUTH_CASES_H
#define TY_TESTS_TRUTH_CASES_H

#include "truth.h"

/* ---- a slab: van de Hulst 1980 ---- */

typedef struct slab_result {
    estimate reflectance, transmittance; /* diffuse reflectance, total transmittance */
} slab_result;

/* Light of irradiance 1 falls along +z on a slab 0.2 mm thick, which is wider than it is thick by 500. */
static inline slab_result measure_slab(ty_context* context, int64_t rays_per_face, int32_t spp) {
    const double thick = 0.0002, wide = 0.1, narrow = 0.02;
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = medium_of(9000, 1000, 0.75);
    medium.bounds = TY_BOUNDS_BOX;
    set3(medium.box_min, -wide / 2, -wide / 2, 0);
    set3(medium.box_max, wide / 2, wide / 2, thick);
    add_medium(scene, &medium);
    ty_light_def light = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(light.direction, 0, 0, 1);
    add_light(scene, &light);
    commit(scene);
    const double front[3] = {-narrow / 2, -narrow / 2, 0}, back[3] = {-narrow / 2, -narrow / 2, thick};
    const double x[3] = {narrow, 0, 0}, y[3] = {0, narrow, 0};
    double* rays = new_numbers(12 * rays_per_face);
    double* radiance = new_numbers(6 * rays_per_face);
    for (int64_t i = 0; i < rays_per_face; ++i) {
        face_ray(i, front, x, y, thick / 10, rays + 6 * i);
        face_ray(i, back, y, x, thick / 10, rays + 6 * (rays_per_face + i));
    }
    radiance_along(scene, 2 * rays_per_face, rays, spp, 0, radiance, NULL);
    slab_result result = {estimate_of(radiance, rays_per_face, 3),
                          estimate_of(radiance + 3 * rays_per_face, rays_per_face, 3)};
    result.reflectance = (estimate){pi * result.reflectance.mean, pi * result.reflectance.error};
    result.transmittance =
        (estimate){pi * result.transmittance.mean + exp(-10000 * thick), pi * result.transmittance.error};
    free(rays);
    free(radiance);
    ty_scene_destroy(scene);
    return result;
}

/* ---- a cube that absorbs nothing ---- */

/* A ray into the unit cube from the n-th point of a face, along the beam's way back or cosine-distributed, half and
 * half; returns the face's power per radiance seen, which is 0 where the ray does not enter. */
static inline double cube_ray(int64_t n, int face, double g, double ray[6]) {
    const int normal = face / 2, upper = face % 2, first = (normal + 1) % 3, second = (normal + 2) % 3;
    const double inwards = upper ? -1 : 1;
    double x[4], way[3];
    even_point(n, x);
    const bool beam = x[3] < 0.5;
    const double turn = 2 * pi * fmod(2 * x[3], 1), s = (1 - g * g) / (1 + g - 2 * g * x[2]);
    const double mu = !beam ? sqrt(1 - x[2]) : g > 0 ? (1 + g * g - s * s) / (2 * g) : 1 - 2 * x[2];
    const double side = sqrt(fmax(0, 1 - mu * mu));
    const int axis = beam ? 1 : normal;
    way[axis] = beam ? mu : inwards * mu;
    way[(axis + 1) % 3] = side * cos(turn);
    way[(axis + 2) % 3] = side * sin(turn);
    ray[normal] = upper ? 0.5 : -0.5;
    ray[first] = x[0] - 0.5;
    ray[second] = x[1] - 0.5;
    for (int a = 0; a < 3; ++a) {
        ray[3 + a] = way[a];
        ray[a] -= 0.01 * way[a];
    }
    const double cosine = inwards * way[normal];
    return cosine > 0 ? cosine / (0.5 * cosine / pi + 0.5 * henyey_greenstein(way[1], g)) : 0;
}

/* The unit cube of sigma_s 4/m gets 1 W from a beam that covers its top: all the power that leaves it, which is the
 * beam's own remainder and what all six faces radiate. Nearly all the noise at high g is on the face the beam leaves
 * by, so that gets eight times the rays. */
static inline estimate measure_cube_energy(ty_context* context, double g, int64_t rays_per_face, int32_t spp) {
    ty_scene* scene = new_scene(context);
    const ty_medium_def medium = medium_cube(0.5, 4, 0, g);
    add_medium(scene, &medium);
    const ty_light_def light = light_of(TY_LIGHT_DIRECTIONAL, 1);
    add_light(scene, &light);
    commit(scene);
    double* rays = new_numbers(48 * rays_per_face);
    double* weights = new_numbers(8 * rays_per_face);
    double* radiance = new_numbers(24 * rays_per_face);
    estimate sum = {exp(-4), 0};
    for (int face = 0; face < 6; ++face) {
        const int64_t count = face == 2 && g > 0.9 ? 8 * rays_per_face : rays_per_face;
        for (int64_t i = 0; i < count; ++i) weights[i] = cube_ray(i, face, g * g, rays + 6 * i);
        radiance_along(scene, count, rays, spp, 0, radiance, NULL);
        for (int64_t i = 0; i < count; ++i) weights[i] *= radiance[3 * i];
        const estimate power = estimate_of(weights, count, 1);
        sum.mean += power.mean;
        sum.error = hypot(sum.error, power.error);
    }
    free(rays);
    free(weights);
    free(radiance);
    ty_scene_destroy(scene);
    return sum;
}

/* ---- images made by other renderers ---- */

/* The mean of one of the reference images, "NAME" + ending, to tolerance, and, where block_noise is not 0, blocks of
 * 8 x 8 pixels within that noise of the reference and our own. */
static inline void check_reference_image(ty_context* context, const char* name, const char* ending, int32_t side,
                                         double tolerance, double block_noise, int32_t spp) {
    char file[64], path[1024], image_path[1024];
    snprintf(file, sizeof file, "reference/%s.json", name);
    data_path(file, path);
    snprintf(file, sizeof file, "reference/%s%s", name, ending);
    data_path(file, image_path);
    ty_scene* scene = NULL;
    ty_image* reference = NULL;
    must(context, ty_scene_load(context, path, NULL, 0, &scene));
    must(context, ty_image_read(context, image_path, &reference));
    ty_image* image = render(scene, side, spp, 3);
    ty_difference blocks;
    must(context, ty_image_compare(context, image, reference, BLOCK_SIDE, &blocks));
    double variance = 0, mean = 0;
    for (int c = 0; c < 3; ++c) {
        const estimate of_channel = image_mean(image, c);
        mean += of_channel.mean / 3;
        variance += of_channel.error * of_channel.error / 3;
    }
    /* The image's mean has the variance of a block's mean over the number of blocks. */
    const double error = sqrt(variance) / mean, noise = error * ((double)side / BLOCK_SIDE);
    printf("%-12s mean ratio %.5f +- %.5f of %.3f; blocks: relative RMSE %.4f, our noise %.4f, theirs %.4f\n", name,
           blocks.mean_ratio[3], error, tolerance, blocks.relative_rmse[3], noise, block_noise);
    assert_int_equal(blocks.not_finite, 0);
    if (!(fabs(blocks.mean_ratio[3] - 1) <= tolerance)) fail_msg("%s: mean ratio %g", name, blocks.mean_ratio[3]);
    if (block_noise > 0 && !(blocks.relative_rmse[3] <= hypot(noise, block_noise)))
        fail_msg("%s: blocks differ by %g", name, blocks.relative_rmse[3]);
    ty_image_destroy(image);
    ty_image_destroy(reference);
    ty_scene_destroy(scene);
}

static inline void check_reference(ty_context* context, const char* name, double tolerance, double block_noise,
                                   int32_t spp) {
    check_reference_image(context, name, ".exr", 256, tolerance, block_noise, spp);
}

/* ---- white furnace ---- */

typedef enum furnace_body { FURNACE_BOX, FURNACE_SPHERE, FURNACE_PLUME, FURNACE_MANY } furnace_body;

/* A medium that absorbs nothing, about two units wide about the origin, whose camera sees it and what is around. */
static inline void add_furnace_body(ty_scene* scene, furnace_body body, double g) {
    ty_medium_def medium = body == FURNACE_SPHERE ? medium_sphere(1, 5, 0, g) : medium_cube(1, 3, 0, g);
    if (body == FURNACE_PLUME) {
        char path[1024];
        must(ty_scene_context(scene),
             ty_vdb_read(ty_scene_context(scene), data_path("volumes/plume/plume_0042.vdb", path), "density",
                         &medium.density_grid));
        medium.bounds = TY_BOUNDS_NONE;
        static const double translate[3] = {-1, -1, -2}, rotate[3] = {0, 0, 0}, size[3] = {1, 1, 1};
        medium.transform = ty_affine_compose(translate, rotate, size);
        medium.scale = 10;
    }
    add_medium(scene, &medium);
    ty_grid_release(medium.density_grid);
    if (body != FURNACE_MANY) return;
    /* Two more that overlap: of other colours, turned, one of them uneven. */
    static const double translate[3] = {0.5, 0.2, 0}, rotate[3] = {20, 30, 40}, size[3] = {1, 0.7, 1};
    ty_medium_def ball = medium_sphere(1, 1, 0, g);
    rgb(ball.sigma_s, 0.5, 2, 6);
    rgb(ball.g, g, -0.3, 0.6);
    ball.transform = ty_affine_compose(translate, rotate, size);
    add_medium(scene, &ball);
    ty_medium_def cloud = medium_cube(0.9, 1, 0, g);
    rgb(cloud.sigma_s, 12, 6, 3);
    cloud.transform = ball.transform;
    ty_noise_def noise = ty_default_noise_def();
    noise.size[0] = noise.size[1] = noise.size[2] = 32;
    must(ty_scene_context(scene), ty_grid_create_noise(ty_scene_context(scene), &noise, &cloud.density_grid));
    add_medium(scene, &cloud);
    ty_grid_release(cloud.density_grid);
}

/* The same light from everywhere: as one colour, or as a map of that colour, which lights are then sampled from. */
static inline void add_furnace_light(ty_scene* scene, const float color[3], bool map) {
    ty_light_def light = light_of(TY_LIGHT_ENVIRONMENT, 1);
    ty_image* image = NULL;
    if (map) {
        must(ty_scene_context(scene), ty_image_create_rgb(ty_scene_context(scene), 32, 16, &image));
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 32 * 16; ++i) ty_image_plane(image, c)[i] = color[c] / 4;
        light.image = image;
        light.scale = 4;
        light.rotation = 77;
    } else {
        memcpy(light.color, color, sizeof light.color);
    }
    add_light(scene, &light);
    ty_image_destroy(image);
}

/* Every pixel shows the environment: the mean to 0.3%, single ones within five standard errors. */
static inline void assert_furnace(const char* name, const ty_scene* scene, const float color[3], int32_t side,
                                  int32_t spp) {
    ty_image* image = render(scene, side, spp, 7);
    assert_finite(image);
    for (int c = 0; c < 3; ++c) {
        const estimate mean = image_mean(image, c);
        const double expected = (double)color[c], tiny = 1e-4 * expected;
        double worst = 0;
        for (int32_t i = 0; i < side * side; ++i) {
            const double off = fabs((double)ty_image_plane_const(image, c)[i] - expected);
            worst = fmax(worst, fmax(0, off - tiny) / (sqrt((double)ty_image_plane_const(image, c + 3)[i]) + 1e-30));
        }
        printf("%-36s %c: %+.4f%% +- %.4f%% of 0.30%%, worst pixel %.2f standard errors\n", name, "RGB"[c],
               100 * (mean.mean / expected - 1), 100 * mean.error / expected, worst);
        if (!(fabs(mean.mean / expected - 1) <= 0.003)) fail_msg("%s: the mean is %g", name, mean.mean);
        if (!(worst <= 5)) fail_msg("%s: a pixel is %g standard errors off", name, worst);
    }
    ty_image_destroy(image);
}

#endif
