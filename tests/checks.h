/* Shared by the unit tests of base, grid, scene and path: contexts, closeness, random numbers, tables of bad fields.
 */
#ifndef TY_TESTS_CHECKS_H
#define TY_TESTS_CHECKS_H

#include "base/vector.k.h"
#include "uniform.h"

#include <tyndall/tyndall.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static inline ty_context* make_context(int32_t threads) {
    ty_context_def def = ty_default_context_def();
    def.threads = threads;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    return context;
}

/* For cmocka's setup and teardown: the state is a context of two threads. */
static inline int start_context(void** state) {
    *state = make_context(2);
    return 0;
}

static inline int stop_context(void** state) {
    ty_context_destroy(*state);
    return 0;
}

#define assert_close(value, expected, tolerance) check_close(value, expected, tolerance, __FILE__, __LINE__)

static inline void check_close(double value, double expected, double tolerance, const char* file, int line) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s:%d: %.17g is not %.17g +- %g", file, line, value, expected, tolerance);
}

static inline void assert_vec_close(ty_vec value, ty_vec expected, double tolerance) {
    assert_close(value.x, expected.x, tolerance);
    assert_close(value.y, expected.y, tolerance);
    assert_close(value.z, expected.z, tolerance);
}

/* Asserts that the error's message, which counts as read then, holds some words. */
static inline void assert_error(ty_context* context, const char* words) {
    const char* message = ty_take_error(context);
    if (strstr(message, words) == NULL) fail_msg("\"%s\" does not say \"%s\"", message, words);
}

static inline double uniform_in(uint64_t* state, double low, double high) {
    return low + (high - low) * uniform(state);
}

static inline ty_vec random_unit(uint64_t* state) {
    const double z = uniform_in(state, -1, 1), turn = 6.283185307179586 * uniform(state);
    const double radius = sqrt(1 - z * z);
    return ty_vec_make((float)(radius * cos(turn)), (float)(radius * sin(turn)), (float)z);
}

/* A field of a def set to a value that must be refused with a message that holds some words. */
typedef enum field_type { FIELD_DOUBLE, FIELD_FLOAT, FIELD_INT } field_type;

typedef struct bad_field {
    size_t offset;
    field_type type;
    double value;
    const char* words;
} bad_field;

static inline void set_field(void* def, const bad_field* bad) {
    char* at = (char*)def + bad->offset;
    const float narrow = (float)bad->value;
    if (bad->type == FIELD_DOUBLE) memcpy(at, &bad->value, sizeof bad->value);
    if (bad->type == FIELD_FLOAT) memcpy(at, &narrow, sizeof narrow);
    if (bad->type == FIELD_INT) {
        const int32_t whole = (int32_t)bad->value;
        memcpy(at, &whole, sizeof whole);
    }
}

static inline void set3(double out[3], double x, double y, double z) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

static inline void set3f(float out[3], float x, float y, float z) {
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* A homogeneous medium in a box. */
static inline ty_medium_def box_medium(const double lower[3], const double upper[3], float sigma_s, float sigma_a) {
    ty_medium_def def = ty_default_medium_def();
    def.bounds = TY_BOUNDS_BOX;
    for (int a = 0; a < 3; ++a) {
        def.box_min[a] = lower[a];
        def.box_max[a] = upper[a];
        def.sigma_s[a] = sigma_s;
        def.sigma_a[a] = sigma_a;
    }
    return def;
}

/* An environment of one radiance. */
static inline ty_light_def sky_light(float red, float green, float blue) {
    ty_light_def sky = ty_default_light_def();
    sky.kind = TY_LIGHT_ENVIRONMENT;
    set3f(sky.color, red, green, blue);
    return sky;
}

/* A quad by its origin and the edges u and v. */
static inline ty_shape_def quad_shape(const double corners[3][3]) {
    ty_shape_def quad = ty_default_shape_def();
    quad.kind = TY_SHAPE_QUAD;
    memcpy(quad.origin, corners[0], sizeof quad.origin);
    memcpy(quad.u, corners[1], sizeof quad.u);
    memcpy(quad.v, corners[2], sizeof quad.v);
    return quad;
}

static inline ty_scene* make_scene(ty_context* context) {
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    return scene;
}

#endif
