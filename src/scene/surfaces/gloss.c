#include "scene/surfaces/gloss.h"

#include "scene/bsdf/tables.h"
#include "base/check.h"
#include "scene/surfaces/surface_gloss.k.h"
#include "scene/surfaces/texture.h"

#include <math.h>
#include <stdio.h>

enum { FIELD_SIZE = 96 };

ty_texture_use ty_default_texture_use(void) {
    return (ty_texture_use){.map = {1, 0, 0, 0, 1, 0}};
}

ty_gloss_def ty_default_gloss(void) {
    ty_gloss_def def = {.roughness = 1,
                        .ior = 1.5f,
                        .specular_color = {1, 1, 1},
                        .normal_scale = 1,
                        .clearcoat_normal_scale = 1,
                        .attenuation_color = {1, 1, 1}};
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) def.textures[i] = ty_default_texture_use();
    return def;
}

ty_result ty_texture_use_check(ty_context* context, const char* prefix, const ty_texture_use* use) {
    char field[2 * FIELD_SIZE];
    snprintf(field, sizeof field, "%s.uv", prefix);
    ty_result result = ty_check_number(context, field, use->uv, 0, 1);
    for (int i = 0; i < 6 && result == TY_OK; ++i) {
        snprintf(field, sizeof field, "%s.map[%d]", prefix, i);
        result = ty_check_number(context, field, (double)use->map[i], -1e9, 1e9);
    }
    return result;
}

ty_result ty_gloss_check(ty_context* context, const char* prefix, const ty_gloss_def* def) {
    const struct {
        const char* name;
        float value;
        double low, high;
    } numbers[] = {{"metallic", def->metallic, 0, 1},
                   {"roughness", def->roughness, 0, 1},
                   {"specular", def->specular, 0, 1},
                   {"transmission", def->transmission, 0, 1},
                   {"clearcoat", def->clearcoat, 0, 1},
                   {"clearcoat_roughness", def->clearcoat_roughness, 0, 1},
                   {"sheen_roughness", def->sheen_roughness, 0, 1},
                   {"normal_scale", def->normal_scale, -1e3, 1e3},
                   {"clearcoat_normal_scale", def->clearcoat_normal_scale, -1e3, 1e3},
                   {"priority", (float)def->priority, -1000, 1000},
                   {"attenuation_distance", def->attenuation_distance, 0, 1e15}};
    char field[FIELD_SIZE];
    ty_result result = TY_OK;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers && result == TY_OK; ++i) {
        snprintf(field, sizeof field, "%s.%s", prefix, numbers[i].name);
        result = ty_check_number(context, field, (double)numbers[i].value, numbers[i].low, numbers[i].high);
    }
    snprintf(field, sizeof field, "%s.ior", prefix);
    if (result == TY_OK && def->ior != 0) result = ty_check_number(context, field, (double)def->ior, 1, 100);
    snprintf(field, sizeof field, "%s.specular_color", prefix);
    if (result == TY_OK) result = ty_check_rgb(context, field, def->specular_color, 0, 1e3);
    snprintf(field, sizeof field, "%s.sheen_color", prefix);
    if (result == TY_OK) result = ty_check_rgb(context, field, def->sheen_color, 0, 1);
    snprintf(field, sizeof field, "%s.attenuation_color", prefix);
    if (result == TY_OK) result = ty_check_rgb(context, field, def->attenuation_color, 0, 1);
    for (int i = 0; i < TY_GLOSS_TEXTURES && result == TY_OK; ++i) {
        snprintf(field, sizeof field, "%s.textures[%d]", prefix, i);
        result = ty_texture_use_check(context, field, &def->textures[i]);
    }
    return result;
}

bool ty_gloss_exists(const ty_gloss_def* def) {
    return def->metallic > 0 || def->specular > 0 || def->transmission > 0 || def->clearcoat > 0 ||
           def->sheen_color[0] > 0 || def->sheen_color[1] > 0 || def->sheen_color[2] > 0 ||
           def->textures[TY_GLOSS_NORMAL].texture != NULL;
}

bool ty_gloss_is_solid(const ty_gloss_def* def) {
    const bool metal = def->metallic >= 1 && def->textures[TY_GLOSS_METALLIC_ROUGHNESS].texture == NULL;
    return def->solid && def->transmission > 0 && !metal && def->ior >= 1;
}

/* The absorption coefficient is -ln(color) / distance (KHR_materials_volume). */
static ty_dielectric view_dielectric(const ty_gloss_def* def) {
    ty_dielectric dielectric = {
        .solid = ty_gloss_is_solid(def), .priority = def->priority, .ior = def->ior, .roughness = def->roughness};
    for (int c = 0; c < 3 && def->attenuation_distance > 0; ++c)
        dielectric.sigma_a[c] = -logf(fmaxf(def->attenuation_color[c], 1e-6f)) / def->attenuation_distance;
    return dielectric;
}

void ty_gloss_retain(const ty_gloss_def* def) {
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) ty_texture_retain(def->textures[i].texture);
}

void ty_gloss_release(const ty_gloss_def* def) {
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) ty_texture_release(def->textures[i].texture);
}

ty_surface_gloss ty_gloss_get_view(const ty_gloss_def* def) {
    ty_surface_gloss gloss = {.tables = &ty_bsdf_default_tables,
                              .factor = {.metallic = def->metallic,
                                         .roughness = def->roughness,
                                         .ior = def->ior,
                                         .specular = def->specular,
                                         .transmission = def->transmission,
                                         .clearcoat = def->clearcoat,
                                         .clearcoat_roughness = def->clearcoat_roughness,
                                         .sheen_roughness = def->sheen_roughness},
                              .dielectric = view_dielectric(def),
                              .normal_scale = {def->normal_scale, def->clearcoat_normal_scale}};
    memcpy(gloss.factor.specular_color, def->specular_color, sizeof def->specular_color);
    memcpy(gloss.factor.sheen_color, def->sheen_color, sizeof def->sheen_color);
    for (int i = 0; i < TY_GLOSS_TEXTURES; ++i) {
        gloss.textures[i] = ty_texture_get_view(def->textures[i].texture);
        gloss.uv[i] = def->textures[i].uv;
        memcpy(gloss.map[i], def->textures[i].map, sizeof gloss.map[i]);
        gloss.textured = gloss.textured || def->textures[i].texture != NULL;
    }
    return gloss;
}
