/* tyndall export: lightmaps, probes and light grids of a bake, in the files and conventions of an engine. */
#include "base/context.h"
#include "cli/export/export.h"
#include "cli/commands.h"
#include "cli/text/text_file.h"
#include "io/textures/textures.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

enum { ZSTD_LEVEL = 9 };

/* ---- Lightmaps ---- */

/* Red, green and blue alone, scaled, and with rows in the engine's order. */
static ty_result make_map(const export_run* run, const ty_image* from, ty_image** out) {
    const float* planes[3];
    const int32_t width = ty_image_width(from), height = ty_image_height(from);
    if (!ty_image_rgb_planes(from, planes))
        return ty_fail(run->session->context, TY_ERROR_INPUT, "%s: a lightmap without red, green and blue", run->from);
    const ty_result result = ty_image_create_rgb(run->session->context, width, height, out);
    if (result != TY_OK) return result;
    const float scale = run->engine->per_pi ? 0.318309886f : 1.0f;
    for (int c = 0; c < 3; ++c)
        for (int32_t y = 0; y < height; ++y) {
            const float* row = planes[c] + (size_t)width * (size_t)(run->engine->flipped ? height - 1 - y : y);
            float* to = ty_image_plane(*out, c) + (size_t)width * (size_t)y;
            for (int32_t x = 0; x < width; ++x) to[x] = scale * row[x];
        }
    return TY_OK;
}

static ty_result write_map(const export_run* run, const ty_image* map, const char* path) {
    if (cli_has_extension(path, ".exr")) return ty_image_write_exr(run->session->context, map, path);
    ty_texels_def def = ty_default_texels_def();
    def.format = run->texels >= 0 ? (ty_texel_format)run->texels : run->engine->format;
    def.mipmaps = run->mipmaps;
    def.zstd = cli_has_extension(path, ".ktx2") ? run->zstd : 0;
    return ty_texels_write(run->session->context, map, &def, path);
}

/* The name of a lightmap's file without its extension. */
static void stem_of(const char* name, char* out, size_t size) {
    snprintf(out, size, "%s", name);
    char* dot = strrchr(out, '.');
    if (dot != NULL) *dot = '\0';
}

static const char* source_of(const export_run* run, const json_t* entry) {
    const char* denoised = json_string_value(json_object_get(entry, "denoised"));
    return run->denoised && denoised != NULL ? denoised : json_string_value(json_object_get(entry, "file"));
}

static ty_result export_lightmap(export_run* run, const json_t* entry) {
    char path[EXPORT_PATH_SIZE], stem[EXPORT_PATH_SIZE];
    ty_image *image = NULL, *map = NULL;
    snprintf(path, sizeof path, "%s/%s", run->from, source_of(run, entry));
    ty_result result = ty_image_read(run->session->context, path, &image);
    if (result == TY_OK) result = make_map(run, image, &map);
    ty_image_destroy(image);
    stem_of(json_string_value(json_object_get(entry, "file")), stem, sizeof stem);
    if (snprintf(path, sizeof path, "%s/%s.%s", run->folder, stem, run->engine->extension) >= (int)sizeof path)
        result = ty_fail(run->session->context, TY_ERROR_ARGUMENT, "%s: the path is too long", run->folder);
    if (result == TY_OK) result = write_map(run, map, path);
    ty_image_destroy(map);
    run->lightmaps += result == TY_OK;
    return result;
}

/* ---- export.json ---- */

static const char* kind_of(const json_t* entry) {
    const char* kind = json_string_value(json_object_get(entry, "kind"));
    return kind == NULL || json_string_value(json_object_get(entry, "file")) == NULL ? "" : kind;
}

static void put_lightmap(json_writer* json, const export_run* run, const json_t* entry) {
    char stem[EXPORT_PATH_SIZE], name[EXPORT_PATH_SIZE + 16];
    size_t i;
    const json_t* mesh;
    stem_of(json_string_value(json_object_get(entry, "file")), stem, sizeof stem);
    snprintf(name, sizeof name, "%s.%s", stem, run->engine->extension);
    json_open_object(json, NULL);
    json_text(json, "file", name);
    json_open_array(json, "meshes");
    json_array_foreach(json_object_get(entry, "meshes"), i, mesh) {
        const char* mesh_name = json_string_value(json_object_get(mesh, "name"));
        json_open_object(json, NULL);
        json_text(json, "name", mesh_name == NULL ? "" : mesh_name);
        json_int(json, "node", json_integer_value(json_object_get(mesh, "node")));
        json_int(json, "primitive", json_integer_value(json_object_get(mesh, "primitive")));
        json_close_object(json);
    }
    json_close_array(json);
    json_close_object(json);
}

/* The parts of the bake that are not exported, in the form of the notes of tyndall convert. */
static void put_notes(json_writer* json, const export_run* run) {
    const json_t *files = json_object_get(run->bake, "files"), *entry;
    char line[EXPORT_PATH_SIZE + 64];
    bool copied = false;
    size_t i;
    json_array_foreach(files, i, entry) copied = copied || strcmp(kind_of(entry), "gltf") == 0;
    json_open_array(json, "comment");
    json_array_foreach(files, i, entry) {
        if (copied || strcmp(kind_of(entry), "vertices") != 0) continue;
        snprintf(line, sizeof line, "left out: %s: light at vertices, of which there is no glTF file",
                 json_string_value(json_object_get(entry, "file")));
        json_text(json, NULL, line);
    }
    if (run->has_more_bands) json_text(json, NULL, "left out: probes: bands above the third");
    json_close_array(json);
}

static ty_result print_manifest(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const export_run* run = user;
    const export_engine* engine = run->engine;
    const json_t *files = json_object_get(run->bake, "files"), *entry;
    size_t i;
    json_writer json = json_begin(file);
    json_open_object(&json, NULL);
    json_int(&json, "tyndall_export", 1);
    json_text(&json, "version", ty_version());
    json_text(&json, "engine", engine->name);
    put_notes(&json, run);
    json_text(&json, "axes", engine->axes_text);
    json_text(&json, "lightmap_quantity",
              engine->per_pi ? "irradiance / pi: times the albedo it is radiance"
                             : "irradiance, W m^-2: times albedo / pi it is radiance");
    json_text(&json, "lightmap_rows",
              engine->flipped ? "the first row is at v = 1 of glTF's TEXCOORD_1"
                              : "the first row is at v = 0 of glTF's TEXCOORD_1");
    json_open_array(&json, "lightmaps");
    json_array_foreach(files, i, entry) if (strcmp(kind_of(entry), "lightmap") == 0) put_lightmap(&json, run, entry);
    json_close_array(&json);
    json_array_foreach(files, i, entry) {
        if (strcmp(kind_of(entry), "grid") == 0) json_text(&json, "grid", "grid.json");
        if (strcmp(kind_of(entry), "probes") == 0) json_text(&json, "probes", "probes.json");
        if (strcmp(kind_of(entry), "gltf") != 0) continue;
        json_text(&json, "vertex_colors", json_string_value(json_object_get(entry, "file")));
        json_number(&json, "color_scale", json_number_value(json_object_get(entry, "color_scale")));
    }
    json_close_object(&json);
    return TY_OK;
}

/* ---- The command ---- */

static bool same_folder(const char* a, const char* b) {
    struct stat first, second;
    return stat(a, &first) == 0 && stat(b, &second) == 0 && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}

static ty_result export_entry(export_run* run, const json_t* entry) {
    static const char* const keys[] = {"file", "denoised"};
    const char* kind = kind_of(entry);
    for (int i = 0; i < 2; ++i) {
        const char* name = json_string_value(json_object_get(entry, keys[i]));
        if (name != NULL && strchr(name, '/') != NULL)
            return ty_fail(run->session->context, TY_ERROR_INPUT, "%s/bake.json: %s is in another folder", run->from,
                           name);
    }
    if (strcmp(kind, "lightmap") == 0) return export_lightmap(run, entry);
    if (strcmp(kind, "grid") == 0 || strcmp(kind, "probes") == 0)
        return export_probes(run, entry, json_string_value(json_object_get(entry, "file")));
    return TY_OK;
}

static int export_all(export_run* run) {
    char path[EXPORT_PATH_SIZE];
    const json_t* entry;
    size_t i;
    ty_result result = TY_OK;
    json_array_foreach(json_object_get(run->bake, "files"), i, entry) {
        result = export_entry(run, entry);
        if (result != TY_OK) break;
    }
    snprintf(path, sizeof path, "%s/export.json", run->folder);
    if (result == TY_OK) result = cli_write_text_file(run->session->context, path, print_manifest, run);
    if (result != TY_OK) return cli_fail_reading(run->session, result);
    if (!run->session->common.quiet)
        printf("wrote %s/export.json: %d lightmaps, %" PRId64 " probes for %s\n", run->folder, (int)run->lightmaps,
               run->probe_count, run->engine->name);
    return CLI_DONE;
}

static int run_export(export_run* run) {
    char path[EXPORT_PATH_SIZE];
    json_error_t error;
    if (snprintf(path, sizeof path, "%s/bake.json", run->from) >= (int)sizeof path)
        return cli_usage_error("export", "%s: the path is too long", run->from);
    run->bake = json_load_file(path, 0, &error);
    if (run->bake == NULL) return cli_fail(CLI_USAGE, "%s:%d: %s", path, error.line, error.text);
    int status = CLI_DONE;
    if (!json_is_integer(json_object_get(run->bake, "tyndall_bake")))
        status = cli_fail(CLI_USAGE, "%s: not the list of a bake", path);
    else if (!json_is_true(json_object_get(run->bake, "complete")))
        status = cli_fail(CLI_USAGE, "%s: the bake is not complete; tyndall bake --resume goes on with it", path);
    const char* up = json_string_value(json_object_get(run->bake, "up"));
    run->z_up = up != NULL && strcmp(up, "+z") == 0;
    if (status == CLI_DONE) status = cli_make_folder("export", run->folder);
    if (status == CLI_GO && same_folder(run->from, run->folder))
        status = cli_fail(CLI_USAGE, "%s: the bake itself is there; name another folder with -o", run->folder);
    if (status == CLI_GO) status = export_all(run);
    json_decref(run->bake);
    return status;
}

int cli_export(int count, char** arguments) {
    int engine = 0;
    bool plain = false;
    export_run run = {.texels = -1, .zstd = ty_has_zstd() ? ZSTD_LEVEL : 0};
    const cli_option table[] = {
        {"output", 'o', CLI_TEXT, "FOLDER", "where the files go", &run.folder, 0, 0, NULL},
        {"for", 0, CLI_CHOICE, "three|godot|unity|unreal", "the engine (default three)", &engine, 0, 0, NULL},
        {"texels", 0, CLI_CHOICE, "bc6h|bc6h-signed|half|float|rgb9e5|rgbe|rgbm",
         "of lightmaps (default rgb9e5 for three, bc6h for godot and unity)", &run.texels, 0, 0, NULL},
        {"mipmaps", 0, CLI_FLAG, NULL, "lightmaps with smaller levels", &run.mipmaps, 0, 0, NULL},
        {"no-zstd", 0, CLI_FLAG, NULL, ".ktx2 without compression", &plain, 0, 0, NULL},
        {"denoised", 0, CLI_FLAG, NULL, "the denoised lightmaps of bake --denoise", &run.denoised, 0, 0, NULL},
    };
    const cli_syntax syntax = {
        "export",
        "BAKED -o FOLDER [--for ENGINE] [options]",
        "Writes the lightmaps and probes of a bake as an engine loads them.",
        "BAKED is a folder of tyndall bake. Lightmaps become .ktx2 (three), .dds (godot, unity) or .exr (unreal);\n"
        "probes and light grids become coefficients in the engine's order, signs, factors and axes, light grids also\n"
        "volumes (.ktx2 or .dds) of the first four. export.json\n"
        "lists them with their meshes. docs/engines.md has the importers.",
        table,
        sizeof table / sizeof table[0],
        1,
        1,
        NULL};
    cli_arguments given;
    int status = cli_parse(&syntax, count, arguments, &given);
    if (status == CLI_GO && run.folder == NULL) status = cli_usage_error("export", "-o FOLDER is missing");
    cli_session session;
    if (status == CLI_GO) status = cli_session_open(&session, "export", &given.common);
    if (status != CLI_GO) return status;
    run.session = &session;
    if (plain) run.zstd = 0;
    run.engine = &export_engines[engine];
    run.from = given.positional[0];
    return cli_session_close(&session, run_export(&run));
}
