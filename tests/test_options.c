/* Options of all methods, from the tables that the registry gathers: defaults, ranges, scene files, the schema, and
 * defs of programs that were compiled against an older definition. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "base/context.h"
#include "method/registry.h"
#include "fog.h"

#include <tyndall/tyndall.h>

enum { DEF_SIZE = 1024 };

/* Calls check for every option of every method. */
static void for_options(void (*check)(ty_context* context, const ty_option_table* table, const ty_option* option),
                        ty_context* context) {
    int count = 0;
    for (int32_t m = 0; ty_methods[m] != NULL; ++m) {
        const ty_option_table* table = ty_methods[m]->options;
        if (table == NULL) continue;
        assert_true(table->bytes <= DEF_SIZE);
        for (int32_t i = 0; i < table->count; ++i, ++count) check(context, table, &table->options[i]);
    }
    assert_true(count > 80);
}

static size_t element_size(const ty_option* option) {
    switch (option->type) {
    case TY_OPTION_INT:
    case TY_OPTION_WORD: return sizeof(int32_t);
    case TY_OPTION_DOUBLE: return sizeof(double);
    case TY_OPTION_FLOAT: return sizeof(float);
    case TY_OPTION_BOOL: return sizeof(bool);
    }
    return 0;
}

static void check_description(ty_context* context, const ty_option_table* table, const ty_option* option) {
    (void)context;
    const size_t elements = option->count > 0 ? (size_t)option->count : 1;
    if (option->size != elements * element_size(option))
        fail_msg("%s.%s has another type than its table says", table->name, option->name);
    assert_true(option->offset >= sizeof(ty_def_head) && option->offset + option->size <= table->bytes);
    assert_ptr_equal(ty_option_find(table, option->name), option);
    const size_t length = strlen(option->doc);
    if (length < 10 || option->doc[length - 1] != '.' || strchr("ABCDEFGHIJKLMNOPQRSTUVWXYZ", option->doc[0]) == NULL)
        fail_msg("%s.%s: \"%s\" is not a sentence", table->name, option->name, option->doc);
    if (option->type == TY_OPTION_WORD) assert_non_null(ty_option_word(option, (uint32_t)option->preset));
}

static void options_describe_fields(void** state) {
    for_options(check_description, *state);
}

/* ---- Ranges ---- */

static ty_result take(ty_context* context, const ty_option_table* table, const void* def) {
    _Alignas(16) char own[DEF_SIZE];
    ty_take_error(context);
    return ty_options_take(context, table, def, own);
}

/* Sets the field to a value. */
static void put(const ty_option* option, void* def, double value) {
    char* field = (char*)def + option->offset;
    const int32_t whole = option->type == TY_OPTION_INT ? (int32_t)value : 0;
    const float single = (float)value;
    if (option->type == TY_OPTION_INT) memcpy(field, &whole, sizeof whole);
    if (option->type == TY_OPTION_DOUBLE) memcpy(field, &value, sizeof value);
    if (option->type == TY_OPTION_FLOAT) memcpy(field, &single, sizeof single);
}

/* A value is taken or refused, by a message that begins with the field and names the range. */
static void expect(ty_context* context, const ty_option_table* table, const ty_option* option, double value,
                   bool taken) {
    _Alignas(16) char def[DEF_SIZE];
    char field[64];
    ty_options_init(table, def, table->bytes);
    put(option, def, value);
    const ty_result result = take(context, table, def);
    if ((result == TY_OK) != taken)
        fail_msg("%s.%s: %g: %s: %s", table->name, option->name, value, ty_result_name(result), ty_take_error(context));
    if (taken) return;
    assert_int_equal(result, TY_ERROR_ARGUMENT);
    snprintf(field, sizeof field, "%s.%s", table->name, option->name);
    const char* message = ty_take_error(context);
    assert_int_equal(strncmp(message, field, strlen(field)), 0);
    assert_true(strstr(message, " is outside ") != NULL || strstr(message, " is not a multiple of ") != NULL);
    if ((option->flags & TY_OPTION_AUTO) != 0) assert_non_null(strstr(message, "TY_AUTO"));
}

static void check_range(ty_context* context, const ty_option_table* table, const ty_option* option) {
    if (option->type == TY_OPTION_WORD || option->type == TY_OPTION_BOOL) return;
    const bool whole = option->type == TY_OPTION_INT;
    const bool open_min = (option->flags & TY_OPTION_OPEN_MIN) != 0,
               open_max = (option->flags & TY_OPTION_OPEN_MAX) != 0;
    const double step = option->multiple > 0 ? option->multiple : 1;
    expect(context, table, option, option->min, !open_min);
    expect(context, table, option, option->max, !open_max);
    /* Just outside; -1 may be TY_AUTO, and 0 may mean none. */
    const double below = whole ? option->min - step : option->min - 1e-3 * fmax(1e-3, fabs(option->min));
    const bool zero = below == 0 && (option->flags & TY_OPTION_OR_ZERO) != 0;
    const bool automatic = below == TY_AUTO && (option->flags & TY_OPTION_AUTO) != 0;
    if (option->min > INT32_MIN && !zero && !automatic) expect(context, table, option, below, false);
    if (option->max < INT32_MAX)
        expect(context, table, option, whole ? option->max + step : option->max * 1.001 + 1e-6, false);
    if (!whole) expect(context, table, option, (double)NAN, false);
    if ((option->flags & TY_OPTION_AUTO) != 0) expect(context, table, option, TY_AUTO, true);
    if ((option->flags & TY_OPTION_AUTO) != 0) expect(context, table, option, 0, option->min <= 0 && !open_min);
    if ((option->flags & TY_OPTION_OR_ZERO) != 0) expect(context, table, option, 0, true);
}

static void ranges_hold(void** state) {
    for_options(check_range, *state);
}

static void check_words(ty_context* context, const ty_option_table* table, const ty_option* option) {
    _Alignas(16) char def[DEF_SIZE];
    if (option->type != TY_OPTION_WORD) return;
    const int32_t wrong = 0x1234567;
    ty_options_init(table, def, table->bytes);
    memcpy(def + option->offset, &wrong, sizeof wrong);
    assert_int_equal(take(context, table, def), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), option->name));
    for (int32_t i = 0; option->words[i] != NULL; ++i) {
        ty_take_error(context);
        assert_int_equal(ty_options_set(context, table, def, option->name, option->words[i]), TY_OK);
        char text[TY_OPTION_TEXT_SIZE];
        ty_option_text(option, ty_option_value(option, def), text);
        assert_string_equal(text, option->words[i]);
        assert_int_equal(take(context, table, def), TY_OK);
    }
}

static void words_are_numbers_and_back(void** state) {
    for_options(check_words, *state);
}

/* ---- Scenes ---- */

/* The schema has the option, with its default, and takes the default's text in a scene file. */
static void check_in_files(ty_context* context, const ty_option_table* table, const ty_option* option) {
    char text[TY_OPTION_TEXT_SIZE], file[256];
    ty_option_text(option, option->preset, text);
    const bool quoted = option->type == TY_OPTION_WORD || strcmp(text, "auto") == 0;
    snprintf(file, sizeof file, "{\"tyndall\":1,\"render\":{\"%s\":{\"%s\":%s%s%s}}}", table->name, option->name,
             quoted ? "\"" : "", text, quoted ? "\"" : "");
    ty_scene* scene = NULL;
    ty_take_error(context);
    const ty_result result = ty_scene_parse(context, file, strlen(file), "test", NULL, NULL, 0, &scene);
    if ((option->flags & TY_OPTION_CALLS_ONLY) != 0) {
        assert_int_equal(result, TY_ERROR_INPUT);
        return;
    }
    if (result != TY_OK) fail_msg("%s: %s", file, ty_take_error(context));
    _Alignas(16) char asked[DEF_SIZE], plain[DEF_SIZE];
    ty_options_init(table, asked, table->bytes);
    ty_options_init(table, plain, table->bytes);
    assert_string_equal(ty_scene_get_option(scene, table->name, option->name), text);
    assert_int_equal(ty_method_options(scene, table->name, asked), TY_OK);
    assert_memory_equal(asked, plain, table->bytes);
    ty_scene_destroy(scene);
}

static void files_have_all_options(void** state) {
    for_options(check_in_files, *state);
}

static void check_automatic(ty_context* context, const ty_option_table* table, const ty_option* option) {
    if ((option->flags & TY_OPTION_AUTO) == 0 || (option->min <= 0 && (option->flags & TY_OPTION_OPEN_MIN) == 0))
        return;
    char file[256];
    ty_scene* scene = NULL;
    snprintf(file, sizeof file, "{\"tyndall\":1,\n\"render\":{\"%s\":{\"%s\":0}}}", table->name, option->name);
    ty_take_error(context);
    assert_int_equal(ty_scene_parse(context, file, strlen(file), "old.json", NULL, NULL, 0, &scene), TY_ERROR_INPUT);
    char begins[96];
    snprintf(begins, sizeof begins, "old.json:2: render.%s.%s: 0 is outside ", table->name, option->name);
    const char* message = ty_take_error(context);
    assert_int_equal(strncmp(message, begins, strlen(begins)), 0);
    assert_non_null(strstr(message, "write \"auto\""));
}

static void zero_is_refused_for_auto(void** state) {
    for_options(check_automatic, *state);
}

static void scenes_carry_options(void** state) {
    ty_context* context = *state;
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    ty_dom_def def = ty_default_dom_def(), again = ty_default_dom_def();
    assert_int_equal(ty_scene_set_option(scene, "dom", "directions", "48"), TY_OK);
    assert_int_equal(ty_scene_set_option(scene, "dom", "acceleration", "none"), TY_OK);
    assert_int_equal(ty_scene_set_option(scene, "dom", "tolerance", "0.25"), TY_OK);
    assert_int_equal(ty_scene_set_option(scene, "fld", "limiter", "kershaw"), TY_OK);
    assert_int_equal(ty_method_options(scene, "dom", &def), TY_OK);
    assert_int_equal(def.directions, 48);
    assert_int_equal(def.acceleration, TY_DOM_ACCELERATION_NONE);
    assert_true(def.tolerance == 0.25 && def.resolution == TY_AUTO);
    def.directions = 200;
    assert_int_equal(ty_method_set_options(scene, "dom", &def), TY_OK);
    assert_int_equal(ty_method_options(scene, "dom", &again), TY_OK);
    assert_memory_equal(&again, &def, sizeof def);
    assert_int_equal(ty_scene_set_option(scene, "dom", "directions", NULL), TY_OK);
    assert_null(ty_scene_get_option(scene, "dom", "directions"));
    ty_fld_def fld = ty_default_fld_def();
    assert_int_equal(ty_method_options(scene, "cda", &fld), TY_OK); /* which has the options of fld */
    assert_int_equal(fld.limiter, TY_FLD_LIMITER_KERSHAW);
    static const char* const wrong[][3] = {{"directions", "7", "render.dom.directions: 7 is outside [8, 1024]"},
                                           {"directions", "8.5", "\"8.5\" is not one of its values"},
                                           {"resolution", "-1", "write \"auto\""},
                                           {"acceleration", "fast", "\"fast\" is not one of its values"},
                                           {"direktions", "8", "render.dom.direktions: there is no such option"},
                                           {"seed", "8", "render.dom.seed: there is no such option"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        ty_take_error(context);
        assert_int_equal(ty_scene_set_option(scene, "dom", wrong[i][0], wrong[i][1]), TY_OK);
        assert_int_equal(ty_method_options(scene, "dom", &def), TY_ERROR_ARGUMENT);
        const char* message = ty_take_error(context);
        if (strstr(message, wrong[i][2]) == NULL) fail_msg("%s", message);
        ty_scene_set_option(scene, "dom", wrong[i][0], NULL);
    }
    assert_int_equal(ty_method_options(scene, "auto", &def), TY_ERROR_ARGUMENT);
    ty_take_error(context);
    ty_pop_def pop = ty_default_pop_def();
    assert_int_equal(ty_method_options(scene, "path", &pop), TY_ERROR_ARGUMENT); /* a larger def than path has */
    assert_error(context, "render.path: the def has ");
    ty_scene_destroy(scene);
}

/* ---- Defs of older programs ---- */

/* Memory of a def as a program with a smaller struct has it, with marks behind. */
typedef struct old_def {
    _Alignas(16) char bytes[DEF_SIZE];
} old_def;

static void expect_marks(const old_def* def, size_t from) {
    for (size_t i = from; i < sizeof def->bytes; ++i) assert_int_equal(def->bytes[i], 0x5a);
}

static void smaller_defs_keep_defaults(void** state) {
    const size_t size = offsetof(ty_fld_def, relaxation); /* there were no options after the solver */
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    old_def old;
    ty_fld_def whole = ty_default_fld_def();
    ty_fld_stats stats = ty_default_fld_stats(), expected = ty_default_fld_stats();
    ty_fld* light = NULL;
    memset(&old, 0x5a, sizeof old);
    ty_init_fld_def(&old, size);
    expect_marks(&old, size);
    const int32_t resolution = 8;
    memcpy(old.bytes + offsetof(ty_fld_def, resolution), &resolution, sizeof resolution);
    whole.resolution = resolution;
    ty_take_error(context);
    if (ty_fld_solve(scene, (const ty_fld_def*)old.bytes, &light, &stats) != TY_OK)
        fail_msg("%s", ty_take_error(context));
    ty_fld_destroy(light);
    assert_int_equal(ty_fld_solve(scene, &whole, &light, &expected), TY_OK);
    ty_fld_destroy(light);
    assert_memory_equal(stats.iterations, expected.iterations, sizeof stats.iterations);
    assert_memory_equal(stats.leaving, expected.leaving, sizeof stats.leaving);
    assert_int_equal(stats.direct_size[0], resolution);
    expect_marks(&old, size);
    /* Options behind the end of the def cannot be set, and are told so. */
    assert_int_equal(ty_scene_set_option(scene, "fld", "tolerance", "0.5"), TY_OK);
    assert_int_equal(ty_method_options(scene, "fld", old.bytes), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "older"));
    ty_scene_destroy(scene);
}

/* Statistics of an older program are filled in as far as they go, and those that no default function made are refused.
 */
static void smaller_stats_are_filled_in_so_far(void** state) {
    const size_t size = offsetof(ty_fld_stats, solve_seconds);
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    old_def old;
    ty_fld_def def = ty_default_fld_def();
    ty_fld_stats whole = ty_default_fld_stats(), copy = ty_default_fld_stats(), unmade = {0};
    ty_fld* light = NULL;
    ty_image* image = NULL;
    memset(&old, 0x5a, sizeof old);
    ty_init_stats(&old, size);
    expect_marks(&old, size);
    def.resolution = 8;
    assert_int_equal(ty_fld_solve(scene, &def, &light, (ty_fld_stats*)old.bytes), TY_OK);
    expect_marks(&old, size);
    ty_fld_destroy(light);
    assert_int_equal(ty_fld_render(scene, &def, &image, &whole), TY_OK);
    ty_image_destroy(image);
    memcpy(&copy, old.bytes, size);
    assert_int_equal(copy.bytes, size);
    assert_int_equal(whole.bytes, sizeof whole);
    assert_memory_equal(copy.iterations, whole.iterations, sizeof whole.iterations);
    assert_memory_equal(copy.leaving, whole.leaving, sizeof whole.leaving);
    assert_true(copy.direct_seconds > 0 && copy.solve_seconds == 0 && whole.solve_seconds > 0);
    assert_true(whole.march_seconds > 0 && whole.isa != NULL);
    ty_take_error(context);
    assert_int_equal(ty_fld_solve(scene, &def, &light, &unmade), TY_ERROR_ARGUMENT);
    assert_null(light);
    assert_non_null(strstr(ty_take_error(context), "ty_default_fld_stats"));
    ty_scene_destroy(scene);
}

/* A program of a newer version has fields that this library leaves at 0. */
static void larger_stats_keep_zeros_behind(void** state) {
    struct {
        ty_path_stats known;
        double later;
    } newer;
    const ty_path_stats made = {.seconds = 2, .paths = 3};
    ty_path_stats own;
    ty_init_stats(&newer, sizeof newer);
    assert_int_equal(ty_take_stats(*state, &newer, "ty_default_path_stats", &own, sizeof own), TY_OK);
    ty_give_stats(&made, sizeof made, &newer);
    assert_true(newer.known.seconds == 2 && newer.known.paths == 3 && newer.later == 0);
    assert_int_equal(newer.known.bytes, sizeof newer);
    assert_int_equal(ty_take_stats(*state, NULL, "ty_default_path_stats", &own, sizeof own), TY_OK);
    ty_give_stats(&made, sizeof made, NULL);
}

/* The stats of every call are checked before any work. */
static void all_stats_are_checked(void** state) {
    ty_context* context = *state;
    ty_scene* scene = foggy_scene(context);
    ty_image* image = NULL;
    ty_impulse* tables = NULL;
    ty_bake_probe probe;
    const float position[3] = {0};
    ty_take_error(context);
#define EXPECT_REFUSED(name, call)                                                                                     \
    do {                                                                                                               \
        ty_##name##_stats unmade = {0};                                                                                \
        assert_int_equal(call, TY_ERROR_ARGUMENT);                                                                     \
        assert_non_null(strstr(ty_take_error(context), "ty_default_" #name "_stats"));                                 \
        const ty_##name##_stats made = ty_default_##name##_stats();                                                    \
        assert_int_equal(made.bytes, sizeof made);                                                                     \
    } while (0)
#define EXPECT_RENDER_REFUSED(name)                                                                                    \
    do {                                                                                                               \
        const ty_##name##_def def = ty_default_##name##_def();                                                         \
        EXPECT_REFUSED(name, ty_##name##_render(scene, &def, &image, &unmade));                                        \
    } while (0)
    EXPECT_RENDER_REFUSED(path);
    EXPECT_RENDER_REFUSED(fld);
    EXPECT_RENDER_REFUSED(pop);
    EXPECT_RENDER_REFUSED(dom);
    EXPECT_RENDER_REFUSED(lpv);
    EXPECT_RENDER_REFUSED(octaves);
    const ty_screen_def screen = ty_default_screen_def();
    const ty_screen_image picture = ty_default_screen_image();
    EXPECT_REFUSED(screen, ty_screen_apply(context, &screen, &picture, NULL, 0, &unmade));
    const ty_impulse_def impulse = ty_default_impulse_def();
    EXPECT_REFUSED(impulse, ty_impulse_create(context, &impulse, &tables, &unmade));
    const ty_denoise_def denoise = ty_default_denoise_def();
    ty_image* noisy = NULL;
    assert_int_equal(ty_image_create_rgb(context, 1, 1, &noisy), TY_OK);
    EXPECT_REFUSED(denoise, ty_denoise_image(context, noisy, &denoise, &image, &unmade));
    ty_image_destroy(noisy);
    const ty_bake_def bake = ty_default_bake_def();
    EXPECT_REFUSED(bake, ty_bake_probes(scene, &bake, position, 1, &probe, &unmade));
    EXPECT_REFUSED(bake, ty_bake_surfaces(scene, &bake, NULL, 0, NULL, &unmade));
    ty_scene_destroy(scene);
}

static void all_defs_have_sizes(void** state) {
    ty_context* context = *state;
    ty_camera_def camera = ty_default_camera_def();
    ty_scene* scene = NULL;
    assert_int_equal(ty_scene_create(context, TY_AXIS_Y, &scene), TY_OK);
    old_def old;
    memset(&old, 0x5a, sizeof old);
    ty_init_camera_def(&old, offsetof(ty_camera_def, fov_y));
    expect_marks(&old, offsetof(ty_camera_def, fov_y));
    assert_int_equal(ty_scene_set_camera(scene, (const ty_camera_def*)old.bytes), TY_OK);
    assert_true(ty_scene_camera(scene).fov_y == camera.fov_y);
    ty_scene_copy_camera(scene, &old, offsetof(ty_camera_def, fov_y));
    expect_marks(&old, offsetof(ty_camera_def, fov_y));
    /* A def of a newer program has fields that this library does not know. */
    ++camera.bytes;
    ty_take_error(context);
    assert_int_equal(ty_scene_set_camera(scene, &camera), TY_ERROR_ARGUMENT);
    assert_non_null(strstr(ty_take_error(context), "newer"));
    ty_scene_destroy(scene);
    ty_context_def def = ty_default_context_def();
    assert_int_equal(def.bytes, sizeof def);
    ++def.bytes;
    ty_context* none = NULL;
    assert_int_equal(ty_context_create(&def, &none), TY_ERROR_ARGUMENT);
}

static void methods_are_found_by_name(void** state) {
    (void)state;
    int32_t count = 0;
    for (; ty_method_name(count) != NULL; ++count)
        assert_ptr_equal(ty_method_find(ty_method_name(count)), ty_methods[count]);
    assert_true(count >= 7);
    assert_null(ty_method_name(-1));
    assert_null(ty_method_name(count + 1));
    assert_null(ty_method_find("nonsense"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(options_describe_fields),    cmocka_unit_test(ranges_hold),
        cmocka_unit_test(words_are_numbers_and_back), cmocka_unit_test(files_have_all_options),
        cmocka_unit_test(zero_is_refused_for_auto),   cmocka_unit_test(scenes_carry_options),
        cmocka_unit_test(smaller_defs_keep_defaults), cmocka_unit_test(all_defs_have_sizes),
        cmocka_unit_test(methods_are_found_by_name),  cmocka_unit_test(smaller_stats_are_filled_in_so_far),
        cmocka_unit_test(all_stats_are_checked),      cmocka_unit_test(larger_stats_keep_zeros_behind),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
