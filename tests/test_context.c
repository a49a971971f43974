/* Contexts: errors, logging, memory, parallel loops; the choice of instruction sets; reports of progress. */
#define _GNU_SOURCE /* pthread_barrier_t */
#include "checks.h"

#include "base/context.h"
#include "base/dispatch.h"
#include "base/progress.h"
#include "ledger.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

static void results_have_names(void** state) {
    (void)state;
    assert_string_equal(ty_result_name(TY_OK), "TY_OK");
    assert_string_equal(ty_result_name(TY_CANCELLED), "TY_CANCELLED");
    assert_string_equal(ty_result_name(TY_ERROR_INTERNAL), "TY_ERROR_INTERNAL");
    assert_string_equal(ty_result_text(TY_ERROR_MEMORY), "not enough memory");
    assert_string_equal(ty_result_name((ty_result)8), "unknown");
    assert_string_equal(ty_result_text((ty_result)-1), "unknown");
    assert_string_equal(ty_version(), TY_VERSION);
}

static void* no_memory(void* user, size_t size) {
    (void)user;
    (void)size;
    return NULL;
}

static void no_free(void* user, void* pointer, size_t size) {
    (void)user;
    (void)pointer;
    (void)size;
}

static void wrong_defs_are_refused(void** state) {
    (void)state;
    ty_context* context = NULL;
    const ty_context_def zero = {0}, good = ty_default_context_def();
    assert_int_equal(ty_context_create(NULL, &context), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_context_create(&good, NULL), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_context_create(&zero, &context), TY_ERROR_ARGUMENT);
    static const int32_t wrong[] = {0, 1025, INT32_MIN, INT32_MAX};
    for (int i = 0; i < 4; ++i) {
        ty_context_def def = good;
        def.threads = wrong[i];
        assert_int_equal(ty_context_create(&def, &context), TY_ERROR_ARGUMENT);
    }
    ty_context_def half = good;
    half.alloc = no_memory;
    assert_int_equal(ty_context_create(&half, &context), TY_ERROR_ARGUMENT);
    half.free = no_free;
    assert_int_equal(ty_context_create(&half, &context), TY_ERROR_MEMORY);
    half.alloc = NULL;
    assert_int_equal(ty_context_create(&half, &context), TY_ERROR_ARGUMENT);
    assert_null(context);
    ty_context_destroy(NULL);
    assert_string_equal(ty_take_error(NULL), "a def was not made by ty_default_context_def()");
}

static void threads_are_as_asked(void** state) {
    (void)state;
    static const int32_t counts[] = {1, 3, 1024};
    for (int i = 0; i < 3; ++i) {
        ty_context* context = make_context(counts[i]);
        assert_int_equal(ty_context_threads(context), counts[i]);
        ty_context_destroy(context);
    }
    ty_context* context = make_context(TY_AUTO);
    assert_true(ty_context_threads(context) >= 1);
    ty_context_destroy(context);
}

static void the_first_message_is_kept_until_it_is_read(void** state) {
    ty_context* context = *state;
    assert_string_equal(ty_take_error(context), "");
    assert_int_equal(ty_fail(context, TY_ERROR_INPUT, "first %d", 1), TY_ERROR_INPUT);
    assert_int_equal(ty_fail(context, TY_ERROR_FILE, "second"), TY_ERROR_FILE);
    assert_true(ty_has_error(context));
    assert_string_equal(ty_take_error(context), "first 1");
    assert_false(ty_has_error(context));
    assert_string_equal(ty_take_error(context), "");
    ty_fail(context, TY_ERROR_FILE, "third");
    assert_string_equal(ty_take_error(context), "third");
}

static void messages_of_failed_creations_are_kept_without_a_context(void** state) {
    (void)state;
    ty_context* context = NULL;
    ty_context_def def = ty_default_context_def();
    assert_string_equal(ty_take_error(NULL), "");
    def.threads = 1025;
    assert_int_equal(ty_context_create(&def, &context), TY_ERROR_ARGUMENT);
    assert_string_equal(ty_take_error(NULL),
                        "context: threads: 1025 is outside [1, 1024]; write TY_AUTO for one per processor");
    assert_string_equal(ty_take_error(NULL), "");
}

/* One message of each of five contexts: a thread keeps those of the last four. */
static void each_context_has_its_own_message(void** state) {
    (void)state;
    enum { COUNT = 5 };
    ty_context* contexts[COUNT];
    char expected[16];
    for (int i = 0; i < COUNT; ++i) contexts[i] = make_context(1);
    for (int i = 0; i < COUNT; ++i) ty_fail(contexts[i], TY_ERROR_INPUT, "of %d", i);
    assert_string_equal(ty_take_error(contexts[0]), "");
    for (int i = COUNT - 1; i > 0; --i) {
        snprintf(expected, sizeof expected, "of %d", i);
        assert_string_equal(ty_take_error(contexts[i]), expected);
    }
    ty_fail(contexts[1], TY_ERROR_INPUT, "unread");
    ty_context_destroy(contexts[1]);
    contexts[1] = make_context(1); /* perhaps at the same address: it has no message all the same */
    assert_string_equal(ty_take_error(contexts[1]), "");
    for (int i = 0; i < COUNT; ++i) ty_context_destroy(contexts[i]);
}

enum { FAILURES = 2000 };

typedef struct failing_thread {
    ty_context* context;
    pthread_barrier_t* begin;
    int number;
    int wrong; /* messages that were not the thread's own first one */
} failing_thread;

static void* fail_again_and_again(void* user) {
    failing_thread* thread = user;
    char expected[48];
    pthread_barrier_wait(thread->begin);
    for (int i = 0; i < FAILURES; ++i) {
        snprintf(expected, sizeof expected, "thread %d: medium %d", thread->number, i);
        ty_fail(thread->context, TY_ERROR_INPUT, "%s", expected);
        ty_fail(thread->context, TY_ERROR_INPUT, "thread %d: a consequence", thread->number);
        thread->wrong += strcmp(ty_take_error(thread->context), expected) != 0;
        thread->wrong += ty_take_error(thread->context)[0] != '\0';
    }
    return NULL;
}

static void threads_that_fail_at_once_read_their_own_messages(void** state) {
    pthread_barrier_t begin;
    assert_int_equal(pthread_barrier_init(&begin, NULL, 2), 0);
    failing_thread threads[2] = {{*state, &begin, 0, 0}, {*state, &begin, 1, 0}};
    pthread_t ids[2];
    for (int i = 0; i < 2; ++i) assert_int_equal(pthread_create(&ids[i], NULL, fail_again_and_again, &threads[i]), 0);
    for (int i = 0; i < 2; ++i) assert_int_equal(pthread_join(ids[i], NULL), 0);
    assert_true(threads[0].wrong == 0 && threads[1].wrong == 0);
    assert_string_equal(ty_take_error(*state), "");
    pthread_barrier_destroy(&begin);
}

enum { BODIES = 64 };

static void fail_in_a_body(void* user, int64_t index, int32_t worker) {
    (void)worker;
    ty_fail(user, TY_ERROR_INTERNAL, "body %d", (int)index);
}

/* A loop's bodies run in other threads, whose messages nobody could read there. */
static void messages_of_loops_are_the_callers(void** state) {
    (void)state;
    ty_context* context = make_context(4);
    for (int run = 0; run < 20; ++run) {
        ty_parallel_for(context, BODIES, fail_in_a_body, context);
        assert_memory_equal(ty_take_error(context), "body ", 5);
        assert_string_equal(ty_take_error(context), "");
    }
    ty_context_destroy(context);
}

static void long_messages_are_cut(void** state) {
    ty_context* context = *state;
    char text[5000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    ty_fail(context, TY_ERROR_INPUT, "%s", text);
    const size_t length = strlen(ty_take_error(context));
    assert_true(length >= 500 && length < sizeof text);
}

typedef struct log_record {
    int count[3];
    char last[64];
} log_record;

static void record(void* user, ty_log_level level, const char* text) {
    log_record* log = user;
    ++log->count[level];
    strncpy(log->last, text, sizeof log->last - 1);
}

static void the_log_hears_every_line(void** state) {
    (void)state;
    log_record log = {.last = ""};
    ty_context_def def = ty_default_context_def();
    def.log = record;
    def.log_user = &log;
    ty_context* context = NULL;
    assert_int_equal(ty_context_create(&def, &context), TY_OK);
    ty_log(context, TY_LOG_INFO, "%s", "hello");
    assert_string_equal(log.last, "hello");
    ty_log(context, TY_LOG_WARNING, "careful");
    ty_fail(context, TY_ERROR_INPUT, "broken");
    ty_fail(context, TY_ERROR_INPUT, "broken again");
    assert_string_equal(log.last, "broken again");
    assert_int_equal(log.count[TY_LOG_INFO], 1);
    assert_int_equal(log.count[TY_LOG_WARNING], 1);
    assert_int_equal(log.count[TY_LOG_ERROR], 2);
    assert_string_equal(ty_take_error(context), "broken");
    ty_context_destroy(context);
}

/* ---- memory ---- */

static ty_result add_lights(ty_scene* scene, ty_image* sky) {
    ty_result result = TY_OK;
    for (int kind = TY_LIGHT_DIRECTIONAL; kind <= TY_LIGHT_ENVIRONMENT && result == TY_OK; ++kind) {
        ty_light_def def = ty_default_light_def();
        def.kind = (ty_light_kind)kind;
        set3(def.position, 0, 3, 0);
        set3(def.u, 1, 0, 0);
        set3(def.v, 0, 0, 1);
        def.image = kind == TY_LIGHT_ENVIRONMENT ? sky : NULL;
        result = ty_scene_add_light(scene, &def);
    }
    return result;
}

static ty_result add_shapes(ty_scene* scene) {
    ty_result result = TY_OK;
    for (int kind = TY_SHAPE_QUAD; kind <= TY_SHAPE_SPHERE && result == TY_OK; ++kind) {
        ty_shape_def def = ty_default_shape_def();
        def.kind = (ty_shape_kind)kind;
        set3(def.origin, -2, -2, kind);
        set3(def.u, 4, 5, 6);
        set3(def.v, 0, 0, 2);
        def.radius = 0.5;
        def.emission[1] = kind == TY_SHAPE_SPHERE ? 1 : 0;
        result = ty_scene_add_shape(scene, &def);
    }
    return result;
}

static ty_result add_media(ty_scene* scene, ty_grid* grid) {
    const double lower[3] = {-1, -1, -1}, upper[3] = {1, 1, 1};
    ty_medium_def def = box_medium(lower, upper, 1, 0.25f);
    def.name = "cloud";
    def.density_grid = grid;
    ty_result result = ty_scene_add_medium(scene, &def);
    def.density_grid = NULL;
    def.sigma_a[1] = 2;
    if (result == TY_OK) result = ty_scene_add_medium(scene, &def);
    return result;
}

static ty_result fill_and_render(ty_scene* scene, ty_grid* grid, ty_image* sky, ty_image** out) {
    ty_result result = add_media(scene, grid);
    if (result == TY_OK) result = add_lights(scene, sky);
    if (result == TY_OK) result = add_shapes(scene);
    if (result == TY_OK) result = ty_scene_commit(scene);
    ty_path_def def = ty_default_path_def();
    def.spp = 1;
    def.width = 16;
    def.height = 8;
    return result == TY_OK ? ty_path_render(scene, &def, out, NULL) : result;
}

/* Makes a scene of everything there is and renders it; frees all of it whatever happens. */
static ty_result work(ty_context* context) {
    float values[9 * 9 * 9];
    for (int i = 0; i < 9 * 9 * 9; ++i) values[i] = (float)(i % 4);
    ty_grid_def def = ty_default_grid_def();
    def.size[0] = def.size[1] = def.size[2] = 9;
    def.values = values;
    ty_grid* grid = NULL;
    ty_image *sky = NULL, *image = NULL;
    ty_scene* scene = NULL;
    ty_result result = ty_grid_create(context, &def, &grid);
    if (result == TY_OK) result = ty_image_create_rgb(context, 4, 2, &sky);
    if (result == TY_OK) result = ty_scene_create(context, TY_AXIS_Y, &scene);
    if (result == TY_OK) result = fill_and_render(scene, grid, sky, &image);
    if (result != TY_OK) assert_null(image);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
    ty_image_destroy(sky);
    ty_grid_release(grid);
    return result;
}

static void all_memory_comes_from_the_allocator_and_returns(void** state) {
    (void)state;
    ledger book = {.refused = -1};
    ty_context* context = ledger_context(&book);
    assert_int_equal(work(context), TY_OK);
    assert_string_equal(ty_take_error(context), "");
    assert_true(atomic_load(&book.allocations) > 40);
    ty_context_destroy(context);
    assert_int_equal(atomic_load(&book.bytes), 0);
    assert_false(atomic_load(&book.wrong_size));
}

static void every_failed_allocation_is_reported(void** state) {
    (void)state;
    check_failed_allocations(work);
}

static void arrays_check_their_size(void** state) {
    ty_context* context = *state;
    assert_null(ty_alloc_array(context, SIZE_MAX / 2, 3, false));
    assert_error(context, "not enough memory");
    assert_null(ty_alloc_array(context, SIZE_MAX, 1, false));
    assert_error(context, "not enough memory");
    assert_null(ty_alloc_array(context, (size_t)1 << 46, 1, false)); /* 64 TiB */
    assert_error(context, "MiB are in use, the machine has ");
    assert_int_equal(ty_check_memory(context, 0x1p46, "clouds"), TY_ERROR_MEMORY);
    assert_error(context, "clouds: not enough memory: 67108864.0 MiB are needed, and the machine has ");
    assert_int_equal(ty_check_memory(context, 1000, "mist"), TY_OK);
    char* none = ty_alloc_array(context, 0, 8, true);
    assert_non_null(none);
    ty_free_array(context, none, 0, 8);
    char* zeros = ty_alloc_array(context, 1000, 1, true);
    assert_int_equal((uintptr_t)zeros % 64, 0);
    for (int i = 0; i < 1000; ++i) assert_int_equal(zeros[i], 0);
    ty_free_array(context, zeros, 1000, 1);
    ty_free_array(context, NULL, 7, 8);
}

static void arrays_grow_and_keep_their_content(void** state) {
    ty_context* context = *state;
    int32_t* items = NULL;
    size_t capacity = 0;
    for (size_t count = 0; count < 100; ++count) {
        assert_true(ty_grow_array(context, (void**)&items, &capacity, count, sizeof *items));
        assert_true(capacity > count);
        items[count] = (int32_t)count;
    }
    for (size_t i = 0; i < 100; ++i) assert_int_equal(items[i], i);
    ty_free_array(context, items, capacity, sizeof *items);
}

/* ---- parallel loops ---- */

enum { INDICES = 3000 };

typedef struct visits {
    _Atomic int32_t count[INDICES];
    int32_t threads;
    _Atomic int32_t strange;
} visits;

static void visit(void* user, int64_t index, int32_t worker) {
    visits* v = user;
    if (index < 0 || index >= INDICES || worker < 0 || worker >= v->threads)
        atomic_fetch_add(&v->strange, 1);
    else
        atomic_fetch_add(&v->count[index], 1);
}

static void every_index_runs_once(void** state) {
    (void)state;
    static const int32_t threads[] = {1, 2, 3, 16};
    static const int64_t counts[] = {0, 1, 2, 15, INDICES, -1};
    for (int t = 0; t < 4; ++t) {
        ty_context* context = make_context(threads[t]);
        for (int c = 0; c < 6; ++c) {
            visits v = {.threads = threads[t]};
            ty_parallel_for(context, counts[c], visit, &v);
            assert_int_equal(atomic_load(&v.strange), 0);
            for (int i = 0; i < INDICES; ++i) assert_int_equal(atomic_load(&v.count[i]), i < counts[c]);
        }
        ty_context_destroy(context);
    }
}

typedef struct nest {
    ty_context* context;
    _Atomic int32_t inner, alone;
} nest;

static void count_inner(void* user, int64_t index, int32_t worker) {
    (void)index;
    nest* n = user;
    atomic_fetch_add(&n->inner, 1);
    atomic_fetch_add(&n->alone, worker == 0);
}

static void run_inner(void* user, int64_t index, int32_t worker) {
    (void)index, (void)worker;
    ty_parallel_for(((nest*)user)->context, 10, count_inner, user);
}

static void loops_in_loops_run_alone(void** state) {
    (void)state;
    nest n = {.context = make_context(4)};
    ty_parallel_for(n.context, 20, run_inner, &n);
    assert_int_equal(atomic_load(&n.inner), 200);
    assert_int_equal(atomic_load(&n.alone), 200);
    ty_context_destroy(n.context);
}

static void* run_many(void* user) {
    for (int i = 0; i < 50; ++i) ty_parallel_for(((nest*)user)->context, 10, count_inner, user);
    return NULL;
}

static void loops_of_several_threads_do_not_wait_for_each_other(void** state) {
    (void)state;
    nest n = {.context = make_context(3)};
    pthread_t threads[4];
    for (int i = 0; i < 4; ++i) assert_int_equal(pthread_create(&threads[i], NULL, run_many, &n), 0);
    for (int i = 0; i < 4; ++i) assert_int_equal(pthread_join(threads[i], NULL), 0);
    assert_int_equal(atomic_load(&n.inner), 4 * 50 * 10);
    ty_context_destroy(n.context);
}

static void clocks_run_forward(void** state) {
    (void)state;
    const double wall = ty_wall_seconds(), cpu = ty_cpu_seconds();
    while (ty_cpu_seconds() < cpu + 2e-3) {
    }
    assert_true(ty_wall_seconds() > wall);
}

/* ---- instruction sets ---- */

#define BUILD_OF_KERNEL(name) int name(void)
BUILD_OF_KERNEL(build_v1);
BUILD_OF_KERNEL(build_v3);
BUILD_OF_KERNEL(build_v4);

int build_v1(void) {
    return TY_ISA_V1;
}

int build_v3(void) {
    return TY_ISA_V3;
}

int build_v4(void) {
    return TY_ISA_V4;
}

static void instruction_sets_can_be_forced(void** state) {
    (void)state;
    const ty_isa best = ty_best_isa();
    for (int isa = 0; isa <= TY_ISA_COUNT; ++isa) {
        const ty_isa expected = isa < (int)best ? (ty_isa)isa : best;
        ty_force_isa((ty_isa)isa);
        assert_int_equal(ty_best_isa(), expected);
        assert_int_equal(TY_BEST_KERNELS(build)(), expected);
        assert_true(strlen(ty_isa_name(ty_best_isa())) > 0);
    }
    assert_int_equal(ty_best_isa(), best);
}

/* ---- progress ---- */

typedef struct reports {
    int count, most; /* most: false is returned once count is this */
    double fraction;
} reports;

static bool take_report(void* user, const ty_progress* progress) {
    reports* r = user;
    r->fraction = progress->fraction;
    return ++r->count != r->most;
}

static void progress_is_of_the_whole_and_throttled(void** state) {
    (void)state;
    reports r = {0};
    ty_part_progress progress = ty_part_begin(take_report, &r, 0.5, 0);
    assert_int_equal(ty_part_next(&progress, "first", 0.75), TY_OK);
    assert_true(r.count == 1 && r.fraction == 0.5);
    for (int i = 0; i < 100; ++i) assert_int_equal(ty_part_show(&progress, "first", 0.5), TY_OK);
    assert_true(r.count < 100); /* 100 calls take less than 10 s */
    progress.reported -= 1;
    assert_int_equal(ty_part_show(&progress, "first", 0.5), TY_OK);
    assert_true(r.fraction == 0.625);
    r.most = r.count + 1;
    assert_int_equal(ty_part_next(&progress, "second", 1), TY_CANCELLED);
    assert_true(r.fraction == 0.75);
    /* A part that begins again, or is no number, leaves the report where it was. */
    const ty_progress back = {.stage = "second", .fraction = -1}, none = {.stage = "second", .fraction = NAN};
    r.most = 0;
    ty_part_report(&progress, &back);
    assert_true(r.fraction == 0.75);
    ty_part_report(&progress, &none);
    assert_true(r.fraction == 0.75);
    const ty_progress early = ty_progress_at("a", 0.001, 1), half = ty_progress_at("a", 0.5, 3);
    assert_true(early.remaining == -1 && half.remaining == 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_have_names),
        cmocka_unit_test(wrong_defs_are_refused),
        cmocka_unit_test(threads_are_as_asked),
        cmocka_unit_test(the_first_message_is_kept_until_it_is_read),
        cmocka_unit_test(messages_of_failed_creations_are_kept_without_a_context),
        cmocka_unit_test(each_context_has_its_own_message),
        cmocka_unit_test(threads_that_fail_at_once_read_their_own_messages),
        cmocka_unit_test(messages_of_loops_are_the_callers),
        cmocka_unit_test(long_messages_are_cut),
        cmocka_unit_test(the_log_hears_every_line),
        cmocka_unit_test(all_memory_comes_from_the_allocator_and_returns),
        cmocka_unit_test(every_failed_allocation_is_reported),
        cmocka_unit_test(arrays_check_their_size),
        cmocka_unit_test(arrays_grow_and_keep_their_content),
        cmocka_unit_test(every_index_runs_once),
        cmocka_unit_test(loops_in_loops_run_alone),
        cmocka_unit_test(loops_of_several_threads_do_not_wait_for_each_other),
        cmocka_unit_test(clocks_run_forward),
        cmocka_unit_test(instruction_sets_can_be_forced),
        cmocka_unit_test(progress_is_of_the_whole_and_throttled),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
