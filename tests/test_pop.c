/* Principal-ordinates propagation's calls: arguments, cancelling, memory, progress, threads, views; not whether the
 * light is right. */
#include "volume_calls.h"

#include <stddef.h>

/* Light that other cameras may see. */
static ty_pop_def small_pop(void) {
    ty_pop_def def = ty_default_pop_def();
    def.resolution = 8;
    def.direct = 12;
    def.ordinates = 5;
    def.vpls = 6;
    def.shadow_texels = 16;
    def.keep_lobes = true;
    def.width = WIDTH;
    def.height = HEIGHT;
    return def;
}

/* ---- calls ---- */

VOLUME_CALLS(pop)

static void make_def(volume_def* def, int mode) {
    def->pop = small_pop();
    def->pop.mode = (ty_pop_mode)mode;
}

static ty_result call_fluence(const void* light, const double lower[3], const double upper[3], const int32_t size[3],
                              double* fluence) {
    return ty_pop_fluence(light, lower, upper, size, fluence, NULL);
}

static void look_up_all(const void* light, double numbers[VOLUME_NUMBERS]) {
    static const double lower[3] = {-1.1, -1, -1.2}, upper[3] = {1.1, 1.1, 0.9};
    static const int32_t size[3] = {SIDE, SIDE, SIDE};
    const size_t uncollided = (size_t)3 * CELLS;
    assert_int_equal(ty_pop_fluence(light, lower, upper, size, numbers, numbers + uncollided), TY_OK);
}

static const volume_calls calls = {VOLUME_CALLS_OF(pop), .variants = 3, .told = 0.4, .make_scene = foggy_scene};

/* ---- arguments ---- */

#define POP(field, type, value, words)                                                                                 \
    { offsetof(ty_pop_def, field), type, value, words }

static const bad_field bad_fields[] = {
    POP(cookie, FIELD_INT, 0, "ty_default_pop_def"),
    POP(mode, FIELD_INT, 3, "pop.mode: 3 is outside [0, 2]"),
    POP(resolution, FIELD_INT, 3, "pop.resolution: 3 is outside [4, 128]"),
    POP(resolution, FIELD_INT, 129, "pop.resolution"),
    POP(merged, FIELD_INT, 3, "pop.merged: 3 is outside [4, 512]"),
    POP(merged, FIELD_INT, 513, "pop.merged"),
    POP(direct, FIELD_INT, -1, "pop.direct: -1 is outside [4, 1024]"),
    POP(direct, FIELD_INT, 1025, "pop.direct"),
    POP(ordinates, FIELD_INT, 0, "pop.ordinates: 0 is outside [1, 4096]"),
    POP(ordinates, FIELD_INT, 4097, "pop.ordinates"),
    POP(prefilter, FIELD_DOUBLE, -1, "pop.prefilter: -1 is outside [0, 16]"),
    POP(prefilter, FIELD_DOUBLE, NAN, "pop.prefilter"),
    POP(surface_points, FIELD_INT, 0, "pop.surface_points: 0 is outside [1, 65536]"),
    POP(vpls, FIELD_INT, -1, "pop.vpls: -1 is outside [0, 4096]"),
    POP(shadow_texels, FIELD_INT, 15, "pop.shadow_texels: 15 is outside [16, 1024]"),
    POP(clamp, FIELD_DOUBLE, 1.5, "pop.clamp: 1.5 is outside [0, 1]"),
    POP(iterations, FIELD_INT, 10001, "pop.iterations: 10001"),
    POP(residuum, FIELD_DOUBLE, 2, "pop.residuum: 2 is outside [0, 1]"),
    POP(residuum_iterations, FIELD_INT, -1, "pop.residuum_iterations: -1"),
    POP(streaming, FIELD_DOUBLE, 1.5, "pop.streaming: 1.5 is outside [0, 1]"),
    POP(tolerance, FIELD_DOUBLE, 0, "pop.tolerance: 0 is outside (0, 1)"),
    POP(tolerance, FIELD_DOUBLE, 1, "pop.tolerance"),
    POP(width, FIELD_INT, 0, "pop: 0 x 11"),
    POP(height, FIELD_INT, 65537, "pop: 19 x 65537"),
    POP(spp, FIELD_INT, 65, "pop.spp: 65 is outside [1, 64]"),
    POP(step, FIELD_DOUBLE, 0.01, "pop.step: 0.01 is outside [0.05, 8]"),
    POP(aovs, FIELD_INT, TY_AOV_NORMAL, "pop.aovs: "),
};

static const volume_suite suite = {&calls, bad_fields, sizeof bad_fields / sizeof *bad_fields};

/* ---- results ---- */

static void threads_do_not_change_bits(void** state) {
    (void)state;
    for (int mode = 0; mode < 3; ++mode) {
        volume_def def;
        make_def(&def, mode);
        def.pop.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;
        check_threads(&calls, &def);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        VOLUME_TESTS,
        cmocka_unit_test(threads_do_not_change_bits),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
