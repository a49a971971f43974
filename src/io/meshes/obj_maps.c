/* Maps of MTL files that hold one number, joined into the textures of glTF's materials. */
#include "base/context.h"
#include "io/meshes/obj.h"

/* Channel of a texture, -1: none, that a channel of a joined image takes; 255 without one. */
typedef struct source {
    int32_t texture;
    int channel;
} source;

static const ty_model_image* image_of(const ty_model* model, int32_t texture) {
    return &model->images[model->textures[texture].image];
}

/* Texel of an image at the place of texel (x, y) of one of another size. */
static const uint8_t* texel_at(const ty_model_image* image, int32_t x, int32_t y, int32_t width, int32_t height) {
    const int64_t column = (2 * (int64_t)x + 1) * image->width / (2 * (int64_t)width);
    const int64_t row = (2 * (int64_t)y + 1) * image->height / (2 * (int64_t)height);
    return image->rgba8 + 4 * (row * image->width + column);
}

static void fill(const ty_model* model, const source sources[4], ty_model_image* out) {
    for (int32_t y = 0; y < out->height; ++y)
        for (int32_t x = 0; x < out->width; ++x) {
            uint8_t* texel = out->rgba8 + 4 * ((size_t)y * (size_t)out->width + (size_t)x);
            for (int c = 0; c < 4; ++c) {
                const int32_t texture = sources[c].texture;
                texel[c] = 255;
                if (texture >= 0)
                    texel[c] = texel_at(image_of(model, texture), x, y, out->width, out->height)[sources[c].channel];
            }
        }
}

/* A new image of the size of the largest source, which a texture has from now on. */
static ty_result join(ty_model* model, const source sources[4], int32_t texture) {
    ty_model_image image = {.width = 1, .height = 1};
    for (int c = 0; c < 4; ++c) {
        if (sources[c].texture < 0) continue;
        const ty_model_image* from = image_of(model, sources[c].texture);
        if ((int64_t)from->width * from->height < (int64_t)image.width * image.height) continue;
        image.width = from->width;
        image.height = from->height;
    }
    image.name = ty_copy_text(model->context, "");
    image.rgba8 = ty_alloc_array(model->context, (size_t)image.width * (size_t)image.height, 4, false);
    if (image.rgba8 == NULL) {
        ty_free_text(model->context, image.name);
        return TY_ERROR_MEMORY;
    }
    fill(model, sources, &image);
    const ty_result result = ty_model_add_image(model, &image);
    if (result == TY_OK) model->textures[texture].image = (int32_t)model->image_count - 1;
    return result;
}

static bool has_alpha(const ty_model_image* image) {
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; ++i)
        if (image->rgba8[4 * i + 3] < 255) return true;
    return false;
}

static bool is_gray(const ty_model_image* image) {
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; ++i) {
        const uint8_t* texel = image->rgba8 + 4 * i;
        if (texel[0] != texel[1] || texel[1] != texel[2]) return false;
    }
    return true;
}

/* The alpha of an image with one, else its red. The image of the base colour named again says so by its alpha alone. */
static ty_result join_opacity(ty_model* model, ty_model_material* material) {
    const int32_t opacity = material->single_textures[TY_SINGLE_OPACITY], albedo = material->albedo_texture;
    if (opacity < 0) return TY_OK;
    const bool alpha = has_alpha(image_of(model, opacity));
    const bool same = albedo >= 0 && model->textures[albedo].image == model->textures[opacity].image;
    if (alpha || !same) material->def.alpha_mode = TY_ALPHA_BLEND;
    if (same) {
        model->textures[opacity].image = -1;
        return TY_OK;
    }
    const source sources[4] = {{albedo, 0}, {albedo, 1}, {albedo, 2}, {opacity, alpha ? 3 : 0}};
    const int32_t texture = albedo >= 0 ? albedo : opacity;
    const ty_result result = join(model, sources, texture);
    if (result != TY_OK) return result;
    if (albedo >= 0) model->textures[opacity].image = -1;
    model->textures[texture].linear = false;
    material->albedo_texture = texture;
    return TY_OK;
}

/* Both of one image are its green and its blue, as in glTF. */
static ty_result join_metal(ty_model* model, ty_model_material* material) {
    const int32_t rough = material->single_textures[TY_SINGLE_ROUGHNESS];
    const int32_t metal = material->single_textures[TY_SINGLE_METALLIC];
    const int32_t texture = rough >= 0 ? rough : metal;
    if (texture < 0) return TY_OK;
    material->gloss_textures[TY_GLOSS_METALLIC_ROUGHNESS] = texture;
    const bool same = rough >= 0 && metal >= 0 && model->textures[rough].image == model->textures[metal].image;
    const source sources[4] = {{-1, 0}, {rough, 1}, {metal, 2}, {-1, 0}};
    const ty_result result = same ? TY_OK : join(model, sources, texture);
    if (rough >= 0 && metal >= 0) model->textures[metal].image = -1;
    return result;
}

/* Gray maps hold heights, which are left out; the others hold normals. */
static bool take_bump(ty_model* model, ty_model_material* material) {
    const int32_t bump = material->single_textures[TY_SINGLE_BUMP];
    if (bump < 0) return true;
    const bool heights = is_gray(image_of(model, bump)), taken = material->gloss_textures[TY_GLOSS_NORMAL] >= 0;
    if (!heights && !taken)
        material->gloss_textures[TY_GLOSS_NORMAL] = bump;
    else
        model->textures[bump].image = -1;
    return !heights;
}

ty_result ty_obj_join_maps(ty_model* model, const char* path) {
    ty_result result = TY_OK;
    size_t heights = 0;
    for (size_t i = 0; i < model->material_count && result == TY_OK; ++i) {
        ty_model_material* material = &model->materials[i];
        result = join_opacity(model, material);
        if (result == TY_OK) result = join_metal(model, material);
        if (result == TY_OK) heights += !take_bump(model, material);
        for (int k = 0; k < TY_SINGLE_MAPS; ++k) material->single_textures[k] = -1;
    }
    if (heights > 0)
        ty_log(model->context, TY_LOG_WARNING, "%s: %zu maps of heights have no effect; maps of normals have", path,
               heights);
    return result;
}
