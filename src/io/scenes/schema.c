/* Validation of JSON against a schema; schema.h lists the supported keywords. */
#include "io/scenes/schema.h"
#include "io/schema_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { BRANCHES_MAX = 16, REF_MAX = 16 };

typedef struct checker {
    const json_t* root; /* the whole schema, for $defs */
    ty_json_path path;
    ty_schema_issue* issue;
} checker;

/* Branches of an anyOf or oneOf that are still candidates. */
typedef struct branch_set {
    const json_t* items[BRANCHES_MAX];
    size_t count;
} branch_set;

static bool check(checker* c, const json_t* schema, const json_t* value);

/* Begins the issue's text at the current path; returns false. */
static bool fail(checker* c, const char* format, ...) __attribute__((format(printf, 2, 3)));
static bool fail(checker* c, const char* format, ...) {
    c->issue->path = c->path;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->issue->text, sizeof c->issue->text, format, arguments);
    va_end(arguments);
    return false;
}

/* ---- reading the schema ---- */

static const json_t* resolve(const checker* c, const json_t* schema) {
    static const char prefix[] = "#/$defs/";
    for (int i = 0; i < REF_MAX; ++i) {
        const char* ref = json_string_value(json_object_get(schema, "$ref"));
        if (ref == NULL) return schema;
        if (strncmp(ref, prefix, sizeof prefix - 1) != 0) return NULL;
        schema = json_object_get(json_object_get(c->root, "$defs"), ref + sizeof prefix - 1);
    }
    return NULL;
}

static bool is_whole(const json_t* value) {
    return json_is_integer(value) || (json_is_real(value) && floor(json_real_value(value)) == json_real_value(value));
}

static bool has_type(const json_t* value, const char* type) {
    if (type == NULL) return true;
    if (strcmp(type, "number") == 0) return json_is_number(value);
    if (strcmp(type, "integer") == 0) return is_whole(value);
    if (strcmp(type, "string") == 0) return json_is_string(value);
    if (strcmp(type, "boolean") == 0) return json_is_boolean(value);
    if (strcmp(type, "array") == 0) return json_is_array(value);
    if (strcmp(type, "object") == 0) return json_is_object(value);
    return json_is_null(value);
}

static const char* type_name(const char* type) {
    static const char* const names[][2] = {{"number", "a number"}, {"integer", "an integer"},
                                           {"string", "a string"}, {"boolean", "true or false"},
                                           {"array", "an array"},  {"object", "an object"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcmp(type, names[i][0]) == 0) return names[i][1];
    return "null";
}

static const char* schema_type(const json_t* schema) {
    return json_string_value(json_object_get(schema, "type"));
}

static const json_t* schema_property(const json_t* schema, const char* key) {
    return json_object_get(json_object_get(schema, "properties"), key);
}

/* ---- scalars and arrays ---- */

static bool fail_type(checker* c, const branch_set* set, const json_t* value) {
    fail(c, "expected ");
    char* text = c->issue->text;
    const size_t size = sizeof c->issue->text;
    const char* previous = "";
    for (size_t i = 0; i < set->count; ++i) {
        const char* name = type_name(schema_type(set->items[i]));
        if (strcmp(name, previous) == 0) continue;
        ty_append(text, size, "%s%s", i > 0 ? " or " : "", name);
        previous = name;
    }
    ty_append(text, size, ", found ");
    if (json_is_string(value))
        ty_append(text, size, "a string");
    else
        ty_append_value(text, size, value);
    return false;
}

static bool check_range(checker* c, const json_t* schema, const json_t* value) {
    const json_t* minimum = json_object_get(schema, "minimum");
    const json_t* maximum = json_object_get(schema, "maximum");
    const json_t* above = json_object_get(schema, "exclusiveMinimum");
    const json_t* exclusive_maximum = json_object_get(schema, "exclusiveMaximum");
    const json_t* multiple = json_object_get(schema, "multipleOf");
    const double number = json_number_value(value);
    char* text = c->issue->text;
    const size_t size = sizeof c->issue->text;
    if ((minimum != NULL && number < json_number_value(minimum)) ||
        (maximum != NULL && number > json_number_value(maximum)) ||
        (above != NULL && !(number > json_number_value(above))) ||
        (exclusive_maximum != NULL && !(number < json_number_value(exclusive_maximum)))) {
        const json_t* lower = above != NULL ? above : minimum;
        const json_t* upper = exclusive_maximum != NULL ? exclusive_maximum : maximum;
        fail(c, "%s", "");
        ty_append_value(text, size, value);
        ty_append(text, size, " is outside %s", above != NULL || lower == NULL ? "(" : "[");
        if (lower != NULL)
            ty_append_number(text, size, json_number_value(lower));
        else
            ty_append(text, size, "-inf");
        ty_append(text, size, ", ");
        if (upper != NULL)
            ty_append_number(text, size, json_number_value(upper));
        else
            ty_append(text, size, "inf");
        ty_append(text, size, "%s", exclusive_maximum != NULL || upper == NULL ? ")" : "]");
        return false;
    }
    if (multiple != NULL && fmod(number, json_number_value(multiple)) != 0) {
        fail(c, "%s", "");
        ty_append_value(text, size, value);
        ty_append(text, size, " is not a multiple of ");
        ty_append_value(text, size, multiple);
        return false;
    }
    return true;
}

static bool check_array(checker* c, const json_t* schema, const json_t* value) {
    const json_t* minimum = json_object_get(schema, "minItems");
    const json_t* maximum = json_object_get(schema, "maxItems");
    const json_t* items = json_object_get(schema, "items");
    const json_int_t count = (json_int_t)json_array_size(value);
    const bool few = minimum != NULL && count < json_integer_value(minimum);
    const bool many = maximum != NULL && count > json_integer_value(maximum);
    if (few || many)
        return fail(c, "expected %s%" JSON_INTEGER_FORMAT " items, found %" JSON_INTEGER_FORMAT,
                    json_equal(minimum, maximum) ? ""
                    : few                        ? "at least "
                                                 : "at most ",
                    json_integer_value(few ? minimum : maximum), count);
    if (items == NULL) return true;
    const ty_json_path here = c->path;
    size_t i;
    json_t* item;
    json_array_foreach(value, i, item) {
        c->path = ty_json_path_index(&here, i);
        if (!check(c, items, item)) return false;
    }
    c->path = here;
    return true;
}

/* Fails since value is none of the words; suggests a similar one. */
static bool fail_words(checker* c, const json_t* value, const char* const* words, size_t count) {
    char* text = c->issue->text;
    const size_t size = sizeof c->issue->text;
    fail(c, "%s", "");
    ty_append_value(text, size, value);
    ty_append(text, size, " is not one of ");
    for (size_t i = 0; i < count; ++i) {
        if (i > 0) ty_append(text, size, ", ");
        ty_append_quoted(text, size, words[i]);
    }
    const char* word = json_string_value(value);
    const char* nearest = NULL;
    for (size_t i = 0; word != NULL && i < count; ++i)
        if (ty_word_is_similar(word, words[i]) &&
            (nearest == NULL || ty_word_distance(word, words[i]) < ty_word_distance(word, nearest)))
            nearest = words[i];
    if (nearest != NULL) ty_append(text, size, "; did you mean \"%s\"?", nearest);
    return false;
}

static bool check_enum(checker* c, const json_t* words, const json_t* value) {
    const char* names[BRANCHES_MAX];
    size_t count = 0, i;
    json_t* word;
    json_array_foreach(words, i, word) {
        if (json_equal(word, value)) return true;
        if (count < BRANCHES_MAX) names[count++] = json_string_value(word);
    }
    return fail_words(c, value, names, count);
}

/* ---- objects ---- */

static bool has_required(const json_t* branch, const json_t* value) {
    size_t i;
    json_t* key;
    json_array_foreach(json_object_get(branch, "required"), i,
                       key) if (json_object_get(value, json_string_value(key)) == NULL) return false;
    return true;
}

/* Distinguishing key of a branch: the first required one without a const value. */
static const char* distinguishing_key(const json_t* branch) {
    size_t i;
    json_t* key;
    json_array_foreach(json_object_get(branch, "required"), i,
                       key) if (json_object_get(schema_property(branch, json_string_value(key)), "const") ==
                                NULL) return json_string_value(key);
    return NULL;
}

/* The intended key for an unknown one: a key whose schema gives that name under "x-formerly", or the key nearest in
 * spelling; NULL: none is similar. */
static const char* find_meant(const branch_set* set, const char* unknown) {
    const char* nearest = NULL;
    const char* key;
    json_t* property;
    for (size_t i = 0; i < set->count; ++i)
        json_object_foreach(json_object_get(set->items[i], "properties"), key, property) {
            const char* earlier = json_string_value(json_object_get(property, "x-formerly"));
            if (earlier != NULL && strcmp(earlier, unknown) == 0) return key;
            if (ty_word_is_similar(unknown, key) &&
                (nearest == NULL || ty_word_distance(unknown, key) < ty_word_distance(unknown, nearest)))
                nearest = key;
        }
    return nearest;
}

/* Fails since no branch of the set has the key. */
static bool fail_unknown(checker* c, const branch_set* set, const char* unknown) {
    const ty_json_path here = c->path;
    c->path = ty_json_path_key(&here, unknown);
    fail(c, "unknown key; ");
    c->path = here;
    char* text = c->issue->text;
    const size_t size = sizeof c->issue->text;
    const char* key;
    json_t* property;
    const char* nearest = find_meant(set, unknown);
    if (nearest != NULL) {
        ty_append(text, size, "did you mean \"%s\"?", nearest);
        return false;
    }
    ty_append(text, size, "known here");
    const char* mark = ": ";
    for (size_t i = 0; i < set->count; ++i)
        json_object_foreach(json_object_get(set->items[i], "properties"), key, property) {
            bool listed = false;
            for (size_t j = 0; j < i; ++j) listed = listed || schema_property(set->items[j], key) != NULL;
            if (listed) continue;
            ty_append(text, size, "%s\"%s\"", mark, key);
            mark = ", ";
        }
    return false;
}

/* Fails if the value has a key that no branch of the set has. */
static bool check_unknown_keys(checker* c, const branch_set* set, const json_t* value) {
    const char* key;
    json_t* member;
    json_object_foreach((json_t*)value, key, member) {
        bool known = false;
        for (size_t i = 0; i < set->count && !known; ++i) known = schema_property(set->items[i], key) != NULL;
        if (!known) return fail_unknown(c, set, key);
    }
    return true;
}

/* Fails if the value has a key that the chosen branch lacks but another one has. */
static bool check_foreign_keys(checker* c, const json_t* chosen, const branch_set* others, const char* reason,
                               const char* reason_value, const json_t* value) {
    const char* key;
    json_t* member;
    json_object_foreach((json_t*)value, key, member) {
        if (schema_property(chosen, key) != NULL) continue;
        for (size_t i = 0; i < others->count; ++i) {
            if (schema_property(others->items[i], key) == NULL) continue;
            c->path = ty_json_path_key(&c->path, key);
            if (reason_value == NULL) return fail(c, "does not go with \"%s\"", reason);
            return fail(c, "does not go with %s \"%s\"", reason, reason_value);
        }
    }
    return true;
}

static bool check_member(checker* c, const json_t* property, const char* key, const json_t* member) {
    const ty_json_path here = c->path;
    c->path = ty_json_path_key(&here, key);
    if (!check(c, property, member)) return false;
    c->path = here;
    return true;
}

static bool check_object(checker* c, const json_t* schema, const json_t* value) {
    const json_t* properties = json_object_get(schema, "properties");
    const char* key;
    json_t *member, *property;
    json_object_foreach((json_t*)properties, key, property) { /* const members (the version) first */
        member = json_object_get(value, key);
        if (member != NULL && json_object_get(property, "const") != NULL && !check_member(c, property, key, member))
            return false;
    }
    json_object_foreach((json_t*)value, key, member) {
        property = json_object_get(properties, key);
        if (property != NULL && !check_member(c, property, key, member)) return false;
        if (property == NULL && json_is_false(json_object_get(schema, "additionalProperties")))
            return fail_unknown(c, &(branch_set){.items = {schema}, .count = 1}, key);
    }
    size_t i;
    json_t* required;
    json_array_foreach(json_object_get(schema, "required"), i,
                       required) if (json_object_get(value, json_string_value(required)) ==
                                     NULL) return fail(c, "the key \"%s\" is missing", json_string_value(required));
    return true;
}

/* ---- branch selection ---- */

/* Narrows the set to the branches whose const value of a common key equals the value's; false if none remains. */
static bool choose_by_const(checker* c, branch_set* set, const json_t* value, const char** common) {
    *common = NULL;
    const char* key;
    json_t* property;
    json_object_foreach(json_object_get(set->items[0], "properties"), key, property) {
        size_t fixed = 0;
        while (fixed < set->count && json_object_get(schema_property(set->items[fixed], key), "const") != NULL) ++fixed;
        if (fixed < set->count) continue;
        const json_t* member = json_object_get(value, key);
        if (member == NULL) return check_unknown_keys(c, set, value) && fail(c, "the key \"%s\" is missing", key);
        branch_set left = {.count = 0};
        const char* words[BRANCHES_MAX];
        size_t count = 0;
        for (size_t i = 0; i < set->count; ++i) {
            const json_t* constant = json_object_get(schema_property(set->items[i], key), "const");
            const char* word = json_string_value(constant);
            if (json_equal(constant, member)) left.items[left.count++] = set->items[i];
            if (count == 0 || strcmp(words[count - 1], word) != 0) words[count++] = word;
        }
        if (left.count == 0) {
            c->path = ty_json_path_key(&c->path, key);
            return fail_words(c, member, words, count);
        }
        *set = left;
        *common = key;
        return true;
    }
    return true;
}

static size_t known_keys(const json_t* branch, const json_t* value) {
    const char* key;
    json_t* member;
    size_t count = 0;
    json_object_foreach((json_t*)value, key, member) if (schema_property(branch, key) != NULL)++ count;
    return count;
}

/* Narrows the set to one branch by the number of known keys; false if it is ambiguous. */
static bool choose_by_keys(checker* c, branch_set* set, const json_t* value) {
    size_t max_known = 0;
    for (size_t i = 0; i < set->count; ++i) {
        const size_t known = known_keys(set->items[i], value);
        if (known > max_known) max_known = known;
    }
    branch_set best = {.count = 0};
    const json_t* whole = NULL;
    for (size_t i = 0; i < set->count; ++i) {
        if (known_keys(set->items[i], value) < max_known) continue;
        best.items[best.count++] = set->items[i];
        if (whole == NULL && has_required(set->items[i], value)) whole = set->items[i];
    }
    if (best.count > 1 && whole == NULL) {
        if (!check_unknown_keys(c, set, value)) return false;
        fail(c, "one of the keys");
        for (size_t i = 0; i < best.count; ++i)
            ty_append(c->issue->text, sizeof c->issue->text, "%s \"%s\"", i > 0 ? "," : "",
                      distinguishing_key(best.items[i]));
        ty_append(c->issue->text, sizeof c->issue->text, " is missing");
        return false;
    }
    set->items[0] = whole != NULL ? whole : best.items[0];
    set->count = 1;
    return true;
}

/* Passes where any branch of the value's type does; the issue is the first branch's, and names a word that other
 * branches allow. */
static bool check_scalar(checker* c, const branch_set* all, const branch_set* fitting, const json_t* value) {
    const ty_json_path here = c->path;
    for (size_t i = fitting->count; i-- > 0; c->path = here)
        if (check(c, fitting->items[i], value)) return true;
    for (size_t i = 0; i < all->count; ++i) {
        const char* word = json_string_value(json_object_get(all->items[i], "const"));
        if (word == NULL) continue;
        if (json_is_number(value)) {
            ty_append(c->issue->text, sizeof c->issue->text, "; write \"%s\" for the default choice", word);
        } else {
            fail(c, "expected %s or \"%s\", found ", type_name(schema_type(all->items[0])), word);
            ty_append_value(c->issue->text, sizeof c->issue->text, value);
        }
    }
    return false;
}

static bool check_branches(checker* c, const json_t* branches, const json_t* value) {
    branch_set all = {.count = 0}, fitting = {.count = 0};
    size_t i;
    json_t* branch;
    json_array_foreach(branches, i, branch) {
        const json_t* resolved = resolve(c, branch);
        if (resolved == NULL || all.count == BRANCHES_MAX) return fail(c, "the schema itself is broken");
        all.items[all.count++] = resolved;
        if (has_type(value, schema_type(resolved))) fitting.items[fitting.count++] = resolved;
    }
    if (fitting.count == 0) return fail_type(c, &all, value);
    if (!json_is_object(value)) return check_scalar(c, &all, &fitting, value);
    if (fitting.count == 1) return check(c, fitting.items[0], value);
    const char* common;
    branch_set alike = fitting;
    if (!choose_by_const(c, &alike, value, &common)) return false;
    branch_set chosen = alike;
    if (!choose_by_keys(c, &chosen, value)) return false;
    const char* own = distinguishing_key(chosen.items[0]);
    if (own != NULL && !check_foreign_keys(c, chosen.items[0], &alike, own, NULL, value)) return false;
    if (common != NULL && !check_foreign_keys(c, chosen.items[0], &fitting, common,
                                              json_string_value(json_object_get(value, common)), value))
        return false;
    return check(c, chosen.items[0], value);
}

static bool check(checker* c, const json_t* schema, const json_t* value) {
    schema = resolve(c, schema);
    if (schema == NULL) return fail(c, "the schema itself is broken");
    const json_t* branches = json_object_get(schema, "anyOf");
    if (branches == NULL) branches = json_object_get(schema, "oneOf");
    if (branches != NULL) return check_branches(c, branches, value);
    if (!has_type(value, schema_type(schema))) return fail_type(c, &(branch_set){.items = {schema}, .count = 1}, value);
    const json_t* words = json_object_get(schema, "enum");
    if (words != NULL) return check_enum(c, words, value);
    const json_t* constant = json_object_get(schema, "const");
    const bool same_number =
        json_is_number(constant) && json_is_number(value) && json_number_value(constant) == json_number_value(value);
    if (constant != NULL && !same_number && !json_equal(constant, value)) {
        fail(c, "expected ");
        ty_append_value(c->issue->text, sizeof c->issue->text, constant);
        ty_append(c->issue->text, sizeof c->issue->text, ", found ");
        ty_append_value(c->issue->text, sizeof c->issue->text, value);
        return false;
    }
    const json_t* length = json_object_get(schema, "minLength");
    if (json_is_string(value) && length != NULL && (json_int_t)json_string_length(value) < json_integer_value(length))
        return fail(c, "is empty");
    if (json_is_number(value)) return check_range(c, schema, value);
    if (json_is_array(value)) return check_array(c, schema, value);
    if (json_is_object(value)) return check_object(c, schema, value);
    return true;
}

bool ty_schema_check(const json_t* schema, const json_t* value, ty_schema_issue* issue) {
    checker c = {.root = schema, .path = {.depth = 0}, .issue = issue};
    return check(&c, schema, value);
}
