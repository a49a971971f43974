/* A material of a mesh file in tyndall info, by the keys of scene files. */
#include "cli/info/info.h"

#include <stdlib.h>

/* Keys with one number, and with three; what has its default is not printed. */
typedef struct number_key {
    const char* name;
    double value, usual;
} number_key;

typedef struct color_key {
    const char* name;
    const float* value;
    double usual;
} color_key;

enum { NUMBERS = 9, COLORS = 5, TEXTURES = TY_GLOSS_TEXTURES + 2 };

typedef struct material_keys {
    number_key numbers[NUMBERS];
    color_key colors[COLORS];
    const char* textures[TEXTURES]; /* keys with a texture */
    int texture_count;
    const char* alpha; /* "mask" or "blend"; NULL: opaque */
} material_keys;

/* The number of seven digits that a float stands for. */
static double decimal(float value) {
    char text[32];
    snprintf(text, sizeof text, "%.7g", (double)value);
    return strtod(text, NULL);
}

static void add_texture(material_keys* keys, bool there, const char* name) {
    if (there) keys->textures[keys->texture_count++] = name;
}

static material_keys describe(const ty_mesh_file_entry* entry) {
    static const char* const names[TY_GLOSS_TEXTURES] = {
        [TY_GLOSS_METALLIC_ROUGHNESS] = "metallic and roughness",
        [TY_GLOSS_NORMAL] = "normal_map",
        [TY_GLOSS_SPECULAR] = "specular",
        [TY_GLOSS_SPECULAR_COLOR] = "specular_color",
        [TY_GLOSS_TRANSMISSION] = "transmission",
        [TY_GLOSS_CLEARCOAT] = "clearcoat",
        [TY_GLOSS_CLEARCOAT_ROUGHNESS] = "clearcoat_roughness",
        [TY_GLOSS_SHEEN_COLOR] = "sheen_color",
        [TY_GLOSS_SHEEN_ROUGHNESS] = "sheen_roughness",
        [TY_GLOSS_CLEARCOAT_NORMAL] = "clearcoat_normal_map",
    };
    const ty_material_def* def = &entry->material;
    const ty_gloss_def* gloss = &def->gloss;
    /* Numbers without a meaning for the material have the value that is not printed. */
    const double shown = entry->glossy ? -1 : 0;
    const bool solid = gloss->solid && gloss->transmission > 0;
    const double attenuation = solid ? decimal(gloss->attenuation_distance) : 0;
    material_keys keys = {
        .numbers = {{"metallic", decimal(gloss->metallic), shown},
                    {"roughness", entry->glossy ? decimal(gloss->roughness) : 0, shown},
                    {"ior", entry->glossy ? decimal(gloss->ior) : 1.5, 1.5},
                    {"specular", entry->glossy ? decimal(gloss->specular) : 1, 1},
                    {"transmission", decimal(gloss->transmission), 0},
                    {"clearcoat", decimal(gloss->clearcoat), 0},
                    {"clearcoat_roughness", gloss->clearcoat > 0 ? decimal(gloss->clearcoat_roughness) : 0, 0},
                    {"sheen_roughness", gloss->sheen_color[0] > 0 ? decimal(gloss->sheen_roughness) : 0, 0},
                    {"attenuation_distance", attenuation, 0}},
        .colors = {{"base_color", def->albedo, -1},
                   {"specular_color", gloss->specular_color, 1},
                   {"sheen_color", gloss->sheen_color, 0},
                   {"attenuation_color", gloss->attenuation_color, 1},
                   {"emission", def->emission, 0}},
        .alpha = def->alpha_mode == TY_ALPHA_MASK    ? "mask"
                 : def->alpha_mode == TY_ALPHA_BLEND ? "blend"
                                                     : NULL};
    add_texture(&keys, entry->base_texture, "base_color");
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) add_texture(&keys, entry->textures[i], names[i]);
    add_texture(&keys, entry->emission_texture, "emission");
    return keys;
}

static bool is_usual(const color_key* key) {
    for (int c = 0; c < 3; ++c)
        if ((double)key->value[c] != key->usual) return false;
    return true;
}

void cli_print_material(const ty_mesh_file_entry* entry) {
    const material_keys keys = describe(entry);
    const bool solid = entry->material.gloss.solid && entry->material.gloss.transmission > 0;
    printf(": %s", !entry->glossy ? "diffuse" : solid ? "solid dielectric" : "glossy");
    for (int i = 0; i < COLORS; ++i) {
        const float* value = keys.colors[i].value;
        const double color[3] = {decimal(value[0]), decimal(value[1]), decimal(value[2])};
        if (is_usual(&keys.colors[i])) continue;
        printf(", %s ", keys.colors[i].name);
        cli_print_vector("", color, "");
    }
    for (int i = 0; i < NUMBERS; ++i)
        if (keys.numbers[i].value != keys.numbers[i].usual)
            printf(", %s %.6g", keys.numbers[i].name, keys.numbers[i].value);
    if (keys.alpha != NULL) printf(", alpha %s %.6g", keys.alpha, decimal(entry->material.alpha));
    for (int i = 0; i < keys.texture_count; ++i) printf("%s%s", i == 0 ? ", textures: " : ", ", keys.textures[i]);
}

void cli_write_material(json_writer* json, const ty_mesh_file_entry* entry) {
    const material_keys keys = describe(entry);
    json_bool(json, "glossy", entry->glossy);
    for (int i = 0; i < COLORS; ++i) {
        const float* value = keys.colors[i].value;
        const double color[3] = {decimal(value[0]), decimal(value[1]), decimal(value[2])};
        if (is_usual(&keys.colors[i])) continue;
        json_numbers(json, keys.colors[i].name, color, 3);
    }
    for (int i = 0; i < NUMBERS; ++i)
        if (keys.numbers[i].value != keys.numbers[i].usual)
            json_number(json, keys.numbers[i].name, keys.numbers[i].value);
    if (entry->material.gloss.solid && entry->material.gloss.transmission > 0) json_bool(json, "solid", true);
    if (keys.alpha != NULL) json_text(json, "alpha_mode", keys.alpha);
    if (keys.alpha != NULL) json_number(json, "alpha", decimal(entry->material.alpha));
    if (entry->material.double_sided) json_bool(json, "double_sided", true);
    json_open_array(json, "textures");
    for (int i = 0; i < keys.texture_count; ++i) json_text(json, NULL, keys.textures[i]);
    json_close_array(json);
}
