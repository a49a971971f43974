/* OBJ material files (.mtl): the keys of Phong's model and those for roughness and metal, and maps. */
#include "base/context.h"
#include "io/images/image_file.h"
#include "io/meshes/obj.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { NAME_SIZE = 1024 };

/* Models of illumination by their numbers in "illum". */
enum {
    ILLUM_COLOR = 0,
    ILLUM_DIFFUSE = 1,
    ILLUM_MIRROR = 3,
    ILLUM_MIRROR_FRESNEL = 5,
    ILLUM_REFRACTION = 6,
    ILLUM_REFRACTION_FRESNEL = 7,
    ILLUM_MAX = 10
};

#define IMAGE_SIZE_MAX ((size_t)1 << 32)

/* Keys of a material that depend on one another, whatever their order. */
typedef struct mtl {
    bool has_specular, has_shininess, has_roughness, has_metallic; /* Ks, Ns, Pr, Pm */
    float specular[3], filter[3];                                  /* Ks, Tf */
    float exponent;                                                /* Ns */
    float dissolve, transparency;                                  /* d and Tr; below 0: not given */
    float illum;                                                   /* -1: not given */
} mtl;

typedef struct library {
    ty_context* context;
    const char* path;
    const char* folder;
    ty_model* model;
    size_t line;
    size_t ignored; /* maps and options of maps without effect */
    mtl keys;       /* of the last material */
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

/* A number within low..high, into which others are clamped. */
static ty_result read_number(const library* lib, ty_words* line, double low, double high, float* out) {
    double value = 0;
    if (!ty_next_number(line, &value) || !isfinite(value)) return fail(lib, "a number is damaged");
    *out = (float)fmin(fmax(value, low), high);
    return TY_OK;
}

/* ---- maps ---- */

/* Reads up to three numbers of an option. */
static void read_vector(ty_words* line, double out[3]) {
    for (int i = 0; i < 3 && ty_next_number(line, &out[i]); ++i) continue;
}

/* Map of texture coordinates by the options -s (scale) and -o (offset). v points up in the file and down here. */
static void set_map(const double scale[3], const double offset[3], float map[6]) {
    const double rows[6] = {scale[0], 0, offset[0], 0, scale[1], 1 - scale[1] - offset[1]};
    for (int i = 0; i < 6; ++i) map[i] = (float)fmin(fmax(rows[i], -1e6), 1e6);
}

/* Reads "-option value ..." before the file name; strength: that of -bm. */
static void read_options(library* lib, ty_words* line, ty_model_texture* texture, float map[6], float* strength) {
    double scale[3] = {1, 1, 1}, offset[3] = {0, 0, 0}, number[3];
    ty_words ahead = *line;
    ty_word word, value;
    while (ty_next_word(&ahead, &word) && word.length > 1 && word.text[0] == '-') {
        if (ty_word_is(word, "-s")) {
            read_vector(&ahead, scale);
        } else if (ty_word_is(word, "-o")) {
            read_vector(&ahead, offset);
        } else if (ty_word_is(word, "-bm")) {
            if (ty_next_number(&ahead, &number[0])) *strength = (float)fmin(fmax(number[0], -1e3), 1e3);
        } else if (ty_word_is(word, "-clamp")) {
            if (ty_next_word(&ahead, &value) && ty_word_is(value, "on"))
                texture->wrap[0] = texture->wrap[1] = TY_WRAP_CLAMP;
        } else {
            ++lib->ignored;
            if (ty_word_is(word, "-t"))
                read_vector(&ahead, number);
            else if (ty_word_is(word, "-mm"))
                for (int i = 0; i < 2 && ty_next_number(&ahead, &number[0]); ++i) continue;
            else
                ty_next_word(&ahead, &value);
        }
        *line = ahead;
    }
    set_map(scale, offset, map);
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

/* A texture, its map of coordinates, and (unless NULL) a factor by -bm. linear: numbers, not colours. */
static ty_result read_map(library* lib, ty_words* line, bool linear, int32_t* out, float map[6], float* strength) {
    ty_model_texture texture = {.linear = linear};
    float unused = 1;
    read_options(lib, line, &texture, map, strength != NULL ? strength : &unused);
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

static ty_result read_gloss_map(library* lib, ty_words* line, ty_gloss_texture number, ty_model_material* material,
                                float* strength) {
    const bool color = number == TY_GLOSS_SPECULAR_COLOR || number == TY_GLOSS_SHEEN_COLOR;
    float* map = material->def.gloss.textures[number].map;
    return read_map(lib, line, !color, &material->gloss_textures[number], map, strength);
}

/* A map of one number, which ty_obj_join_maps puts where it belongs. */
static ty_result read_single(library* lib, ty_words* line, ty_single_map number, ty_model_material* material) {
    float own[6];
    float* map = number == TY_SINGLE_OPACITY ? own : material->def.gloss.textures[TY_GLOSS_METALLIC_ROUGHNESS].map;
    if (number == TY_SINGLE_BUMP) map = material->def.gloss.textures[TY_GLOSS_NORMAL].map;
    float* strength = number == TY_SINGLE_BUMP ? &material->def.gloss.normal_scale : NULL;
    return read_map(lib, line, true, &material->single_textures[number], map, strength);
}

/* Reads a map; *known stays false if the key is none. */
static ty_result read_map_key(library* lib, ty_word key, ty_words* line, ty_model_material* material, bool* known) {
    static const char* const left_out[] = {"map_Ns", "map_Tr", "map_Pc", "map_Pcr", "disp", "decal", "refl", "aniso"};
    static const char* const bumps[] = {"bump", "map_bump", "map_Bump"};
    static const struct {
        const char* key;
        ty_single_map number;
    } singles[] = {{"map_d", TY_SINGLE_OPACITY}, {"map_Pr", TY_SINGLE_ROUGHNESS}, {"map_Pm", TY_SINGLE_METALLIC}};
    ty_material_def* def = &material->def;
    *known = true;
    if (ty_word_is(key, "map_Kd")) return read_map(lib, line, false, &material->albedo_texture, def->albedo_map, NULL);
    if (ty_word_is(key, "map_Ke"))
        return read_map(lib, line, false, &material->emission_texture, def->emission_map, NULL);
    if (ty_word_is(key, "map_Ks")) return read_gloss_map(lib, line, TY_GLOSS_SPECULAR_COLOR, material, NULL);
    if (ty_word_is(key, "map_Ps")) return read_gloss_map(lib, line, TY_GLOSS_SHEEN_COLOR, material, NULL);
    if (ty_word_is(key, "norm")) return read_gloss_map(lib, line, TY_GLOSS_NORMAL, material, &def->gloss.normal_scale);
    for (size_t i = 0; i < sizeof singles / sizeof *singles; ++i)
        if (ty_word_is(key, singles[i].key)) return read_single(lib, line, singles[i].number, material);
    for (size_t i = 0; i < sizeof bumps / sizeof *bumps; ++i)
        if (ty_word_is(key, bumps[i])) return read_single(lib, line, TY_SINGLE_BUMP, material);
    for (size_t i = 0; i < sizeof left_out / sizeof *left_out; ++i)
        if (ty_word_is(key, left_out[i])) {
            ++lib->ignored;
            return TY_OK;
        }
    *known = false;
    return TY_OK;
}

/* ---- materials ---- */

/* A map replaces a black color, which many writers leave beside a map. */
static void whiten(float color[3]) {
    if (color[0] > 0 || color[1] > 0 || color[2] > 0) return;
    for (int c = 0; c < 3; ++c) color[c] = 1;
}

/* Opacity: "d", or 1 - Tr. Tr of 1 is opaque, as writers have it for whom 1 - Tr is the transparency. */
static float opacity_of(const mtl* keys) {
    if (keys->dissolve >= 0) return keys->dissolve;
    return keys->transparency > 0 && keys->transparency < 1 ? 1 - keys->transparency : 1;
}

/* "illum" 6 and 7 refract: a solid dielectric of index Ni that "Tf" tints. Phong's lobe is not that of its surface. */
static void make_glass(const mtl* keys, ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    memcpy(material->def.albedo, keys->filter, sizeof keys->filter);
    material->albedo_texture = material->single_textures[TY_SINGLE_OPACITY] = -1;
    gloss->specular = gloss->transmission = 1;
    gloss->solid = true;
    if (!keys->has_roughness) gloss->roughness = 0;
}

/* Roughness of "Ns n": the exponent of Phong's lobe, which is about as wide as that of microfacets of
 * alpha = sqrt(2 / (n + 2)) (Walter et al. 2007, section 5). Ks of 0.5 is the reflection of a dielectric of ior 1.5,
 * as writers of such files have it; under "illum" 3 and 5, of mirrors, it is the reflectance. */
static void make_opaque(const mtl* keys, ty_model_material* material) {
    ty_gloss_def* gloss = &material->def.gloss;
    const bool physical = keys->has_roughness || keys->has_metallic ||
                          material->single_textures[TY_SINGLE_ROUGHNESS] >= 0 ||
                          material->single_textures[TY_SINGLE_METALLIC] >= 0;
    const bool mirror = keys->illum == ILLUM_MIRROR || keys->illum == ILLUM_MIRROR_FRESNEL;
    const bool dull = !physical && (keys->illum == ILLUM_COLOR || keys->illum == ILLUM_DIFFUSE);
    const float largest = fmaxf(keys->specular[0], fmaxf(keys->specular[1], keys->specular[2]));
    /* Many writers have an index of 1 for all materials. */
    if (!(gloss->ior > 1)) gloss->ior = ty_default_material_def().gloss.ior;
    const float f0 = (gloss->ior - 1) / (gloss->ior + 1) * ((gloss->ior - 1) / (gloss->ior + 1));
    if (!keys->has_roughness && keys->has_shininess) gloss->roughness = sqrtf(sqrtf(2.0f / (keys->exponent + 2.0f)));
    if (keys->has_specular) {
        const float factor = mirror && !physical ? 1 / f0 : 2;
        for (int c = 0; c < 3; ++c) gloss->specular_color[c] = fminf(keys->specular[c] * factor, 1e3f);
        gloss->specular = largest > 0 ? 1 : 0;
    } else if (physical) {
        gloss->specular = 1;
    }
    if (material->gloss_textures[TY_GLOSS_SPECULAR_COLOR] >= 0) {
        gloss->specular = 1;
        whiten(gloss->specular_color);
    }
    if (dull) gloss->specular = 0;
}

static void finish_material(library* lib, size_t first) {
    if (lib->model->material_count == first) return;
    ty_model_material* material = &lib->model->materials[lib->model->material_count - 1];
    ty_material_def* def = &material->def;
    const mtl* keys = &lib->keys;
    if (material->albedo_texture >= 0) whiten(def->albedo);
    if (material->emission_texture >= 0) whiten(def->emission);
    if (material->gloss_textures[TY_GLOSS_SHEEN_COLOR] >= 0) whiten(def->gloss.sheen_color);
    if (material->single_textures[TY_SINGLE_METALLIC] >= 0 && !(def->gloss.metallic > 0)) def->gloss.metallic = 1;
    if (keys->illum == ILLUM_REFRACTION || keys->illum == ILLUM_REFRACTION_FRESNEL) {
        make_glass(keys, material);
        return;
    }
    make_opaque(keys, material);
    def->alpha = opacity_of(keys);
    def->alpha_mode = def->alpha < 1 ? TY_ALPHA_BLEND : TY_ALPHA_OPAQUE;
}

static ty_result begin_material(library* lib, ty_words* line) {
    const ty_word name = ty_rest_of_line(line);
    ty_model_material material = ty_model_plain_material(ty_default_material_def().albedo[0]);
    lib->keys = (mtl){.filter = {1, 1, 1}, .dissolve = -1, .transparency = -1, .illum = -1};
    char* copy = ty_alloc_array(lib->context, name.length + 1, 1, true);
    if (copy == NULL) return TY_ERROR_MEMORY;
    memcpy(copy, name.text, name.length);
    material.name = memchr(copy, '\0', name.length) == NULL ? copy : NULL;
    if (material.name != NULL) return ty_model_add_material(lib->model, &material);
    ty_free_array(lib->context, copy, name.length + 1, 1);
    return fail(lib, "the name of a material is damaged");
}

/* "Ps n": white sheen of that strength, of a medium roughness. */
static ty_result read_sheen(const library* lib, ty_words* line, ty_gloss_def* gloss) {
    const ty_result result = read_number(lib, line, 0, 1, &gloss->sheen_color[0]);
    gloss->sheen_color[1] = gloss->sheen_color[2] = gloss->sheen_color[0];
    gloss->sheen_roughness = 0.5f;
    return result;
}

/* A key with one number; *known stays false if it is none. */
static ty_result read_number_key(library* lib, ty_word key, ty_words* line, ty_gloss_def* gloss, bool* known) {
    mtl* keys = &lib->keys;
    bool unused = false;
    const struct {
        const char* key;
        double low, high;
        float* value;
        bool* given;
    } numbers[] = {{"d", 0, 1, &keys->dissolve, &unused},
                   {"Tr", 0, 1, &keys->transparency, &unused},
                   {"illum", 0, ILLUM_MAX, &keys->illum, &unused},
                   {"Ns", 0, 1e9, &keys->exponent, &keys->has_shininess},
                   {"Ni", 1, 100, &gloss->ior, &unused},
                   {"Pr", 0, 1, &gloss->roughness, &keys->has_roughness},
                   {"Pm", 0, 1, &gloss->metallic, &keys->has_metallic},
                   {"Pc", 0, 1, &gloss->clearcoat, &unused},
                   {"Pcr", 0, 1, &gloss->clearcoat_roughness, &unused}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        if (ty_word_is(key, numbers[i].key)) {
            *known = *numbers[i].given = true;
            return read_number(lib, line, numbers[i].low, numbers[i].high, numbers[i].value);
        }
    return TY_OK;
}

static ty_result read_key(library* lib, ty_word key, ty_words* line, ty_model_material* material) {
    ty_material_def* def = &material->def;
    bool known = false;
    ty_result result = read_number_key(lib, key, line, &def->gloss, &known);
    if (result == TY_OK && !known) result = read_map_key(lib, key, line, material, &known);
    if (result != TY_OK || known) return result;
    if (ty_word_is(key, "Kd")) return read_color(lib, line, 1, def->albedo);
    if (ty_word_is(key, "Ke")) return read_color(lib, line, 1e15, def->emission);
    if (ty_word_is(key, "Tf")) return read_color(lib, line, 1, lib->keys.filter);
    if (ty_word_is(key, "Ps")) return read_sheen(lib, line, &def->gloss);
    if (!ty_word_is(key, "Ks")) return TY_OK;
    lib->keys.has_specular = true;
    return read_color(lib, line, 1, lib->keys.specular);
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
        if (ty_word_is(key, "newmtl")) {
            finish_material(&lib, before);
            result = begin_material(&lib, &line);
        } else if (model->material_count > before) {
            result = read_key(&lib, key, &line, &model->materials[model->material_count - 1]);
        }
    }
    if (result == TY_OK) finish_material(&lib, before);
    if (lib.ignored > 0) ty_log(context, TY_LOG_WARNING, "%s: some maps and options of maps have no effect", path);
    return result;
}
