/* One hash per method and instruction set: the same for 1 to 32 threads, and the same as it was.
 *
 * Every method renders one small scene. Its hash must not depend on the number of threads on any machine. It must also
 * be the one in the tables below where they apply: sums are contracted to fused multiply-adds by the compiler's rules
 * and Embree picks its own kernels, so the tables hold for optimised builds by gcc 12 and by clang 14 on processors
 * with AVX-512, and elsewhere the hash is printed and only its independence of threads is checked. Without fused
 * multiply-adds, on x86-64 as such, both compilers agree to the bit in all methods but dom, whose sums they order
 * differently.
 *
 * When a change means to alter a method's results, run `build/release/bin/test_golden --update` and
 * `build/clang/bin/test_golden --update` on such a machine, paste the rows they print over those of the compiler's
 * table, and say in the commit why they changed. */
#include "base/isa.h"
#include "effort.h"
#include "fog.h"
#include "screen_maker.h"

#include <tyndall/bake.h>
#include <tyndall/dom.h>
#include <tyndall/fld.h>
#include <tyndall/lpv.h>
#include <tyndall/pop.h>

#include <stdio.h>

#ifdef __clang__
#define IS_OF_CLANG 1
#define IS_OF_KNOWN_COMPILER (__clang_major__ == 14)
#else
#define IS_OF_CLANG 0
#define IS_OF_KNOWN_COMPILER (__GNUC__ == 12)
#endif
#if IS_OF_KNOWN_COMPILER && defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TABLE_IS_OF_THIS_BUILD 1
#else
#define TABLE_IS_OF_THIS_BUILD 0
#endif

/* ---- the instruction set: test_golden is linked with --wrap=ty_best_isa ---- */

ty_isa __real_ty_best_isa(void);
ty_isa __wrap_ty_best_isa(void);

static ty_isa forced_isa;

ty_isa __wrap_ty_best_isa(void) {
    return forced_isa;
}

/* ---- hashes ---- */

/* FNV-1a, 64 bits. */
static uint64_t hash_bytes(uint64_t hash, const void* bytes, size_t size) {
    const unsigned char* at = bytes;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ at[i]) * 0x100000001b3u;
    return hash;
}

static const uint64_t hash_start = 0xcbf29ce484222325u;

static uint64_t hash_image(ty_image* image) {
    const size_t pixels = (size_t)ty_image_width(image) * (size_t)ty_image_height(image);
    uint64_t hash = hash_start;
    for (int32_t c = 0; c < ty_image_channel_count(image); ++c)
        hash = hash_bytes(hash, ty_image_plane_const(image, c), pixels * sizeof(float));
    ty_image_destroy(image);
    return hash;
}

static void must(ty_context* context, ty_result result) {
    if (result != TY_OK) fail_msg("%s: %s", ty_result_name(result), ty_take_error(context));
}

/* ---- the scene ---- */

enum { VOXELS = 8 };

/* Smoke of 8^3 voxels in a box of fog over a floor, under a sun and a point light; with `sky`, under a sky, too. */
static ty_scene* make_golden_scene(ty_context* context, bool sky) {
    static const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1}, inner[3] = {-0.6, -0.5, -0.6};
    static const double outer[3] = {0.7, 0.8, 0.5};
    float values[VOXELS * VOXELS * VOXELS];
    uint64_t seed = 7;
    for (int i = 0; i < VOXELS * VOXELS * VOXELS; ++i) values[i] = (float)uniform(&seed);
    ty_grid_def grid = ty_default_grid_def();
    grid.size[0] = grid.size[1] = grid.size[2] = VOXELS;
    grid.values = values;
    ty_medium_def fog = box_medium(lower, upper, 0.4f, 0.05f), smoke = box_medium(inner, outer, 3, 0.3f);
    set3f(fog.sigma_s, 0.3f, 0.4f, 0.5f);
    set3f(smoke.g, 0.6f, 0.6f, 0.6f);
    must(context, ty_grid_create(context, &grid, &smoke.density_grid));
    ty_shape_def floor = quad_shape((const double[3][3]){{-2, -1.05, -2}, {0, 0, 4}, {4, 0, 0}});
    set3f(floor.albedo, 0.7f, 0.5f, 0.3f);
    ty_light_def sun = ty_default_light_def(), lamp = sun, environment = sun;
    set3(sun.direction, -0.4, -1, -0.3);
    set3f(sun.color, 3, 2.8f, 2.5f);
    lamp.kind = TY_LIGHT_POINT;
    set3(lamp.position, 0.9, 0.3, 1.2);
    environment.kind = TY_LIGHT_ENVIRONMENT;
    set3f(environment.color, 0.3f, 0.4f, 0.6f);
    ty_camera_def camera = ty_default_camera_def();
    set3(camera.position, 0.4, 0.6, 4);
    camera.fov_y = 45;
    ty_scene* scene = make_scene(context);
    must(context, ty_scene_add_medium(scene, &fog));
    must(context, ty_scene_add_medium(scene, &smoke));
    must(context, ty_scene_add_shape(scene, &floor));
    must(context, ty_scene_add_light(scene, &sun));
    must(context, ty_scene_add_light(scene, &lamp));
    if (sky) must(context, ty_scene_add_light(scene, &environment));
    must(context, ty_scene_set_camera(scene, &camera));
    must(context, ty_scene_commit(scene));
    ty_grid_release(smoke.density_grid);
    return scene;
}

/* ---- the methods ---- */

static uint64_t hash_path(ty_context* context) {
    ty_scene* scene = make_golden_scene(context, true);
    ty_path_def def = small_def(8);
    ty_image* image = NULL;
    def.aovs = TY_AOV_VARIANCE | TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
    must(context, ty_path_render(scene, &def, &image, NULL));
    ty_scene_destroy(scene);
    return hash_image(image);
}

/* hash_NAME: an image by a method whose def begins as its default, then changes by assignments. */
#define DEFINE_HASH(method, sky, ...)                                                                                  \
    static uint64_t hash_##method(ty_context* context) {                                                               \
        ty_scene* scene = make_golden_scene(context, sky);                                                             \
        ty_##method##_def def = ty_default_##method##_def();                                                           \
        ty_image* image = NULL;                                                                                        \
        __VA_ARGS__;                                                                                                   \
        def.width = WIDTH;                                                                                             \
        def.height = HEIGHT;                                                                                           \
        def.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE;                                                                    \
        must(context, ty_##method##_render(scene, &def, &image, NULL));                                                \
        ty_scene_destroy(scene);                                                                                       \
        return hash_image(image);                                                                                      \
    }

DEFINE_HASH(fld, true, def.resolution = 16, def.environment_beams = 4)
DEFINE_HASH(pop, true, def.resolution = 8, def.ordinates = 4)
DEFINE_HASH(dom, true, def.resolution = 8, def.direct = 16, def.directions = 24, def.environment_beams = 4)
DEFINE_HASH(octaves, true, def.resolution = 16, def.environment_beams = 4)
DEFINE_HASH(lpv, false, def.resolution = 8, def.map_side = 32, def.shadow_side = 64, def.iterations = 4)

static uint64_t hash_screen(ty_context* context) {
    picture p = make_picture(61, 37, 0);
    fill_random(&p, 1, 60, 11);
    ty_screen_def def = ty_default_screen_def();
    set3f(def.sigma_s, 0.08f, 0.1f, 0.12f);
    set3f(def.sigma_a, 0.01f, 0.02f, 0.01f);
    set3f(def.g, 0.9f, 0.9f, 0.9f);
    def.focal[0] = def.focal[1] = ty_screen_focal(p.height, 40);
    const ty_screen_image image = image_of(&p);
    must(context, ty_screen_apply(context, &def, &image, NULL, 0, NULL));
    const uint64_t hash = hash_bytes(hash_start, p.out, 3 * (size_t)pixel_count(&p) * sizeof(float));
    free_picture(&p);
    return hash;
}

static uint64_t hash_bake(ty_context* context) {
    enum { RECEIVERS = 6 };
    ty_scene* scene = make_golden_scene(context, true);
    ty_bake_receiver receivers[RECEIVERS] = {{{0}, {0}, {0}, 0}};
    static ty_bake_light light[RECEIVERS];
    ty_bake_def def = ty_default_bake_def();
    def.spp = 32;
    def.cells = 6;
    def.cell_paths = 8;
    for (int i = 0; i < RECEIVERS; ++i) {
        receivers[i].position[0] = -1 + 0.4f * (float)i;
        receivers[i].position[1] = -1.05f;
        receivers[i].position[2] = 0.3f * (float)(i % 3) - 0.3f;
        receivers[i].normal[1] = receivers[i].face[1] = 1;
        receivers[i].margin = 1e-4f;
    }
    must(context, ty_bake_surfaces(scene, &def, receivers, RECEIVERS, light, NULL));
    uint64_t hash = hash_start;
    for (int i = 0; i < RECEIVERS; ++i) {
        hash = hash_bytes(hash, light[i].irradiance, sizeof light[i].irradiance);
        hash = hash_bytes(hash, light[i].vector_irradiance, sizeof light[i].vector_irradiance);
    }
    ty_scene_destroy(scene);
    return hash;
}

typedef struct golden {
    const char* method;
    uint64_t (*hash)(ty_context* context);
    uint64_t expected[TY_ISA_COUNT]; /* x86-64, -v3, -v4; by gcc 12 */
} golden;

static const golden table[] = {
    {"path", hash_path, {0x3501547bd5d0ac53, 0xd1da618d25197ecd, 0xd1da618d25197ecd}},
    {"screen", hash_screen, {0x8f6b85b66741a6dd, 0x4762fb6f13246ca6, 0x3bb1bdcb3ddf4f6c}},
    {"fld", hash_fld, {0x4b44b8f42e90c67e, 0x95e29f350653b6d3, 0x95e29f350653b6d3}},
    {"pop", hash_pop, {0x6e62bad9a2177e4a, 0xb47f6037b8c399f6, 0xb47f6037b8c399f6}},
    {"dom", hash_dom, {0xc4053a5b9ba16f68, 0x30e1be7a54b8f305, 0xf0af78e77eadaf34}},
    {"octaves", hash_octaves, {0x091b156b140d26b7, 0x8fbe43713367fea8, 0x8fbe43713367fea8}},
    {"lpv", hash_lpv, {0x618843f82242a5c5, 0x27562524636cbac2, 0x27562524636cbac2}},
    {"bake", hash_bake, {0xe9c6909a97e6b588, 0xec255e4d04eb780a, 0xec255e4d04eb780a}},
};

enum { METHODS = sizeof table / sizeof table[0] };

/* The same by clang 14. */
static const uint64_t expected_of_clang[METHODS][TY_ISA_COUNT] = {
    {0x3501547bd5d0ac53, 0xb7344b775ad04179, 0xb7344b775ad04179}, /* path */
    {0x8f6b85b66741a6dd, 0x521a95b60736ce68, 0x521a95b60736ce68}, /* screen */
    {0x4b44b8f42e90c67e, 0x77724c81fdbf607d, 0x77724c81fdbf607d}, /* fld */
    {0x6e62bad9a2177e4a, 0x419930dfcb3c51a3, 0x3f97b6a93b52d601}, /* pop */
    {0x2a907262df766cef, 0x1df4bf45dd05cb14, 0x9b00e888d19aaa0e}, /* dom */
    {0x091b156b140d26b7, 0xe4926e8c8bfbbd30, 0xe4926e8c8bfbbd30}, /* octaves */
    {0x618843f82242a5c5, 0x1090f85873b2c1df, 0x5c5900c3723b7f1c}, /* lpv */
    {0xe9c6909a97e6b588, 0xaf18462a4856df28, 0xaf18462a4856df28}, /* bake */
};

static uint64_t expected_hash(const golden* g, ty_isa isa) {
    return IS_OF_CLANG ? expected_of_clang[g - table][isa] : g->expected[isa];
}

/* ---- the test ---- */

static uint64_t hash_with(const golden* g, int32_t threads) {
    ty_context* context = make_context(threads);
    const uint64_t hash = g->hash(context);
    ty_context_destroy(context);
    return hash;
}

/* Every thread count gives the hash of one thread, and that is the expected one where the table applies. */
static bool check_method(const golden* g, ty_isa isa) {
    static const int32_t threads[] = {3, 2, 8, 32};
    const size_t counts = UNDER_THREAD_SANITIZER ? 1 : sizeof threads / sizeof *threads;
    forced_isa = isa;
    const uint64_t hash = hash_with(g, 1);
    bool same = true;
    for (size_t i = 0; i < counts; ++i) {
        const uint64_t other = hash_with(g, threads[i]);
        if (other != hash)
            printf("%s, %s: 0x%016llx by %d threads, 0x%016llx by one\n", g->method, ty_isa_name(isa),
                   (unsigned long long)other, (int)threads[i], (unsigned long long)hash);
        same = same && other == hash;
    }
    const bool known = TABLE_IS_OF_THIS_BUILD && __real_ty_best_isa() == TY_ISA_V4;
    if (!known || hash != expected_hash(g, isa))
        printf("%s, %s: 0x%016llx%s\n", g->method, ty_isa_name(isa), (unsigned long long)hash,
               known ? " is not the expected hash" : " (the table is of another build or machine)");
    return same && (!known || hash == expected_hash(g, isa));
}

/* Builds with sanitizers have kernels of one instruction set alone. */
static int least_isa(void) {
    return UNDER_THREAD_SANITIZER ? (int)__real_ty_best_isa() : 0;
}

static void results_depend_neither_on_threads_nor_on_time(void** state) {
    (void)state;
    skip_under_address_sanitizer();
    bool right = true;
    for (int m = 0; m < METHODS; ++m)
        for (int isa = least_isa(); isa <= (int)__real_ty_best_isa(); ++isa)
            right = check_method(&table[m], (ty_isa)isa) && right;
    assert_true(right);
}

/* A hash that no difference could change would prove nothing. */
static void another_pixel_makes_another_hash(void** state) {
    forced_isa = __real_ty_best_isa();
    ty_image* images[2];
    for (int i = 0; i < 2; ++i) {
        must(*state, ty_image_create_rgb(*state, WIDTH, HEIGHT, &images[i]));
        ty_image_plane(images[i], 2)[PIXELS - 1] = i == 0 ? 1 : nextafterf(1, 2);
    }
    const uint64_t first = hash_image(images[0]);
    assert_true(first != hash_image(images[1]));
}

static int print_table(void) {
    for (int m = 0; m < METHODS; ++m) {
        if (IS_OF_CLANG)
            printf("    {");
        else
            printf("    {\"%s\", hash_%s, {", table[m].method, table[m].method);
        for (int isa = 0; isa <= (int)__real_ty_best_isa(); ++isa) {
            forced_isa = (ty_isa)isa;
            printf("%s0x%016llx", isa == 0 ? "" : ", ", (unsigned long long)hash_with(&table[m], 1));
        }
        if (IS_OF_CLANG)
            printf("}, /* %s */\n", table[m].method);
        else
            printf("}},\n");
    }
    return 0;
}

int main(int argc, char** argv) {
    if (argc == 2 && strcmp(argv[1], "--update") == 0) return print_table();
    const struct CMUnitTest tests[] = {cmocka_unit_test(another_pixel_makes_another_hash),
                                       cmocka_unit_test(results_depend_neither_on_threads_nor_on_time)};
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
