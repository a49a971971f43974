/* Materials: as those of scene files that come nearest. */
#include "base/context.h"
#include "io/file.h"
#include "io/interchange/pbrt/pbrt.h"
#include "io/interchange/texture_files.h"
#include "io/json_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A material that is being made. */
typedef struct maker {
    ty_pbrt* reader;
    const ty_pbrt_parameters* parameters;
    ty_conversion_material material;
} maker;

static ty_result set(maker* m, const char* key, json_t* value) {
    return ty_conversion_set(m->reader->conversion, m->material.keys, key, value);
}

static ty_result set_number(maker* m, const char* key, double value) {
    return set(m, key, ty_json_number(value));
}

/* ---- textures ---- */

/* The texture that a parameter names; *out is NULL if it is none. */
static ty_result find_texture(maker* m, const char* name, bool number, const ty_pbrt_texture** out) {
    char named[TY_PBRT_NAME_SIZE];
    const ty_pbrt_parameter* parameter = ty_pbrt_find(m->parameters, name);
    *out = NULL;
    if (parameter == NULL || parameter->type != TY_PBRT_TEXTURE) return TY_OK;
    ty_pbrt_string(m->parameters, name, named, sizeof named);
    *out = ty_pbrt_find_texture(m->reader, named, number);
    if (*out == NULL) *out = ty_pbrt_find_texture(m->reader, named, !number);
    return *out != NULL ? TY_OK : ty_pbrt_refuse(m->parameters, "the texture \"%s\" is not defined", named);
}

/* All textures of a material share the mapping of the first one. */
static void share_mapping(maker* m, const double uv_map[4]) {
    if (m->material.textured && memcmp(m->material.uv_map, uv_map, sizeof m->material.uv_map) != 0)
        ty_conversion_approximate(m->reader->conversion, "a material's second texture takes the mapping of the first");
    if (!m->material.textured) memcpy(m->material.uv_map, uv_map, sizeof m->material.uv_map);
    m->material.textured = true;
}

static ty_result use_image(maker* m, const ty_pbrt_texture* texture, double exponent, char** reference) {
    char location[512];
    ty_pbrt_location(m->reader, m->parameters->file, m->parameters->line, location, sizeof location);
    const ty_texture_reading reading = {texture->linear, texture->inverted, exponent};
    const ty_result result = ty_convert_texture(m->reader->conversion, location, texture->file, &reading, reference);
    if (*reference != NULL) share_mapping(m, texture->uv_map);
    return result;
}

/* A colour or a texture under a key; colors is its default. */
static ty_result set_colour(maker* m, const char* name, const char* key, const double otherwise[3]) {
    double rgb[3] = {otherwise[0], otherwise[1], otherwise[2]};
    const ty_pbrt_texture* texture;
    bool found;
    char* reference = NULL;
    ty_result result = find_texture(m, name, false, &texture);
    if (result != TY_OK) return result;
    if (texture == NULL) {
        result = ty_pbrt_spectrum(m->parameters, name, TY_PBRT_REFLECTANCE, rgb, &found);
        return result == TY_OK ? set(m, key, ty_conversion_colour(rgb, 0, 1)) : result;
    }
    if (texture->file != NULL) result = use_image(m, texture, 0, &reference);
    if (result != TY_OK) return result;
    json_t* value = reference == NULL ? ty_conversion_colour(texture->color, 0, 1)
                                      : json_pack("{s:s, s:o}", "file", reference, "factor",
                                                  ty_conversion_colour(texture->color, 0, 1));
    ty_free_text(m->reader->context, reference);
    return set(m, key, value);
}

/* A number, or the mean colour of a constant texture. */
static ty_result read_number(maker* m, const char* name, double otherwise, double* out) {
    const ty_pbrt_texture* texture;
    *out = ty_pbrt_float(m->parameters, name, otherwise);
    const ty_result result = find_texture(m, name, true, &texture);
    if (texture == NULL) return result;
    if (texture->file != NULL)
        ty_conversion_leave_out(m->reader->conversion, "material \"%s\": the image of \"%s\"", m->parameters->type,
                                name);
    *out = texture->file != NULL ? otherwise : texture->color[0];
    return TY_OK;
}

/* ---- roughness ---- */

/* Ours is the square root of alpha; pbrt's alpha is its roughness, or its square root with remaproughness. */
static double roughness_from(double roughness, bool remapped) {
    return pow(fmin(fmax(roughness, 0), 1), remapped ? 0.25 : 0.5);
}

/* Roughness under a key, by the parameters `prefix`roughness, uroughness and vroughness. */
static ty_result set_roughness(maker* m, const char* prefix, const char* key) {
    char names[3][64];
    static const char* const parts[3] = {"roughness", "uroughness", "vroughness"};
    double values[3];
    const ty_pbrt_texture* texture;
    const bool remapped = ty_pbrt_bool(m->parameters, "remaproughness", true);
    for (int i = 0; i < 3; ++i) snprintf(names[i], sizeof names[i], "%s%s", prefix, parts[i]);
    ty_result result = find_texture(m, names[0], true, &texture);
    if (result == TY_OK && texture != NULL && texture->file != NULL && prefix[0] == '\0') {
        char* reference = NULL;
        result = use_image(m, texture, remapped ? 0.25 : 0.5, &reference);
        if (result != TY_OK || reference == NULL) return result;
        const double factor = roughness_from(texture->color[0], remapped);
        json_t* value = json_pack("{s:s, s:o}", "file", reference, "factor", ty_json_number(factor));
        ty_free_text(m->reader->context, reference);
        return set(m, key, value);
    }
    if (result == TY_OK) result = read_number(m, names[0], 0, &values[0]);
    for (int i = 1; i < 3 && result == TY_OK; ++i) result = read_number(m, names[i], values[0], &values[i]);
    if (result != TY_OK) return result;
    if (fabs(values[1] - values[2]) > 1e-6)
        ty_conversion_approximate(m->reader->conversion,
                                  "material \"%s\": anisotropic roughness became its geometric mean",
                                  m->parameters->type);
    return set_number(m, key, sqrt(roughness_from(values[1], remapped) * roughness_from(values[2], remapped)));
}

/* ---- materials ---- */

static const double half[3] = {0.5, 0.5, 0.5};

static ty_result read_ior(maker* m, const char* name, double* out) {
    double values[3] = {1.5, 1.5, 1.5};
    bool found;
    const ty_result result = ty_pbrt_spectrum_at(m->parameters, name, values, &found);
    *out = values[1];
    if (result == TY_OK && fabs(values[0] - values[2]) > 1e-3)
        ty_conversion_leave_out(m->reader->conversion, "material \"%s\": dispersion", m->parameters->type);
    return result;
}

static ty_result make_coated_diffuse(maker* m) {
    double ior, unused;
    ty_result result = set_colour(m, "reflectance", "base_color", half);
    if (result == TY_OK) result = set_roughness(m, "", "roughness");
    if (result == TY_OK) result = read_ior(m, "eta", &ior);
    if (result == TY_OK) result = set_number(m, "ior", fmax(ior, 1));
    if (result == TY_OK) result = read_number(m, "thickness", 0.01, &unused);
    ty_pbrt_find(m->parameters, "maxdepth");
    ty_pbrt_find(m->parameters, "nsamples");
    ty_conversion_approximate(m->reader->conversion,
                              "material \"coateddiffuse\" became a diffuse base below a dielectric");
    return result;
}

/* base_color by `prefix`eta and k, or reflectance. */
static ty_result set_metal(maker* m, const char* prefix) {
    char eta_name[64], k_name[64];
    double eta[3], k[3], rgb[3];
    bool found;
    const ty_pbrt_parameter* reflectance = ty_pbrt_find(m->parameters, "reflectance");
    if (reflectance != NULL) return set_colour(m, "reflectance", "base_color", half);
    snprintf(eta_name, sizeof eta_name, "%seta", prefix);
    snprintf(k_name, sizeof k_name, "%sk", prefix);
    ty_named_metal("Cu", eta, k);
    ty_result result = ty_pbrt_spectrum_at(m->parameters, eta_name, eta, &found);
    if (result == TY_OK) result = ty_pbrt_spectrum_at(m->parameters, k_name, k, &found);
    for (int c = 0; c < 3; ++c) rgb[c] = ty_conductor_reflectance(eta[c], k[c]);
    return result == TY_OK ? set(m, "base_color", ty_conversion_colour(rgb, 0, 1)) : result;
}

static ty_result make_conductor(maker* m) {
    ty_result result = set_metal(m, "");
    if (result == TY_OK) result = set_number(m, "metallic", 1);
    return result == TY_OK ? set_roughness(m, "", "roughness") : result;
}

static ty_result make_coated_conductor(maker* m) {
    double ior, unused;
    ty_result result = set_metal(m, "conductor.");
    if (result == TY_OK) result = set_number(m, "metallic", 1);
    if (result == TY_OK) result = set_roughness(m, "conductor.", "roughness");
    if (result == TY_OK) result = set_number(m, "clearcoat", 1);
    if (result == TY_OK) result = set_roughness(m, "interface.", "clearcoat_roughness");
    if (result == TY_OK) result = read_ior(m, "interface.eta", &ior);
    if (result == TY_OK) result = read_number(m, "thickness", 0.01, &unused);
    ty_conversion_approximate(m->reader->conversion, "material \"coatedconductor\" became metal below a clear coat");
    return result;
}

static ty_result make_dielectric(maker* m) {
    double ior;
    ty_result result = read_ior(m, "eta", &ior);
    if (result == TY_OK && ior < 1)
        ty_conversion_approximate(m->reader->conversion,
                                  "material \"dielectric\": an index of refraction below 1 became its reciprocal");
    if (result == TY_OK) result = set_number(m, "base_color", 1);
    if (result == TY_OK) result = set_roughness(m, "", "roughness");
    if (result == TY_OK) result = set_number(m, "ior", fmax(ior < 1 ? 1 / fmax(ior, 0.01) : ior, 1));
    if (result == TY_OK) result = set_number(m, "transmission", 1);
    return result == TY_OK ? set(m, "volume", json_object()) : result;
}

/* Of the two interfaces of a sheet, with all orders: 2 F / (1 + F), by an index that has this at normal incidence. */
static ty_result make_thin_dielectric(maker* m) {
    double ior;
    ty_result result = read_ior(m, "eta", &ior);
    if (result != TY_OK) return result;
    const double f = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1)), root = sqrt(2 * f / (1 + f));
    ty_conversion_approximate(m->reader->conversion,
                              "material \"thindielectric\" became a pane that reflects alike at normal incidence");
    result = set_number(m, "base_color", 1);
    if (result == TY_OK) result = set_number(m, "roughness", 0);
    if (result == TY_OK) result = set_number(m, "ior", fmin((1 + root) / (1 - root), 100));
    return result == TY_OK ? set_number(m, "transmission", 1) : result;
}

static ty_result make_diffuse_transmission(maker* m) {
    double colors[2][3] = {{0.25, 0.25, 0.25}, {0.25, 0.25, 0.25}}, sum[3], all = 0, through = 0;
    static const char* const names[2] = {"reflectance", "transmittance"};
    const double scale = ty_pbrt_float(m->parameters, "scale", 1);
    ty_result result = TY_OK;
    for (int i = 0; i < 2 && result == TY_OK; ++i) {
        const ty_pbrt_texture* texture;
        bool found;
        result = find_texture(m, names[i], false, &texture);
        if (texture != NULL && texture->file == NULL) memcpy(colors[i], texture->color, sizeof colors[i]);
        if (texture != NULL && texture->file != NULL)
            ty_conversion_leave_out(m->reader->conversion, "material \"diffusetransmission\": the image of \"%s\"",
                                    names[i]);
        if (result == TY_OK && texture == NULL)
            result = ty_pbrt_spectrum(m->parameters, names[i], TY_PBRT_REFLECTANCE, colors[i], &found);
    }
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) {
        sum[c] = scale * (colors[0][c] + colors[1][c]);
        all += sum[c];
        through += scale * colors[1][c];
    }
    ty_conversion_approximate(m->reader->conversion, "material \"diffusetransmission\" became a rough thin wall");
    result = set(m, "base_color", ty_conversion_colour(sum, 0, 1));
    if (result == TY_OK) result = set_number(m, "roughness", 1);
    if (result == TY_OK) result = set_number(m, "ior", 1);
    return result == TY_OK ? set_number(m, "transmission", all > 0 ? fmin(through / all, 1) : 0) : result;
}

/* Albedo for which a half space has a diffuse reflectance (Chiang, Kutz and Burley 2016). */
static double albedo_of_reflectance(double a) {
    return 1 - exp(-5.09406 * a + 2.61188 * a * a - 4.31805 * a * a * a);
}

/* Coefficients of a subsurface material, 1/m of its lengths, which count as metres. */
static ty_result read_subsurface(maker* m, double sigma_a[3], double sigma_s[3]) {
    char name[TY_PBRT_NAME_SIZE];
    double reflectance[3], mfp[3] = {1, 1, 1};
    bool found, ignored;
    ty_result result = ty_pbrt_spectrum(m->parameters, "reflectance", TY_PBRT_REFLECTANCE, reflectance, &found);
    if (result == TY_OK && found) {
        result = ty_pbrt_spectrum(m->parameters, "mfp", TY_PBRT_REFLECTANCE, mfp, &ignored);
        for (int c = 0; c < 3; ++c) {
            const double sigma_t = 1 / fmax(mfp[c], 1e-9);
            sigma_s[c] = sigma_t * albedo_of_reflectance(fmin(reflectance[c], 1));
            sigma_a[c] = sigma_t - sigma_s[c];
        }
    } else if (result == TY_OK && ty_pbrt_string(m->parameters, "name", name, sizeof name)) {
        ty_medium_def medium = ty_default_medium_def();
        if (!ty_medium_preset(name, &medium))
            return ty_pbrt_refuse(m->parameters, "the medium \"%s\" is not known", name);
        for (int c = 0; c < 3; ++c) {
            sigma_a[c] = (double)medium.sigma_a[c] / 1000;
            sigma_s[c] = (double)medium.sigma_s[c] / 1000;
        }
    } else if (result == TY_OK) {
        result = ty_pbrt_spectrum(m->parameters, "sigma_a", TY_PBRT_REFLECTANCE, sigma_a, &ignored);
        if (result == TY_OK)
            result = ty_pbrt_spectrum(m->parameters, "sigma_s", TY_PBRT_REFLECTANCE, sigma_s, &ignored);
    }
    const double scale = ty_pbrt_float(m->parameters, "scale", 1);
    for (int c = 0; c < 3; ++c) {
        sigma_a[c] *= scale;
        sigma_s[c] *= scale;
    }
    return result;
}

/* A dielectric that its medium fills, in place of a BSSRDF. */
static ty_result make_subsurface(maker* m) {
    double sigma_a[3] = {0.0011, 0.0024, 0.014}, sigma_s[3] = {2.55, 3.21, 3.77};
    ty_conversion_medium medium = {.inside = true, .transform = ty_affine_identity()};
    ty_result result = read_subsurface(m, sigma_a, sigma_s);
    if (result != TY_OK) return result;
    ty_conversion_approximate(m->reader->conversion, "material \"subsurface\" became a dielectric that a medium fills");
    medium.name = ty_copy_text(m->reader->context, "subsurface");
    medium.entries = json_pack("[{s:s, s:o, s:o, s:o}]", "name", "subsurface", "sigma_s",
                               ty_conversion_colour(sigma_s, 0, 1e9), "sigma_a", ty_conversion_colour(sigma_a, 0, 1e9),
                               "g", ty_json_number(fmin(fmax(ty_pbrt_float(m->parameters, "g", 0), -0.999), 0.999)));
    result = ty_conversion_add_medium(m->reader->conversion, &medium, &m->material.medium);
    if (result == TY_OK && (medium.name == NULL || medium.entries == NULL))
        result = ty_conversion_no_memory(m->reader->conversion);
    return result == TY_OK ? make_dielectric(m) : result;
}

static ty_result make_unknown(maker* m) {
    ty_conversion_approximate(m->reader->conversion, "material \"%s\" became diffuse, with a reflectance of 0.5",
                              m->parameters->type);
    for (size_t i = 0; i < m->parameters->count; ++i) m->parameters->items[i].used = true;
    return set(m, "base_color", ty_json_number(0.5));
}

static ty_result make_diffuse(maker* m) {
    return set_colour(m, "reflectance", "base_color", half);
}

static const struct {
    const char* type;
    ty_result (*make)(maker* m);
} makers[] = {{"diffuse", make_diffuse},
              {"coateddiffuse", make_coated_diffuse},
              {"conductor", make_conductor},
              {"coatedconductor", make_coated_conductor},
              {"dielectric", make_dielectric},
              {"thindielectric", make_thin_dielectric},
              {"diffusetransmission", make_diffuse_transmission},
              {"subsurface", make_subsurface},
              {"hair", make_unknown},
              {"measured", make_unknown}};

/* A mixture is the material of its larger part. */
static ty_result choose_of_mix(ty_pbrt* reader, const ty_pbrt_parameters* parameters, int32_t* index) {
    const ty_pbrt_parameter* names = ty_pbrt_find(parameters, "materials");
    char name[TY_PBRT_NAME_SIZE];
    if (names == NULL || names->string_count != 2)
        return ty_pbrt_refuse(parameters, "material \"mix\" has no two \"string materials\"");
    const ty_pbrt_token* chosen = &names->strings[ty_pbrt_float(parameters, "amount", 0.5) > 0.5 ? 1 : 0];
    snprintf(name, sizeof name, "%.*s", (int)chosen->length, chosen->text);
    ty_conversion_approximate(reader->conversion, "material \"mix\" became one of its two materials");
    *index = -1;
    for (size_t i = reader->material_count; i-- > 0;) {
        if (strcmp(reader->materials[i].name, name) != 0) continue;
        *index = reader->materials[i].index;
        return TY_OK;
    }
    return strcmp(name, "interface") == 0 ? TY_OK
                                          : ty_pbrt_refuse(parameters, "the material \"%s\" is not defined", name);
}

/* Maps of normals, which all materials take, and displacement, which none does. */
static ty_result set_common(maker* m) {
    char name[1024];
    ty_result result = TY_OK;
    if (ty_pbrt_find(m->parameters, "displacement") != NULL)
        ty_conversion_leave_out(m->reader->conversion, "displacement of a material");
    if (ty_pbrt_string(m->parameters, "normalmap", name, sizeof name)) {
        static const double plain[4] = {1, 1, 0, 0};
        char location[512];
        char* reference = NULL;
        ty_pbrt_location(m->reader, m->parameters->file, m->parameters->line, location, sizeof location);
        const ty_texture_reading reading = {false, false, 0};
        result = ty_convert_texture(m->reader->conversion, location, name, &reading, &reference);
        if (result != TY_OK || reference == NULL) return result;
        if (!m->material.textured) share_mapping(m, plain);
        json_t* value = json_pack("{s:s}", "file", reference);
        ty_free_text(m->reader->context, reference);
        result = set(m, "normal_map", value);
    }
    return result;
}

ty_result ty_pbrt_material(ty_pbrt* reader, const ty_pbrt_parameters* parameters, int32_t* index) {
    const char* type = parameters->type;
    *index = -1;
    if (strcmp(type, "interface") == 0 || type[0] == '\0' || strcmp(type, "none") == 0) return TY_OK;
    if (strcmp(type, "mix") == 0) return choose_of_mix(reader, parameters, index);
    maker m = {reader, parameters, {.keys = json_object(), .medium = -1}};
    ty_result result = m.material.keys == NULL ? ty_conversion_no_memory(reader->conversion) : TY_OK;
    size_t i = 0;
    while (i < sizeof makers / sizeof makers[0] && strcmp(makers[i].type, type) != 0) ++i;
    if (i == sizeof makers / sizeof makers[0])
        result = ty_pbrt_refuse(parameters, "the material \"%s\" is not known", type);
    if (result == TY_OK) result = makers[i].make(&m);
    if (result == TY_OK) result = set_common(&m);
    if (result == TY_OK) return ty_conversion_add_material(reader->conversion, &m.material, index);
    json_decref(m.material.keys);
    return result;
}
