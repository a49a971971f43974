/* Textures: images and what is constant; of other kinds a mean. */
#include "base/context.h"
#include "io/interchange/pbrt/pbrt.h"

#include <stdio.h>
#include <string.h>

const ty_pbrt_texture* ty_pbrt_find_texture(const ty_pbrt* reader, const char* name, bool number) {
    for (size_t i = reader->texture_count; i-- > 0;)
        if (reader->textures[i].number == number && strcmp(reader->textures[i].name, name) == 0)
            return &reader->textures[i];
    return NULL;
}

/* A texture's operand, which is a value or a texture: its colour, and in *image the texture if it is an image. */
static ty_result read_operand(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name, bool number,
                              double color[3], const ty_pbrt_texture** image) {
    char named[TY_PBRT_NAME_SIZE];
    const ty_pbrt_parameter* parameter = ty_pbrt_find(parameters, name);
    bool found;
    *image = NULL;
    if (parameter == NULL) return TY_OK;
    if (parameter->type != TY_PBRT_TEXTURE)
        return ty_pbrt_spectrum(parameters, name, TY_PBRT_REFLECTANCE, color, &found);
    ty_pbrt_string(parameters, name, named, sizeof named);
    const ty_pbrt_texture* texture = ty_pbrt_find_texture(reader, named, number);
    if (texture == NULL) texture = ty_pbrt_find_texture(reader, named, true);
    if (texture == NULL) return ty_pbrt_refuse(parameters, "the texture \"%s\" is not defined", named);
    memcpy(color, texture->color, sizeof texture->color);
    if (texture->file != NULL) *image = texture;
    return TY_OK;
}

/* The same image as another texture's. */
static ty_result share_image(ty_pbrt* reader, const ty_pbrt_texture* from, ty_pbrt_texture* out) {
    out->file = ty_copy_text(reader->context, from->file);
    out->inverted = from->inverted;
    out->linear = from->linear;
    memcpy(out->uv_map, from->uv_map, sizeof out->uv_map);
    return out->file != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result read_image(ty_pbrt* reader, const ty_pbrt_parameters* parameters, ty_pbrt_texture* out) {
    char name[1024], word[64];
    if (!ty_pbrt_string(parameters, "filename", name, sizeof name))
        return ty_pbrt_refuse(parameters, "the texture \"%s\" has no \"string filename\"", out->name);
    if (ty_pbrt_string(parameters, "mapping", word, sizeof word) && strcmp(word, "uv") != 0)
        ty_conversion_approximate(reader->conversion, "Texture: the mapping \"%s\" is taken for that of u and v", word);
    if (ty_pbrt_string(parameters, "encoding", word, sizeof word)) {
        out->linear = strcmp(word, "linear") == 0;
        if (!out->linear && strcmp(word, "sRGB") != 0)
            ty_conversion_approximate(reader->conversion, "Texture: the encoding \"%s\" is taken for sRGB", word);
    }
    if (ty_pbrt_string(parameters, "wrap", word, sizeof word) && strcmp(word, "repeat") != 0)
        ty_conversion_approximate(reader->conversion, "Texture: the wrap mode \"%s\" is taken for repetition", word);
    ty_pbrt_find(parameters, "filter");
    ty_pbrt_find(parameters, "maxanisotropy");
    out->inverted = ty_pbrt_bool(parameters, "invert", false);
    const double scale = ty_pbrt_float(parameters, "scale", 1);
    for (int c = 0; c < 3; ++c) out->color[c] = scale;
    out->uv_map[0] = ty_pbrt_float(parameters, "uscale", 1);
    out->uv_map[1] = ty_pbrt_float(parameters, "vscale", 1);
    out->uv_map[2] = ty_pbrt_float(parameters, "udelta", 0);
    out->uv_map[3] = ty_pbrt_float(parameters, "vdelta", 0);
    out->file = ty_copy_text(reader->context, name);
    return out->file != NULL ? TY_OK : TY_ERROR_MEMORY;
}

static ty_result read_scale(ty_pbrt* reader, const ty_pbrt_parameters* parameters, ty_pbrt_texture* out) {
    double a[3] = {1, 1, 1}, b[3] = {1, 1, 1};
    const ty_pbrt_texture *first = NULL, *second = NULL;
    ty_result result = read_operand(reader, parameters, "tex", out->number, a, &first);
    if (result == TY_OK) result = read_operand(reader, parameters, "scale", out->number, b, &second);
    for (int c = 0; c < 3; ++c) out->color[c] = a[c] * b[c];
    if (first != NULL && second != NULL)
        ty_conversion_leave_out(reader->conversion, "Texture \"scale\": of two images the second");
    const ty_pbrt_texture* image = first != NULL ? first : second;
    return result == TY_OK && image != NULL ? share_image(reader, image, out) : result;
}

/* A mixture of two operands; with images, the one that has the larger part. */
static ty_result read_mix(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* const names[2],
                          const double defaults[2], double amount, ty_pbrt_texture* out) {
    double colors[2][3];
    const ty_pbrt_texture* images[2] = {NULL, NULL};
    ty_result result = TY_OK;
    for (int i = 0; i < 2; ++i) {
        colors[i][0] = colors[i][1] = colors[i][2] = defaults[i];
        if (result == TY_OK) result = read_operand(reader, parameters, names[i], out->number, colors[i], &images[i]);
    }
    const int larger = amount > 0.5 ? 1 : 0;
    if (images[0] == NULL && images[1] == NULL) {
        for (int c = 0; c < 3; ++c) out->color[c] = (1 - amount) * colors[0][c] + amount * colors[1][c];
        return result;
    }
    ty_conversion_approximate(reader->conversion, "Texture \"%s\": of what it mixes, only \"%s\" is left",
                              parameters->type, names[larger]);
    memcpy(out->color, colors[larger], sizeof out->color);
    return result == TY_OK && images[larger] != NULL ? share_image(reader, images[larger], out) : result;
}

static ty_result read_value(ty_pbrt* reader, const ty_pbrt_parameters* parameters, ty_pbrt_texture* out) {
    static const char *const pair[2] = {"tex1", "tex2"}, *const dots[2] = {"outside", "inside"};
    const ty_pbrt_texture* image;
    const char* type = parameters->type;
    if (strcmp(type, "imagemap") == 0) return read_image(reader, parameters, out);
    if (strcmp(type, "constant") == 0)
        return read_operand(reader, parameters, "value", out->number, out->color, &image);
    if (strcmp(type, "scale") == 0) return read_scale(reader, parameters, out);
    if (strcmp(type, "mix") == 0) {
        double amount[3] = {0.5, 0.5, 0.5};
        const ty_result result = read_operand(reader, parameters, "amount", true, amount, &image);
        if (image != NULL) ty_conversion_leave_out(reader->conversion, "Texture \"mix\": the amount's image");
        return result == TY_OK ? read_mix(reader, parameters, pair, (const double[2]){0, 1}, amount[0], out) : result;
    }
    for (size_t i = 0; i < parameters->count; ++i) parameters->items[i].used = true;
    ty_conversion_approximate(reader->conversion, "Texture \"%s\" became its mean colour", type);
    if (strcmp(type, "checkerboard") == 0) return read_mix(reader, parameters, pair, (const double[2]){1, 0}, 0.5, out);
    if (strcmp(type, "dots") == 0) return read_mix(reader, parameters, dots, (const double[2]){0, 1}, 0.5, out);
    out->color[0] = out->color[1] = out->color[2] = 0.5;
    return TY_OK;
}

ty_result ty_pbrt_read_texture(ty_pbrt* reader, const ty_pbrt_parameters* parameters, const char* name, bool number) {
    ty_pbrt_texture texture = {.number = number, .color = {1, 1, 1}, .uv_map = {1, 1, 0, 0}};
    snprintf(texture.name, sizeof texture.name, "%s", name);
    const ty_result result = read_value(reader, parameters, &texture);
    if (result == TY_OK && ty_grow_array(reader->context, (void**)&reader->textures, &reader->texture_capacity,
                                         reader->texture_count, sizeof *reader->textures)) {
        reader->textures[reader->texture_count++] = texture;
        return TY_OK;
    }
    ty_free_text(reader->context, texture.file);
    return result != TY_OK ? result : TY_ERROR_MEMORY;
}
