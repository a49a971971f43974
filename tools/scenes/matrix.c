/* The covering set of scenes: greedy choice of scenes by the pairs and triples of values that they add. */
#include "scenes/matrix.h"

#include <string.h>

const matrix_factor_words matrix_factors[MATRIX_FACTORS] = {
    [MATRIX_LIGHT] = {"light", {"directional", "point", "spot", "area", "mesh", "constant", "map", "sky"}, 8},
    [MATRIX_SURROUNDINGS] = {"surroundings", {"open", "room", "terrain", "level"}, 4},
    [MATRIX_MEDIUM] = {"medium", {"homogeneous", "grid", "several", "emissive"}, 4},
    [MATRIX_THICKNESS] = {"thickness", {"clear", "thin", "moderate", "dense", "opaque"}, 5},
    [MATRIX_G] = {"g", {"g0", "g0.5", "g0.9", "g0.96"}, 4},
    [MATRIX_ALBEDO] = {"albedo", {"a0.5", "a0.9", "a1"}, 3},
};

enum { ALBEDO_ONE = 2 };

/* Combinations of values that the scenes so far have. */
typedef struct covered {
    bool pairs[MATRIX_FACTORS][MATRIX_FACTORS][MATRIX_VALUES_MAX][MATRIX_VALUES_MAX];
    bool triples[MATRIX_FACTORS][MATRIX_FACTORS][MATRIX_FACTORS][MATRIX_VALUES_MAX][MATRIX_VALUES_MAX]
                [MATRIX_VALUES_MAX];
} covered;

bool matrix_is_possible(const matrix_scene* scene) {
    const int32_t* values = scene->values;
    if (values[MATRIX_MEDIUM] == MATRIX_EMISSIVE && values[MATRIX_ALBEDO] == ALBEDO_ONE) return false;
    if (values[MATRIX_THICKNESS] != MATRIX_CLEAR) return true;
    /* Without a medium there is something to see of surfaces alone, and one kind is enough. */
    return values[MATRIX_SURROUNDINGS] != MATRIX_OPEN && values[MATRIX_MEDIUM] == MATRIX_HOMOGENEOUS &&
           values[MATRIX_G] == 0 && values[MATRIX_ALBEDO] == ALBEDO_ONE;
}

/* New pairs count more than all triples of a scene. */
static int32_t count_new(const covered* so_far, const int32_t values[MATRIX_FACTORS]) {
    int32_t pairs = 0, triples = 0;
    for (int a = 0; a < MATRIX_FACTORS; ++a)
        for (int b = a + 1; b < MATRIX_FACTORS; ++b) {
            pairs += !so_far->pairs[a][b][values[a]][values[b]];
            for (int c = b + 1; c < MATRIX_FACTORS; ++c)
                triples += !so_far->triples[a][b][c][values[a]][values[b]][values[c]];
        }
    return 100 * pairs + triples;
}

static void add(covered* so_far, const int32_t values[MATRIX_FACTORS]) {
    for (int a = 0; a < MATRIX_FACTORS; ++a)
        for (int b = a + 1; b < MATRIX_FACTORS; ++b) {
            so_far->pairs[a][b][values[a]][values[b]] = true;
            for (int c = b + 1; c < MATRIX_FACTORS; ++c)
                so_far->triples[a][b][c][values[a]][values[b]][values[c]] = true;
        }
}

/* The scene of a number below the product of all counts. */
static matrix_scene scene_at(int32_t number) {
    matrix_scene scene;
    for (int f = 0; f < MATRIX_FACTORS; ++f) {
        scene.values[f] = number % matrix_factors[f].count;
        number /= matrix_factors[f].count;
    }
    return scene;
}

static matrix_scene find_next(const covered* so_far) {
    enum { STRIDE = 1009 }; /* prime to the number of scenes, so that ties are not all of the first values */
    int32_t all = 1, best_count = -1;
    matrix_scene best = {{0}};
    for (int f = 0; f < MATRIX_FACTORS; ++f) all *= matrix_factors[f].count;
    for (int32_t i = 0; i < all; ++i) {
        const matrix_scene scene = scene_at((int32_t)((int64_t)i * STRIDE % all));
        const int32_t added = matrix_is_possible(&scene) ? count_new(so_far, scene.values) : -1;
        if (added <= best_count) continue;
        best_count = added;
        best = scene;
    }
    return best;
}

void matrix_cover(matrix_scene scenes[MATRIX_SCENES]) {
    covered so_far;
    memset(&so_far, 0, sizeof so_far);
    for (int i = 0; i < MATRIX_SCENES; ++i) {
        scenes[i] = find_next(&so_far);
        add(&so_far, scenes[i].values);
    }
}

void matrix_name(const matrix_scene* scene, char out[MATRIX_NAME_SIZE]) {
    int used = 0;
    for (int f = 0; f < MATRIX_FACTORS; ++f)
        used += snprintf(out + used, (size_t)(MATRIX_NAME_SIZE - used), "%s%s", f > 0 ? "_" : "",
                         matrix_factors[f].values[scene->values[f]]);
}
