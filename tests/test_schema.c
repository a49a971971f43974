/* The schema checker, the line finder, and the scene schema itself. */
#include <locale.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/json_locate.h"
#include "io/scenes/schema.h"
#include "io/schema_text.h"

#include <tyndall/io.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static json_t* parse(const char* text) {
    json_error_t error;
    json_t* value = json_loads(text, JSON_DECODE_ANY | JSON_REJECT_DUPLICATES, &error);
    if (value == NULL) fail_msg("%s: %s", text, error.text);
    return value;
}

/* A small schema with every keyword. */
static const char zoo[] =
    "{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"version\"],\"properties\":{"
    "\"version\":{\"const\":1},"
    "\"range\":{\"type\":\"number\",\"minimum\":0,\"exclusiveMaximum\":2},"
    "\"above\":{\"type\":\"number\",\"exclusiveMinimum\":0},"
    "\"even\":{\"type\":\"integer\",\"multipleOf\":2},"
    "\"word\":{\"enum\":[\"red\",\"green\"]},"
    "\"text\":{\"type\":\"string\",\"minLength\":1},"
    "\"flag\":{\"type\":\"boolean\"},"
    "\"list\":{\"type\":\"array\",\"maxItems\":2,\"items\":{\"$ref\":\"#/$defs/point\"}},"
    "\"value\":{\"anyOf\":[{\"type\":\"number\"},{\"type\":\"array\",\"minItems\":2,\"items\":{\"type\":\"number\"}}]},"
    "\"shape\":{\"oneOf\":[{\"$ref\":\"#/$defs/circle\"},{\"$ref\":\"#/$defs/square\"},{\"$ref\":\"#/$defs/grid\"}]},"
    "\"form\":{\"anyOf\":[{\"$ref\":\"#/$defs/point\"},{\"$ref\":\"#/$defs/named\"}]}},"
    "\"$defs\":{"
    "\"point\":{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"x\"],\"properties\":{"
    "\"x\":{\"type\":\"number\"},\"color\":{\"type\":\"string\"}}},"
    "\"named\":{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"name\"],\"properties\":{"
    "\"name\":{\"type\":\"string\"},\"color\":{\"type\":\"string\"}}},"
    "\"circle\":{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"type\",\"radius\"],\"properties\":{"
    "\"type\":{\"const\":\"circle\"},\"radius\":{\"type\":\"number\"}}},"
    "\"square\":{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"type\",\"side\"],\"properties\":{"
    "\"type\":{\"const\":\"square\"},\"side\":{\"type\":\"number\"}}},"
    "\"grid\":{\"type\":\"object\",\"additionalProperties\":false,\"required\":[\"type\",\"rows\"],\"properties\":{"
    "\"type\":{\"const\":\"square\"},\"rows\":{\"type\":\"integer\"}}}}}";

typedef struct zoo_case {
    const char* members; /* beside "version":1 */
    const char* path;    /* NULL: no issue */
    const char* text;
} zoo_case;

static const zoo_case zoo_cases[] = {
    {"", NULL, NULL},
    {",\"range\":0", NULL, NULL},
    {",\"range\":1.5", NULL, NULL},
    {",\"range\":2", "range", "2 is outside [0, 2)"},
    {",\"range\":-1e-3", "range", "-0.001 is outside [0, 2)"},
    {",\"range\":\"1\"", "range", "expected a number, found a string"},
    {",\"range\":true", "range", "expected a number, found true"},
    {",\"above\":0", "above", "0 is outside (0, inf)"},
    {",\"above\":0.1", NULL, NULL},
    {",\"even\":4.0", NULL, NULL},
    {",\"even\":3", "even", "3 is not a multiple of 2"},
    {",\"even\":2.5", "even", "expected an integer, found 2.5"},
    {",\"word\":\"green\"", NULL, NULL},
    {",\"word\":\"gren\"", "word", "\"gren\" is not one of \"red\", \"green\"; did you mean \"green\"?"},
    {",\"word\":\"mauve\"", "word", "\"mauve\" is not one of \"red\", \"green\""},
    {",\"word\":3", "word", "3 is not one of \"red\", \"green\""},
    {",\"text\":\"\"", "text", "is empty"},
    {",\"text\":null", "text", "expected a string, found null"},
    {",\"flag\":false", NULL, NULL},
    {",\"flag\":0", "flag", "expected true or false, found 0"},
    {",\"list\":[{\"x\":1},{\"x\":2}]", NULL, NULL},
    {",\"list\":[{\"x\":1},{}]", "list[1]", "the key \"x\" is missing"},
    {",\"list\":[{\"x\":1},{\"x\":[]}]", "list[1].x", "expected a number, found an array"},
    {",\"list\":[{\"x\":1},{\"x\":2},{\"x\":3}]", "list", "expected at most 2 items, found 3"},
    {",\"value\":3", NULL, NULL},
    {",\"value\":[1,2]", NULL, NULL},
    {",\"value\":[1]", "value", "expected at least 2 items, found 1"},
    {",\"value\":[1,null]", "value[1]", "expected a number, found null"},
    {",\"value\":\"x\"", "value", "expected a number or an array, found a string"},
    {",\"shape\":{\"type\":\"circle\",\"radius\":1}", NULL, NULL},
    {",\"shape\":{\"type\":\"square\",\"rows\":1}", NULL, NULL},
    {",\"shape\":{\"type\":\"circle\",\"radius\":{}}", "shape.radius", "expected a number, found an object"},
    {",\"shape\":{\"type\":\"circle\"}", "shape", "the key \"radius\" is missing"},
    {",\"shape\":{\"type\":\"circle\",\"side\":1}", "shape.side", "does not go with type \"circle\""},
    {",\"shape\":{\"type\":\"square\",\"side\":1,\"rows\":1}", "shape.rows", "does not go with \"side\""},
    {",\"shape\":{\"type\":\"square\"}", "shape", "one of the keys \"side\", \"rows\" is missing"},
    {",\"shape\":{\"type\":\"squire\"}", "shape.type",
     "\"squire\" is not one of \"circle\", \"square\"; did you mean \"square\"?"},
    {",\"shape\":{\"tpye\":\"square\"}", "shape.tpye", "unknown key; did you mean \"type\"?"},
    {",\"shape\":{\"side\":1}", "shape", "the key \"type\" is missing"},
    {",\"shape\":[]", "shape", "expected an object, found an array"},
    {",\"form\":{\"x\":1}", NULL, NULL},
    {",\"form\":{\"name\":\"a\",\"color\":\"b\"}", NULL, NULL},
    {",\"form\":{\"color\":\"b\"}", "form", "one of the keys \"x\", \"name\" is missing"},
    {",\"form\":{\"x\":1,\"name\":\"a\"}", "form.name", "does not go with \"x\""},
    {",\"form\":{\"nmae\":\"a\"}", "form.nmae", "unknown key; did you mean \"name\"?"},
    {",\"form\":{\"quux\":\"a\"}", "form.quux", "unknown key; known here: \"x\", \"color\", \"name\""},
    {",\"rnage\":1", "rnage", "unknown key; did you mean \"range\"?"},
    {",\"a\\nb\":1", "a?b",
     "unknown key; known here: \"version\", \"range\", \"above\", \"even\", \"word\", \"text\", \"flag\", \"list\", "
     "\"value\", \"shape\", \"form\""},
};

static void issues_are_named(void** state) {
    (void)state;
    json_t* schema = parse(zoo);
    for (size_t i = 0; i < COUNT(zoo_cases); ++i) {
        const zoo_case* row = &zoo_cases[i];
        char text[512], path[128];
        snprintf(text, sizeof text, "{\"version\":1%s}", row->members);
        json_t* value = parse(text);
        ty_schema_issue issue;
        const bool good = ty_schema_check(schema, value, &issue);
        if (good != (row->path == NULL)) fail_msg("%s: %s", text, good ? "accepted" : issue.text);
        if (!good) {
            ty_json_path_text(&issue.path, path, sizeof path);
            assert_string_equal(path, row->path);
            assert_string_equal(issue.text, row->text);
        }
        json_decref(value);
    }
    json_decref(schema);
}

static void version_comes_first(void** state) {
    (void)state;
    json_t* schema = parse(zoo);
    json_t* value = parse("{\"new\":1,\"version\":2}");
    ty_schema_issue issue;
    assert_false(ty_schema_check(schema, value, &issue));
    assert_string_equal(issue.text, "expected 1, found 2");
    json_decref(value);
    value = parse("{\"version\":1.0}");
    assert_true(ty_schema_check(schema, value, &issue));
    json_decref(value);
    value = parse("[]");
    assert_false(ty_schema_check(schema, value, &issue));
    assert_string_equal(issue.text, "expected an object, found an array");
    assert_int_equal(issue.path.depth, 0);
    json_decref(value);
    json_decref(schema);
}

static void broken_schema_is_reported(void** state) {
    (void)state;
    json_t* schema = parse("{\"$ref\":\"#/$defs/gone\"}");
    json_t* value = parse("1");
    ty_schema_issue issue;
    assert_false(ty_schema_check(schema, value, &issue));
    assert_string_equal(issue.text, "the schema itself is broken");
    json_decref(value);
    json_decref(schema);
}

static void words_are_quoted(void** state) {
    (void)state;
    assert_int_equal(ty_word_distance("", ""), 0);
    assert_int_equal(ty_word_distance("", "abc"), 3);
    assert_int_equal(ty_word_distance("kitten", "sitting"), 3);
    assert_int_equal(ty_word_distance("Sigma_S", "sigma_s"), 0);
    assert_int_equal(ty_word_distance("tpye", "type"), 1);
    assert_int_equal(ty_word_distance("abcdef", "badcfe"), 3);
    assert_true(ty_word_is_similar("sigma_z", "sigma_s"));
    assert_true(ty_word_is_similar("fov", "fov_y"));
    assert_true(ty_word_is_similar("cam", "camera"));
    assert_false(ty_word_is_similar("u", "g"));
    assert_false(ty_word_is_similar("radius", "density"));
    char long_word[200];
    memset(long_word, 'x', sizeof long_word - 1);
    long_word[sizeof long_word - 1] = '\0';
    assert_int_equal(ty_word_distance(long_word, "x"), 62);
}

static void expect_number(double value, const char* expected) {
    char text[64] = "";
    ty_append_number(text, sizeof text, value);
    assert_string_equal(text, expected);
}

static void numbers_are_shortest_in_every_locale(void** state) {
    (void)state;
    static const char* const locales[] = {"C", "de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"};
    for (size_t i = 0; i < COUNT(locales); ++i) {
        if (setlocale(LC_NUMERIC, locales[i]) == NULL) continue;
        expect_number(1.2, "1.2");
        expect_number(0.1 + 0.2, "0.30000000000000004");
        expect_number(-3, "-3");
        expect_number(180, "180");
        expect_number(1e300, "1e+300");
    }
    setlocale(LC_NUMERIC, "C");
}

static void long_text_is_cut_between_characters(void** state) {
    (void)state;
    assert_int_equal(ty_text_fit("abc", 10), 3);
    assert_int_equal(ty_text_fit("abc", 2), 2);
    assert_int_equal(ty_text_fit("a\xc3\xa4", 2), 1);
    char text[16] = "";
    ty_append_quoted(text, sizeof text, "a\x01z");
    assert_string_equal(text, "\"a?z\"");
}

/* ---- Lines ---- */

static const char document[] = "{\n"
                               "  \"a\": 1, \"b\": {\n"
                               "    \"c\": [1,\n"
                               "      {\"d\": \"}]\\\"\",\n"
                               "       \"\\u0065\": null}, [],\n"
                               "      7]\n"
                               "  },\n"
                               "  \"f\": []\n"
                               "}\n";

static int32_t line_of(const char* text, size_t length, const char* key0, int index, const char* key1) {
    ty_json_path path = {.depth = 0};
    if (key0 != NULL && strcmp(key0, "c") == 0) path = ty_json_path_key(&path, "b");
    if (key0 != NULL) path = ty_json_path_key(&path, key0);
    if (index >= 0) path = ty_json_path_index(&path, (size_t)index);
    if (key1 != NULL) path = ty_json_path_key(&path, key1);
    return ty_json_line(text, length, &path);
}

static void lines_are_found(void** state) {
    (void)state;
    const size_t length = strlen(document);
    assert_int_equal(line_of(document, length, NULL, -1, NULL), 1);
    assert_int_equal(line_of(document, length, "a", -1, NULL), 2);
    assert_int_equal(line_of(document, length, "b", -1, NULL), 2);
    assert_int_equal(line_of(document, length, "c", -1, NULL), 3);
    assert_int_equal(line_of(document, length, "c", 0, NULL), 3);
    assert_int_equal(line_of(document, length, "c", 1, NULL), 4);
    assert_int_equal(line_of(document, length, "c", 1, "d"), 4);
    assert_int_equal(line_of(document, length, "c", 1, "e"), 5);
    assert_int_equal(line_of(document, length, "c", 2, NULL), 5);
    assert_int_equal(line_of(document, length, "c", 3, NULL), 6);
    assert_int_equal(line_of(document, length, "f", -1, NULL), 8);
    assert_int_equal(line_of(document, length, "c", 4, NULL), 0);
    assert_int_equal(line_of(document, length, "f", 0, NULL), 0);
    assert_int_equal(line_of(document, length, "g", -1, NULL), 0);
    assert_int_equal(line_of(document, length, "a", 0, NULL), 0);
    for (size_t cut = 0; cut <= length; ++cut) { /* broken text is read safely */
        char* copy = malloc(cut + 1);
        memcpy(copy, document, cut);
        line_of(copy, cut, "c", 3, NULL);
        line_of(copy, cut, "c", 1, "e");
        free(copy);
    }
}

static void paths_are_named(void** state) {
    (void)state;
    const ty_json_path root = {.depth = 0};
    const ty_json_path media = ty_json_path_key(&root, "media");
    const ty_json_path first = ty_json_path_index(&media, 0), second = ty_json_path_index(&media, 1);
    const ty_json_path g = ty_json_path_key(&first, "g");
    char text[64];
    ty_json_path_text(&g, text, sizeof text);
    assert_string_equal(text, "media[0].g");
    assert_true(ty_json_path_within(&g, &root));
    assert_true(ty_json_path_within(&g, &first));
    assert_true(ty_json_path_within(&g, &g));
    assert_false(ty_json_path_within(&g, &second));
    assert_false(ty_json_path_within(&media, &g));
    ty_json_path deep = root;
    for (int i = 0; i < 2 * TY_JSON_PATH_STEPS; ++i) deep = ty_json_path_index(&deep, 9);
    assert_int_equal(deep.depth, TY_JSON_PATH_STEPS);
    char small[8];
    ty_json_path_text(&deep, small, sizeof small);
    assert_string_equal(small, "[9][9][");
}

/* ---- The scene schema ---- */

/* Fails on a keyword that the checker would not look at, and on a default that is against its own schema. */
static void check_keywords(const json_t* root, const json_t* schema) {
    static const char* const known[] = {"$schema",
                                        "$defs",
                                        "$ref",
                                        "title",
                                        "description",
                                        "default",
                                        "type",
                                        "const",
                                        "enum",
                                        "minimum",
                                        "maximum",
                                        "exclusiveMinimum",
                                        "exclusiveMaximum",
                                        "multipleOf",
                                        "minLength",
                                        "items",
                                        "minItems",
                                        "maxItems",
                                        "properties",
                                        "additionalProperties",
                                        "required",
                                        "anyOf",
                                        "oneOf",
                                        "x-formerly"};
    const char* key;
    json_t *value, *inner;
    json_object_foreach((json_t*)schema, key, value) {
        bool found = false;
        for (size_t i = 0; i < COUNT(known); ++i) found = found || strcmp(key, known[i]) == 0;
        if (!found) fail_msg("keyword %s is not checked", key);
        if (strcmp(key, "properties") == 0 || strcmp(key, "$defs") == 0) {
            const char* name;
            json_object_foreach(value, name, inner) check_keywords(root, inner);
        }
        if (strcmp(key, "anyOf") == 0 || strcmp(key, "oneOf") == 0) {
            size_t i;
            json_array_foreach(value, i, inner) check_keywords(root, inner);
        }
        if (strcmp(key, "items") == 0) check_keywords(root, value);
        if (strcmp(key, "default") == 0) {
            json_t* own = json_copy((json_t*)schema);
            json_object_set(own, "$defs", json_object_get(root, "$defs"));
            ty_schema_issue issue;
            if (!ty_schema_check(own, value, &issue)) fail_msg("a default: %s", issue.text);
            json_decref(own);
        }
        if (strcmp(key, "$ref") == 0) {
            const char* name = json_string_value(value) + strlen("#/$defs/");
            if (json_object_get(json_object_get(root, "$defs"), name) == NULL) fail_msg("%s is not there", name);
        }
    }
}

static void scene_schema_is_sound(void** state) {
    (void)state;
    json_t* schema = parse(ty_scene_schema());
    check_keywords(schema, schema);
    json_decref(schema);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(issues_are_named),
        cmocka_unit_test(version_comes_first),
        cmocka_unit_test(broken_schema_is_reported),
        cmocka_unit_test(words_are_quoted),
        cmocka_unit_test(numbers_are_shortest_in_every_locale),
        cmocka_unit_test(long_text_is_cut_between_characters),
        cmocka_unit_test(lines_are_found),
        cmocka_unit_test(paths_are_named),
        cmocka_unit_test(scene_schema_is_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
