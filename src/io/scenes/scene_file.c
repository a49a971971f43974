/* Scene files: text, overrides, schema validation, then calls of the scene's own functions. */
#include "base/context.h"
#include "base/number.h"
#include "io/scenes/builtin.h"
#include "io/file.h"
#include "io/json_parse.h"
#include "io/scenes/scene_reader.h"
#include "io/scenes/scene_schema.h"
#include "io/scenes/schema.h"
#include "io/schema_text.h"
#include "option/option.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char builtin_prefix[] = "builtin:";

enum { FILE_SIZE_MAX = 256 << 20 };

/* ---- text to validated JSON ---- */

ty_result ty_reader_parse(ty_scene_reader* reader) {
    static const char mark[] = "\xef\xbb\xbf"; /* UTF-8 byte order mark, which some editors write */
    if (reader->length >= 3 && memcmp(reader->text, mark, 3) == 0) {
        reader->text += 3;
        reader->length -= 3;
    }
    return ty_json_parse(reader->context, reader->name, reader->text, reader->length, &reader->root);
}

ty_result ty_reader_check(const ty_scene_reader* reader, const char* part) {
    json_t* schema = reader->schema != NULL ? json_incref(reader->schema) : ty_scene_schema_tree();
    if (schema != NULL && part != NULL) {
        json_t* whole = schema;
        schema = json_pack("{s:s+, s:O}", "$ref", "#/$defs/", part, "$defs", json_object_get(whole, "$defs"));
        json_decref(whole);
    }
    if (schema == NULL) return ty_fail(reader->context, TY_ERROR_INTERNAL, "the scene schema cannot be read");
    ty_schema_issue issue;
    ty_result result = TY_OK;
    if (!ty_schema_check(schema, reader->root, &issue))
        result = ty_reader_fail(reader, &issue.path, TY_ERROR_INPUT, "%s", issue.text);
    json_decref(schema);
    return result;
}

static uint64_t hash_number(uint64_t hash, uint64_t number) {
    uint8_t bytes[8];
    for (int i = 0; i < 8; ++i) bytes[i] = (uint8_t)(number >> 8 * i);
    return ty_hash_bytes(hash, bytes, sizeof bytes);
}

/* True if a section before this one, or the values before i in it, have the i-th value. */
static bool is_repeated(const ty_file_digests files[TY_SECTIONS], int section, size_t i) {
    const uint64_t value = files[section].values[i];
    for (int s = 0; s <= section; ++s)
        for (size_t k = 0; k < (s == section ? i : files[s].count); ++k)
            if (files[s].values[k] == value) return true;
    return false;
}

ty_result ty_reader_hash(const ty_scene_reader* reader, const ty_file_digests files[TY_SECTIONS], uint64_t* hash) {
    char* text = json_dumps(reader->root, JSON_SORT_KEYS | JSON_COMPACT);
    if (text == NULL) return ty_fail(reader->context, TY_ERROR_MEMORY, "not enough memory for the scene's text");
    *hash = ty_hash_bytes(TY_HASH_START, text, strlen(text));
    free(text);
    for (int s = 0; s < TY_SECTIONS; ++s)
        for (size_t i = 0; i < files[s].count; ++i)
            if (!is_repeated(files, s, i)) *hash = hash_number(*hash, files[s].values[i]);
    return TY_OK;
}

/* ---- sections ---- */

/* Formats an option's value for ty_scene_set_option. */
static void option_text(const json_t* value, char text[TY_OPTION_TEXT_SIZE]) {
    if (json_is_string(value))
        snprintf(text, TY_OPTION_TEXT_SIZE, "%s", json_string_value(value));
    else if (json_is_boolean(value))
        snprintf(text, TY_OPTION_TEXT_SIZE, "%s", json_is_true(value) ? "true" : "false");
    else
        ty_format_number(json_number_value(value), text, TY_OPTION_TEXT_SIZE);
}

/* Passes the options of single methods to the scene; the schema has checked them. */
static ty_result read_options(const ty_scene_reader* reader, const json_t* render) {
    const char *method, *key;
    json_t *options, *value;
    json_object_foreach((json_t*)render, method, options) json_object_foreach(options, key, value) {
        char text[TY_OPTION_TEXT_SIZE];
        option_text(value, text);
        const ty_result result = ty_scene_set_option(reader->scene, method, key, text);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}

static ty_result read_render(const ty_scene_reader* reader) {
    const json_t* render = json_object_get(reader->root, "render");
    ty_render_settings settings = ty_scene_render_settings(reader->scene);
    const char* method = json_string_value(json_object_get(render, "method"));
    if (method != NULL) snprintf(settings.method, sizeof settings.method, "%s", method);
    double seed = (double)settings.seed;
    ty_read_number(render, "seed", &seed);
    settings.seed = (uint64_t)seed;
    ty_read_int(render, "spp", &settings.spp);
    ty_scene_set_render_settings(reader->scene, &settings);
    return read_options(reader, render);
}

ty_result ty_read_sections(ty_scene_reader* reader, unsigned sections) {
    static ty_result (*const readers[TY_SECTIONS])(ty_scene_reader*) = {ty_read_camera, ty_read_media, ty_read_lights,
                                                                        ty_read_geometry};
    const char* up = json_string_value(json_object_get(reader->root, "up_axis"));
    reader->up_axis = up != NULL && strcmp(up, "z") == 0 ? TY_AXIS_Z : TY_AXIS_Y;
    reader->unit = 1;
    ty_read_number(reader->root, "meters_per_unit", &reader->unit);
    ty_read_int(reader->root, "frame", &reader->frame);
    ty_result result = ty_scene_create(reader->context, reader->up_axis, &reader->scene);
    if (result == TY_OK) result = ty_read_boundary(reader);
    for (int s = 0; s < TY_SECTIONS && result == TY_OK; ++s) {
        reader->section = (ty_scene_section)s;
        if ((sections & 1u << s) != 0) result = readers[s](reader);
        if (s == TY_SECTION_LIGHTS) reader->listed_lights = reader->scene->light_count;
    }
    return result == TY_OK ? read_render(reader) : result;
}

static ty_result build_scene(ty_scene_reader* reader) {
    ty_asset_cache assets = {.context = reader->context, .reading = 1};
    reader->assets = &assets;
    uint64_t hash = 0;
    ty_result result = ty_read_sections(reader, (1u << TY_SECTIONS) - 1);
    if (result == TY_OK) result = ty_reader_hash(reader, reader->files, &hash);
    if (result == TY_OK) ty_scene_set_hash(reader->scene, hash);
    if (result == TY_OK) result = ty_reader_commit(reader);
    ty_assets_release(&assets);
    return result;
}

static void free_reader(ty_scene_reader* reader) {
    ty_free_digests(reader);
    ty_free_overrides(reader);
    json_decref(reader->root);
}

/* ---- entry points ---- */

ty_result ty_scene_parse(ty_context* context, const char* text, size_t length, const char* name, const char* folder,
                         const char* const* overrides, int32_t override_count, ty_scene** out) {
    if (context == NULL || text == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_parse: context, text or out is NULL");
    ty_scene_reader reader = {.context = context,
                              .clean = !ty_has_error(context),
                              .name = name != NULL ? name : "scene",
                              .folder = folder,
                              .text = text,
                              .length = length};
    ty_result result = ty_reader_parse(&reader);
    if (result == TY_OK) result = ty_apply_overrides(&reader, overrides, override_count);
    if (result == TY_OK) result = ty_reader_check(&reader, NULL);
    if (result == TY_OK) result = build_scene(&reader);
    free_reader(&reader);
    if (result == TY_OK)
        *out = reader.scene;
    else
        ty_scene_destroy(reader.scene);
    return result;
}

static ty_result fail_builtin(ty_context* context, const char* path) {
    char text[512] = "there is no scene ";
    ty_append_quoted(text, sizeof text, path);
    for (const ty_builtin_scene* scene = ty_builtin_scenes; scene->name != NULL; ++scene)
        ty_append(text, sizeof text, "%s %s", scene == ty_builtin_scenes ? "; known:" : ",", scene->name);
    return ty_fail(context, TY_ERROR_INPUT, "%s", text);
}

/* Role of a file in a scene, by its name, or NULL: volumes, meshes and images are easily passed instead of a scene. */
static const char* file_role(const char* path) {
    static const char* const images[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".webp", NULL};
    if (ty_has_extension(path, images)) return "an image; a scene may have it as \"file\" of an environment light";
    if (ty_has_extension(path, ty_mesh_extensions)) return "a mesh; a scene has it as \"file\" in its geometry";
    return ty_has_extension(path, ty_volume_extensions) ? "a volume; a scene has it as \"file\" of a medium's density"
                                                        : NULL;
}

static ty_result open_builtin(ty_context* context, const char* path, ty_scene_source* source) {
    const ty_builtin_scene* scene = ty_builtin_scenes;
    while (scene->name != NULL && strcmp(scene->name, path + sizeof builtin_prefix - 1) != 0) ++scene;
    if (scene->name == NULL) return fail_builtin(context, path);
    source->text = scene->text;
    source->length = scene->size;
    source->folder = ty_copy_text(context, "");
    return source->folder != NULL ? TY_OK : TY_ERROR_MEMORY;
}

ty_result ty_open_source(ty_context* context, const char* path, ty_scene_source* source) {
    *source = (ty_scene_source){.length = 0};
    if (strncmp(path, builtin_prefix, sizeof builtin_prefix - 1) == 0) return open_builtin(context, path, source);
    const ty_result result = ty_read_file(context, path, FILE_SIZE_MAX, &source->bytes, &source->length);
    if (result != TY_OK) return result;
    const char* part = file_role(path);
    if (part != NULL) return ty_fail(context, TY_ERROR_INPUT, "%s: not a scene but %s (docs/scene.md)", path, part);
    source->text = (const char*)source->bytes;
    source->folder = ty_folder_of(context, path);
    return source->folder != NULL ? TY_OK : TY_ERROR_MEMORY;
}

void ty_close_source(ty_context* context, ty_scene_source* source) {
    ty_free_text(context, source->folder);
    if (source->bytes != NULL) ty_free_file(context, source->bytes, source->length);
}

ty_result ty_scene_load(ty_context* context, const char* path, const char* const* overrides, int32_t override_count,
                        ty_scene** out) {
    if (context == NULL || path == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_load: context, path or out is NULL");
    ty_scene_source source;
    ty_result result = ty_open_source(context, path, &source);
    if (result == TY_OK)
        result =
            ty_scene_parse(context, source.text, source.length, path, source.folder, overrides, override_count, out);
    ty_close_source(context, &source);
    return result;
}
