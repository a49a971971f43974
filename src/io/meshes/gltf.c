/* glTF 2.0 files: the container, extensions, and the order of reading. */
#include "io/meshes/gltf.h"

#include "base/context.h"
#include "io/json_parse.h"
#include "io/schema_text.h"

#include <string.h>

enum { GLB_HEAD = 12, CHUNK_HEAD = 8, CHUNK_JSON = 0x4e4f534a, CHUNK_BIN = 0x004e4942, LIST_SIZE = 512 };

/* ---- container ---- */

static uint32_t read_u32(const uint8_t* at) {
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* Finds the JSON text in a GLB, and its binary chunk if present. */
static ty_result open_glb(ty_gltf* gltf, const uint8_t* bytes, size_t size, const uint8_t** text, size_t* length) {
    if (size < GLB_HEAD) return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: cut short", gltf->path);
    const uint32_t version = read_u32(bytes + 4), stated = read_u32(bytes + 8);
    if (version != 2)
        return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: a GLB of version %u; only 2 can be read", gltf->path,
                       version);
    if (stated > size)
        return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: cut short: %zu bytes of %u", gltf->path, size, stated);
    for (size_t at = GLB_HEAD; at + CHUNK_HEAD <= stated;) {
        const uint32_t chunk = read_u32(bytes + at), type = read_u32(bytes + at + 4);
        const uint8_t* content = bytes + at + CHUNK_HEAD;
        if (chunk > stated - at - CHUNK_HEAD)
            return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: a chunk of %u bytes reaches past the end", gltf->path,
                           chunk);
        if (type == CHUNK_JSON && *text == NULL) {
            *text = content;
            *length = chunk;
        } else if (type == CHUNK_BIN && gltf->chunk == NULL) {
            gltf->chunk = content;
            gltf->chunk_size = chunk;
        }
        at += CHUNK_HEAD + chunk;
    }
    if (*text == NULL) return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: there is no JSON chunk", gltf->path);
    return TY_OK;
}

static ty_result parse_json(ty_gltf* gltf, const uint8_t* text, size_t length) {
    static const char mark[] = "\xef\xbb\xbf"; /* UTF-8 byte order mark, which some editors write */
    if (length >= 3 && memcmp(text, mark, 3) == 0) {
        text += 3;
        length -= 3;
    }
    const ty_result result = ty_json_parse(gltf->context, gltf->path, (const char*)text, length, &gltf->root);
    if (result != TY_OK) return result;
    const char* version = json_string_value(json_object_get(json_object_get(gltf->root, "asset"), "version"));
    if (version == NULL)
        return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: not a glTF file: asset.version is missing", gltf->path);
    if (strncmp(version, "2.", 2) != 0)
        return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: glTF version \"%.16s\"; 2.0 can be read", gltf->path,
                       version);
    return TY_OK;
}

/* ---- extensions ---- */

static bool is_known(const char* name) {
    /* Textures of the last five have another source, or are refused where they are used. */
    static const char* const known[] = {"EXT_mesh_gpu_instancing",
                                        "EXT_meshopt_compression",
                                        "EXT_texture_webp",
                                        "KHR_draco_mesh_compression",
                                        "KHR_lights_punctual",
                                        "KHR_materials_clearcoat",
                                        "KHR_materials_emissive_strength",
                                        "KHR_materials_ior",
                                        "KHR_materials_pbrSpecularGlossiness",
                                        "KHR_materials_sheen",
                                        "KHR_materials_specular",
                                        "KHR_materials_transmission",
                                        "KHR_materials_volume",
                                        "KHR_materials_unlit",
                                        "KHR_materials_variants",
                                        "KHR_mesh_quantization",
                                        "KHR_texture_transform",
                                        "EXT_texture_avif",
                                        "GOOGLE_texture_basis",
                                        "KHR_texture_basisu",
                                        "KHR_texture_ktx",
                                        "MSFT_texture_dds"};
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        if (strcmp(name, known[i]) == 0) return true;
    return false;
}

/* Lists the unsupported extensions under a key; false if there are none. */
static bool list_unknown(const ty_gltf* gltf, const char* key, char list[LIST_SIZE]) {
    size_t i;
    json_t* item;
    list[0] = '\0';
    json_array_foreach(json_object_get(gltf->root, key), i, item) {
        const char* name = json_string_value(item);
        if (name == NULL || is_known(name)) continue;
        if (list[0] != '\0') ty_append(list, LIST_SIZE, ", ");
        ty_append_quoted(list, LIST_SIZE, name);
    }
    return list[0] != '\0';
}

static ty_result check_extensions(const ty_gltf* gltf) {
    char list[LIST_SIZE];
    if (list_unknown(gltf, "extensionsRequired", list))
        return ty_fail(gltf->context, TY_ERROR_INPUT, "%s: it requires what cannot be read here: %s", gltf->path, list);
    if (list_unknown(gltf, "extensionsUsed", list))
        ty_log(gltf->context, TY_LOG_WARNING, "%s: extensions that are ignored: %s", gltf->path, list);
    return TY_OK;
}

/* ---- whole file ---- */

ty_result ty_gltf_open(ty_gltf* gltf, const uint8_t* bytes, size_t size) {
    const uint8_t* text = bytes;
    size_t length = size;
    ty_result result = TY_OK;
    if (size >= 4 && memcmp(bytes, "glTF", 4) == 0) {
        text = NULL;
        result = open_glb(gltf, bytes, size, &text, &length);
    }
    return result == TY_OK ? parse_json(gltf, text, length) : result;
}

ty_result ty_gltf_create_tables(ty_gltf* gltf) {
    const ty_result result = ty_gltf_check_shape(gltf);
    if (result != TY_OK) return result;
    gltf->buffers = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "buffers"), sizeof *gltf->buffers, true);
    gltf->views = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "bufferViews"), sizeof *gltf->views, true);
    gltf->meshes = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "meshes"), sizeof *gltf->meshes, true);
    gltf->images = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "images"), sizeof *gltf->images, true);
    gltf->textures = ty_alloc_array(gltf->context, 2 * ty_gltf_count(gltf, "textures"), sizeof *gltf->textures, true);
    gltf->visited = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "nodes"), sizeof *gltf->visited, true);
    gltf->parents = ty_alloc_array(gltf->context, ty_gltf_count(gltf, "nodes"), sizeof *gltf->parents, true);
    const bool all = gltf->buffers != NULL && gltf->views != NULL && gltf->meshes != NULL && gltf->images != NULL &&
                     gltf->textures != NULL && gltf->visited != NULL && gltf->parents != NULL;
    return all ? TY_OK : TY_ERROR_MEMORY;
}

void ty_gltf_close(ty_gltf* gltf) {
    ty_gltf_free_buffers(gltf);
    ty_free_array(gltf->context, gltf->meshes, ty_gltf_count(gltf, "meshes"), sizeof *gltf->meshes);
    ty_free_array(gltf->context, gltf->images, ty_gltf_count(gltf, "images"), sizeof *gltf->images);
    ty_free_array(gltf->context, gltf->textures, 2 * ty_gltf_count(gltf, "textures"), sizeof *gltf->textures);
    ty_free_array(gltf->context, gltf->visited, ty_gltf_count(gltf, "nodes"), sizeof *gltf->visited);
    ty_free_array(gltf->context, gltf->parents, ty_gltf_count(gltf, "nodes"), sizeof *gltf->parents);
    json_decref(gltf->root);
}

/* One warning for each kind of skipped content. */
static void warn(const ty_gltf* gltf) {
    if ((gltf->want & TY_MODEL_MESHES) == 0) return;
    if (gltf->skipped > 0)
        ty_log(gltf->context, TY_LOG_WARNING, "%s: %zu primitives that are no triangles are left out", gltf->path,
               gltf->skipped);
    if (json_array_size(json_object_get(gltf->root, "animations")) > 0)
        ty_log(gltf->context, TY_LOG_WARNING, "%s: animations are not played: meshes are in their rest pose",
               gltf->path);
}

ty_result ty_read_gltf(ty_context* context, const char* path, const char* folder, const uint8_t* bytes, size_t size,
                       unsigned want, ty_model* model) {
    *model = (ty_model){.context = context};
    ty_gltf gltf = {.context = context, .path = path, .folder = folder, .want = want, .model = model};
    ty_result result = ty_gltf_open(&gltf, bytes, size);
    if (result == TY_OK) result = check_extensions(&gltf);
    if (result == TY_OK) result = ty_gltf_create_tables(&gltf);
    if (result == TY_OK && (want & TY_MODEL_MATERIALS) != 0) result = ty_gltf_read_materials(&gltf);
    if (result == TY_OK) result = ty_gltf_read_scene(&gltf);
    if (result == TY_OK) warn(&gltf);
    ty_gltf_close(&gltf);
    return result == TY_OK ? ty_model_decode_images(model) : result;
}
