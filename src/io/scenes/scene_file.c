/* Scene files: text, overrides, schema validation, then calls of the scene's own functions. */
#include "base/context.h"
#include "io/scenes/builtin.h"
#include "io/file.h"
#include "io/scenes/scene_reader.h"
#include "io/scenes/schema.h"
#include "io/schema_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char builtin_prefix[] = "builtin:";

enum { FILE_SIZE_MAX = 256 << 20 };

const char* ty_scene_schema(void) {
    return ty_scene_schema_text;
}

/* ---- text to validated JSON ---- */

ty_result ty_reader_parse(ty_scene_reader* reader) {
    static const char mark[] = "\xef\xbb\xbf"; /* UTF-8 byte order mark, which some editors write */
    if (reader->length >= 3 && memcmp(reader->text, mark, 3) == 0) {
        reader->text += 3;
        reader->length -= 3;
    }
    json_error_t error;
    reader->root = json_loadb(reader->text, reader->length, JSON_REJECT_DUPLICATES, &error);
    if (reader->root == NULL)
        return ty_fail(reader->context, TY_ERROR_INPUT, "%s:%d: %s", reader->name, error.line < 1 ? 1 : error.line,
                       error.text);
    return TY_OK;
}

ty_result ty_reader_check(const ty_scene_reader* reader, const char* part) {
    json_t* schema = json_loadb(ty_scene_schema_text, ty_scene_schema_size, 0, NULL);
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

static ty_result hash_tree(ty_scene_reader* reader) {
    char* text = json_dumps(reader->root, JSON_SORT_KEYS | JSON_COMPACT);
    if (text == NULL) return ty_fail(reader->context, TY_ERROR_MEMORY, "not enough memory for the scene's text");
    reader->hash = ty_hash_bytes(TY_HASH_START, text, strlen(text));
    free(text);
    return TY_OK;
}

/* ---- sections ---- */

/* Reads a word; out is unchanged if the key is absent. */
static void read_word(const json_t* object, const char* key, char out[16]) {
    const char* word = json_string_value(json_object_get(object, key));
    if (word != NULL) snprintf(out, 16, "%s", word);
}

static void read_fld(const json_t* fld, ty_fld_settings* settings) {
    const char* limiter = json_string_value(json_object_get(fld, "limiter"));
    if (limiter != NULL) snprintf(settings->limiter, sizeof settings->limiter, "%s", limiter);
    read_word(fld, "boundary", settings->boundary);
    read_word(fld, "solver", settings->solver);
    read_word(fld, "beam", settings->beam);
    ty_read_number(fld, "larsen_power", &settings->larsen_power);
    ty_read_number(fld, "streaming", &settings->streaming);
    ty_read_number(fld, "relaxation", &settings->relaxation);
    ty_read_number(fld, "tolerance", &settings->tolerance);
    ty_read_number(fld, "sigma_eps", &settings->sigma_eps);
    ty_read_number(fld, "ratio", &settings->ratio);
    ty_read_number(fld, "step", &settings->step);
    ty_read_int(fld, "resolution", &settings->resolution);
    ty_read_int(fld, "iterations", &settings->iterations);
    ty_read_int(fld, "environment_beams", &settings->environment_beams);
    ty_read_int(fld, "surface_points", &settings->surface_points);
    ty_read_int(fld, "spp", &settings->spp);
}

static void read_pop(const json_t* pop, ty_pop_settings* settings) {
    read_word(pop, "mode", settings->mode);
    ty_read_int(pop, "resolution", &settings->resolution);
    ty_read_int(pop, "merged", &settings->merged);
    ty_read_bool(pop, "sharp", &settings->sharp);
    ty_read_int(pop, "direct", &settings->direct);
    ty_read_int(pop, "ordinates", &settings->ordinates);
    ty_read_number(pop, "prefilter", &settings->prefilter);
    ty_read_bool(pop, "importance", &settings->importance);
    ty_read_int(pop, "surface_points", &settings->surface_points);
    ty_read_int(pop, "vpls", &settings->vpls);
    ty_read_int(pop, "shadow_texels", &settings->shadow_texels);
    ty_read_number(pop, "clamp", &settings->clamp);
    ty_read_int(pop, "iterations", &settings->iterations);
    ty_read_number(pop, "residuum", &settings->residuum);
    ty_read_int(pop, "residuum_iterations", &settings->residuum_iterations);
    ty_read_number(pop, "streaming", &settings->streaming);
    ty_read_number(pop, "tolerance", &settings->tolerance);
    ty_read_int(pop, "spp", &settings->spp);
    ty_read_number(pop, "step", &settings->step);
}

static void read_lpv(const json_t* lpv, ty_lpv_settings* settings) {
    read_word(lpv, "mode", settings->mode);
    read_word(lpv, "parts", settings->parts);
    read_word(lpv, "place", settings->place);
    ty_read_int(lpv, "resolution", &settings->resolution);
    ty_read_int(lpv, "cascades", &settings->cascades);
    ty_read_int(lpv, "bands", &settings->bands);
    ty_read_number(lpv, "extent", &settings->extent);
    ty_read_number(lpv, "window", &settings->window);
    ty_read_int(lpv, "iterations", &settings->iterations);
    ty_read_number(lpv, "tolerance", &settings->tolerance);
    ty_read_int(lpv, "map_side", &settings->map_side);
    ty_read_int(lpv, "samples", &settings->samples);
    ty_read_int(lpv, "block_side", &settings->block_side);
    ty_read_int(lpv, "shadow_side", &settings->shadow_side);
    ty_read_bool(lpv, "shadow_rays", &settings->shadow_rays);
    ty_read_bool(lpv, "half", &settings->half);
    ty_read_number(lpv, "step", &settings->step);
    ty_read_int(lpv, "spp", &settings->spp);
}

static void read_dom(const json_t* dom, ty_dom_settings* settings) {
    read_word(dom, "acceleration", settings->acceleration);
    ty_read_int(dom, "resolution", &settings->resolution);
    ty_read_int(dom, "direct", &settings->direct);
    ty_read_int(dom, "directions", &settings->directions);
    ty_read_int(dom, "last_directions", &settings->last_directions);
    ty_read_int(dom, "bands", &settings->bands);
    ty_read_number(dom, "tolerance", &settings->tolerance);
    ty_read_int(dom, "iterations", &settings->iterations);
    ty_read_int(dom, "environment_beams", &settings->environment_beams);
    ty_read_int(dom, "surface_points", &settings->surface_points);
    ty_read_int(dom, "spp", &settings->spp);
    ty_read_number(dom, "step", &settings->step);
}

static void read_screen(const json_t* screen, ty_screen_settings* settings) {
    read_word(screen, "variant", settings->variant);
    read_word(screen, "spread", settings->spread);
    read_word(screen, "environment", settings->environment);
    ty_read_int(screen, "filter", &settings->filter);
    ty_read_int(screen, "levels", &settings->levels);
    ty_read_bool(screen, "balance", &settings->balance);
}

static void read_render(const ty_scene_reader* reader) {
    const json_t* render = json_object_get(reader->root, "render");
    ty_render_settings settings = ty_scene_render_settings(reader->scene);
    read_word(render, "method", settings.method);
    double seed = (double)settings.seed;
    ty_read_number(render, "seed", &seed);
    settings.seed = (uint64_t)seed;
    ty_read_int(render, "spp", &settings.spp);
    ty_read_int(json_object_get(render, "path"), "max_depth", &settings.path.max_depth);
    read_screen(json_object_get(render, "screen"), &settings.screen);
    read_fld(json_object_get(render, "fld"), &settings.fld);
    read_pop(json_object_get(render, "pop"), &settings.pop);
    read_lpv(json_object_get(render, "lpv"), &settings.lpv);
    read_dom(json_object_get(render, "dom"), &settings.dom);
    ty_scene_set_render_settings(reader->scene, &settings);
}

static ty_result build_scene(ty_scene_reader* reader) {
    const char* up = json_string_value(json_object_get(reader->root, "up_axis"));
    reader->up_axis = up != NULL && strcmp(up, "z") == 0 ? TY_AXIS_Z : TY_AXIS_Y;
    reader->unit = 1;
    ty_read_number(reader->root, "meters_per_unit", &reader->unit);
    ty_read_int(reader->root, "frame", &reader->frame);
    ty_result result = hash_tree(reader);
    if (result == TY_OK) result = ty_scene_create(reader->context, reader->up_axis, &reader->scene);
    if (result == TY_OK) result = ty_read_camera(reader);
    if (result == TY_OK) result = ty_read_media(reader);
    if (result == TY_OK) result = ty_read_lights(reader);
    if (result == TY_OK) result = ty_read_geometry(reader);
    if (result != TY_OK) return result;
    read_render(reader);
    ty_scene_set_hash(reader->scene, reader->hash);
    return ty_scene_commit(reader->scene);
}

static void free_reader(ty_scene_reader* reader) {
    ty_free_assets(reader);
    ty_free_overrides(reader);
    json_decref(reader->root);
}

/* ---- entry points ---- */

ty_result ty_scene_parse(ty_context* context, const char* text, size_t length, const char* name, const char* folder,
                         const char* const* overrides, int32_t override_count, ty_scene** out) {
    if (context == NULL || text == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_parse: context, text or out is NULL");
    ty_scene_reader reader = {.context = context,
                              .clean = ty_last_error(context)[0] == '\0',
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
    static const char* const images[] = {".exr", ".hdr", ".png", ".jpg", ".jpeg", NULL};
    if (ty_has_extension(path, ty_volume_extensions))
        return "a volume; a scene has it as \"file\" of a medium's density";
    if (ty_has_extension(path, ty_mesh_extensions)) return "a mesh; a scene has it as \"file\" in its geometry";
    return ty_has_extension(path, images) ? "an image; a scene may have it as \"file\" of an environment light" : NULL;
}

ty_result ty_scene_load(ty_context* context, const char* path, const char* const* overrides, int32_t override_count,
                        ty_scene** out) {
    if (context == NULL || path == NULL || out == NULL)
        return ty_fail(context, TY_ERROR_ARGUMENT, "ty_scene_load: context, path or out is NULL");
    const size_t prefix = sizeof builtin_prefix - 1;
    if (strncmp(path, builtin_prefix, prefix) == 0) {
        const ty_builtin_scene* scene = ty_builtin_scenes;
        while (scene->name != NULL && strcmp(scene->name, path + prefix) != 0) ++scene;
        if (scene->name == NULL) return fail_builtin(context, path);
        return ty_scene_parse(context, scene->text, scene->size, path, "", overrides, override_count, out);
    }
    uint8_t* bytes;
    size_t size;
    ty_result result = ty_read_file(context, path, FILE_SIZE_MAX, &bytes, &size);
    if (result != TY_OK) return result;
    const char* part = file_role(path);
    if (part != NULL) {
        ty_free_file(context, bytes, size);
        return ty_fail(context, TY_ERROR_INPUT, "%s: not a scene but %s (docs/scene.md)", path, part);
    }
    char* folder = ty_folder_of(context, path);
    result = folder == NULL
                 ? TY_ERROR_MEMORY
                 : ty_scene_parse(context, (const char*)bytes, size, path, folder, overrides, override_count, out);
    ty_free_text(context, folder);
    ty_free_file(context, bytes, size);
    return result;
}
