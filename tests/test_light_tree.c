/* The tree of lights: its probabilities are those of its samples, and no light that can be seen is left out. */
#include "base/context.h"
#include "effort.h"
#include "light_maker.h"

#include <stdio.h>

enum { DRAWS = 100000 };

/* The steps from a node to the farthest light below it; every light must be there once. */
static int depth_of(const ty_light_tree* tree, int32_t node, int* seen) {
    const ty_light_node* n = &tree->nodes[node];
    if (n->next < 0) {
        ++seen[~n->next];
        return 0;
    }
    const int first = depth_of(tree, node + 1, seen), second = depth_of(tree, n->next, seen);
    return 1 + (first > second ? first : second);
}

static int check_structure(const ty_light_tree* tree) {
    int* seen = calloc(tree->light_count, sizeof *seen);
    assert_non_null(seen);
    const int depth = depth_of(tree, 0, seen);
    for (size_t i = 0; i < tree->light_count; ++i) assert_int_equal(seen[i], bounds[i].power > 0);
    free(seen);
    assert_true(depth <= TY_LIGHT_TREE_DEPTH);
    return depth;
}

static void bounds_are_the_light_s(void** state) {
    (void)state;
    ty_light_bounds b;
    ty_light_view view = lamp_at(ty_vec_make(1, 2, 3), 6);
    view.color[1] = 0;
    assert_true(ty_light_get_bounds(&view, &b));
    assert_vec_close(b.lower, view.position, 0);
    assert_vec_close(b.upper, view.position, 0);
    assert_close(b.power, 4, 1e-6);
    assert_true(b.cos_o == -1 && b.is_local == 1);
    view.kind = TY_KIND_SPOT;
    view.direction = ty_vec_make(0, 1, 0);
    view.cos_inner = (float)cos(0.3);
    view.cos_outer = (float)cos(0.8);
    assert_true(ty_light_get_bounds(&view, &b));
    assert_close(b.cos_o, cos(0.3), 1e-6);
    assert_close(b.cos_e, cos(0.5), 1e-6);
    view.kind = TY_KIND_SPHERE;
    view.radius = 0.5f;
    assert_true(ty_light_get_bounds(&view, &b));
    assert_vec_close(b.upper, ty_vec_make(1.5f, 2.5f, 3.5f), 1e-6);
    assert_close(b.power, 4 * 3.14159265 * 0.25, 1e-5);
    assert_int_equal(b.is_local, 0);
    view.kind = TY_KIND_TRIANGLE;
    view.u = ty_vec_make(0, 0, 2);
    view.v = ty_vec_make(2, 0, 0);
    view.area = 2;
    assert_true(ty_light_get_bounds(&view, &b));
    assert_vec_close(b.upper, ty_vec_make(3, 2, 5), 0);
    assert_close(b.power, 8, 1e-5);
    assert_true(b.cos_o == 1 && b.cos_e == 0 && b.is_local == 1);
    view.two_sided = 1;
    assert_true(ty_light_get_bounds(&view, &b) && b.cos_o == -1);
    view.kind = TY_KIND_DIRECTIONAL;
    assert_false(ty_light_get_bounds(&view, &b));
    view.kind = TY_KIND_ENVIRONMENT;
    assert_false(ty_light_get_bounds(&view, &b));
    view = lamp_at(ty_vec_make(0, 0, 0), 0);
    assert_false(ty_light_get_bounds(&view, &b));
    assert_true(b.power == 0);
}

static void no_light_and_one_light(void** state) {
    const ty_vec zero = {0, 0, 0}, from = {1, 2, 3}, x = {1, 0, 0};
    float u = 0.25f, probability = 1;
    ty_light_tree* tree = tree_of(*state, 0);
    assert_null(tree->nodes);
    assert_int_equal(ty_light_tree_sample(tree->nodes, from, zero, NULL, &u, &probability), -1);
    assert_int_equal(ty_light_tree_sample_ray(tree->nodes, from, x, 0, 1, &u, &probability), -1);
    assert_true(probability == 0);
    ty_light_tree_destroy(*state, tree);
    views[0] = (ty_light_view){.kind = TY_KIND_DIRECTIONAL, .color = {1, 1, 1}};
    views[1] = lamp_at(ty_vec_make(0, 1, 0), 5);
    tree = tree_of(*state, 2);
    assert_int_equal(ty_light_tree_sample(tree->nodes, from, zero, NULL, &u, &probability), 1);
    assert_true(probability == 1 && u == 0.25f);
    assert_true(ty_light_tree_probability(tree->nodes, tree->trails, 1, from, zero, NULL) == 1);
    assert_true(ty_light_tree_probability(tree->nodes, tree->trails, 0, from, zero, NULL) == 0);
    assert_int_equal(ty_light_tree_sample_ray(tree->nodes, from, x, 0, 1, &u, &probability), 1);
    assert_int_equal(ty_light_tree_sample_ray(tree->nodes, from, x, 1, 1, &u, &probability), -1);
    ty_light_tree_destroy(*state, tree);
}

/* Draws by many u: how often each light comes is its probability, which is what probability() says to the bit. */
static void check_draws(const ty_light_tree* tree, ty_vec from, ty_vec normal, bool reached) {
    static int64_t hits[LIGHTS_MAX];
    const int32_t count = (int32_t)tree->light_count;
    double sum = 0, chi = 0, cells = 0, rest = DRAWS;
    int64_t lost = 0;
    memset(hits, 0, sizeof hits);
    for (int i = 0; i < DRAWS; ++i) {
        float u = ((float)i + 0.5f) / DRAWS, probability;
        const int32_t light = ty_light_tree_sample(tree->nodes, from, normal, NULL, &u, &probability);
        assert_true(u >= 0 && u < 1);
        if (light < 0) {
            assert_true(probability == 0);
            ++lost;
            continue;
        }
        ++hits[light];
        const float again = ty_light_tree_probability(tree->nodes, tree->trails, light, from, normal, NULL);
        assert_true(memcmp(&again, &probability, sizeof again) == 0);
    }
    for (int32_t i = 0; i < count; ++i) {
        const double p = (double)ty_light_tree_probability(tree->nodes, tree->trails, i, from, normal, NULL);
        const double expected = p * DRAWS, off = (double)hits[i] - expected;
        sum += p;
        if (expected < 10) continue;
        chi += off * off / expected;
        cells += 1;
        rest -= expected;
    }
    assert_close(sum, 1 - (double)lost / DRAWS, reached ? 2e-5 : 1e-3);
    if (reached) assert_int_equal(lost, 0);
    /* Draws are evenly spread: they scatter less than random ones. */
    if (chi > cells + 3 * sqrt(2 * cells) + 1) fail_msg("chi-square %g of %g lights, %g draws left", chi, cells, rest);
}

static void draws_match_probabilities(void** state) {
    uint64_t random = 3;
    static const size_t counts[] = {2, 3, 7, 40, 1000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c)
        for (int32_t kinds = 1; kinds <= 5; kinds += 2) {
            ty_light_tree* tree = random_tree(*state, &random, counts[c], kinds, 3);
            check_structure(tree);
            for (int i = 0; i < (in_full() ? 6 : 2); ++i) {
                const bool surface = i % 2 == 1;
                const ty_vec normal = surface ? random_unit(&random) : ty_vec_make(0, 0, 0);
                check_draws(tree, random_point(&random, 4), normal, !surface && kinds <= 2);
            }
            ty_light_tree_destroy(*state, tree);
        }
}

/* Random numbers are used up and stretched back: what is left of them is even, too. */
static void numbers_are_stretched_back(void** state) {
    uint64_t random = 4;
    ty_light_tree* tree = random_tree(*state, &random, 8, 2, 1);
    double sum = 0, square = 0;
    for (int i = 0; i < DRAWS; ++i) {
        float u = (float)uniform(&random), probability;
        u = ty_minf(u, 0x1.fffffep-1f);
        ty_light_tree_sample(tree->nodes, ty_vec_make(3, 1, 2), ty_vec_make(0, 0, 0), NULL, &u, &probability);
        sum += (double)u;
        square += (double)u * (double)u;
    }
    assert_close(sum / DRAWS, 0.5, 4.5 * sqrt(1.0 / 12 / DRAWS));
    assert_close(square / DRAWS, 1.0 / 3, 4.5 * sqrt(4.0 / 45 / DRAWS));
    ty_light_tree_destroy(*state, tree);
}

/* True if a light sends anything to a point, on a surface unless normal is 0: some points of the light tell. */
static bool contributes(const ty_light_view* light, ty_vec from, ty_vec normal, uint64_t* random) {
    for (int i = 0; i < 8; ++i) {
        ty_light_sample sample;
        const float u = (float)uniform(random) * 0.999f, v = (float)uniform(random) * 0.999f;
        if (!light_sent(light, from, u, v, &sample)) continue;
        if (ty_dot(normal, normal) > 0 && ty_dot(normal, sample.wi) <= 0) continue;
        return true;
    }
    return false;
}

static void no_light_that_contributes_is_left_out(void** state) {
    uint64_t random = 5;
    int64_t lit = 0, spared = 0;
    for (int scene = 0; scene < 60; ++scene) {
        const size_t count = (size_t)(1 + 200 * uniform(&random));
        ty_light_tree* tree = random_tree(*state, &random, count, 5, scene % 2 == 0 ? 1 : 20);
        for (int i = 0; i < 100; ++i) {
            const ty_vec from = random_point(&random, scene % 3 == 0 ? 1 : 30);
            const ty_vec normal = i % 2 == 0 ? ty_vec_make(0, 0, 0) : random_unit(&random);
            for (size_t light = 0; light < count; ++light) {
                const float p =
                    ty_light_tree_probability(tree->nodes, tree->trails, (int32_t)light, from, normal, NULL);
                const bool lights = contributes(&views[light], from, normal, &random);
                lit += lights;
                spared += !lights && p == 0;
                if (lights && !(p > 0)) fail_msg("scene %d: light %d of kind %d", scene, (int)light, views[light].kind);
            }
        }
        ty_light_tree_destroy(*state, tree);
    }
    printf("%lld times a light was seen, %lld times one was known not to be\n", (long long)lit, (long long)spared);
    assert_true(lit > 100000 && spared > 100000);
}

/* Points at the very edge of what lights reach: in their planes, at the horizon, at the rim of spots. */
static void grazing_lights_are_not_left_out(void** state) {
    uint64_t random = 6;
    for (int scene = 0; scene < 300; ++scene) {
        ty_light_tree* tree = random_tree(*state, &random, 20, 5, 2);
        for (size_t light = 0; light < 20; ++light) {
            const ty_light_view* view = &views[light];
            const ty_vec axis = view->direction;
            const float mu = view->kind == TY_KIND_SPOT ? view->cos_outer : 0;
            const ty_vec way = ty_direction_about(axis, ty_minf(mu + 1e-5f, 1), (float)uniform(&random));
            const ty_vec from = ty_mad(view->position, way, (float)pow(10, uniform_in(&random, -1, 2)));
            const ty_vec to = ty_normalize(ty_sub(view->position, from));
            const ty_vec normal = ty_normalize(ty_mad(ty_direction_about(to, 0, (float)uniform(&random)), to, 1e-5f));
            for (int side = 0; side < 2; ++side) {
                const ty_vec n = side == 0 ? ty_vec_make(0, 0, 0) : normal;
                const float p = ty_light_tree_probability(tree->nodes, tree->trails, (int32_t)light, from, n, NULL);
                assert_true(p > 0 || !contributes(view, from, n, &random));
            }
        }
        ty_light_tree_destroy(*state, tree);
    }
}

/* Every light of the same place, of no extent, in rows whose steps double, and of powers far apart. */
static void awkward_lights(void** state) {
    uint64_t random = 7;
    const ty_vec zero = {0, 0, 0}, here = {1, 1, 1};
    for (int i = 0; i < 100; ++i) views[i] = random_light(&random, i % 2 ? TY_KIND_POINT : TY_KIND_SPOT, 0);
    ty_light_tree* tree = tree_of(*state, 100);
    check_structure(tree);
    check_draws(tree, zero, zero, true);
    check_draws(tree, here, zero, false);
    ty_light_tree_destroy(*state, tree);
    for (int i = 0; i < 200; ++i) {
        const float place = ldexpf(1, i - 120);
        views[i] = lamp_at(ty_vec_make(ty_minf(place, 1e9f), i % 2 ? place * 1e-3f : 0, 0), ldexpf(1, -(i % 100)));
    }
    tree = tree_of(*state, 200);
    const int depth = check_structure(tree);
    check_draws(tree, here, zero, true);
    check_draws(tree, ty_vec_make(-1e9f, 1e9f, 5), ty_vec_make(1, 0, 0), false);
    assert_true(depth > 7);
    ty_light_tree_destroy(*state, tree);
}

static void rays_pick_lamps_only(void** state) {
    uint64_t random = 8;
    ty_light_tree* tree = random_tree(*state, &random, 200, 5, 3);
    for (int ray = 0; ray < 20; ++ray) {
        static double chances[200];
        static int64_t hits[200];
        const ty_vec origin = random_point(&random, 4), direction = random_unit(&random);
        const float enter = (float)uniform_in(&random, 0, 2), leave = ray % 5 ? enter + 3 : TY_FLOAT_MAX;
        double sum = 0, chi = 0, cells = 0;
        memset(chances, 0, sizeof chances);
        memset(hits, 0, sizeof hits);
        for (int i = 0; i < DRAWS; ++i) {
            float u = ((float)i + 0.5f) / DRAWS, probability;
            const int32_t light =
                ty_light_tree_sample_ray(tree->nodes, origin, direction, enter, leave, &u, &probability);
            assert_true(light >= 0 && views[light].kind != TY_KIND_SPHERE && probability > 0);
            assert_true(chances[light] == 0 || chances[light] == (double)probability);
            const float again =
                ty_light_tree_ray_probability(tree->nodes, tree->trails, light, origin, direction, enter, leave);
            assert_true(memcmp(&again, &probability, sizeof again) == 0);
            chances[light] = (double)probability;
            ++hits[light];
        }
        for (int i = 0; i < 200; ++i) {
            const double expected = chances[i] * DRAWS, off = (double)hits[i] - expected;
            sum += chances[i];
            if (expected < 10) continue;
            chi += off * off / expected;
            cells += 1;
        }
        assert_close(sum, 1, 2e-3); /* lights that never came are missing */
        assert_true(chi <= cells + 3 * sqrt(2 * cells) + 1);
    }
    ty_light_tree_destroy(*state, tree);
}

typedef struct scarce {
    int64_t bytes; /* handed out */
    int left;      /* allocations that succeed */
} scarce;

static void* scarce_alloc(void* user, size_t size) {
    scarce* memory = user;
    if (memory->left-- <= 0) return NULL;
    memory->bytes += (int64_t)size;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void scarce_free(void* user, void* pointer, size_t size) {
    if (pointer != NULL) ((scarce*)user)->bytes -= (int64_t)size;
    free(pointer);
}

static void failed_allocations_are_reported(void** state) {
    (void)state;
    scarce memory = {0, 1};
    ty_context_def def = ty_default_context_def();
    def.alloc = scarce_alloc;
    def.free = scarce_free;
    def.alloc_user = &memory;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    const int64_t before = memory.bytes;
    for (int i = 0; i < 10; ++i) {
        views[i] = lamp_at(ty_vec_make((float)i, 0, 0), 1);
        ty_light_get_bounds(&views[i], &bounds[i]);
    }
    for (int enough = 0;; ++enough) {
        ty_light_tree* tree = NULL;
        memory.left = enough;
        const ty_result result = ty_light_tree_create(context, bounds, 10, &tree);
        ty_light_tree_destroy(context, tree);
        assert_true(memory.bytes == before);
        if (result == TY_OK) break;
        assert_int_equal(result, TY_ERROR_MEMORY);
        assert_null(tree);
        assert_true(enough < 5);
    }
    ty_context_destroy(context);
}

static void many_lights_build_fast(void** state) {
    uint64_t random = 11;
    ty_light_tree* tree = random_tree(*state, &random, LIGHTS_MAX, 5, 100);
    ty_light_tree_destroy(*state, tree);
    const double begin = ty_cpu_seconds();
    assert_int_equal(ty_light_tree_create(*state, bounds, LIGHTS_MAX, &tree), TY_OK);
    const double seconds = ty_cpu_seconds() - begin;
    const int depth = check_structure(tree);
    double sum = 0;
    const double drawing = ty_cpu_seconds();
    for (int i = 0; i < DRAWS; ++i) {
        float u = (float)i / DRAWS, probability;
        ty_light_tree_sample(tree->nodes, views[i].v, ty_vec_make(0, 0, 0), NULL, &u, &probability);
        sum += (double)probability;
    }
    printf("%d lights: built in %.3f s, %d steps deep, %zu bytes, %.0f ns a draw\n", LIGHTS_MAX, seconds, depth,
           ty_light_tree_bytes(tree), (ty_cpu_seconds() - drawing) / DRAWS * 1e9);
    assert_true(sum > 0 && seconds < 10);
    ty_light_tree_destroy(*state, tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_are_the_light_s),
        cmocka_unit_test(no_light_and_one_light),
        cmocka_unit_test(draws_match_probabilities),
        cmocka_unit_test(numbers_are_stretched_back),
        cmocka_unit_test(no_light_that_contributes_is_left_out),
        cmocka_unit_test(grazing_lights_are_not_left_out),
        cmocka_unit_test(awkward_lights),
        cmocka_unit_test(rays_pick_lamps_only),
        cmocka_unit_test(failed_allocations_are_reported),
        cmocka_unit_test(many_lights_build_fast),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
