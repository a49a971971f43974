/* Tests of the calls of every method whose light is solved once and then seen from anywhere: arguments, progress,
 * cancelling, memory, threads, cameras. They say nothing of the light itself. VOLUME_TESTS(&suite) is the list of them
 * for cmocka. */
#ifndef TY_TESTS_VOLUME_CALLS_H
#define TY_TESTS_VOLUME_CALLS_H

#include "effort.h"
#include "files.h"
#include "fld_maker.h"

#include <tyndall/dom.h>
#include <tyndall/octaves.h>

#include <stddef.h>

/* A def of any of them. */
typedef union volume_def {
    ty_dom_def dom;
    ty_fld_def fld;
    ty_octaves_def octaves;
    ty_pop_def pop;
} volume_def;

enum { VOLUME_NUMBERS = 15 * CELLS };

/* A method's calls; light is what it solves. */
typedef struct volume_calls {
    const char* name;                               /* as messages begin */
    const char* maker;                              /* of defs, which messages name */
    int variants;                                   /* of defs, such as solvers, by all of which calls must behave */
    int resolution;                                 /* in tests of threads; 0: that of make_def */
    double told;                                    /* fraction that even a short solve says is done, at least */
    void (*make_def)(volume_def* def, int variant); /* small, of WIDTH x HEIGHT */
    void (*watch)(volume_def* def, ty_progress_fn progress, void* user);
    void (*enlarge)(volume_def* def, int resolution); /* 0: no change; and asks for all channels */
    void (*space)(volume_def* def, int32_t spacing);  /* rays so many pixels apart, in an image five times as wide */
    ty_scene* (*make_scene)(ty_context* context);     /* that takes little time */
    ty_result (*solve)(const ty_scene* scene, const volume_def* def, void** light);
    ty_result (*view)(void* light, const ty_scene* scene, const volume_def* def, ty_image** image);
    ty_result (*render)(const ty_scene* scene, const volume_def* def, ty_image** image);
    ty_result (*fluence)(const void* light, const double lower[3], const double upper[3], const int32_t size[3],
                         double* fluence);
    /* All that calls tell of it on a few cells; NULL: images are all there is. */
    void (*look_up)(const void* light, double numbers[VOLUME_NUMBERS]);
    void (*destroy)(void* light);
} volume_calls;

/* The functions that are alike but for the method's name. */
#define VOLUME_CALLS(method)                                                                                           \
    static void watch_def(volume_def* def, ty_progress_fn progress, void* user) {                                      \
        def->method.progress = progress;                                                                               \
        def->method.progress_user = user;                                                                              \
    }                                                                                                                  \
    static void enlarge_def(volume_def* def, int resolution) {                                                         \
        if (resolution > 0) def->method.resolution = resolution;                                                       \
        def->method.aovs = TY_AOV_SINGLE | TY_AOV_MULTIPLE | TY_AOV_TRANSMITTANCE | TY_AOV_DEPTH;                      \
    }                                                                                                                  \
    static void space_def(volume_def* def, int32_t spacing) {                                                          \
        def->method.ray_spacing = spacing;                                                                             \
        def->method.width = 5 * WIDTH;                                                                                 \
        def->method.height = 5 * HEIGHT;                                                                               \
    }                                                                                                                  \
    static ty_result call_solve(const ty_scene* scene, const volume_def* def, void** light) {                          \
        ty_##method* solved = NULL;                                                                                    \
        const ty_result result = ty_##method##_solve(scene, (const ty_##method##_def*)def, &solved, NULL);             \
        *light = solved;                                                                                               \
        return result;                                                                                                 \
    }                                                                                                                  \
    static ty_result call_view(void* light, const ty_scene* scene, const volume_def* def, ty_image** image) {          \
        return ty_##method##_view(light, scene, (const ty_##method##_def*)def, image, NULL);                           \
    }                                                                                                                  \
    static ty_result call_render(const ty_scene* scene, const volume_def* def, ty_image** image) {                     \
        return ty_##method##_render(scene, (const ty_##method##_def*)def, image, NULL);                                \
    }                                                                                                                  \
    static void call_destroy(void* light) {                                                                            \
        ty_##method##_destroy(light);                                                                                  \
    }

/* ty_NAME_fluence on the test's cells, for methods that have uncollided fluence and nothing else beside it. */
#define VOLUME_FLUENCE(method)                                                                                         \
    static ty_result call_fluence(const void* light, const double lower[3], const double upper[3],                     \
                                  const int32_t size[3], double* fluence) {                                            \
        return ty_##method##_fluence(light, lower, upper, size, fluence, NULL);                                        \
    }                                                                                                                  \
    static void look_up_all(const void* light, double numbers[VOLUME_NUMBERS]) {                                       \
        static const double lower[3] = {-1.1, -1, -1.2}, upper[3] = {1.1, 1.1, 0.9};                                   \
        static const int32_t size[3] = {SIDE, SIDE, SIDE};                                                             \
        double* uncollided = numbers + 3 * CELLS;                                                                      \
        assert_int_equal(ty_##method##_fluence(light, lower, upper, size, numbers, uncollided), TY_OK);                \
    }

/* Those fields of a method's volume_calls; the file has make_def. */
#define VOLUME_CALLS_OF(method)                                                                                        \
    .name = #method, .maker = "ty_default_" #method "_def", .make_def = make_def, .watch = watch_def,                  \
    .enlarge = enlarge_def, .space = space_def, .solve = call_solve, .view = call_view, .render = call_render,         \
    .destroy = call_destroy
#define VOLUME_FLUENCE_OF .fluence = call_fluence, .look_up = look_up_all

/* A field of a method's def with a value that is refused, and what the message says; those of all methods. */
#define VOLUME_BAD_FIELD(method, field, type, value, words)                                                            \
    { offsetof(ty_##method##_def, field), type, value, words }
#define VOLUME_BAD_FIELDS(method)                                                                                      \
    VOLUME_BAD_FIELD(method, cookie, FIELD_INT, 0, "ty_default_" #method "_def"),                                      \
        VOLUME_BAD_FIELD(method, width, FIELD_INT, 0, #method ": 0 x 11"),                                             \
        VOLUME_BAD_FIELD(method, width, FIELD_INT, -5, #method ": -5 x 11"),                                           \
        VOLUME_BAD_FIELD(method, height, FIELD_INT, 0, #method ": 19 x 0"),                                            \
        VOLUME_BAD_FIELD(method, height, FIELD_INT, 65537, #method ": 19 x 65537"),                                    \
        VOLUME_BAD_FIELD(method, ray_spacing, FIELD_INT, 0, #method ".ray_spacing"),                                   \
        VOLUME_BAD_FIELD(method, ray_spacing, FIELD_INT, 9, #method ".ray_spacing"),                                   \
        VOLUME_BAD_FIELD(method, aovs, FIELD_INT, TY_AOV_NORMAL, #method ".aovs: ")

/* A method and the defs that it must refuse. */
typedef struct volume_suite {
    const volume_calls* calls;
    const bad_field* bad_fields; /* that defs must not have */
    size_t bad_count;
} volume_suite;

static const volume_suite suite; /* the file that includes this defines it */

static inline void* solve_volume(const volume_calls* calls, const ty_scene* scene, const volume_def* def) {
    void* light = NULL;
    check_result(ty_scene_context(scene), calls->solve(scene, def, &light));
    return light;
}

/* ---- arguments ---- */

/* Every call says the same of a def, and hands nothing out. */
static inline void refuse_def(const volume_calls* calls, const ty_scene* scene, void* light, const volume_def* def,
                              const char* words) {
    ty_context* context = ty_scene_context(scene);
    void* other = NULL;
    ty_image* image = (ty_image*)(uintptr_t)1;
    assert_int_equal(calls->solve(scene, def, &other), TY_ERROR_ARGUMENT);
    assert_null(other);
    assert_error(context, words);
    assert_int_equal(calls->render(scene, def, &image), TY_ERROR_ARGUMENT);
    assert_null(image);
    assert_error(context, words);
    image = (ty_image*)(uintptr_t)1;
    assert_int_equal(calls->view(light, scene, def, &image), TY_ERROR_ARGUMENT);
    assert_null(image);
    assert_error(context, words);
}

static inline void wrong_defs_are_refused(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    volume_def def;
    calls->make_def(&def, 0);
    void* light = solve_volume(calls, scene, &def);
    for (size_t i = 0; i < suite.bad_count; ++i) {
        calls->make_def(&def, 0);
        set_field(&def, &suite.bad_fields[i]);
        refuse_def(calls, scene, light, &def, suite.bad_fields[i].words);
    }
    refuse_def(calls, scene, light, NULL, calls->maker);
    calls->destroy(light);
    calls->destroy(NULL);
    ty_scene_destroy(scene);
}

static inline void scenes_need_media(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    ty_scene* scene = make_scene(context);
    char words[64];
    volume_def def;
    void* light = NULL;
    ty_image* image = NULL;
    snprintf(words, sizeof words, "%s: the scene has no media", calls->name);
    calls->make_def(&def, 0);
    assert_int_equal(calls->solve(scene, &def, &light), TY_ERROR_ARGUMENT);
    assert_error(context, "not committed");
    commit(scene);
    assert_int_equal(calls->solve(scene, &def, &light), TY_ERROR_ARGUMENT);
    assert_error(context, words);
    assert_int_equal(calls->render(scene, &def, &image), TY_ERROR_ARGUMENT);
    assert_error(context, words);
    assert_null(light);
    assert_null(image);
    ty_scene_destroy(scene);
}

static inline void cuts_of_boxes_are_checked(void** state) {
    const volume_calls* calls = suite.calls;
    if (calls->fluence == NULL) return;
    ty_context* context = *state;
    static const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1}, odd[3] = {0, NAN, 0};
    static const int32_t size[3] = {1, 1, 1}, none[3] = {1, 0, 1}, many[3] = {1, 1, 65537};
    static const struct {
        const double *lower, *upper;
        const int32_t* size;
        const char* words;
    } cuts[] = {{one, zero, size, "fluence: 1 cells from 1 to 0 m"},
                {zero, one, none, "fluence: 0 cells"},
                {zero, one, many, "fluence: 65537 cells"},
                {odd, one, size, "fluence: lower"}};
    ty_scene* scene = foggy_scene(context);
    volume_def def;
    calls->make_def(&def, 0);
    void* light = solve_volume(calls, scene, &def);
    double out[3];
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; ++i) {
        assert_int_equal(calls->fluence(light, cuts[i].lower, cuts[i].upper, cuts[i].size, out), TY_ERROR_ARGUMENT);
        assert_error(context, cuts[i].words);
    }
    calls->destroy(light);
    ty_scene_destroy(scene);
}

/* ---- progress, cancelling, memory ---- */

typedef struct volume_watch {
    int calls, stop_at; /* 0: never */
    double fraction;
    bool strange;
} volume_watch;

static inline bool look_on(void* user, const ty_progress* progress) {
    volume_watch* w = user;
    w->strange = w->strange || !(progress->fraction >= w->fraction - 1e-12 && progress->fraction <= 1 + 1e-12) ||
                 !(progress->seconds >= 0) || progress->stage == NULL;
    w->fraction = progress->fraction;
    return ++w->calls != w->stop_at;
}

static inline void progress_runs_to_the_end(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    for (int variant = 0; variant < calls->variants; ++variant) {
        volume_watch w = {.calls = 0};
        volume_def def;
        calls->make_def(&def, variant);
        calls->watch(&def, look_on, &w);
        ty_image* image = NULL;
        check_result(context, calls->render(scene, &def, &image));
        assert_true(w.calls >= 3 && !w.strange);
        assert_close(w.fraction, 1, 1e-9);
        ty_image_destroy(image);
        w = (volume_watch){.calls = 0};
        void* light = solve_volume(calls, scene, &def);
        assert_true(w.calls >= 3 && !w.strange && w.fraction >= calls->told);
        w = (volume_watch){.calls = 0};
        check_result(context, calls->view(light, scene, &def, &image));
        assert_true(w.calls >= 1 && !w.strange);
        assert_close(w.fraction, 1, 1e-9);
        ty_image_destroy(image);
        calls->destroy(light);
    }
    ty_scene_destroy(scene);
}

/* True if stopping at the stop-th call cancelled; if so, nothing is handed out and all memory is back. */
static inline bool stops(const volume_calls* calls, const ty_scene* scene, volume_def* def, int stop,
                         const strict_memory* memory) {
    ty_context* context = ty_scene_context(scene);
    volume_watch w = {.stop_at = stop};
    ty_image* image = (ty_image*)(uintptr_t)1;
    const size_t before = memory->used;
    calls->watch(def, look_on, &w);
    const ty_result result = calls->render(scene, def, &image);
    if (result != TY_CANCELLED) {
        check_result(context, result);
        ty_image_destroy(image);
        return false;
    }
    assert_int_equal(w.calls, stop);
    assert_null(image);
    assert_int_equal(memory->used, before);
    assert_string_equal(ty_take_error(context), "");
    return true;
}

/* Whoever says no at any time gets nothing, and all memory back. */
static inline void cancel_everywhere(const volume_calls* calls, int variant) {
    strict_memory memory = {.limit = (size_t)1 << 28, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = calls->make_scene(context);
    volume_def def;
    calls->make_def(&def, variant);
    int stop = 1;
    while (stops(calls, scene, &def, stop, &memory)) ++stop;
    assert_true(stop >= 4);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

static inline void callers_can_cancel_at_any_time(void** state) {
    (void)state;
    const volume_calls* calls = suite.calls;
    for (int variant = 0; variant < calls->variants; ++variant) cancel_everywhere(calls, variant);
}

/* True if memory that is refused after `count` allocations is missed; if so, nothing is handed out. */
static inline bool misses(const volume_calls* calls, const ty_scene* scene, const volume_def* def, int count,
                          strict_memory* memory) {
    ty_context* context = ty_scene_context(scene);
    ty_image* image = NULL;
    const size_t before = memory->used;
    memory->until_refusal = count;
    const ty_result result = calls->render(scene, def, &image);
    memory->until_refusal = -1;
    if (result != TY_ERROR_MEMORY) {
        check_result(context, result);
        ty_image_destroy(image);
        return false;
    }
    assert_null(image);
    assert_int_equal(memory->used, before);
    assert_error(context, "memory");
    return true;
}

static inline void refused_memory_leaves_nothing(void** state) {
    (void)state;
    const volume_calls* calls = suite.calls;
    strict_memory memory = {.limit = (size_t)1 << 28, .until_refusal = -1};
    ty_context* context = strict_context(&memory);
    ty_scene* scene = calls->make_scene(context);
    volume_def def;
    int count = 0;
    calls->make_def(&def, 0);
    assert_false(misses(calls, scene, &def, -1, &memory)); /* starts the context's threads */
    while (misses(calls, scene, &def, count, &memory)) ++count;
    assert_true(count > 30);
    ty_scene_destroy(scene);
    ty_context_destroy(context);
    assert_int_equal(memory.used, 0);
}

/* ---- results ---- */

/* Light that was solved once is seen from where the camera is moved to, as if it had been solved there. */
static inline void cameras_move_without_solving_again(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    volume_def def;
    calls->make_def(&def, 0);
    void* light = solve_volume(calls, scene, &def);
    ty_image* images[3] = {NULL};
    ty_camera_def camera = ty_scene_camera(scene);
    check_result(context, calls->view(light, scene, &def, &images[0]));
    set3(camera.position, 1, 3, -4);
    check_result(context, ty_scene_set_camera(scene, &camera));
    check_result(context, calls->view(light, scene, &def, &images[1]));
    check_result(context, calls->render(scene, &def, &images[2]));
    assert_true(same_images(images[1], images[2]));
    assert_false(same_images(images[0], images[1]));
    for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
    calls->destroy(light);
    ty_scene_destroy(scene);
}

/* Rays several pixels apart are asked for by all methods in the same way, and are fewer, but show about the same. */
static inline void rays_may_lie_apart(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    volume_def def;
    calls->make_def(&def, 0);
    void* light = solve_volume(calls, scene, &def);
    ty_image* images[3] = {NULL};
    for (int i = 0; i < 3; ++i) {
        ty_difference difference;
        calls->space(&def, i + 1);
        check_result(context, calls->view(light, scene, &def, &images[i]));
        check_result(context, ty_image_compare(context, images[i], images[0], 1, &difference));
        assert_close(difference.mean_ratio[3], 1, 2e-3);
        assert_true(difference.relative_rmse[3] < 0.015 * i || i == 0);
    }
    assert_false(same_images(images[0], images[1]) || same_images(images[1], images[2]));
    for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
    calls->destroy(light);
    ty_scene_destroy(scene);
}

/* Light does not refer to the scene that it was solved for: lookups work without it, and views of a scene like it. */
static inline void light_outlives_its_scene(void** state) {
    const volume_calls* calls = suite.calls;
    ty_context* context = *state;
    static double numbers[2][VOLUME_NUMBERS];
    ty_image* images[2] = {NULL};
    ty_scene* scene = foggy_scene(context);
    volume_def def;
    calls->make_def(&def, 0);
    void* light = solve_volume(calls, scene, &def);
    if (calls->look_up != NULL) calls->look_up(light, numbers[0]);
    check_result(context, calls->view(light, scene, &def, &images[0]));
    ty_scene_destroy(scene);
    if (calls->look_up != NULL) calls->look_up(light, numbers[1]);
    assert_memory_equal(numbers[0], numbers[1], sizeof numbers[0]);
    scene = foggy_scene(context);
    check_result(context, calls->view(light, scene, &def, &images[1]));
    ty_scene_destroy(scene);
    calls->destroy(light);
    assert_true(same_images(images[0], images[1]));
    for (int i = 0; i < 2; ++i) ty_image_destroy(images[i]);
}

/* As images, and on cells. */
static inline void check_threads(const volume_calls* calls, const volume_def* def) {
    static const int32_t threads[] = {1, 2, 4};
    static double numbers[2][VOLUME_NUMBERS];
    ty_context* contexts[3];
    ty_image* images[3] = {NULL};
    for (int i = 0; i < 3; ++i) {
        contexts[i] = make_context(threads[i]);
        ty_scene* scene = foggy_scene(contexts[i]);
        check_result(contexts[i], calls->render(scene, def, &images[i]));
        void* light = solve_volume(calls, scene, def);
        if (calls->look_up != NULL) calls->look_up(light, numbers[i > 0]);
        calls->destroy(light);
        assert_true(same_images(images[i], images[0]));
        if (i > 0 && calls->look_up != NULL) assert_memory_equal(numbers[1], numbers[0], sizeof numbers[0]);
        ty_scene_destroy(scene);
    }
    for (int i = 0; i < 3; ++i) ty_image_destroy(images[i]);
    for (int i = 0; i < 3; ++i) ty_context_destroy(contexts[i]);
}

static inline void threads_do_not_change_bits(void** state) {
    (void)state;
    for (int variant = 0; variant < suite.calls->variants; ++variant) {
        volume_def def;
        suite.calls->make_def(&def, variant);
        if (!UNDER_ADDRESS_SANITIZER) suite.calls->enlarge(&def, suite.calls->resolution);
        check_threads(suite.calls, &def);
    }
}

/* For methods whose light does not depend on the camera, cameras_move_without_solving_again is one more. */
#define VOLUME_TESTS                                                                                                   \
    cmocka_unit_test(wrong_defs_are_refused), cmocka_unit_test(scenes_need_media),                                     \
        cmocka_unit_test(cuts_of_boxes_are_checked), cmocka_unit_test(progress_runs_to_the_end),                       \
        cmocka_unit_test(callers_can_cancel_at_any_time), cmocka_unit_test(refused_memory_leaves_nothing),             \
        cmocka_unit_test(light_outlives_its_scene), cmocka_unit_test(threads_do_not_change_bits),                      \
        cmocka_unit_test(rays_may_lie_apart)

#endif
