/* Gradients by adjoint solves against central differences of the solves themselves, by fld and by dom. */
#ifndef TY_TESTS_GRADIENT_MAKER_H
#define TY_TESTS_GRADIENT_MAKER_H

#include "fog.h"

enum { SIDE = 5, CELLS = SIDE * SIDE * SIDE, VOXELS_SIDE = 14, VOXELS = VOXELS_SIDE * VOXELS_SIDE * VOXELS_SIDE };

/* Relative error of a derivative; at most 4.1e-5 is measured, by the single precision of the fluences that are
 * subtracted. */
static const double TOLERANCE = 1e-4;

/* A scene by its parameters, so that each of them can be moved. */
typedef struct parameters {
    double sigma_s[3], sigma_a[3], g[3], sun, sky; /* sun, sky: factors of the lights */
    double lamps;                                  /* of two points and a spot; 0: without them */
    float* voxels;                                 /* NULL: a box without */
    ty_fld_def def;
    ty_dom_def dom;
    bool by_dom; /* else by fld */
} parameters;

static inline parameters gray(void) {
    parameters p = {.sigma_s = {3, 3, 3}, .sigma_a = {0.3, 0.3, 0.3}, .g = {0.4, 0.4, 0.4}, .sun = 1, .sky = 1};
    p.def = ty_default_fld_def();
    p.def.resolution = 16;
    p.def.environment_beams = 12;
    p.def.tolerance = 1e-7;
    p.dom = ty_default_dom_def();
    p.dom.direct = 16;
    p.dom.resolution = 12;
    p.dom.directions = 24;
    p.dom.environment_beams = 12;
    p.dom.tolerance = 2e-7;
    p.dom.differentiable = true;
    return p;
}

static inline parameters colored(void) {
    parameters p = gray();
    set3(p.sigma_s, 1, 3, 6);
    set3(p.sigma_a, 0.5, 0.2, 0.1);
    set3(p.g, 0, 0.3, 0.7);
    return p;
}

/* A point within the media, a spot and a point outside of them. */
static inline void add_lamps(ty_scene* scene, double factor) {
    ty_light_def point = ty_default_light_def(), spot = point, outside = point;
    point.kind = TY_LIGHT_POINT;
    set3(point.position, 0.31, 0.12, 0.07);
    spot.kind = TY_LIGHT_SPOT;
    set3(spot.position, -1.6, 0.9, 0.4);
    set3(spot.direction, 1.6, -0.8, -0.5);
    spot.cone = 30;
    spot.penumbra = 0.3;
    outside.kind = TY_LIGHT_POINT;
    set3(outside.position, 0.2, -1.2, -0.8);
    ty_light_def* const lamps[3] = {&point, &spot, &outside};
    for (int i = 0; i < 3; ++i) {
        for (int c = 0; c < 3; ++c) lamps[i]->color[c] = (float)(factor * (2 - 0.5 * c + i));
        assert_int_equal(ty_scene_add_light(scene, lamps[i]), TY_OK);
    }
}

static inline ty_scene* make(ty_context* context, const parameters* p) {
    static const double lower[3] = {-1, -0.75, -0.5}, upper[3] = {1, 0.75, 0.5};
    ty_scene* scene = make_scene(context);
    ty_medium_def medium = box_medium(lower, upper, 0, 0);
    ty_light_def sun = ty_default_light_def(), sky = sky_light(0.25f, 0.5f, 0.75f);
    ty_grid* grid = NULL;
    set3(sun.direction, -1, -2, -0.5);
    for (int c = 0; c < 3; ++c) {
        medium.sigma_s[c] = (float)p->sigma_s[c];
        medium.sigma_a[c] = (float)p->sigma_a[c];
        medium.g[c] = (float)p->g[c];
        sun.color[c] = (float)(p->sun * (1 + 0.3 * c));
        sky.color[c] *= (float)p->sky;
    }
    if (p->voxels != NULL) {
        ty_grid_def def = ty_default_grid_def();
        for (int a = 0; a < 3; ++a) def.size[a] = VOXELS_SIDE;
        def.values = p->voxels;
        assert_int_equal(ty_grid_create(context, &def, &grid), TY_OK);
        medium.density_grid = grid;
    }
    assert_int_equal(ty_scene_add_medium(scene, &medium), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sun), TY_OK);
    assert_int_equal(ty_scene_add_light(scene, &sky), TY_OK);
    if (p->lamps > 0) add_lamps(scene, p->lamps);
    assert_int_equal(ty_scene_commit(scene), TY_OK);
    ty_grid_release(grid);
    return scene;
}

/* Weights of both signs. */
static inline void make_weights(double weights[3 * CELLS], bool same_in_channels) {
    uint64_t state = 7;
    for (int i = 0; i < CELLS; ++i)
        for (int c = 0; c < 3; ++c)
            weights[3 * i + c] = same_in_channels && c > 0 ? weights[3 * i] : uniform_in(&state, -0.5, 1);
}

static const double from[3] = {-0.9, -0.8, -0.45}, to[3] = {1.05, 0.7, 0.4};
static const int32_t cells_size[3] = {SIDE, SIDE, SIDE};

/* Light of either method. */
typedef struct solved_light {
    ty_fld* fld;
    ty_dom* dom;
} solved_light;

static inline solved_light solve(const ty_scene* scene, const parameters* p) {
    solved_light light = {NULL, NULL};
    ty_fld_stats stats = ty_default_fld_stats();
    ty_dom_stats dom_stats = ty_default_dom_stats();
    if (p->by_dom)
        assert_int_equal(ty_dom_solve(scene, &p->dom, &light.dom, &dom_stats), TY_OK);
    else
        assert_int_equal(ty_fld_solve(scene, &p->def, &light.fld, &stats), TY_OK);
    return light;
}

static inline void destroy_light(solved_light light) {
    ty_fld_destroy(light.fld);
    ty_dom_destroy(light.dom);
}

static inline ty_result gradient_of(const ty_scene* scene, const parameters* p, solved_light light,
                                    const double* weights, ty_gradient** out, ty_gradient_stats* stats) {
    if (p->by_dom) return ty_dom_gradient(light.dom, scene, &p->dom, from, to, cells_size, weights, out, stats);
    return ty_fld_gradient(light.fld, scene, &p->def, from, to, cells_size, weights, out, stats);
}

static inline double loss_of(ty_context* context, const parameters* p, const double* weights) {
    double fluence[3 * CELLS], sum = 0;
    ty_scene* scene = make(context, p);
    const solved_light light = solve(scene, p);
    if (p->by_dom)
        assert_int_equal(ty_dom_fluence(light.dom, from, to, cells_size, fluence, NULL), TY_OK);
    else
        assert_int_equal(ty_fld_fluence(light.fld, from, to, cells_size, fluence, NULL, NULL), TY_OK);
    for (int i = 0; i < 3 * CELLS; ++i) sum += weights[i] * fluence[i];
    destroy_light(light);
    ty_scene_destroy(scene);
    return sum;
}

/* The derivative by central differences of sixth order with a step of `step` in the numbers at `at`. */
static inline double difference(ty_context* context, parameters* p, double* at[], int count, double step,
                                const double* weights) {
    static const double move[6] = {-3, -2, -1, 1, 2, 3}, weight[6] = {-1, 9, -45, 45, -9, 1};
    double sum = 0;
    for (int i = 0; i < 6; ++i) {
        for (int n = 0; n < count; ++n) *at[n] += move[i] * step;
        sum += weight[i] * loss_of(context, p, weights);
        for (int n = 0; n < count; ++n) *at[n] -= move[i] * step;
    }
    return sum / (60 * step);
}

static inline void compare(const char* what, double found, double expected, double scale) {
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("%-12s %12.6g %12.6g  relative %.2g\n", what, found, expected, (found - expected) / scale);
    if (!(fabs(found - expected) <= TOLERANCE * scale))
        fail_msg("%s: %.9g, by differences %.9g", what, found, expected);
}

static inline ty_gradient* find(const ty_scene* scene, const parameters* p, const double* weights,
                                ty_gradient_stats* stats) {
    const solved_light light = solve(scene, p);
    ty_gradient* gradient = NULL;
    if (gradient_of(scene, p, light, weights, &gradient, stats) != TY_OK)
        fail_msg("%s", ty_take_error(ty_scene_context(scene)));
    destroy_light(light);
    assert_true(stats->converged);
    return gradient;
}

/* All coefficients of the medium and both lights. */
static inline void check_all(ty_context* context, parameters* p, bool same_in_channels) {
    double weights[3 * CELLS], sigma_s[3], sigma_a[3], g[3], factor[3];
    ty_gradient_stats stats = ty_default_gradient_stats();
    make_weights(weights, same_in_channels);
    ty_scene* scene = make(context, p);
    ty_gradient* gradient = find(scene, p, weights, &stats);
    if (getenv("TYNDALL_SHOW") != NULL)
        print_message("%d solves, residual %.1e, imbalance %.1e\n", stats.iterations, stats.residual, stats.imbalance);
    assert_int_equal(ty_gradient_medium(gradient, scene, 0, sigma_s, sigma_a, g), TY_OK);
    const int planes = ty_gradient_planes(gradient);
    for (int c = 0; c < planes; ++c) {
        const int count = planes == 1 ? 3 : 1;
        double *at_s[3] = {&p->sigma_s[c], &p->sigma_s[1], &p->sigma_s[2]},
               *at_a[3] = {&p->sigma_a[c], &p->sigma_a[1], &p->sigma_a[2]}, *at_g[3] = {&p->g[c], &p->g[1], &p->g[2]};
        const double by_s = difference(context, p, at_s, count, 0.04 * p->sigma_s[c], weights);
        const double by_a = difference(context, p, at_a, count, 0.005, weights);
        const double g_step = p->by_dom ? fmin(0.04, 0.1 * (1 - p->g[c])) : 0.02;
        const double by_g = difference(context, p, at_g, count, g_step, weights);
        compare("sigma_s", sigma_s[c], by_s, fabs(by_s) + 0.1 * fabs(by_a));
        compare("sigma_a", sigma_a[c], by_a, fabs(by_a));
        if (p->g[c] > 0) compare("g", g[c], by_g, fabs(by_g));
    }
    double* at[1] = {&p->sun};
    double sums[5], all = 0;
    const int lights = p->lamps > 0 ? 5 : 2;
    for (int i = 0; i < lights; ++i) {
        assert_int_equal(ty_gradient_light(gradient, i, factor), TY_OK);
        sums[i] = factor[0] + factor[1] + factor[2];
        all += sums[i];
    }
    const double by_sun = difference(context, p, at, 1, 0.02, weights);
    compare("sun", sums[0], by_sun, fabs(by_sun));
    if (p->lamps > 0) {
        at[0] = &p->lamps;
        const double by_lamps = difference(context, p, at, 1, 0.02, weights);
        compare("lamps", sums[2] + sums[3] + sums[4], by_lamps, fabs(by_lamps));
    }
    /* Light is linear in the lights. Differences by the sky's factor would move its clusters. */
    const double loss = loss_of(context, p, weights);
    compare("all lights", all, loss, fabs(loss));
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

/* Moves all voxels by random amounts at once, which differences resolve better than one voxel. */
static inline void check_voxels(ty_context* context, parameters p) {
    float voxels[VOXELS], direction[VOXELS];
    double weights[3 * CELLS], gradient_of[VOXELS], sum = 0;
    uint64_t random = 3;
    p.voxels = voxels;
    for (int i = 0; i < VOXELS; ++i) {
        voxels[i] = (float)fmax(0.2, uniform_in(&random, -0.3, 1.5));
        direction[i] = (float)uniform_in(&random, -0.2, 1);
    }
    make_weights(weights, true);
    ty_scene* scene = make(context, &p);
    ty_gradient_stats stats = ty_default_gradient_stats();
    ty_gradient* gradient = find(scene, &p, weights, &stats);
    if (ty_gradient_density(gradient, scene, 0, gradient_of) != TY_OK) fail_msg("%s", ty_take_error(context));
    for (int i = 0; i < VOXELS; ++i) {
        /* Around lamps what voxels change cancels; so each is moved with its own sign. */
        if (p.lamps > 0) direction[i] = (float)copysign((double)direction[i], gradient_of[i]);
        sum += gradient_of[i] * (double)direction[i];
    }
    /* Differences of fourth order; ordinates have kinks nearby. */
    static const double move[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    const double step = p.by_dom ? 0.01 : 0.08;
    double expected = 0;
    for (int s = 0; s < 4; ++s) {
        float moved[VOXELS];
        for (int i = 0; i < VOXELS; ++i) moved[i] = voxels[i] + (float)(move[s] * step) * direction[i];
        p.voxels = moved;
        expected += weight[s] * loss_of(context, &p, weights) / (12 * step);
    }
    compare("voxels", sum, expected, fabs(expected));
    ty_gradient_destroy(gradient);
    ty_scene_destroy(scene);
}

/* One and three threads find the same bits of the derivatives by media and lights. */
static inline void check_threads(const parameters* p) {
    double weights[3 * CELLS], numbers[2][16];
    make_weights(weights, false);
    for (int i = 0; i < 2; ++i) {
        ty_context* context = make_context(1 + 2 * i);
        ty_scene* scene = make(context, p);
        ty_gradient_stats stats = ty_default_gradient_stats();
        ty_gradient* gradient = find(scene, p, weights, &stats);
        assert_int_equal(ty_gradient_medium(gradient, scene, 0, numbers[i], numbers[i] + 3, numbers[i] + 6), TY_OK);
        assert_int_equal(ty_gradient_light(gradient, 0, numbers[i] + 9), TY_OK);
        assert_int_equal(ty_gradient_light(gradient, 1, numbers[i] + 12), TY_OK);
        numbers[i][15] = stats.residual;
        ty_gradient_destroy(gradient);
        ty_scene_destroy(scene);
        ty_context_destroy(context);
    }
    assert_memory_equal(numbers[0], numbers[1], sizeof numbers[0]);
}

#endif
