/* Coefficients and presets of media, in scene files and as short text. */
#include "base/context.h"
#include "base/number.h"
#include "io/scenes/medium_text.h"
#include "io/scenes/scene_reader.h"
#include "io/schema_text.h"
#include "base/check.h"

#include <math.h>
#include <string.h>

/* ---- presets ---- */

/* Index of a preset; negative after an error message. */
static int32_t find_preset(const ty_scene_reader* reader, const ty_json_path* json_path, const char* name) {
    const int32_t index = ty_medium_preset_find(name);
    if (index >= 0) return index;
    const char* nearest = ty_medium_preset_name(0);
    const char* preset;
    for (int32_t i = 1; (preset = ty_medium_preset_name(i)) != NULL; ++i)
        if (ty_word_distance(name, preset) < ty_word_distance(name, nearest)) nearest = preset;
    char text[256] = "there is no medium ";
    ty_append_quoted(text, sizeof text, name);
    if (ty_word_is_similar(name, nearest))
        ty_append(text, sizeof text, "; did you mean \"%s\"?", nearest);
    else
        ty_append(text, sizeof text, "; 'tyndall info --media' lists all");
    ty_reader_fail(reader, json_path, TY_ERROR_INPUT, "%s", text);
    return index;
}

static ty_result read_preset(const ty_scene_reader* reader, const json_t* medium, const ty_json_path* path,
                             ty_medium_def* def) {
    const char* name = json_string_value(json_object_get(medium, "preset"));
    const json_t* visibility = json_object_get(medium, "visibility");
    const json_t* dilution = json_object_get(medium, "dilution");
    const ty_json_path json_path = ty_json_path_key(path, "preset");
    const int32_t index = find_preset(reader, &json_path, name);
    if (index < 0) return TY_ERROR_INPUT;
    const ty_preset_kind kind = ty_medium_preset_kind(index);
    if (visibility != NULL && kind != TY_PRESET_VISIBILITY) {
        const ty_json_path key = ty_json_path_key(path, "visibility");
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT,
                              "does not go with the preset \"%s\", only with fog and haze",
                              ty_medium_preset_name(index));
    }
    if (dilution != NULL && kind != TY_PRESET_MEASURED) {
        const ty_json_path key = ty_json_path_key(path, "dilution");
        return ty_reader_fail(reader, &key, TY_ERROR_INPUT,
                              "does not go with the preset \"%s\", only with measured media",
                              ty_medium_preset_name(index));
    }
    if (visibility == NULL && kind == TY_PRESET_VISIBILITY)
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                              "%s needs its visibility in metres, the key \"visibility\"",
                              ty_medium_preset_name(index));
    const json_t* number = visibility != NULL ? visibility : dilution;
    const bool known =
        number != NULL ? ty_medium_preset_with(name, json_number_value(number), def) : ty_medium_preset(name, def);
    return known ? TY_OK : ty_reader_fail(reader, &json_path, TY_ERROR_INTERNAL, "the schema lets a wrong number pass");
}

/* ---- coefficients ---- */

/* First of two keys that the object has; NULL if it has neither. */
static const char* first_key(const json_t* object, const char* a, const char* b) {
    return json_object_get(object, a) != NULL ? a : json_object_get(object, b) != NULL ? b : NULL;
}

/* Fails unless the coefficients are given completely in exactly one form. */
static ty_result check_forms(const ty_scene_reader* reader, const json_t* medium, const ty_json_path* path) {
    const char* parts = first_key(medium, "sigma_s", "sigma_a");
    const char* total = first_key(medium, "sigma_t", "albedo");
    const char* preset = first_key(medium, "preset", "preset");
    const char* number = first_key(medium, "visibility", "dilution");
    if ((parts != NULL) + (total != NULL) + (preset != NULL) > 1) {
        const char* present = parts != NULL ? parts : total;
        const char* extra = preset != NULL ? preset : total;
        const ty_json_path json_path = ty_json_path_key(path, extra);
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                              "does not go with \"%s\"; give sigma_s and sigma_a, or sigma_t and albedo, or preset",
                              present);
    }
    if (number != NULL && preset == NULL) {
        const ty_json_path json_path = ty_json_path_key(path, number);
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "the key \"preset\" is missing beside it");
    }
    if (parts == NULL && total == NULL && preset == NULL)
        return ty_reader_fail(
            reader, path, TY_ERROR_INPUT,
            "the coefficients are missing; give sigma_s and sigma_a, or sigma_t and albedo, or preset");
    const bool sigma_t = json_object_get(medium, "sigma_t") != NULL, albedo = json_object_get(medium, "albedo") != NULL;
    const bool points = ty_transfer_has_albedo(medium);
    if (points && !sigma_t) {
        const ty_json_path json_path = ty_json_path_key(path, "transfer");
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                              "points with albedo need the key \"sigma_t\" beside it");
    }
    if (points && albedo) {
        const ty_json_path json_path = ty_json_path_key(path, "albedo");
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "the points of \"transfer\" give the albedo already");
    }
    if (total != NULL && !(sigma_t && (albedo || points))) {
        const ty_json_path json_path = ty_json_path_key(path, total);
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "the key \"%s\" is missing beside it",
                              sigma_t ? "albedo" : "sigma_t");
    }
    return TY_OK;
}

ty_result ty_read_coefficients(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path,
                               ty_medium_def* def, ty_phase_table* table) {
    const char* preset = json_string_value(json_object_get(medium, "preset"));
    ty_result result = check_forms(reader, medium, path);
    if (result == TY_OK && preset != NULL) result = read_preset(reader, medium, path, def);
    if (result != TY_OK) return result;
    if (preset != NULL && json_is_object(json_object_get(medium, "g"))) {
        const ty_json_path json_path = ty_json_path_key(path, "g");
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "a volume does not go with \"preset\"");
    }
    const bool reduced = preset != NULL && ty_medium_preset_kind(ty_medium_preset_find(preset)) == TY_PRESET_MEASURED;
    double g[3] = {def->g[0], def->g[1], def->g[2]}, sigma_t[3] = {0, 0, 0}, albedo[3] = {0, 0, 0};
    float mean[3] = {0, 0, 0};
    if (json_object_get(medium, "g") != NULL) def->phase_count = 0; /* in place of the preset's */
    ty_read_rgb(medium, "sigma_s", def->sigma_s);
    ty_read_rgb(medium, "sigma_a", def->sigma_a);
    ty_read_numbers(medium, "sigma_t", sigma_t);
    ty_read_numbers(medium, "albedo", albedo); /* a volume, which replaces it later, counts as 0 */
    ty_read_numbers(medium, "g", g);
    const float below_one = nextafterf(1, 0);
    for (int c = 0; c < 3; ++c) {
        def->g[c] = fminf(fmaxf((float)g[c], -below_one), below_one);
        if (json_object_get(medium, "sigma_t") != NULL) {
            def->sigma_s[c] = (float)(sigma_t[c] * albedo[c]);
            def->sigma_a[c] = (float)(sigma_t[c] * (1 - albedo[c]));
        }
    }
    result = ty_read_phase(reader, medium, path, def, table);
    if (result == TY_OK) result = ty_medium_mean_cosine(reader->context, def, mean);
    /* Measured values are reduced: sigma_s' = (1 - g) sigma_s. */
    for (int c = 0; c < 3 && result == TY_OK && reduced; ++c) def->sigma_s[c] /= 1 - mean[c];
    return result;
}

/* ---- homogeneous medium as text ---- */

const char* const ty_homogeneous_keys[] = {"preset", "visibility", "dilution", "sigma_s", "sigma_a", "sigma_t",
                                           "albedo", "scale",      "g",        "phase",   NULL};

/* Fails on properties that a homogeneous medium does not have. */
static ty_result check_homogeneous(const ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const char* key;
    json_t* value;
    json_object_foreach(reader->root, key, value) {
        const char* const* known = ty_homogeneous_keys;
        while (*known != NULL && strcmp(key, *known) != 0) ++known;
        const ty_json_path json_path = ty_json_path_key(&root, key);
        if (*known == NULL)
            return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                                  "has no place here, where a medium is the same everywhere; give what it is made of");
        if (json_is_object(value) && strcmp(key, "phase") != 0)
            return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                                  "a volume has no place here, where a medium is the same everywhere");
    }
    return TY_OK;
}

/* Parses "NAME" or "NAME:NUMBER" to the equivalent object of a scene file. */
static ty_result parse_name(ty_scene_reader* reader, const char* text) {
    const ty_json_path root = {.depth = 0};
    const char* colon = strchr(text, ':');
    const size_t length = colon != NULL ? (size_t)(colon - text) : strlen(text);
    reader->root = json_pack("{s:s%}", "preset", text, length);
    if (reader->root == NULL) return ty_reader_fail(reader, &root, TY_ERROR_INPUT, "the name is not UTF-8");
    const int32_t index = find_preset(reader, &root, json_string_value(json_object_get(reader->root, "preset")));
    if (index < 0) return TY_ERROR_INPUT;
    const char* name = ty_medium_preset_name(index);
    const ty_preset_kind kind = ty_medium_preset_kind(index);
    if (colon == NULL && kind == TY_PRESET_VISIBILITY)
        return ty_reader_fail(reader, &root, TY_ERROR_INPUT, "%s needs its visibility in metres: %s:50", name, name);
    if (colon == NULL) return TY_OK;
    if (kind == TY_PRESET_WATER) return ty_reader_fail(reader, &root, TY_ERROR_INPUT, "%s takes no number", name);
    const char* end;
    const double number = ty_parse_number(colon + 1, &end);
    if (end == colon + 1 || *end != '\0' || !isfinite(number)) {
        char message[256] = "";
        ty_append_quoted(message, sizeof message, colon + 1);
        ty_append(message, sizeof message,
                  kind == TY_PRESET_VISIBILITY ? " is not a number; %s takes its visibility in metres: %s:50"
                                               : " is not a number; %s takes its dilution: %s:1000",
                  name, name);
        return ty_reader_fail(reader, &root, TY_ERROR_INPUT, "%s", message);
    }
    const char* key = kind == TY_PRESET_VISIBILITY ? "visibility" : "dilution";
    if (json_object_set_new(reader->root, key, json_real(number)) != 0)
        return ty_reader_fail(reader, &root, TY_ERROR_MEMORY, "not enough memory");
    return TY_OK;
}

static ty_scene_reader start_reading(ty_context* context) {
    return (ty_scene_reader){.context = context, .clean = !ty_has_error(context), .name = "medium", .text = ""};
}

/* Sets root from JSON, or from a name and a number. */
static ty_result read_text(ty_scene_reader* reader, const char* text) {
    const bool json = text[strspn(text, " \t\r\n")] == '{';
    if (json) {
        reader->text = text;
        reader->length = strlen(text);
    }
    ty_result result = json ? ty_reader_parse(reader) : parse_name(reader, text);
    if (result == TY_OK) result = ty_reader_check(reader, "medium");
    return result == TY_OK ? check_homogeneous(reader) : result;
}

ty_result ty_medium_object(ty_context* context, const char* text, json_t** out) {
    ty_scene_reader reader = start_reading(context);
    const ty_result result = read_text(&reader, text);
    *out = result == TY_OK ? json_incref(reader.root) : NULL;
    json_decref(reader.root);
    return result;
}

ty_result ty_medium_parse(ty_context* context, const char* text, ty_medium_def* medium) {
    if (context == NULL || text == NULL || medium == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_medium_parse: context, text or medium is NULL");
    const ty_json_path root = {.depth = 0};
    ty_scene_reader reader = start_reading(context);
    ty_medium_def def = ty_default_medium_def();
    ty_phase_table table;
    ty_result result = read_text(&reader, text);
    if (result == TY_OK) result = ty_read_coefficients(&reader, reader.root, &root, &def, &table);
    if (result == TY_OK && def.phase_count > 0 && def.phase[0].kind == TY_PHASE_TABLE) {
        const ty_json_path path = ty_json_path_key(&root, "phase");
        result = ty_reader_fail(&reader, &path, TY_ERROR_INPUT, "a table has no place here; give a formula");
    }
    double scale = 1;
    if (result == TY_OK) ty_read_number(reader.root, "scale", &scale);
    json_decref(reader.root);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) {
        def.sigma_s[c] = (float)(scale * def.sigma_s[c]);
        def.sigma_a[c] = (float)(scale * def.sigma_a[c]);
    }
    result = ty_check_rgb(context, "sigma_s", def.sigma_s, 0, TY_COLOR_MAX);
    if (result == TY_OK) result = ty_check_rgb(context, "sigma_a", def.sigma_a, 0, TY_COLOR_MAX);
    if (result != TY_OK) return ty_reader_prefix_error(&reader, &root, result);
    *medium = def;
    return TY_OK;
}
