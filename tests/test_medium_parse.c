/* Media in words: what they come to, and every message about those that are wrong. */
#include "checks.h"
#include "io/scenes/medium_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

typedef struct word_case {
    const char* text;
    double sigma_s[3], sigma_a[3], g[3];
} word_case;

static const word_case word_cases[] = {
    {"wholemilk", {2550, 3210, 3770}, {1.1, 2.4, 14}, {0, 0, 0}},
    {" Whole-Milk ", {2550, 3210, 3770}, {1.1, 2.4, 14}, {0, 0, 0}},
    {"wholemilk:1", {2550, 3210, 3770}, {1.1, 2.4, 14}, {0, 0, 0}},
    {"wholemilk:1e3", {2.5508756, 3.2114695, 3.7734985}, {0.2763245, 0.0588435, 0.02321078}, {0, 0, 0}},
    {"Jerlov 7C", {1.918, 2.35, 3.3}, {0.3538, 0.195, 0.542}, {0.9295574, 0.9294003, 0.9289955}},
    {"fog: 100", {0.0299573, 0.0299573, 0.0299573}, {0, 0, 0}, {0.864164, 0.864164, 0.864164}},
    {"haze:100", {0.0243556, 0.02845946, 0.03694037}, {0.00128187, 0.00149787, 0.00194423}, {0.7, 0.7, 0.7}},
    {"{\"sigma_s\":[1,2,3],\"g\":0.5}", {1, 2, 3}, {0, 0, 0}, {0.5, 0.5, 0.5}},
    {"\n {\"sigma_t\":2,\"albedo\":[0,0.5,1],\"scale\":10}\n", {0, 10, 20}, {20, 10, 0}, {0, 0, 0}},
    {"{\"preset\":\"wholemilk\",\"g\":0.5,\"scale\":0.1}", {510, 642, 754}, {0.11, 0.24, 1.4}, {0.5, 0.5, 0.5}},
    {"{\"preset\":\"wholemilk\",\"dilution\":1000,\"g\":0.5}",
     {5.1017512, 6.422939, 7.546997},
     {0.2763245, 0.0588435, 0.02321078},
     {0.5, 0.5, 0.5}},
    {"{\"preset\":\"fog\",\"visibility\":100,\"g\":0.9,\"scale\":2}",
     {0.0599146, 0.0599146, 0.0599146},
     {0, 0, 0},
     {0.9, 0.9, 0.9}},
    {"{\"sigma_s\":2,\"phase\":{\"type\":\"rayleigh\"}}", {2, 2, 2}, {0, 0, 0}, {0, 0, 0}},
    {"{\"sigma_s\":2,\"phase\":{\"type\":\"hg\",\"g\":0.25}}", {2, 2, 2}, {0, 0, 0}, {0.25, 0.25, 0.25}},
    {"{\"preset\":\"wholemilk\",\"phase\":{\"type\":\"mix\",\"lobes\":[{\"weight\":3,\"g\":0.8},{\"weight\":1,\"g\":-0."
     "4}]}}",
     {5100, 6420, 7540},
     {1.1, 2.4, 14},
     {0.5, 0.5, 0.5}},
    {"{\"preset\":\"fog\",\"visibility\":100,\"phase\":{\"type\":\"draine\",\"g\":0.6,\"alpha\":20}}",
     {0.0299573, 0.0299573, 0.0299573},
     {0, 0, 0},
     {0.7642781, 0.7642781, 0.7642781}},
    {"{\"preset\":\"jerlov7c\",\"g\":[0,0.5,-0.5]}", {1.918, 2.35, 3.3}, {0.3538, 0.195, 0.542}, {0, 0.5, -0.5}},
};

static void expect_rgb(const char* text, const char* field, const float value[3], const double expected[3]) {
    for (int c = 0; c < 3; ++c)
        if (!(fabs((double)value[c] - expected[c]) <= 3e-6 * fabs(expected[c])))
            fail_msg("%s: %s[%d] is %.9g, not %.9g", text, field, c, (double)value[c], expected[c]);
}

static void words_come_to_coefficients(void** state) {
    for (size_t i = 0; i < COUNT(word_cases); ++i) {
        const word_case* word = &word_cases[i];
        ty_medium_def def;
        memset(&def, 0xff, sizeof def);
        if (ty_medium_parse(*state, word->text, &def) != TY_OK) fail_msg("%s: %s", word->text, ty_take_error(*state));
        expect_rgb(word->text, "sigma_s", def.sigma_s, word->sigma_s);
        expect_rgb(word->text, "sigma_a", def.sigma_a, word->sigma_a);
        float g[3];
        assert_int_equal(ty_medium_mean_cosine(*state, &def, g), TY_OK);
        expect_rgb(word->text, "g", g, word->g);
        const ty_medium_def fresh = ty_default_medium_def();
        assert_int_equal(def.cookie, fresh.cookie);
        assert_string_equal(def.name, "");
        assert_float_equal(def.scale, 1, 0);
        assert_int_equal(def.bounds, TY_BOUNDS_NONE);
        assert_null(def.density_grid);
    }
}

/* The object of a text is the same medium, bit for bit. */
static void objects_are_the_same_media(void** state) {
    for (size_t i = 0; i < COUNT(word_cases); ++i) {
        ty_medium_def def, again;
        json_t* object = NULL;
        assert_int_equal(ty_medium_object(*state, word_cases[i].text, &object), TY_OK);
        char* text = json_dumps(object, JSON_COMPACT);
        assert_int_equal(ty_medium_parse(*state, word_cases[i].text, &def), TY_OK);
        assert_int_equal(ty_medium_parse(*state, text, &again), TY_OK);
        assert_memory_equal(def.sigma_s, again.sigma_s, sizeof def.sigma_s);
        assert_memory_equal(def.sigma_a, again.sigma_a, sizeof def.sigma_a);
        assert_memory_equal(def.g, again.g, sizeof def.g);
        free(text);
        json_decref(object);
    }
    json_t* none = NULL;
    assert_int_equal(ty_medium_object(*state, "fog", &none), TY_ERROR_INPUT);
    assert_null(none);
    assert_error(*state, "medium: Fog needs its visibility in metres: Fog:50");
}

/* A name and an object say the same, bit for bit, in words and in a scene. */
static void every_preset_is_the_same_in_words_and_in_a_scene(void** state) {
    for (int32_t i = 0; i < ty_medium_preset_count(); ++i) {
        const char* name = ty_medium_preset_name(i);
        const bool visibility = ty_medium_preset_kind(i) == TY_PRESET_VISIBILITY;
        char word[128], object[256], text[512];
        snprintf(word, sizeof word, "%s%s", name, visibility ? ":40" : "");
        snprintf(object, sizeof object, "\"preset\":\"%s\"%s", name, visibility ? ",\"visibility\":40" : "");
        snprintf(text, sizeof text, "{\"tyndall\":1,\"media\":[{%s,\"bounds\":[[0,0,0],[1,1,1]]}]}", object);
        ty_medium_def in_words, in_scene;
        ty_scene* scene = NULL;
        assert_int_equal(ty_medium_parse(*state, word, &in_words), TY_OK);
        assert_int_equal(ty_scene_parse(*state, text, strlen(text), "s.json", NULL, NULL, 0, &scene), TY_OK);
        assert_int_equal(ty_scene_get_medium(scene, 0, &in_scene), TY_OK);
        assert_memory_equal(in_words.sigma_s, in_scene.sigma_s, sizeof in_words.sigma_s);
        assert_memory_equal(in_words.sigma_a, in_scene.sigma_a, sizeof in_words.sigma_a);
        assert_memory_equal(in_words.g, in_scene.g, sizeof in_words.g);
        assert_memory_equal(in_words.phase, in_scene.phase, sizeof in_words.phase);
        assert_int_equal(in_words.phase_count, in_scene.phase_count);
        ty_scene_destroy(scene);
    }
}

static const char* const wrong[][2] = {
    {"{\"sigma_s\":1,\"g\":0.5,\"phase\":{\"type\":\"rayleigh\"}}",
     "medium:1: phase: does not go with \"g\"; give one of them"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"table\",\"angles\":[0,180],\"values\":[1,1]}}",
     "medium:1: phase: a table has no place here; give a formula"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"table\",\"angles\":[0,90,180],\"values\":[1,1]}}",
     "medium:1: phase.values: 2 values do not go with 3 angles"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"table\",\"angles\":[0,90],\"values\":[1,1]}}",
     "medium:1: phase: table: the nodes do not reach from 0 to 180 degrees"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"table\",\"cosines\":[-1,1],\"values\":[0,0]}}",
     "medium:1: phase: table: all values are 0"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"mix\",\"lobes\":[{\"weight\":-1,\"g\":0}]}}",
     "medium:1: phase.lobes[0].weight: -1 is outside [0, 1e+06]"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"mix\",\"lobes\":[{\"weight\":0,\"g\":0}]}}",
     "medium:1: phase: mix: the weights add up to 0"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"mie\",\"diameter\":60}}",
     "medium:1: phase.diameter: 60 is outside [0.001, 50]"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"mie\"}}", "medium:1: phase: the key \"diameter\" is missing"},
    {"{\"sigma_s\":1,\"phase\":{\"type\":\"moe\",\"diameter\":6}}",
     "medium:1: phase.type: \"moe\" is not one of \"hg\", \"rayleigh\", \"draine\", \"mie\", \"mix\", "
     "\"fournier_forand\", \"table\"; did you mean \"mie\"?"},
    {"wholmilk", "medium: there is no medium \"wholmilk\"; did you mean \"Wholemilk\"?"},
    {"", "medium: there is no medium \"\"; 'tyndall info --media' lists all"},
    {"jerlov 1", "medium: there is no medium \"jerlov 1\"; did you mean \"Jerlov I\"?"},
    {"[1]", "medium: there is no medium \"[1]\"; 'tyndall info --media' lists all"},
    {"a\033b:1", "medium: there is no medium \"a?b\"; 'tyndall info --media' lists all"},
    {"\xff", "medium: the name is not UTF-8"},
    {"fog", "medium: Fog needs its visibility in metres: Fog:50"},
    {"fog:", "medium: \"\" is not a number; Fog takes its visibility in metres: Fog:50"},
    {"fog:50m", "medium: \"50m\" is not a number; Fog takes its visibility in metres: Fog:50"},
    {"fog:1,5", "medium: \"1,5\" is not a number; Fog takes its visibility in metres: Fog:50"},
    {"fog:nan", "medium: \"nan\" is not a number; Fog takes its visibility in metres: Fog:50"},
    {"fog:0", "medium: visibility: 0 is outside [0.001, 1e+09]"},
    {"wholemilk:x", "medium: \"x\" is not a number; Wholemilk takes its dilution: Wholemilk:1000"},
    {"wholemilk:0.5", "medium: dilution: 0.5 is outside [1, 1e+12]"},
    {"pure water:3", "medium: Pure Water takes no number"},
    {"{", "medium:1: string or '}' expected near end of file"},
    {"{}", "medium:1: the coefficients are missing; give sigma_s and sigma_a, or sigma_t and albedo, or preset"},
    {"{\"preset\": 3}", "medium:1: preset: expected a string, found 3"},
    {"{\n\"preset\": \"coek\"}", "medium:2: preset: there is no medium \"coek\"; did you mean \"Coke\"?"},
    {"{\"preset\": \"fog\"}", "medium:1: preset: Fog needs its visibility in metres, the key \"visibility\""},
    {"{\"preset\": \"coke\", \"visibility\": 3}",
     "medium:1: visibility: does not go with the preset \"Coke\", only with fog and haze"},
    {"{\"preset\": \"Haze\", \"visibility\": 3, \"dilution\": 2}",
     "medium:1: dilution: does not go with the preset \"Haze\", only with measured media"},
    {"{\"preset\": \"jerlov i\", \"dilution\": 2}",
     "medium:1: dilution: does not go with the preset \"Jerlov I\", only with measured media"},
    {"{\"visibility\": 3}", "medium:1: visibility: the key \"preset\" is missing beside it"},
    {"{\"sigma_s\": 1, \"dilution\": 3}", "medium:1: dilution: the key \"preset\" is missing beside it"},
    {"{\"preset\": \"fog\", \"visibility\": 1e10}", "medium:1: visibility: 1e+10 is outside [0.001, 1e+09]"},
    {"{\"sigma_s\": 1, \"preset\": \"coke\"}",
     "medium:1: preset: does not go with \"sigma_s\"; give sigma_s and sigma_a, or sigma_t and albedo, or preset"},
    {"{\"sigma_t\": 1}", "medium:1: sigma_t: the key \"albedo\" is missing beside it"},
    {"{\"sigma_s\": -1}", "medium:1: sigma_s: -1 is outside [0, 1e+09]"},
    {"{\"preset\": \"spectralon\", \"g\": 0.9999999999, \"scale\": 1e6}",
     "medium:1: sigma_s[0]: 1.94616e+17 is outside [0, 1e+15]"},
    {"{\"sigma_z\": 1}", "medium:1: sigma_z: unknown key; did you mean \"sigma_s\"?"},
    {"{\"sigma_s\": 1, \"bounds\": [[0,0,0],[1,1,1]]}",
     "medium:1: bounds: has no place here, where a medium is the same everywhere; give what it is made of"},
    {"{\"sigma_s\": 1, \"name\": \"a\"}",
     "medium:1: name: has no place here, where a medium is the same everywhere; give what it is made of"},
    {"{\"sigma_s\": 1, \"g\": {\"file\": \"a.vdb\"}}",
     "medium:1: g: a volume has no place here, where a medium is the same everywhere"},
    {"{\"sigma_t\": 1, \"albedo\": {\"file\": \"a.vdb\"}}",
     "medium:1: albedo: a volume has no place here, where a medium is the same everywhere"},
};

static void wrong_words_are_refused(void** state) {
    for (size_t i = 0; i < COUNT(wrong); ++i) {
        ty_medium_def def = ty_default_medium_def();
        def.sigma_s[0] = 7;
        assert_int_equal(ty_medium_parse(*state, wrong[i][0], &def), TY_ERROR_INPUT);
        assert_string_equal(ty_take_error(*state), wrong[i][1]);
        assert_float_equal(def.sigma_s[0], 7, 0);
    }
}

static void missing_arguments_are_refused(void** state) {
    ty_medium_def def = ty_default_medium_def();
    assert_int_equal(ty_medium_parse(NULL, "coke", &def), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_medium_parse(*state, NULL, &def), TY_ERROR_ARGUMENT);
    assert_int_equal(ty_medium_parse(*state, "coke", NULL), TY_ERROR_ARGUMENT);
    assert_error(*state, "ty_medium_parse: context, text or medium is NULL");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_come_to_coefficients),
        cmocka_unit_test(every_preset_is_the_same_in_words_and_in_a_scene),
        cmocka_unit_test(objects_are_the_same_media),
        cmocka_unit_test(wrong_words_are_refused),
        cmocka_unit_test(missing_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, start_context, stop_context);
}
