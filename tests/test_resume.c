/* States: a render that was interrupted anywhere goes on to the same bits, and no other bytes are taken for one. */
#include "effort.h"
#include "fog.h"

enum { KEPT_MAX = 64 };

/* Keeps what is handed out; stops the work after so many states. */
typedef struct keeper {
    uint8_t* bytes[KEPT_MAX];
    size_t sizes[KEPT_MAX];
    int calls, every, kept, stop_at; /* stop_at 0: never */
} keeper;

static bool keep(void* user, const void* state, size_t size) {
    keeper* k = user;
    ++k->calls;
    if (k->every > 0 && k->calls % k->every == 0 && k->kept < KEPT_MAX) {
        k->bytes[k->kept] = malloc(size);
        assert_non_null(k->bytes[k->kept]);
        memcpy(k->bytes[k->kept], state, size);
        k->sizes[k->kept++] = size;
    }
    return k->calls != k->stop_at;
}

static void forget(keeper* k) {
    for (int i = 0; i < k->kept; ++i) free(k->bytes[i]);
    *k = (keeper){.every = 1};
}

/* As many states as there can be. */
static ty_path_def kept_def(int32_t spp, keeper* k) {
    ty_path_def def = small_def(spp);
    def.aovs = TY_AOV_ALL | TY_AOV_HALF;
    def.crop[0] = 1;
    def.crop[2] = WIDTH - 1;
    def.crop[3] = HEIGHT;
    def.state = keep;
    def.state_user = k;
    def.state_seconds = 0;
    return def;
}

/* The last state of a render that was stopped at its n-th; the caller frees it. */
static uint8_t* stopped_state(const ty_scene* scene, const ty_path_def* wanted, int n, size_t* size) {
    keeper k = {.every = 1, .stop_at = n};
    ty_path_def def = *wanted;
    def.state = keep;
    def.state_user = &k;
    def.state_seconds = 0;
    ty_image* image = NULL;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_CANCELLED);
    ty_image_destroy(image);
    assert_true(k.kept > 0);
    uint8_t* last = k.bytes[--k.kept];
    *size = k.sizes[k.kept];
    forget(&k);
    return last;
}

static void states_come_in_time_and_at_the_end(void** state) {
    ty_scene* scene = foggy_scene(*state);
    keeper k = {.every = 1000000};
    ty_path_def def = kept_def(4, &k);
    def.state_seconds = 1e6;
    ty_image_destroy(render(scene, &def, NULL));
    assert_int_equal(k.calls, 1);
    def.state_seconds = 0;
    ty_image_destroy(render(scene, &def, NULL));
    assert_true(k.calls > 4);
    ty_scene_destroy(scene);
}

/* A partial image has the channels and the size of the final one, and light in it. */
static bool look(void* user, const ty_image* image) {
    int* calls = user;
    assert_int_equal(ty_image_width(image), WIDTH);
    assert_int_equal(ty_image_height(image), HEIGHT);
    float sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) sum += ty_image_plane_const(image, 0)[i];
    assert_true(sum > 0);
    return ++*calls < 2;
}

static void partial_images_come_and_may_cancel(void** state) {
    ty_scene* scene = foggy_scene(*state);
    int calls = 0;
    ty_path_def def = small_def(1 << 24);
    def.partial = look;
    def.partial_user = &calls;
    ty_image* image = NULL;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_CANCELLED);
    assert_int_equal(calls, 2);
    assert_non_null(image);
    ty_image_destroy(image);
    ty_scene_destroy(scene);
}

/* Every state that was handed out while threads worked gives the same image. */
static void any_state_leads_to_the_same_image(void** state) {
    ty_scene* scene = foggy_scene(*state);
    keeper k = {.every = 1}, nobody = {0};
    const ty_path_def def = kept_def(40, &k);
    ty_path_stats plain_stats = ty_default_path_stats();
    ty_image* plain = render(scene, &def, &plain_stats);
    assert_true(k.kept > 5);
    for (int i = 0; i < k.kept; ++i) {
        ty_path_def again = kept_def(40, &nobody);
        again.resume = k.bytes[i];
        again.resume_size = k.sizes[i];
        ty_path_stats stats = ty_default_path_stats();
        ty_image* image = render(scene, &again, &stats);
        assert_true(same_images(image, plain));
        assert_int_equal(stats.paths, plain_stats.paths);
        assert_int_equal(stats.vertices, plain_stats.vertices);
        assert_close(stats.error, plain_stats.error, 0);
        ty_image_destroy(image);
    }
    forget(&k);
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
}

/* Interrupted again and again. */
static void renders_survive_many_interruptions(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(24);
    ty_image* plain = render(scene, &def, NULL);
    uint8_t* last = NULL;
    size_t size = 0;
    ty_image* image = NULL;
    ty_result result = TY_CANCELLED;
    int runs = 0;
    for (; result == TY_CANCELLED; ++runs) {
        keeper k = {.every = 1, .stop_at = 6};
        def.state = keep;
        def.state_user = &k;
        def.state_seconds = 0;
        def.resume = last;
        def.resume_size = size;
        ty_image_destroy(image);
        result = ty_path_render(scene, &def, &image, NULL);
        assert_true(k.kept > 0);
        free(last);
        last = k.bytes[--k.kept];
        size = k.sizes[k.kept];
        forget(&k);
        assert_true(runs < 1000);
    }
    assert_int_equal(result, TY_OK);
    assert_true(runs > 2);
    assert_true(same_images(image, plain));
    free(last);
    ty_image_destroy(image);
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
}

static void more_samples_may_follow(void** state) {
    ty_scene* scene = foggy_scene(*state);
    keeper k = {.every = 1}, nobody = {0};
    ty_path_def def = kept_def(7, &k);
    def.state_seconds = 1e6;
    ty_image_destroy(render(scene, &def, NULL));
    ty_path_def more = kept_def(30, &nobody);
    ty_image* plain = render(scene, &more, NULL);
    more.resume = k.bytes[0];
    more.resume_size = k.sizes[0];
    ty_image* image = render(scene, &more, NULL);
    assert_true(same_images(image, plain));
    more.spp = 6;
    ty_image* none = NULL;
    assert_int_equal(ty_path_render(scene, &more, &none, NULL), TY_ERROR_INPUT);
    assert_error(*state, "the state has 7 samples per pixel, more than the 6 asked for");
    assert_null(none);
    forget(&k);
    ty_image_destroy(image);
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
}

/* The error bound is looked at after the same samples as without the interruption. */
static void error_bounds_survive_interruptions(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(1 << 20);
    def.error = 0.08;
    ty_path_stats plain_stats = ty_default_path_stats(), stats = ty_default_path_stats();
    ty_image* plain = render(scene, &def, &plain_stats);
    for (int n = 1; n < 14; n += numbers_count() ? 2 : 6) {
        size_t size;
        uint8_t* bytes = stopped_state(scene, &def, n, &size);
        def.resume = bytes;
        def.resume_size = size;
        ty_image* image = render(scene, &def, &stats);
        assert_true(same_images(image, plain));
        assert_close(stats.spp, plain_stats.spp, 0);
        def.resume = NULL;
        def.resume_size = 0;
        free(bytes);
        ty_image_destroy(image);
    }
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
}

/* Time that earlier runs took counts. */
static void time_bounds_survive_interruptions(void** state) {
    ty_scene* scene = foggy_scene(*state);
    keeper k = {.every = 1};
    ty_path_def def = small_def(1 << 24);
    def.seconds = 0.2;
    def.state = keep;
    def.state_user = &k;
    ty_path_stats first = ty_default_path_stats(), second = ty_default_path_stats();
    ty_image_destroy(render(scene, &def, &first));
    def.resume = k.bytes[0];
    def.resume_size = k.sizes[0];
    ty_image* image = render(scene, &def, &second);
    assert_true(second.paths == first.paths && second.seconds >= first.seconds);
    ty_image_destroy(image);
    forget(&k);
    ty_scene_destroy(scene);
}

static void refuse(ty_context* context, const ty_scene* scene, ty_path_def def, const void* bytes, size_t size,
                   const char* words) {
    ty_image* image = NULL;
    def.resume = bytes;
    def.resume_size = size;
    assert_int_equal(ty_path_render(scene, &def, &image, NULL), TY_ERROR_INPUT);
    assert_error(context, words);
    assert_null(image);
}

/* The bytes of a state and its changes, as a command keeps them in a file. */
typedef struct journal {
    uint8_t bytes[1 << 20], before[1 << 20]; /* before: the longest up to a whole state */
    size_t first, size, before_first, before_size;
    int changes, refuse_at; /* refuse_at: the number of the change that is not kept; 0: none */
} journal;

static bool begin_journal(void* user, const void* state, size_t size) {
    journal* j = user;
    assert_true(size <= sizeof j->bytes);
    if (j->size >= j->before_size) {
        memcpy(j->before, j->bytes, j->size);
        j->before_first = j->first;
        j->before_size = j->size;
    }
    memcpy(j->bytes, state, size);
    j->first = j->size = size;
    return true;
}

static bool extend_journal(void* user, const void* changes, size_t size) {
    journal* j = user;
    assert_true(j->size > 0 && j->size + size < sizeof j->bytes);
    /* A change that was not kept is followed by a whole state, and then by the next change. */
    assert_true(j->refuse_at == 0 || j->changes != j->refuse_at || j->before_size > 0);
    if (++j->changes == j->refuse_at) return false;
    memcpy(j->bytes + j->size, changes, size);
    j->size += size;
    return true;
}

static ty_path_def journal_def(journal* j) {
    ty_path_def def = kept_def(6, NULL);
    def.state = begin_journal;
    def.state_change = extend_journal;
    def.state_user = j;
    return def;
}

/* Cut anywhere, as by a kill, it leads to the same image, unless nothing of the first state is left. */
static void changes_lead_to_the_same_image(void** state) {
    ty_scene* scene = foggy_scene(*state);
    journal* j = calloc(1, sizeof *j);
    assert_non_null(j);
    ty_path_def def = journal_def(j);
    ty_path_stats plain_stats = ty_default_path_stats(), stats = ty_default_path_stats();
    ty_image* plain = render(scene, &def, &plain_stats);
    assert_true(j->changes > 2 && j->before_size > j->before_first + 997);
    def = kept_def(6, NULL);
    def.state = NULL;
    def.resume = j->before;
    for (size_t cut = j->before_first; cut < j->before_size + 997; cut += 997) {
        def.resume_size = cut < j->before_size ? cut : j->before_size;
        ty_image* image = render(scene, &def, &stats);
        assert_true(same_images(image, plain));
        assert_int_equal(stats.paths, plain_stats.paths);
        assert_int_equal(stats.vertices, plain_stats.vertices);
        ty_image_destroy(image);
    }
    refuse(*state, scene, def, j->before, j->before_first - 1, "cut short");
    j->before[j->before_size] = 'x';
    refuse(*state, scene, def, j->before, j->before_size + 1, "1 bytes behind it are not its changes");
    j->before[j->before_size - 5] ^= 1; /* as after a crash of the machine: the last change does not count */
    def.resume_size = j->before_size;
    ty_image* image = render(scene, &def, &stats);
    assert_true(same_images(image, plain));
    ty_image_destroy(image);
    free(j);
    ty_image_destroy(plain);
    ty_scene_destroy(scene);
}

static void a_change_that_is_not_kept_brings_a_whole_state(void** state) {
    ty_scene* scene = foggy_scene(*state);
    journal* j = calloc(1, sizeof *j);
    assert_non_null(j);
    ty_path_def def = journal_def(j);
    ty_image_destroy(render(scene, &def, NULL));
    assert_true(j->changes > 3);
    *j = (journal){.refuse_at = 1};
    ty_image_destroy(render(scene, &def, NULL));
    assert_true(j->changes > 1);
    free(j);
    ty_scene_destroy(scene);
}

static void states_of_other_renders_are_refused(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(8);
    def.seed = 3;
    size_t size;
    uint8_t* bytes = stopped_state(scene, &def, 2, &size);
    const ty_path_def same = def;
    def.seed = 4;
    refuse(*state, scene, def, bytes, size, "the state is of seed 3, not 4");
    def = same;
    def.width = WIDTH + 1;
    refuse(*state, scene, def, bytes, size, "the state is of 19 x 11 pixels, not 20 x 11");
    def = same;
    def.crop[2] = 3;
    def.crop[3] = 2;
    refuse(*state, scene, def, bytes, size, "the state is of the crop 0,0,19x11, not 0,0,3x2");
    def = same;
    def.max_depth = 9;
    refuse(*state, scene, def, bytes, size, "the state is of max_depth 0, not 9");
    def = same;
    def.aovs |= TY_AOV_DEPTH;
    refuse(*state, scene, def, bytes, size, "the state has other channels");
    def = same;
    def.ignore_media = true;
    refuse(*state, scene, def, bytes, size, "the state is of the scene with its media");
    def = same;
    def.unscattered = 1;
    refuse(*state, scene, def, bytes, size, "the state is of all light");
    free(bytes);
    ty_scene_destroy(scene);
}

static void damaged_states_are_refused(void** state) {
    ty_scene* scene = foggy_scene(*state);
    ty_path_def def = small_def(8);
    def.width = def.height = 5;
    size_t size;
    uint8_t* bytes = stopped_state(scene, &def, 2, &size);
    for (size_t cut = 0; cut < size; cut += cut < 200 ? 1 : 61)
        refuse(*state, scene, def, bytes, cut, cut < 160 ? "is cut short" : "the state is");
    for (size_t i = 0; i < size; ++i) {
        bytes[i] ^= 0x10;
        refuse(*state, scene, def, bytes, size, i < 8 ? "not the state of a render" : "the state ");
        bytes[i] ^= 0x10;
    }
    refuse(*state, scene, def, "a text that is none", 19, "is cut short");
    free(bytes);
    ty_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(states_come_in_time_and_at_the_end),
        cmocka_unit_test(any_state_leads_to_the_same_image),
        cmocka_unit_test(renders_survive_many_interruptions),
        cmocka_unit_test(more_samples_may_follow),
        cmocka_unit_test(error_bounds_survive_interruptions),
        cmocka_unit_test(time_bounds_survive_interruptions),
        cmocka_unit_test(partial_images_come_and_may_cancel),
        cmocka_unit_test(changes_lead_to_the_same_image),
        cmocka_unit_test(a_change_that_is_not_kept_brings_a_whole_state),
        cmocka_unit_test(states_of_other_renders_are_refused),
        cmocka_unit_test(damaged_states_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
