/* Materials of a scene file, and their textures. */
#include "base/context.h"
#include "io/images/image_file.h"
#include "io/scenes/memory_files.h"
#include "io/scenes/scene_reader.h"

#include <string.h>

enum { IMAGE_FILE_MAX = 1 << 30 };

/* Surfaces with any of these keys are glossy. */
static const char* const gloss_keys[] = {"metallic",       "roughness",      "ior",          "specular",
                                         "specular_color", "clearcoat",      "transmission", "clearcoat_roughness",
                                         "sheen_color",    "sheen_roughness"};

/* ---- images ---- */

typedef struct texels {
    uint8_t* rgba8;
    int32_t width, height;
} texels;

static void free_texels(ty_context* context, texels* image) {
    ty_free_array(context, image->rgba8, (size_t)image->width * (size_t)image->height, 4);
}

/* Texels of the image that a texture object at path names. */
static ty_result read_texels(const ty_scene_reader* reader, const ty_json_path* json_path, const ty_asset_file* file,
                             bool colors, texels* out) {
    uint8_t* bytes = NULL;
    size_t size = 0;
    if (file->memory != NULL)
        return ty_reader_prefix_error(
            reader, json_path, ty_memory_texels(reader->assets, file, colors, &out->width, &out->height, &out->rgba8));
    ty_result result =
        ty_read_inspected_file(reader->context, file->path, IMAGE_FILE_MAX, ty_inspect_image, &bytes, &size);
    if (result == TY_OK) {
        const ty_image_format format = ty_image_format_of(bytes, size);
        if (format == TY_IMAGE_PNG || format == TY_IMAGE_JPEG || format == TY_IMAGE_WEBP)
            result = ty_decode_rgba8(reader->context, file->path, bytes, size, &out->width, &out->height, &out->rgba8);
        else
            result = ty_fail(reader->context, TY_ERROR_INPUT, "%s: textures are PNG, JPEG or WebP files", file->path);
        ty_free_file(reader->context, bytes, size);
    }
    return ty_reader_prefix_error(reader, json_path, result);
}

static ty_result create_texture(const ty_scene_reader* reader, const ty_json_path* json_path, const texels* image,
                                bool linear, ty_texture** out) {
    ty_texture_def def = ty_default_texture_def();
    def.width = image->width;
    def.height = image->height;
    def.rgba8 = image->rgba8;
    def.linear = linear;
    return ty_reader_prefix_error(reader, json_path, ty_texture_create(reader->context, &def, out));
}

/* Sets all channels but one to 1. */
static void keep_channel(texels* image, int kept) {
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < 4 * count; ++i)
        if ((int)(i % 4) != kept) image->rgba8[i] = 255;
}

/* ---- textures ---- */

static ty_result find_image(ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                            const ty_asset_file** file) {
    const ty_json_path json_path = ty_json_path_key(path, "file");
    return ty_find_file(reader, &json_path, json_string_value(json_object_get(object, "file")), file);
}

/* The texture of an object at path; the caller has a reference. */
static ty_result read_texture(ty_scene_reader* reader, const json_t* object, const ty_json_path* path,
                              ty_texture_content content, ty_texture** out) {
    const ty_json_path json_path = ty_json_path_key(path, "file");
    ty_asset texture = {.kind = TY_ASSET_TEXTURE, .content = content};
    ty_result result = find_image(reader, object, path, &texture.file);
    if (result != TY_OK) return result;
    const ty_asset* found = ty_assets_find(reader->assets, &texture);
    if (found != NULL) {
        *out = ty_texture_retain(found->texture);
        return TY_OK;
    }
    texels image = {.rgba8 = NULL};
    result = read_texels(reader, &json_path, texture.file, content == TY_TEXTURE_COLORS, &image);
    if (result == TY_OK && content == TY_TEXTURE_ROUGHNESS) keep_channel(&image, 1);
    if (result == TY_OK && content == TY_TEXTURE_METALLIC) keep_channel(&image, 2);
    if (result == TY_OK)
        result = create_texture(reader, &json_path, &image, content != TY_TEXTURE_COLORS, &texture.texture);
    free_texels(reader->context, &image);
    if (result != TY_OK) return result;
    *out = ty_texture_retain(texture.texture);
    return ty_assets_keep(reader->assets, &texture);
}

/* Repetitions of a texture along u and v. */
static void read_repeat(const json_t* object, float map[6]) {
    const json_t* repeat = json_object_get(object, "repeat");
    if (repeat == NULL) return;
    const bool both = json_is_array(repeat);
    map[0] = (float)json_number_value(both ? json_array_get(repeat, 0) : repeat);
    map[4] = (float)json_number_value(both ? json_array_get(repeat, 1) : repeat);
}

/* A number, or a texture with a factor. */
static ty_result read_textured(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                               const char* key, ty_texture_content content, float* number, ty_texture_use* use) {
    const json_t* object = json_object_get(material, key);
    const ty_json_path json_path = ty_json_path_key(path, key);
    if (!json_is_object(object)) {
        ty_read_float(material, key, number);
        return TY_OK;
    }
    *number = 1;
    ty_read_float(object, "factor", number);
    read_repeat(object, use->map);
    return read_texture(reader, object, &json_path, content, &use->texture);
}

static ty_result read_normals(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                              const char* key, float* scale, ty_texture_use* use) {
    const json_t* object = json_object_get(material, key);
    const ty_json_path json_path = ty_json_path_key(path, key);
    if (object == NULL) return TY_OK;
    ty_read_float(object, "scale", scale);
    read_repeat(object, use->map);
    return read_texture(reader, object, &json_path, TY_TEXTURE_NUMBERS, &use->texture);
}

/* One texture of the green of one image and the blue of another. */
static ty_result join_images(ty_scene_reader* reader, const json_t* roughness, const json_t* metallic,
                             const ty_json_path* path, ty_texture** out) {
    const ty_json_path green_path = ty_json_path_key(path, "roughness"), blue_path = ty_json_path_key(path, "metallic");
    const ty_json_path file_path = ty_json_path_key(&green_path, "file");
    const ty_asset_file *green_file = NULL, *blue_file = NULL;
    texels green = {.rgba8 = NULL}, blue = {.rgba8 = NULL};
    ty_result result = find_image(reader, roughness, &green_path, &green_file);
    if (result == TY_OK) result = find_image(reader, metallic, &blue_path, &blue_file);
    if (result == TY_OK) result = read_texels(reader, &file_path, green_file, false, &green);
    if (result == TY_OK) result = read_texels(reader, &file_path, blue_file, false, &blue);
    if (result == TY_OK && (green.width != blue.width || green.height != blue.height))
        result = ty_reader_fail(reader, &file_path, TY_ERROR_INPUT,
                                "%d x %d texels beside %d x %d of metallic: both images need the same size",
                                (int)green.width, (int)green.height, (int)blue.width, (int)blue.height);
    for (size_t i = 0; result == TY_OK && i < (size_t)green.width * (size_t)green.height; ++i)
        green.rgba8[4 * i + 2] = blue.rgba8[4 * i + 2];
    if (result == TY_OK) result = create_texture(reader, &file_path, &green, true, out);
    free_texels(reader->context, &green);
    free_texels(reader->context, &blue);
    return result;
}

/* Metallic and roughness, which share a texture: roughness is its green, metallic its blue. */
static ty_result read_metal(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                            ty_gloss_def* gloss) {
    const json_t *roughness = json_object_get(material, "roughness"), *metallic = json_object_get(material, "metallic");
    const ty_json_path json_path = ty_json_path_key(path, "metallic");
    ty_texture_use* use = &gloss->textures[TY_GLOSS_METALLIC_ROUGHNESS];
    ty_texture_use rough = *use;
    if (!json_is_object(roughness) || !json_is_object(metallic)) {
        ty_texture_use* own = json_is_object(metallic) ? use : &rough;
        ty_result result =
            read_textured(reader, material, path, "metallic", TY_TEXTURE_METALLIC, &gloss->metallic, use);
        if (result == TY_OK)
            result =
                read_textured(reader, material, path, "roughness", TY_TEXTURE_ROUGHNESS, &gloss->roughness, &rough);
        *use = *own;
        return result;
    }
    gloss->metallic = gloss->roughness = 1;
    ty_read_float(metallic, "factor", &gloss->metallic);
    ty_read_float(roughness, "factor", &gloss->roughness);
    read_repeat(metallic, use->map);
    read_repeat(roughness, rough.map);
    if (memcmp(use->map, rough.map, sizeof rough.map) != 0)
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT,
                              "its texture repeats otherwise than that of roughness");
    const char* file = json_string_value(json_object_get(metallic, "file"));
    if (strcmp(file, json_string_value(json_object_get(roughness, "file"))) == 0)
        return read_texture(reader, metallic, &json_path, TY_TEXTURE_NUMBERS, &use->texture);
    return join_images(reader, roughness, metallic, path, &use->texture);
}

/* ---- materials ---- */

static ty_result read_base_color(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                                 ty_material_def* out) {
    const json_t* color = json_object_get(material, "base_color");
    const ty_json_path json_path = ty_json_path_key(path, "base_color");
    const ty_json_path old_name = ty_json_path_key(path, "albedo");
    if (json_object_get(material, "albedo") != NULL && color != NULL)
        return ty_reader_fail(reader, &old_name, TY_ERROR_INPUT, "is the old name of base_color; give one of them");
    ty_read_rgb(material, "albedo", out->albedo);
    if (!json_is_object(color)) {
        ty_read_rgb(material, "base_color", out->albedo);
        return TY_OK;
    }
    for (int c = 0; c < 3; ++c) out->albedo[c] = 1;
    ty_read_rgb(color, "factor", out->albedo);
    read_repeat(color, out->albedo_map);
    return read_texture(reader, color, &json_path, TY_TEXTURE_COLORS, &out->albedo_texture);
}

static ty_result read_emission(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                               ty_material_def* out) {
    const json_t* emission = json_object_get(material, "emission");
    const ty_json_path json_path = ty_json_path_key(path, "emission");
    if (!json_is_object(emission)) {
        ty_read_rgb(material, "emission", out->emission);
        return TY_OK;
    }
    for (int c = 0; c < 3; ++c) out->emission[c] = 1;
    ty_read_rgb(emission, "factor", out->emission);
    read_repeat(emission, out->emission_map);
    return read_texture(reader, emission, &json_path, TY_TEXTURE_COLORS, &out->emission_texture);
}

static ty_result read_gloss(ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                            ty_gloss_def* gloss) {
    bool glossy = false;
    for (size_t i = 0; i < sizeof gloss_keys / sizeof *gloss_keys; ++i)
        glossy = glossy || json_object_get(material, gloss_keys[i]) != NULL;
    if (!glossy) return TY_OK;
    gloss->specular = 1;
    ty_read_float(material, "ior", &gloss->ior);
    ty_read_float(material, "specular", &gloss->specular);
    ty_read_rgb(material, "specular_color", gloss->specular_color);
    ty_read_rgb(material, "sheen_color", gloss->sheen_color);
    ty_read_float(material, "sheen_roughness", &gloss->sheen_roughness);
    ty_result result = read_metal(reader, material, path, gloss);
    const struct {
        const char* key;
        ty_gloss_texture texture;
        float* number;
    } textured[] = {{"transmission", TY_GLOSS_TRANSMISSION, &gloss->transmission},
                    {"clearcoat", TY_GLOSS_CLEARCOAT, &gloss->clearcoat},
                    {"clearcoat_roughness", TY_GLOSS_CLEARCOAT_ROUGHNESS, &gloss->clearcoat_roughness}};
    for (size_t i = 0; i < sizeof textured / sizeof *textured && result == TY_OK; ++i)
        result = read_textured(reader, material, path, textured[i].key, TY_TEXTURE_NUMBERS, textured[i].number,
                               &gloss->textures[textured[i].texture]);
    return result;
}

/* The solid that the surface bounds. */
static ty_result read_volume(const ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                             ty_gloss_def* gloss) {
    const json_t* volume = json_object_get(material, "volume");
    const ty_json_path json_path = ty_json_path_key(path, "volume");
    if (volume == NULL) return TY_OK;
    if (!(gloss->transmission > 0))
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "needs the key \"transmission\" above 0 beside it");
    gloss->solid = true;
    ty_read_int(volume, "priority", &gloss->priority);
    ty_read_rgb(volume, "attenuation_color", gloss->attenuation_color);
    ty_read_float(volume, "attenuation_distance", &gloss->attenuation_distance);
    return TY_OK;
}

ty_result ty_read_material(ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                           ty_material_def* out) {
    const json_t* material = json_object_get(item, "material");
    const ty_json_path json_path = ty_json_path_key(path, "material");
    ty_gloss_def* gloss = &out->gloss;
    ty_result result = read_emission(reader, material, &json_path, out);
    if (result == TY_OK) result = read_base_color(reader, material, &json_path, out);
    if (result == TY_OK) result = read_gloss(reader, material, &json_path, gloss);
    if (result == TY_OK) result = read_volume(reader, material, &json_path, gloss);
    if (result == TY_OK)
        result = read_normals(reader, material, &json_path, "normal_map", &gloss->normal_scale,
                              &gloss->textures[TY_GLOSS_NORMAL]);
    if (result == TY_OK)
        result = read_normals(reader, material, &json_path, "clearcoat_normal_map", &gloss->clearcoat_normal_scale,
                              &gloss->textures[TY_GLOSS_CLEARCOAT_NORMAL]);
    return result;
}

void ty_release_material(const ty_material_def* material) {
    ty_texture_release(material->albedo_texture);
    ty_texture_release(material->emission_texture);
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) ty_texture_release(material->gloss.textures[i].texture);
}
