/* OBJ material files (.mtl): diffuse, specular and emitted color, opacity, roughness and metal, and maps. */
#include "base/context.h"
#include "io/images/image_file.h"
#include "io/meshes/obj.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { NAME_SIZE = 1024 };

#define IMAGE_SIZE_MAX ((size_t)1 << 32)

typedef struct library {
    ty_context* context;
    const char* path;
    const char* folder;
    ty_model* model;
    size_t line;
    size_t ignored; /* ignored opacity maps and map options */
} library;

static ty_result fail(const library* lib, const char* text) {
    return ty_fail(lib->context, TY_ERROR_INPUT, "%s:%zu: %s", lib->path, lib->line, text);
}

/* Reads "Kd r g b", or "Kd r" for gray, within 0..high. */
static ty_result read_color(const library* lib, ty_words* line, double high, float out[3]) {
    double rgb[3] = {0, 0, 0};
    int count = 0;
    while (count < 3 && ty_next_number(line, &rgb[count])) ++count;
    if (count != 1 && count != 3) return fail(lib, "a colour is not three numbers");
    for (int c = 0; c < 3; ++c) {
        const double value = count == 1 ? rgb[0] : rgb[c];
        if (!isfinite(value)) return fail(lib, "a colour is not finite");
        out[c] = (float)fmin(fmax(value, 0), high);
    }
    return TY_OK;
}

/* Reads "d a". Tr is ignored: writers disagree on whether 1 is transparent or opaque. */
static ty_result read_opacity(const library* lib, ty_words* line, ty_material_def* def) {
    double value = 0;
    if (!ty_next_number(line, &value) || !isfinite(value)) return fail(lib, "the opacity is not a number");
    def->alpha = (float)fmin(fmax(value, 0), 1);
    def->alpha_mode = def->alpha < 1 ? TY_ALPHA_BLEND : TY_ALPHA_OPAQUE;
    return TY_OK;
}

/* ---- maps ---- */

/* Skips "-option value ..." before the file name. Only -clamp is supported. */
static void read_options(library* lib, ty_words* line, ty_model_texture* texture) {
    static const char* const three[] = {"-o", "-s", "-t"};
    ty_words ahead = *line;
    ty_word word, value;
    while (ty_next_word(&ahead, &word) && word.length > 1 && word.text[0] == '-') {
        double number;
        bool vector = false;
        for (size_t i = 0; i < sizeof three / sizeof *three; ++i) vector = vector || ty_word_is(word, three[i]);
        const bool clamp = ty_word_is(word, "-clamp");
        if (vector)
            for (int i = 0; i < 3 && ty_next_number(&ahead, &number); ++i) continue;
        else if (ty_word_is(word, "-mm"))
            for (int i = 0; i < 2 && ty_next_number(&ahead, &number); ++i) continue;
        else if (ty_next_word(&ahead, &value) && clamp && ty_word_is(value, "on"))
            texture->wrap[0] = texture->wrap[1] = TY_WRAP_CLAMP;
        if (!clamp) ++lib->ignored;
        *line = ahead;
    }
}

/* Index of the model's image for a file, shared between materials. */
static ty_result use_image(library* lib, const char* name, int32_t* out) {
    char place[512], *path = NULL;
    snprintf(place, sizeof place, "%s:%zu", lib->path, lib->line);
    ty_result result = ty_model_inner_path(lib->context, place, lib->folder, name, &path);
    if (result != TY_OK) return result;
    for (size_t i = 0; i < lib->model->image_count; ++i)
        if (strcmp(lib->model->images[i].name, path) == 0) {
            ty_free_text(lib->context, path);
            *out = (int32_t)i;
            return TY_OK;
        }
    ty_model_image image = {.name = path};
    result = ty_model_read_reference(lib->context, place, path, IMAGE_SIZE_MAX, ty_inspect_image, &image.encoded,
                                     &image.encoded_size);
    if (result != TY_OK) {
        ty_free_text(lib->context, path);
        return result;
    }
    *out = (int32_t)lib->model->image_count;
    return ty_model_add_image(lib->model, &image);
}

static ty_result read_map(library* lib, ty_words* line, bool linear, int32_t* out) {
    ty_model_texture texture = {.linear = linear};
    read_options(lib, line, &texture);
    const ty_word rest = ty_rest_of_line(line);
    char name[NAME_SIZE];
    if (rest.length == 0 || rest.length >= sizeof name) return fail(lib, "the name of a map is damaged");
    for (size_t i = 0; i < rest.length; ++i) name[i] = rest.text[i] == '\\' ? '/' : rest.text[i];
    name[rest.length] = '\0';
    ty_result result = use_image(lib, name, &texture.image);
    if (result == TY_OK) result = ty_model_add_texture(lib->model, &texture);
    if (result == TY_OK) *out = (int32_t)lib->model->texture_count - 1;
    return result;
}

/* ---- materials ---- */

static ty_result begin_material(library* lib, ty_words* line) {
    const ty_word name = ty_rest_of_line(line);
    ty_model_material material = ty_model_plain_material(ty_default_material_def().albedo[0]);
    char* copy = ty_alloc_array(lib->context, name.length + 1, 1, true);
    if (copy == NULL) return TY_ERROR_MEMORY;
    memcpy(copy, name.text, name.length);
    material.name = memchr(copy, '\0', name.length) == NULL ? copy : NULL;
    if (material.name != NULL) return ty_model_add_material(lib->model, &material);
    ty_free_array(lib->context, copy, name.length + 1, 1);
    return fail(lib, "the name of a material is damaged");
}

/* A map replaces a black color, which many writers leave beside a map. */
static void whiten(float color[3]) {
    if (color[0] > 0 || color[1] > 0 || color[2] > 0) return;
    for (int c = 0; c < 3; ++c) color[c] = 1;
}

/* A number within low..high, into which others are clamped. */
static ty_result read_number(const library* lib, ty_words* line, double low, double high, float* out) {
    double value = 0;
    if (!ty_next_number(line, &value) || !isfinite(value)) return fail(lib, "a number is damaged");
    *out = (float)fmin(fmax(value, low), high);
    return TY_OK;
}

/* "Ns n": the exponent of Phong's lobe, which is about as wide as that of microfacets of alpha = sqrt(2 / (n + 2))
 * (Walter et al. 2007, section 5). "Pr" takes precedence. */
static ty_result read_shininess(const library* lib, ty_words* line, ty_model_material* material) {
    float exponent = 0;
    const ty_result result = read_number(lib, line, 0, 1e9, &exponent);
    if (!material->has_roughness) material->def.gloss.roughness = sqrtf(sqrtf(2.0f / (exponent + 2.0f)));
    return result;
}

/* "Ks r g b": 0.5 is the reflection of a dielectric of ior 1.5, as writers of such files have it. */
static ty_result read_specular(const library* lib, ty_words* line, ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    const ty_result result = read_color(lib, line, 1, gloss->specular_color);
    const float largest = fmaxf(gloss->specular_color[0], fmaxf(gloss->specular_color[1], gloss->specular_color[2]));
    gloss->specular = largest > 0 ? 1 : 0;
    for (int c = 0; c < 3; ++c) gloss->specular_color[c] *= 2;
    material->has_specular = true;
    return result;
}

/* Keys of a material that is not diffuse. */
static ty_result read_gloss_key(library* lib, ty_word key, ty_words* line, ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    if (ty_word_is(key, "Ks")) return read_specular(lib, line, material);
    if (ty_word_is(key, "Ns")) return read_shininess(lib, line, material);
    if (ty_word_is(key, "Ni")) return read_number(lib, line, 1, 100, &gloss->ior);
    if (ty_word_is(key, "Pm")) return read_number(lib, line, 0, 1, &gloss->metallic);
    if (ty_word_is(key, "Pc")) return read_number(lib, line, 0, 1, &gloss->clearcoat);
    if (ty_word_is(key, "Pcr")) return read_number(lib, line, 0, 1, &gloss->clearcoat_roughness);
    if (ty_word_is(key, "norm")) return read_map(lib, line, true, &material->gloss_textures[TY_GLOSS_NORMAL]);
    if (!ty_word_is(key, "Pr")) return TY_OK;
    material->has_roughness = true;
    if (!material->has_specular) gloss->specular = 1;
    return read_number(lib, line, 0, 1, &gloss->roughness);
}

static ty_result read_key(library* lib, ty_word key, ty_words* line, ty_model_material* material) {
    ty_material_def* def = &material->def;
    if (ty_word_is(key, "Kd")) return read_color(lib, line, 1, def->albedo);
    if (ty_word_is(key, "Ke")) return read_color(lib, line, 1e15, def->emission);
    if (ty_word_is(key, "d")) return read_opacity(lib, line, def);
    if (ty_word_is(key, "map_Kd")) return read_map(lib, line, false, &material->albedo_texture);
    if (ty_word_is(key, "map_Ke")) return read_map(lib, line, false, &material->emission_texture);
    if (ty_word_is(key, "map_d")) ++lib->ignored;
    return read_gloss_key(lib, key, line, material);
}

ty_result ty_read_mtl(ty_context* context, const char* path, const char* folder, const char* text, size_t size,
                      ty_model* model) {
    library lib = {.context = context, .path = path, .folder = folder, .model = model};
    const size_t before = model->material_count;
    ty_words all = {text, text + size}, line;
    ty_result result = TY_OK;
    for (size_t line_count = 0; result == TY_OK;) {
        lib.line = line_count + 1;
        ty_word key;
        if (!ty_next_line(&all, &line, &line_count)) break;
        if (!ty_next_word(&line, &key)) continue;
        if (ty_word_is(key, "newmtl"))
            result = begin_material(&lib, &line);
        else if (model->material_count > before)
            result = read_key(&lib, key, &line, &model->materials[model->material_count - 1]);
    }
    for (size_t i = before; i < model->material_count; ++i) {
        if (model->materials[i].albedo_texture >= 0) whiten(model->materials[i].def.albedo);
        if (model->materials[i].emission_texture >= 0) whiten(model->materials[i].def.emission);
    }
    if (lib.ignored > 0) ty_log(context, TY_LOG_WARNING, "%s: opacity maps and options of maps are ignored", path);
    return result;
}
