/* Fig. 12 of principal-ordinates propagation: the unit cube in parallel light, and its fluence by path tracing. */
#ifndef TY_TESTS_TRUTH_CUBE_H
#define TY_TESTS_TRUTH_CUBE_H

#include "truth.h"

enum { COARSE = 16, CELLS = COARSE * COARSE * COARSE };

static const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
static const int32_t coarse[3] = {COARSE, COARSE, COARSE};

/* sigma_s = 4/m and no absorption; light of 1 W m^-2 comes down. */
static inline ty_scene* cube_in_light(ty_context* context, double g) {
    ty_scene* scene = new_scene(context);
    ty_medium_def medium = medium_cube(0.5, 4, 0, g);
    for (int a = 0; a < 3; ++a) {
        medium.box_min[a] = 0;
        medium.box_max[a] = 1;
    }
    add_medium(scene, &medium);
    ty_light_def sun = light_of(TY_LIGHT_DIRECTIONAL, 1);
    set3(sun.direction, 0, -1, 0);
    add_light(scene, &sun);
    commit(scene);
    return scene;
}

/* Scattered light alone, a channel of each cell. */
typedef struct truth {
    double scattered[CELLS], uncollided[CELLS], noise; /* noise: relative RMSE of scattered */
} truth;

/* The mean of a cell and its seven mirror images: light comes down along y. */
static inline double mirrored(const double* fluence, int cell) {
    const int x = cell % COARSE, y = cell / COARSE % COARSE, z = cell / (COARSE * COARSE), last = COARSE - 1;
    double sum = 0;
    for (int image = 0; image < 8; ++image) {
        const int a = (image & 1) != 0 ? last - x : x, b = (image & 2) != 0 ? last - z : z;
        const int u = (image & 4) != 0 ? b : a, w = (image & 4) != 0 ? a : b;
        sum += fluence[3 * (u + COARSE * (y + COARSE * w))];
    }
    return sum / 8;
}

static inline void trace(const ty_scene* scene, double g, truth* out) {
    const int32_t spp = g > 0.9 ? 512 : fewer(512, 2); /* sharp lobes are noise already */
    double* runs[2] = {new_numbers(3 * CELLS), new_numbers(3 * CELLS)};
    double* uncollided = new_numbers(3 * CELLS);
    double sum = 0, square = 0;
    for (int run = 0; run < 2; ++run) {
        ty_path_def def = ty_default_path_def();
        def.spp = spp;
        def.seed = (uint64_t)run;
        must(ty_scene_context(scene), ty_path_fluence(scene, &def, low, high, coarse, runs[run], uncollided, NULL));
    }
    for (int i = 0; i < CELLS; ++i) {
        const double y = (i / COARSE % COARSE + 0.5) / COARSE;
        out->uncollided[i] = exp(-4 * (1 - y)) * sinh(2.0 / COARSE) / (2.0 / COARSE);
        const double run[2] = {mirrored(runs[0], i), mirrored(runs[1], i)};
        out->scattered[i] = 0.5 * (run[0] + run[1]) - out->uncollided[i];
        sum += out->scattered[i];
        square += 0.25 * pow(run[0] - run[1], 2);
    }
    out->noise = sqrt(square / CELLS) / (sum / CELLS);
    free(runs[0]);
    free(runs[1]);
    free(uncollided);
}

typedef struct error {
    double mean_ratio, rmse; /* of scattered light; rmse relative, noise taken off */
} error;

/* The fluence of all light on those cells, 3 channels alike, against the truth. */
static inline error error_of(const double* fluence, const truth* expected) {
    double sum = 0, truth_sum = 0, square = 0;
    for (int i = 0; i < CELLS; ++i) {
        const double value = fluence[3 * i] - expected->uncollided[i];
        sum += value;
        truth_sum += expected->scattered[i];
        square += pow(value - expected->scattered[i], 2);
    }
    const double mean = truth_sum / CELLS;
    return (error){sum / truth_sum, sqrt(fmax(0, square / CELLS - pow(expected->noise * mean, 2))) / mean};
}

#endif
