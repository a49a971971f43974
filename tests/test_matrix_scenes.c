/* The covering set of scenes: all possible pairs of values, names of their own, and stored means of each. */
#include "checks.h"
#include "files.h"

#include "scenes/matrix.h"

static matrix_scene scenes[MATRIX_SCENES];

/* True if some scene has both values. */
static bool is_covered(int a, int32_t value_a, int b, int32_t value_b) {
    for (int i = 0; i < MATRIX_SCENES; ++i)
        if (scenes[i].values[a] == value_a && scenes[i].values[b] == value_b) return true;
    return false;
}

/* True if any possible scene has both values. */
static bool is_possible(int a, int32_t value_a, int b, int32_t value_b) {
    int32_t all = 1;
    for (int f = 0; f < MATRIX_FACTORS; ++f) all *= matrix_factors[f].count;
    for (int32_t i = 0; i < all; ++i) {
        matrix_scene scene;
        int32_t rest = i;
        for (int f = 0; f < MATRIX_FACTORS; rest /= matrix_factors[f++].count)
            scene.values[f] = rest % matrix_factors[f].count;
        if (scene.values[a] == value_a && scene.values[b] == value_b && matrix_is_possible(&scene)) return true;
    }
    return false;
}

static void every_possible_pair_is_covered(void** state) {
    (void)state;
    int32_t pairs = 0;
    for (int a = 0; a < MATRIX_FACTORS; ++a)
        for (int b = a + 1; b < MATRIX_FACTORS; ++b)
            for (int32_t v = 0; v < matrix_factors[a].count; ++v)
                for (int32_t w = 0; w < matrix_factors[b].count; ++w) {
                    if (!is_possible(a, v, b, w)) continue;
                    ++pairs;
                    if (!is_covered(a, v, b, w))
                        fail_msg("no scene has %s and %s", matrix_factors[a].values[v], matrix_factors[b].values[w]);
                }
    assert_in_range(pairs, 250, 350);
}

static void no_scene_is_impossible_or_there_twice(void** state) {
    (void)state;
    for (int i = 0; i < MATRIX_SCENES; ++i) {
        assert_true(matrix_is_possible(&scenes[i]));
        for (int k = 0; k < i; ++k) assert_memory_not_equal(&scenes[i], &scenes[k], sizeof scenes[i]);
    }
}

static void names_say_what_scenes_hold(void** state) {
    (void)state;
    char name[MATRIX_NAME_SIZE];
    const matrix_scene scene = {{MATRIX_AREA, MATRIX_ROOM, MATRIX_GRID, MATRIX_THIN, 1, 1}};
    matrix_name(&scene, name);
    assert_string_equal(name, "area_room_grid_thin_g0.5_a0.9");
}

/* Each name begins a line of the table of stored means. */
static void every_scene_has_stored_means(void** state) {
    (void)state;
    size_t size;
    char* text = (char*)get_file(TYNDALL_SOURCE_DIR "/tools/scenes/matrix_reference.txt", &size);
    for (int i = 0; i < MATRIX_SCENES; ++i) {
        char line[MATRIX_NAME_SIZE + 2] = "\n";
        matrix_name(&scenes[i], line + 1);
        strcat(line, " ");
        if (strstr(text, line) == NULL) fail_msg("no stored means of%s", line + 1);
    }
    free(text);
}

/* Scenes without a map, which the tool writes beside them, load. */
static void scenes_load(void** state) {
    ty_context* context = make_context(1);
    (void)state;
    for (int i = 0; i < MATRIX_SCENES; i += 9) {
        ty_scene* scene = NULL;
        if (scenes[i].values[MATRIX_LIGHT] >= MATRIX_MAP) continue;
        FILE* file = fopen("scene.json", "w");
        assert_non_null(file);
        matrix_print_scene(&scenes[i], file);
        fclose(file);
        assert_int_equal(ty_scene_load(context, "scene.json", NULL, 0, &scene), TY_OK);
        ty_scene_destroy(scene);
    }
    ty_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_possible_pair_is_covered),
        cmocka_unit_test(no_scene_is_impossible_or_there_twice),
        cmocka_unit_test(names_say_what_scenes_hold),
        cmocka_unit_test(every_scene_has_stored_means),
        cmocka_unit_test(scenes_load),
    };
    matrix_cover(scenes);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
