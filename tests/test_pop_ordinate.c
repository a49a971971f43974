/* Lights as principal ordinates. */
#include "files.h"
#include "method/pop/ordinate/ordinate.h"
#include "pop_maker.h"
#include "scene/media/phase.k.h"

#include <tyndall/io.h>

static const double pi = 3.14159265358979323846;
enum { DIRECTIONS = TY_POP_IMPORTANCE_WIDTH * TY_POP_IMPORTANCE_HEIGHT };

typedef struct found {
    ty_context* context;
    ty_discrete_light_set set;
} found;

static found find(ty_scene* scene, const ty_pop_def* def, const float* importance) {
    found out = {.context = ty_scene_context(scene)};
    ty_grid_box box;
    check_result(out.context, ty_scene_commit(scene));
    check_result(out.context, ty_grid_box_fit(scene, 16, &box));
    check_result(out.context, ty_pop_ordinates_create(scene, def, &box, importance, &out.set));
    return out;
}

static void forget(found* f, ty_scene* scene) {
    ty_discrete_light_set_destroy(f->context, &f->set);
    ty_scene_destroy(scene);
}

static void sum_colors(const found* f, double sum[3]) {
    for (int c = 0; c < 3; ++c) sum[c] = 0;
    for (int32_t i = 0; i < f->set.count; ++i)
        for (int c = 0; c < 3; ++c) sum[c] += (double)f->set.items[i].color[c];
}

static void add_light(ty_scene* scene, ty_light_kind kind, double x, double y, double z) {
    ty_light_def def = ty_default_light_def();
    def.kind = kind;
    set3(def.position, x, y, z);
    set3(def.u, 0, 0, 1);
    set3(def.v, 0.5, 0, 0);
    check_result(ty_scene_context(scene), ty_scene_add_light(scene, &def));
}

/* ---- lights ---- */

static void lights_by_kind(void** state) {
    ty_scene* scene = pop_fog(*state, 1, 0);
    ty_pop_def def = pop_def(8);
    def.fine_lights = false;
    direct_add_sun(scene, 0, -2, 0, 3);
    add_light(scene, TY_LIGHT_POINT, 0, 4, 0);
    add_light(scene, TY_LIGHT_SPOT, 0, 0, 4);
    add_light(scene, TY_LIGHT_AREA, 0, -3, 0);
    found f = find(scene, &def, NULL);
    assert_int_equal(f.set.count, 3 + 16);
    assert_int_equal(f.set.items[0].kind, TY_DISCRETE_DIRECTIONAL);
    assert_vec_close(f.set.items[0].direction, ty_vec_make(0, -1, 0), 1e-6);
    assert_close((double)f.set.items[0].color[1], 3, 1e-6);
    assert_close((double)f.set.items[0].mean_cosine, 1, 0);
    assert_int_equal(f.set.items[0].shadowed, 1); /* by the area light */
    assert_int_equal(f.set.items[1].profile, TY_PROFILE_ISOTROPIC);
    assert_int_equal(f.set.items[2].profile, TY_PROFILE_SPOT);
    assert_int_equal(f.set.items[2].light, 2);
    assert_true(f.set.items[1].min_distance > 0 && f.set.items[1].min_distance < 0.01f);
    double sum = 0;
    for (int i = 3; i < f.set.count; ++i) {
        assert_int_equal(f.set.items[i].profile, TY_PROFILE_COSINE);
        assert_vec_close(f.set.items[i].direction, ty_vec_make(0, 1, 0), 1e-6);
        assert_close((double)f.set.items[i].min_distance, sqrt(0.5 / 16 / pi), 1e-6);
        assert_true(f.set.items[i].position.y > -3 && f.set.items[i].position.y < -2.99f);
        assert_true(f.set.items[i].mean_cosine > 0.99f && f.set.items[i].mean_cosine < 1);
        sum += (double)f.set.items[i].color[0];
    }
    assert_close(sum, 0.5, 1e-6);
    forget(&f, scene);
}

static void fine_grid_lights_are_left_out(void** state) {
    ty_scene* scene = pop_fog(*state, 1, 0);
    ty_pop_def def = pop_def(8);
    for (int i = 0; i < 10; ++i) {
        if (i == 4) add_light(scene, TY_LIGHT_AREA, 0, -3, 0);
        add_light(scene, i % 2 == 0 ? TY_LIGHT_POINT : TY_LIGHT_DIRECTIONAL, i, 4, 0);
    }
    found f = find(scene, &def, NULL);
    assert_int_equal(f.set.count, 16 + 2); /* the ninth and tenth have no fine grid */
    for (int i = 0; i < 8; ++i) assert_true(ty_pop_uses_fine_grid(scene, &def, i));
    for (int i = 8; i < 11; ++i) assert_false(ty_pop_uses_fine_grid(scene, &def, i));
    def.mode = TY_POP_MODE_COLLIDED;
    assert_false(ty_pop_uses_fine_grid(scene, &def, 0));
    forget(&f, scene);
}

/* A triangle that glows on both sides is two point lights back to back, black lights none. */
static void two_sides_and_none(void** state) {
    static const float positions[9] = {0, 2, 0, 0, 2, 1, 1, 2, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    ty_scene* scene = pop_fog(*state, 1, 0);
    ty_mesh_def mesh = ty_default_mesh_def();
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    mesh.positions = positions;
    mesh.indices = indices;
    mesh.material.double_sided = true;
    set3f(mesh.material.emission, 1, 1, 1);
    check_result(*state, ty_scene_add_mesh(scene, &mesh));
    direct_add_sun(scene, 0, -2, 0, 0);
    ty_pop_def def = pop_def(8);
    def.fine_lights = false;
    found f = find(scene, &def, NULL);
    assert_int_equal(f.set.count, 2 * 4 * 16);
    double up = 0, down = 0;
    for (int i = 0; i < f.set.count; ++i) {
        const double color = (double)f.set.items[i].color[1];
        up += f.set.items[i].direction.y > 0 ? color : 0;
        down += f.set.items[i].direction.y < 0 ? color : 0;
    }
    assert_close(up, 0.5, 1e-5);
    assert_close(down, 0.5, 1e-5);
    forget(&f, scene);
}

/* ---- environments ---- */

static void even_environments(void** state) {
    static const int32_t counts[4] = {1, 8, 64, 216};
    for (int n = 0; n < 4; ++n) {
        ty_scene* scene = pop_fog(*state, 1, 0);
        const ty_pop_def def = pop_def(counts[n]);
        double sum[3], away[3] = {0, 0, 0}, cosine = 0;
        pop_add_environment(scene, 0, 0, NULL, 0);
        found f = find(scene, &def, NULL);
        assert_int_equal(f.set.count, counts[n]);
        sum_colors(&f, sum);
        for (int c = 0; c < 3; ++c) assert_close(sum[c], 4 * pi * (c + 1), 1e-4 * (c + 1));
        for (int32_t i = 0; i < f.set.count; ++i) {
            const double fraction = (double)f.set.items[i].color[0] / (4 * pi);
            const ty_vec direction = f.set.items[i].direction;
            assert_close((double)ty_dot(direction, direction), 1, 1e-5);
            away[0] += fraction * (double)(direction.x * f.set.items[i].mean_cosine);
            away[1] += fraction * (double)(direction.y * f.set.items[i].mean_cosine);
            away[2] += fraction * (double)(direction.z * f.set.items[i].mean_cosine);
            cosine += fraction * (double)f.set.items[i].mean_cosine;
            /* A cone of the same solid angle has the largest mean cosine there can be. */
            assert_true((double)f.set.items[i].mean_cosine <= 1 - fraction + 1e-3);
        }
        assert_true(fabs(away[0]) + fabs(away[1]) + fabs(away[2]) < 1e-3); /* no net flux */
        assert_true(cosine > 1 - 1.7 / counts[n] - 1e-3 || counts[n] == 1);
        forget(&f, scene);
    }
}

/* One texel that is brighter than all the rest together: it is one ordinate, and where it is. */
static void one_bright_texel(void** state) {
    enum { WIDTH = 64, HEIGHT = 32 };
    static float pixels[3 * WIDTH * HEIGHT];
    for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i) pixels[i] = 0.01f;
    const int column = 5, row = 9;
    for (int c = 0; c < 3; ++c) pixels[3 * (WIDTH * row + column) + c] = 5000;
    ty_scene* scene = pop_fog(*state, 1, 0);
    const ty_pop_def def = pop_def(64);
    double sum[3];
    pop_add_environment(scene, WIDTH, HEIGHT, pixels, 0);
    found f = find(scene, &def, NULL);
    assert_true(f.set.count <= 64 && f.set.count > 32);
    sum_colors(&f, sum);
    const double texel = 2 * pi / WIDTH * (cos(pi * row / HEIGHT) - cos(pi * (row + 1) / HEIGHT));
    const double total = 0.01 * (4 * pi - texel) + 5000 * texel;
    assert_close(sum[1] / total, 1, 1e-4);
    const double angle = 2 * pi * ((column + 0.5) / WIDTH - 0.5), down = pi * (row + 0.5) / HEIGHT;
    const ty_vec look = ty_vec_make((float)(sin(down) * cos(angle)), (float)cos(down), (float)(sin(down) * sin(angle)));
    double there = 0;
    for (int32_t i = 0; i < f.set.count; ++i)
        if (-ty_dot(look, f.set.items[i].direction) > 0.99f) there += (double)f.set.items[i].color[1];
    assert_close(there / total, 1, 0.01);
    forget(&f, scene);
}

/* In the dark but for one texel of a large map: one ordinate, with no width. */
static void a_sun_alone(void** state) {
    enum { WIDTH = 1024, HEIGHT = 512 };
    float* pixels = calloc(3 * WIDTH * HEIGHT, sizeof *pixels);
    assert_non_null(pixels);
    for (int c = 0; c < 3; ++c) pixels[3 * (WIDTH * 100 + 700) + c] = 1000;
    ty_scene* scene = pop_fog(*state, 1, 0);
    const ty_pop_def def = pop_def(64);
    pop_add_environment(scene, WIDTH, HEIGHT, pixels, 30);
    found f = find(scene, &def, NULL);
    assert_int_equal(f.set.count, 1);
    assert_true(f.set.items[0].mean_cosine > 0.99999f);
    const double texel = 2 * pi / WIDTH * (cos(pi * 100 / HEIGHT) - cos(pi * 101 / HEIGHT));
    assert_close((double)f.set.items[0].color[2] / (1000 * texel), 1, 1e-4);
    free(pixels);
    forget(&f, scene);
}

static void black_environments(void** state) {
    static const float pixels[3 * 2];
    ty_scene* scene = pop_fog(*state, 1, 0);
    const ty_pop_def def = pop_def(64);
    pop_add_environment(scene, 2, 1, pixels, 0);
    found f = find(scene, &def, NULL);
    assert_int_equal(f.set.count, 0);
    forget(&f, scene);
}

/* Irradiance on planes, by ordinates spread as prefiltering says and by the map itself. */
static void hdr_maps(void** state) {
    static const char* const names[3] = {"hdri/kiara_1_dawn_1k.hdr", "hdri/potsdamer_platz_1k.hdr",
                                         "hdri/st_fagans_interior_1k.hdr"};
    for (int n = 0; n < 3; ++n) {
        char path[1024];
        ty_image* image = NULL;
        check_result(*state, ty_image_read(*state, data_path(names[n], path), &image));
        ty_scene* scene = pop_fog(*state, 1, 0);
        ty_light_def light = ty_default_light_def();
        light.kind = TY_LIGHT_ENVIRONMENT;
        light.image = image;
        light.rotation = 75;
        check_result(*state, ty_scene_add_light(scene, &light));
        const ty_pop_def def = pop_def(64);
        found f = find(scene, &def, NULL);
        double sum[3], lost = 0;
        float mean[3];
        sum_colors(&f, sum);
        ty_scene_environment(scene, mean);
        for (int c = 0; c < 3; ++c) assert_close(sum[c] / (4 * pi * (double)mean[c]), 1, 1e-4);
        assert_int_equal(f.set.count, 64);
        for (int32_t i = 0; i < f.set.count; ++i)
            lost += (double)(f.set.items[i].color[1] * (1 - f.set.items[i].mean_cosine)) / sum[1];
        assert_true(lost < 1.7 / 64); /* less than an even sky's */
        ty_image_destroy(image);
        forget(&f, scene);
    }
}

static void rotation_and_up_turn_ordinates(void** state) {
    enum { WIDTH = 512, HEIGHT = 256 };
    float* pixels = malloc(3 * WIDTH * HEIGHT * sizeof *pixels);
    assert_non_null(pixels);
    uint64_t random = 7;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; ++i) pixels[i] = (float)uniform(&random);
    ty_scene* unrotated = pop_fog(*state, 1, 0);
    ty_scene* rotated = pop_fog(*state, 1, 0);
    const ty_pop_def def = pop_def(16);
    pop_add_environment(unrotated, WIDTH, HEIGHT, pixels, 0);
    pop_add_environment(rotated, WIDTH, HEIGHT, pixels, 90);
    found a = find(unrotated, &def, NULL), b = find(rotated, &def, NULL);
    assert_int_equal(a.set.count, b.set.count);
    for (int32_t i = 0; i < a.set.count; ++i) {
        const ty_vec d = a.set.items[i].direction; /* counter-clockwise from above: x goes to -z */
        assert_vec_close(b.set.items[i].direction, ty_vec_make(d.z, d.y, -d.x), 1e-4);
    }
    free(pixels);
    forget(&a, unrotated);
    forget(&b, rotated);
}

/* ---- importance ---- */

/* Four times as much on one side draws more ordinates there, and changes no total. */
static void importance_draws_ordinates(void** state) {
    float importance[DIRECTIONS];
    for (int i = 0; i < DIRECTIONS; ++i)
        importance[i] = i % TY_POP_IMPORTANCE_WIDTH < TY_POP_IMPORTANCE_WIDTH / 2 ? 1.8f : 0.2f;
    ty_scene* scene = pop_fog(*state, 1, 0);
    const ty_pop_def def = pop_def(64);
    pop_add_environment(scene, 0, 0, NULL, 0);
    found f = find(scene, &def, importance);
    int32_t important = 0;
    double sum[3];
    /* u < 1/2: behind -z, where one looks along -z. */
    for (int32_t i = 0; i < f.set.count; ++i) important += f.set.items[i].direction.z > 0;
    assert_true(important >= 42 && important <= 60);
    sum_colors(&f, sum);
    assert_close(sum[2], 4 * pi * 3, 1e-3);
    forget(&f, scene);
}

/* ---- what ordinates are for ---- */

enum { SKY_WIDTH = 256, SKY_HEIGHT = 128 };

static ty_vec look_at(double u, double v) {
    const double angle = 2 * pi * (u - 0.5), down = pi * v;
    return ty_vec_make((float)(sin(down) * cos(angle)), (float)cos(down), (float)(sin(down) * sin(angle)));
}

/* A dim sky with a dozen lights of all sizes and colors. */
static void paint_sky(float* pixels) {
    uint64_t random = 11;
    for (int i = 0; i < 3 * SKY_WIDTH * SKY_HEIGHT; ++i) pixels[i] = 0.2f;
    for (int light = 0; light < 12; ++light) {
        const ty_vec center = random_unit(&random);
        const double sharpness = exp(uniform_in(&random, 1, 6)), bright = sharpness * uniform_in(&random, 0.01, 0.1);
        for (int i = 0; i < SKY_WIDTH * SKY_HEIGHT; ++i) {
            const ty_vec look =
                look_at((i % SKY_WIDTH + 0.5) / SKY_WIDTH, ((double)(i / SKY_WIDTH) + 0.5) / SKY_HEIGHT);
            const double lobe = bright * exp(sharpness * ((double)ty_dot(look, center) - 1));
            for (int c = 0; c < 3; ++c) pixels[3 * i + c] += (float)(lobe * (c == light % 3 ? 1 : 0.5));
        }
    }
}

/* Light of the sky, green, scattered along `omega` with mean cosine g. */
static double scattered_by_sky(const float* pixels, ty_vec omega, float g) {
    double sum = 0;
    for (int i = 0; i < SKY_WIDTH * SKY_HEIGHT; ++i) {
        const int row = i / SKY_WIDTH;
        const double fraction = cos(pi * row / SKY_HEIGHT) - cos(pi * (row + 1) / SKY_HEIGHT);
        const ty_vec look = look_at((i % SKY_WIDTH + 0.5) / SKY_WIDTH, (row + 0.5) / SKY_HEIGHT);
        sum += fraction * (double)(pixels[3 * i + 1] * ty_hg(ty_dot(look, omega), g));
    }
    return sum * 2 * pi / SKY_WIDTH;
}

static double scattered_by(const found* f, ty_vec omega, float g) {
    double sum = 0;
    for (int32_t i = 0; i < f->set.count; ++i) {
        const ty_discrete_light* o = &f->set.items[i];
        sum += (double)(o->color[1] * ty_hg(-ty_dot(o->direction, omega), o->mean_cosine * g));
    }
    return sum;
}

/* Error, relative, of once scattered light over some view directions; important: whether each way's own phase function
 * is the importance. */
static double error_of(ty_context* context, const float* pixels, int32_t ordinates, double prefilter, bool important) {
    enum { WAYS = 16 };
    const float g = 0.8f;
    double square = 0;
    uint64_t random = 5;
    ty_scene* scene = pop_fog(context, 1, 0);
    ty_pop_def def = pop_def(ordinates);
    def.prefilter = prefilter;
    pop_add_environment(scene, SKY_WIDTH, SKY_HEIGHT, pixels, 0);
    for (int n = 0; n < WAYS; ++n) {
        const ty_vec omega = random_unit(&random);
        float importance[DIRECTIONS];
        for (int i = 0; i < DIRECTIONS; ++i)
            importance[i] =
                12.566f *
                ty_hg(ty_dot(omega, look_at((i % TY_POP_IMPORTANCE_WIDTH + 0.5) / TY_POP_IMPORTANCE_WIDTH,
                                            ((double)(i / TY_POP_IMPORTANCE_WIDTH) + 0.5) / TY_POP_IMPORTANCE_HEIGHT)),
                      g);
        found f = find(scene, &def, important ? importance : NULL);
        const double error = scattered_by(&f, omega, g) / scattered_by_sky(pixels, omega, g) - 1;
        square += error * error / WAYS;
        ty_discrete_light_set_destroy(context, &f.set);
    }
    ty_scene_destroy(scene);
    return sqrt(square);
}

/* More ordinates, importance and prefiltering each make once scattered light better. */
static void errors_of_scattered_light(void** state) {
    static float pixels[3 * SKY_WIDTH * SKY_HEIGHT];
    double plain[4], important[4];
    static const int32_t counts[4] = {8, 27, 64, 216};
    paint_sky(pixels);
    for (int n = 0; n < 4; ++n) {
        plain[n] = error_of(*state, pixels, counts[n], 1, false);
        important[n] = error_of(*state, pixels, counts[n], 1, true);
        assert_true(plain[n] < error_of(*state, pixels, counts[n], 0, false));
    }
    for (int n = 0; n < 4; ++n) {
        assert_true(important[n] < plain[n]);
        if (n > 0) assert_true(plain[n] < 0.8 * plain[n - 1] && important[n] < 0.8 * important[n - 1]);
    }
    assert_true(plain[2] < 0.15 && important[2] < 0.03);
}

static void seeds_and_threads(void** state) {
    (void)state;
    found f[3];
    ty_scene* scenes[3];
    ty_context* contexts[3];
    ty_pop_def def = pop_def(27);
    for (int i = 0; i < 3; ++i) {
        contexts[i] = make_context(i == 0 ? 1 : 2);
        scenes[i] = pop_fog(contexts[i], 1, 0);
        add_light(scenes[i], TY_LIGHT_AREA, 0, -3, 0);
        pop_add_environment(scenes[i], 0, 0, NULL, 0);
        def.seed = i == 2;
        f[i] = find(scenes[i], &def, NULL);
    }
    assert_int_equal(f[0].set.count, f[1].set.count);
    assert_memory_equal(f[0].set.items, f[1].set.items, (size_t)f[0].set.count * sizeof *f[0].set.items);
    assert_true(memcmp(f[0].set.items, f[2].set.items, (size_t)f[0].set.count * sizeof *f[0].set.items) != 0);
    for (int i = 0; i < 3; ++i) {
        forget(&f[i], scenes[i]);
        ty_context_destroy(contexts[i]);
    }
}

static ty_result create_ordinates(ty_context* context, void* scene) {
    const ty_pop_def def = pop_def(8);
    ty_grid_box box;
    ty_discrete_light_set set;
    check_result(context, ty_grid_box_fit(scene, 16, &box));
    const ty_result result = ty_pop_ordinates_create(scene, &def, &box, NULL, &set);
    ty_discrete_light_set_destroy(context, &set);
    return result;
}

static void no_memory(void** state) {
    (void)state;
    strict_memory memory = {.limit = SIZE_MAX, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = pop_fog(context, 1, 0);
    pop_add_environment(scene, 0, 0, NULL, 0);
    check_result(context, ty_scene_commit(scene));
    assert_true(check_short_memory(context, &memory, create_ordinates, scene) > 1);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

int main(void) {
#define on_context(f) cmocka_unit_test_setup_teardown(f, start_context, stop_context)
    const struct CMUnitTest tests[] = {
        on_context(lights_by_kind),
        on_context(fine_grid_lights_are_left_out),
        on_context(two_sides_and_none),
        on_context(even_environments),
        on_context(one_bright_texel),
        on_context(a_sun_alone),
        on_context(black_environments),
        on_context(hdr_maps),
        on_context(rotation_and_up_turn_ordinates),
        on_context(importance_draws_ordinates),
        on_context(errors_of_scattered_light),
        cmocka_unit_test(seeds_and_threads),
        cmocka_unit_test(no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
