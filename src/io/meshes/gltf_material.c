/* glTF materials and textures. Of the specular-glossiness model only the diffuse color is used. */
#include "base/context.h"
#include "io/images/image_file.h"
#include "io/meshes/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define EMISSION_MAX 1e15

/* ---- images ---- */

/* Loads the bytes of an image, with the zero byte of ty_read_file. */
static ty_result load_image(ty_gltf* gltf, size_t index, uint8_t** bytes, size_t* size) {
    const ty_json_path json_path = ty_gltf_json_path("images", index);
    const json_t* json = ty_gltf_item(gltf, "images", index);
    const char* uri = json_string_value(json_object_get(json, "uri"));
    if (uri != NULL) return ty_gltf_load_uri(gltf, &json_path, uri, TY_GLTF_FILE_MAX, ty_inspect_image, bytes, size);
    int64_t view = -1;
    ty_result result = ty_gltf_read_reference(gltf, json, &json_path, "bufferView", "bufferViews", &view);
    if (result != TY_OK) return result;
    if (view < 0) return ty_gltf_fail(gltf, &json_path, "it has neither a uri nor a bufferView");
    const uint8_t* data = NULL;
    size_t length = 0, stride = 0;
    result = ty_gltf_open_view(gltf, (size_t)view, &data, &length, &stride);
    if (result != TY_OK) return result;
    uint8_t* copy = ty_alloc_array(gltf->context, length + 1, 1, false);
    if (copy == NULL) return TY_ERROR_MEMORY;
    memcpy(copy, data, length);
    copy[length] = 0;
    *bytes = copy;
    *size = length;
    return TY_OK;
}

/* Index of the model's image for a glTF image, loaded on first use. */
static ty_result use_image(ty_gltf* gltf, size_t index, int32_t* out) {
    if (gltf->images[index] == 0) {
        ty_model_image image = {0};
        ty_result result = load_image(gltf, index, &image.encoded, &image.encoded_size);
        if (result != TY_OK) return result;
        char name[512];
        snprintf(name, sizeof name, "%s: images[%zu]", gltf->path, index);
        image.name = ty_copy_text(gltf->context, name);
        result = ty_model_add_image(gltf->model, &image);
        if (result != TY_OK) return result;
        gltf->images[index] = (int32_t)gltf->model->image_count;
    }
    *out = gltf->images[index] - 1;
    return TY_OK;
}

/* ---- textures ---- */

static ty_result read_wrap(const ty_gltf* gltf, const json_t* sampler, const ty_json_path* json_path, const char* key,
                           ty_wrap* out) {
    enum { CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648, REPEAT = 10497 };
    int64_t wrap = REPEAT;
    const ty_result result = ty_gltf_read_integer(gltf, sampler, json_path, key, 0, 65535, &wrap);
    if (result == TY_OK && wrap != REPEAT && wrap != CLAMP_TO_EDGE && wrap != MIRRORED_REPEAT)
        return ty_gltf_fail(gltf, json_path, "%s: there is no wrapping %lld", key, (long long)wrap);
    *out = wrap == CLAMP_TO_EDGE ? TY_WRAP_CLAMP : wrap == MIRRORED_REPEAT ? TY_WRAP_MIRROR : TY_WRAP_REPEAT;
    return result;
}

static ty_result read_sampler(const ty_gltf* gltf, size_t index, ty_model_texture* texture) {
    enum { NEAREST = 9728 };
    const ty_json_path json_path = ty_gltf_json_path("samplers", index);
    const json_t* sampler = ty_gltf_item(gltf, "samplers", index);
    int64_t filter = 0;
    ty_result result = read_wrap(gltf, sampler, &json_path, "wrapS", &texture->wrap[0]);
    if (result == TY_OK) result = read_wrap(gltf, sampler, &json_path, "wrapT", &texture->wrap[1]);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, sampler, &json_path, "magFilter", 0, 65535, &filter);
    texture->nearest = filter == NEAREST;
    return result;
}

/* Image of a texture: its source, or the WebP image of an extension. Other kinds of images are refused. */
static ty_result read_source(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path, int64_t* source) {
    static const char* const others[] = {"KHR_texture_basisu", "KHR_texture_ktx", "GOOGLE_texture_basis",
                                         "MSFT_texture_dds", "EXT_texture_avif"};
    ty_result result = ty_gltf_read_reference(gltf, json, json_path, "source", "images", source);
    const json_t* webp = ty_gltf_extension(json, "EXT_texture_webp");
    if (result == TY_OK && *source < 0 && webp != NULL)
        result = ty_gltf_read_reference(gltf, webp, json_path, "source", "images", source);
    if (result != TY_OK || *source >= 0) return result;
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
        if (ty_gltf_extension(json, others[i]) != NULL)
            return ty_gltf_fail(gltf, json_path,
                                "its only image is one of %s, which cannot be read; convert it to PNG or JPEG, as "
                                "\"gltf-transform ktxdecompress\" does for KTX2",
                                others[i]);
    return ty_gltf_fail(gltf, json_path, "it has no source that can be read");
}

/* Index of the model's texture for a glTF texture, created on first use; linear: for numbers, not colours. */
static ty_result use_texture(ty_gltf* gltf, size_t index, bool linear, int32_t* out) {
    int32_t* known = &gltf->textures[index + (linear ? ty_gltf_count(gltf, "textures") : 0)];
    if (*known == 0) {
        const ty_json_path json_path = ty_gltf_json_path("textures", index);
        const json_t* json = ty_gltf_item(gltf, "textures", index);
        ty_model_texture texture = {.linear = linear};
        int64_t source = -1, sampler = -1;
        ty_result result = read_source(gltf, json, &json_path, &source);
        if (result == TY_OK) result = ty_gltf_read_reference(gltf, json, &json_path, "sampler", "samplers", &sampler);
        if (result == TY_OK && sampler >= 0) result = read_sampler(gltf, (size_t)sampler, &texture);
        if (result == TY_OK) result = use_image(gltf, (size_t)source, &texture.image);
        if (result == TY_OK) result = ty_model_add_texture(gltf->model, &texture);
        if (result != TY_OK) return result;
        *known = (int32_t)gltf->model->texture_count;
    }
    *out = *known - 1;
    return TY_OK;
}

/* KHR_texture_transform: scale, rotation, translation. Rotation is counter-clockwise with v pointing down. */
static ty_result read_map(const ty_gltf* gltf, const json_t* transform, const ty_json_path* json_path, float map[6],
                          int64_t* uv) {
    double offset[2] = {0, 0}, scale[2] = {1, 1}, angle = 0;
    ty_result result = ty_gltf_read_numbers(gltf, transform, json_path, "offset", 2, -1e6, 1e6, offset);
    if (result == TY_OK) result = ty_gltf_read_numbers(gltf, transform, json_path, "scale", 2, -1e6, 1e6, scale);
    if (result == TY_OK) result = ty_gltf_read_number(gltf, transform, json_path, "rotation", -1e6, 1e6, &angle);
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, transform, json_path, "texCoord", 0, INT32_MAX, uv);
    const double c = cos(angle), s = sin(angle);
    const double rows[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    for (int i = 0; i < 6; ++i) map[i] = (float)rows[i];
    return result;
}

/* Texture reference: index, texture coordinate set, transform. */
static ty_result read_texture(ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                              bool linear, int32_t* texture, int32_t* uv, float map[6]) {
    const json_t* info = json_object_get(object, key);
    if (info == NULL) return TY_OK;
    const ty_json_path here = ty_json_path_key(json_path, key);
    int64_t index = -1, set = 0;
    ty_result result = ty_gltf_read_reference(gltf, info, &here, "index", "textures", &index);
    if (result == TY_OK && index < 0) return ty_gltf_fail(gltf, &here, "index is missing");
    if (result == TY_OK) result = ty_gltf_read_integer(gltf, info, &here, "texCoord", 0, INT32_MAX, &set);
    const json_t* transform = ty_gltf_extension(info, "KHR_texture_transform");
    if (result == TY_OK && transform != NULL) result = read_map(gltf, transform, &here, map, &set);
    if (result == TY_OK && set > 1)
        return ty_gltf_fail(gltf, &here, "it uses TEXCOORD_%lld; 0 and 1 can be read", (long long)set);
    if (result == TY_OK) result = use_texture(gltf, (size_t)index, linear, texture);
    *uv = (int32_t)set;
    return result;
}

/* ---- materials ---- */

static ty_result read_surface(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                              ty_model_material* material) {
    const json_t* diffuse = ty_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness");
    const char* name = diffuse != NULL ? "KHR_materials_pbrSpecularGlossiness" : "pbrMetallicRoughness";
    const json_t* surface = diffuse != NULL ? diffuse : json_object_get(json, name);
    const ty_json_path here = ty_json_path_key(json_path, name);
    ty_material_def* def = &material->def;
    double color[4] = {1, 1, 1, 1};
    const ty_result result = ty_gltf_read_numbers(
        gltf, surface, &here, diffuse != NULL ? "diffuseFactor" : "baseColorFactor", 4, 0, 1, color);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) def->albedo[c] = (float)color[c];
    def->alpha = (float)color[3];
    return read_texture(gltf, surface, &here, diffuse != NULL ? "diffuseTexture" : "baseColorTexture", false,
                        &material->albedo_texture, &def->albedo_uv, def->albedo_map);
}

/* ---- gloss ---- */

static ty_result read_gloss_texture(ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                                    ty_gloss_texture number, ty_model_material* material) {
    const bool color = number == TY_GLOSS_SPECULAR_COLOR || number == TY_GLOSS_SHEEN_COLOR;
    ty_texture_use* use = &material->def.gloss.textures[number];
    return read_texture(gltf, object, json_path, key, !color, &material->gloss_textures[number], &use->uv, use->map);
}

static ty_result read_factor(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                             double low, double high, float* out) {
    double value = (double)*out;
    const ty_result result = ty_gltf_read_number(gltf, object, json_path, key, low, high, &value);
    *out = (float)value;
    return result;
}

static ty_result read_color(const ty_gltf* gltf, const json_t* object, const ty_json_path* json_path, const char* key,
                            double high, float out[3]) {
    double color[3] = {(double)out[0], (double)out[1], (double)out[2]};
    const ty_result result = ty_gltf_read_numbers(gltf, object, json_path, key, 3, 0, high, color);
    for (int c = 0; c < 3; ++c) out[c] = (float)color[c];
    return result;
}

/* A texture of normals under key, and its scale. */
static ty_result read_normals(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path, const char* key,
                              ty_gloss_texture number, ty_model_material* material, float* scale) {
    const json_t* texture = json_object_get(json, key);
    const ty_json_path here = ty_json_path_key(json_path, key);
    const ty_result result = read_factor(gltf, texture, &here, "scale", -1e3, 1e3, scale);
    return result == TY_OK ? read_gloss_texture(gltf, json, json_path, key, number, material) : result;
}

/* An extension of a material; its JSON path is stored, too. */
static const json_t* find_extension(const json_t* json, const ty_json_path* json_path, const char* name,
                                    ty_json_path* here) {
    const ty_json_path extensions = ty_json_path_key(json_path, "extensions");
    *here = ty_json_path_key(&extensions, name);
    return ty_gltf_extension(json, name);
}

static ty_result read_dielectric(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                                 ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    ty_json_path here;
    const json_t* ior = find_extension(json, json_path, "KHR_materials_ior", &here);
    ty_result result = read_factor(gltf, ior, &here, "ior", 0, 100, &gloss->ior);
    if (result == TY_OK && gloss->ior > 0 && gloss->ior < 1)
        return ty_gltf_fail(gltf, &here, "ior: %g is neither 0 nor in [1, 100]", (double)gloss->ior);
    const json_t* specular = find_extension(json, json_path, "KHR_materials_specular", &here);
    gloss->specular = 1;
    if (result == TY_OK) result = read_factor(gltf, specular, &here, "specularFactor", 0, 1, &gloss->specular);
    if (result == TY_OK) result = read_color(gltf, specular, &here, "specularColorFactor", 1e3, gloss->specular_color);
    if (result == TY_OK)
        result = read_gloss_texture(gltf, specular, &here, "specularTexture", TY_GLOSS_SPECULAR, material);
    if (result == TY_OK)
        result = read_gloss_texture(gltf, specular, &here, "specularColorTexture", TY_GLOSS_SPECULAR_COLOR, material);
    const json_t* transmission = find_extension(json, json_path, "KHR_materials_transmission", &here);
    if (result == TY_OK)
        result = read_factor(gltf, transmission, &here, "transmissionFactor", 0, 1, &gloss->transmission);
    if (result != TY_OK) return result;
    return read_gloss_texture(gltf, transmission, &here, "transmissionTexture", TY_GLOSS_TRANSMISSION, material);
}

/* The interior of a closed surface. A thickness above 0 says that there is one; light finds its own way through. */
static ty_result read_volume(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                             ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    ty_json_path here;
    const json_t* volume = find_extension(json, json_path, "KHR_materials_volume", &here);
    float thickness = 0;
    ty_result result = read_factor(gltf, volume, &here, "thicknessFactor", 0, 1e15, &thickness);
    if (result == TY_OK)
        result = read_factor(gltf, volume, &here, "attenuationDistance", 0, 1e15, &gloss->attenuation_distance);
    gloss->solid = thickness > 0;
    return result == TY_OK ? read_color(gltf, volume, &here, "attenuationColor", 1, gloss->attenuation_color) : result;
}

static ty_result read_coats(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                            ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    ty_json_path here;
    const json_t* coat = find_extension(json, json_path, "KHR_materials_clearcoat", &here);
    ty_result result = read_factor(gltf, coat, &here, "clearcoatFactor", 0, 1, &gloss->clearcoat);
    if (result == TY_OK)
        result = read_factor(gltf, coat, &here, "clearcoatRoughnessFactor", 0, 1, &gloss->clearcoat_roughness);
    if (result == TY_OK)
        result = read_gloss_texture(gltf, coat, &here, "clearcoatTexture", TY_GLOSS_CLEARCOAT, material);
    if (result == TY_OK)
        result =
            read_gloss_texture(gltf, coat, &here, "clearcoatRoughnessTexture", TY_GLOSS_CLEARCOAT_ROUGHNESS, material);
    if (result == TY_OK)
        result = read_normals(gltf, coat, &here, "clearcoatNormalTexture", TY_GLOSS_CLEARCOAT_NORMAL, material,
                              &gloss->clearcoat_normal_scale);
    const json_t* sheen = find_extension(json, json_path, "KHR_materials_sheen", &here);
    if (result == TY_OK) result = read_color(gltf, sheen, &here, "sheenColorFactor", 1, gloss->sheen_color);
    if (result == TY_OK)
        result = read_factor(gltf, sheen, &here, "sheenRoughnessFactor", 0, 1, &gloss->sheen_roughness);
    if (result == TY_OK)
        result = read_gloss_texture(gltf, sheen, &here, "sheenColorTexture", TY_GLOSS_SHEEN_COLOR, material);
    if (result != TY_OK) return result;
    return read_gloss_texture(gltf, sheen, &here, "sheenRoughnessTexture", TY_GLOSS_SHEEN_ROUGHNESS, material);
}

static ty_result read_gloss(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                            ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    const json_t* surface = json_object_get(json, "pbrMetallicRoughness");
    const ty_json_path here = ty_json_path_key(json_path, "pbrMetallicRoughness");
    gloss->metallic = 1;
    ty_result result = read_factor(gltf, surface, &here, "metallicFactor", 0, 1, &gloss->metallic);
    if (result == TY_OK) result = read_factor(gltf, surface, &here, "roughnessFactor", 0, 1, &gloss->roughness);
    if (result == TY_OK)
        result =
            read_gloss_texture(gltf, surface, &here, "metallicRoughnessTexture", TY_GLOSS_METALLIC_ROUGHNESS, material);
    if (result == TY_OK) result = read_dielectric(gltf, json, json_path, material);
    if (result == TY_OK) result = read_volume(gltf, json, json_path, material);
    return result == TY_OK ? read_coats(gltf, json, json_path, material) : result;
}

/* ---- emission and alpha ---- */

static ty_result read_emission(ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                               ty_model_material* material) {
    const json_t* extension = ty_gltf_extension(json, "KHR_materials_emissive_strength");
    ty_material_def* def = &material->def;
    double color[3] = {0, 0, 0}, strength = 1;
    ty_result result = ty_gltf_read_numbers(gltf, json, json_path, "emissiveFactor", 3, 0, EMISSION_MAX, color);
    if (result == TY_OK)
        result = ty_gltf_read_number(gltf, extension, json_path, "emissiveStrength", 0, EMISSION_MAX, &strength);
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) def->emission[c] = (float)fmin(color[c] * strength, EMISSION_MAX);
    const bool emissive = def->emission[0] > 0 || def->emission[1] > 0 || def->emission[2] > 0;
    return !emissive ? TY_OK
                     : read_texture(gltf, json, json_path, "emissiveTexture", false, &material->emission_texture,
                                    &def->emission_uv, def->emission_map);
}

static ty_result read_alpha(const ty_gltf* gltf, const json_t* json, const ty_json_path* json_path,
                            ty_material_def* def) {
    const char* mode = json_string_value(json_object_get(json, "alphaMode"));
    double cutoff = 0.5;
    const ty_result result = ty_gltf_read_number(gltf, json, json_path, "alphaCutoff", 0, 1e6, &cutoff);
    if (result != TY_OK) return result;
    def->alpha_cutoff = (float)fmin(cutoff, 1);
    if (mode == NULL || strcmp(mode, "OPAQUE") == 0) return TY_OK;
    const bool mask = strcmp(mode, "MASK") == 0;
    if (!mask && strcmp(mode, "BLEND") != 0)
        return ty_gltf_fail(gltf, json_path, "there is no alphaMode \"%.32s\"", mode);
    def->alpha_mode = mask ? TY_ALPHA_MASK : TY_ALPHA_BLEND;
    return TY_OK;
}

static ty_result read_material(ty_gltf* gltf, size_t index) {
    const ty_json_path json_path = ty_gltf_json_path("materials", index);
    const json_t* json = ty_gltf_item(gltf, "materials", index);
    ty_model_material material = ty_model_plain_material(1);
    material.def.double_sided = json_is_true(json_object_get(json, "doubleSided"));
    ty_result result = read_surface(gltf, json, &json_path, &material);
    if (result == TY_OK)
        result = read_normals(gltf, json, &json_path, "normalTexture", TY_GLOSS_NORMAL, &material,
                              &material.def.gloss.normal_scale);
    const bool diffuse = ty_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness") != NULL ||
                         ty_gltf_extension(json, "KHR_materials_unlit") != NULL;
    if (result == TY_OK && !diffuse) result = read_gloss(gltf, json, &json_path, &material);
    if (result == TY_OK) result = read_emission(gltf, json, &json_path, &material);
    if (result == TY_OK) result = read_alpha(gltf, json, &json_path, &material.def);
    if (result != TY_OK) return result;
    material.name = ty_copy_text(gltf->context, json_string_value(json_object_get(json, "name")));
    return ty_model_add_material(gltf->model, &material);
}

ty_result ty_gltf_read_materials(ty_gltf* gltf) {
    const size_t count = ty_gltf_count(gltf, "materials");
    ty_result result = TY_OK;
    for (size_t i = 0; i < count && result == TY_OK; ++i) result = read_material(gltf, i);
    if (result != TY_OK) return result;
    ty_model_material plain = ty_model_plain_material(1);
    plain.plain = true;
    plain.name = ty_copy_text(gltf->context, "");
    return ty_model_add_material(gltf->model, &plain);
}
