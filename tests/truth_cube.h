/* Fig. 12 of principal-ordinates propagation: the unit cube in parallel light, and its fluence by path tracing. */
#ifndef TY_TESTS_TRUTH_CUBE_H
#define TY_TESTS_TRUTH_CUBE_H

#include "truth.h"
#include "uniform.h"

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

/* Where light comes to be after `length` more through the cube, from `at` along `way`; false: outside. */
static inline bool walk_on(double at[3], const double way[3], double length) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
        at[a] += length * way[a];
        inside = inside && at[a] >= 0 && at[a] < 1;
    }
    return inside;
}

/* Turns a way by a phase function of mean cosine g. */
static inline void turn(double way[3], double g, uint64_t* random) {
    const double between = (1 - g * g) / (1 - g + 2 * g * uniform(random));
    const double cosine = (1 + g * g - between * between) / (2 * g), sine = sqrt(fmax(0, 1 - cosine * cosine));
    const double angle = 2 * pi * uniform(random), a = sine * cos(angle), b = sine * sin(angle);
    const double x = way[0], y = way[1], z = way[2], flat = sqrt(fmax(1e-30, x * x + y * y));
    way[0] = cosine * x + (a * x * z - b * y) / flat;
    way[1] = cosine * y + (a * y * z + b * x) / flat;
    way[2] = cosine * z - a * flat;
}

/* Light that comes down on the cube, followed from collision to collision: where lobes are sharp, paths that end at
 * the sun would take too many. Every collision but the first counts for its cell. */
static inline void walk(double g, int64_t walks, uint64_t seed, double* fluence) {
    uint64_t random = seed;
    for (int64_t i = 0; i < walks; ++i) {
        double at[3] = {uniform(&random), 1, uniform(&random)}, way[3] = {0, -1, 0};
        bool first = true;
        while (walk_on(at, way, -log(1 - uniform(&random)) / 4)) {
            const int cell = (int)(at[0] * COARSE) + COARSE * ((int)(at[1] * COARSE) + COARSE * (int)(at[2] * COARSE));
            if (!first) fluence[3 * cell] += (double)CELLS / (4 * (double)walks);
            first = false;
            turn(way, g, &random);
        }
    }
}

static inline void trace(const ty_scene* scene, double g, truth* out) {
    double* runs[2] = {new_numbers(3 * CELLS), new_numbers(3 * CELLS)};
    double* uncollided = new_numbers(3 * CELLS);
    double sum = 0, square = 0;
    for (int run = 0; run < 2; ++run) {
        if (g > 0.9) {
            walk(g, fewer(20000000, 4), (uint64_t)run, runs[run]);
            continue;
        }
        ty_path_def def = ty_default_path_def();
        def.spp = fewer(512, 2);
        def.seed = (uint64_t)run;
        must(ty_scene_context(scene), ty_path_fluence(scene, &def, low, high, coarse, runs[run], uncollided, NULL));
    }
    for (int i = 0; i < CELLS; ++i) {
        const double y = (i / COARSE % COARSE + 0.5) / COARSE;
        out->uncollided[i] = exp(-4 * (1 - y)) * sinh(2.0 / COARSE) / (2.0 / COARSE);
        const double run[2] = {mirrored(runs[0], i), mirrored(runs[1], i)};
        out->scattered[i] = 0.5 * (run[0] + run[1]) - (g > 0.9 ? 0 : out->uncollided[i]);
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
