/* Materials: as those of scene files that come nearest. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/context.h"
#include "io/interchange/texture_files.h"
#include "io/json_text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A material that is being made. */
typedef struct maker {
    ty_mitsuba* scene;
    int32_t node;
    ty_conversion_material material;
} maker;

static ty_result set(maker* m, const char* key, json_t* value) {
    return ty_conversion_set(m->scene->conversion, m->material.keys, key, value);
}

static ty_result set_number(maker* m, const char* key, double value) {
    return set(m, key, ty_json_number(value));
}

/* ---- textures ---- */

/* The mean of a checkerboard; grey for other textures than images. */
static ty_result mean_of_texture(maker* m, int32_t texture, double rgb[3]) {
    double colors[2][3] = {{0.4, 0.4, 0.4}, {0.2, 0.2, 0.2}};
    bool found;
    const char* type = ty_mitsuba_type(m->scene, texture);
    ty_conversion_approximate(m->scene->conversion, "texture \"%.60s\" became its mean colour", type);
    rgb[0] = rgb[1] = rgb[2] = 0.5;
    if (strcmp(type, "checkerboard") != 0) return TY_OK;
    ty_result result = ty_mitsuba_colour(m->scene, texture, "color0", false, colors[0], &found);
    if (result == TY_OK) result = ty_mitsuba_colour(m->scene, texture, "color1", false, colors[1], &found);
    for (int c = 0; c < 3; ++c) rgb[c] = 0.5 * (colors[0][c] + colors[1][c]);
    return result;
}

/* The file of an image, whose mapping becomes that of the material. */
static ty_result use_image(maker* m, int32_t texture, bool number, char** reference) {
    ty_affine map;
    char location[TY_MITSUBA_LOCATION_SIZE];
    const char* name = ty_mitsuba_string(m->scene, texture, "filename");
    if (name == NULL) return ty_mitsuba_fail(m->scene, texture, "the bitmap has no filename");
    ty_result result = ty_mitsuba_transform(m->scene, texture, "to_uv", &map);
    if (result != TY_OK) return result;
    const double uv_map[4] = {map.m[0], map.m[5], map.m[3], map.m[7]};
    const bool linear = ty_mitsuba_bool(m->scene, texture, "raw", number);
    const ty_texture_reading reading = {!number && linear, false, number ? 1 : 0};
    char* found = ty_mitsuba_file_name(m->scene, name);
    if (found == NULL) return TY_ERROR_MEMORY;
    ty_mitsuba_location(m->scene, texture, location);
    result = ty_convert_texture(m->scene->conversion, location, found, &reading, reference);
    ty_free_text(m->scene->context, found);
    if (*reference != NULL && m->material.textured && memcmp(uv_map, m->material.uv_map, sizeof uv_map) != 0)
        ty_conversion_approximate(m->scene->conversion, "a material's second texture takes the mapping of the first");
    else if (*reference != NULL)
        memcpy(m->material.uv_map, uv_map, sizeof uv_map);
    m->material.textured = m->material.textured || *reference != NULL;
    return result;
}

/* A colour or an image under a key, times a factor. */
static ty_result set_colour(maker* m, const char* name, const char* key, double otherwise, double factor) {
    double rgb[3] = {otherwise, otherwise, otherwise};
    bool found;
    char* reference = NULL;
    ty_result result = ty_mitsuba_colour(m->scene, m->node, name, false, rgb, &found);
    const int32_t texture = ty_mitsuba_child(m->scene, m->node, name);
    if (result == TY_OK && !found && texture >= 0 && ty_mitsuba_is(m->scene, texture, "texture")) {
        if (strcmp(ty_mitsuba_type(m->scene, texture), "bitmap") == 0)
            result = use_image(m, texture, false, &reference);
        else
            result = mean_of_texture(m, texture, rgb);
    }
    if (result != TY_OK) return result;
    for (int c = 0; c < 3; ++c) rgb[c] *= factor;
    if (reference == NULL) return set(m, key, ty_conversion_colour(rgb, 0, 1));
    json_t* value = json_pack("{s:s, s:o}", "file", reference, "factor", ty_json_number(fmin(factor, 1)));
    ty_free_text(m->scene->context, reference);
    return set(m, key, value);
}

/* ---- numbers ---- */

/* A number, or what stands for the texture in its place. */
static ty_result read_number(maker* m, const char* name, double* out) {
    const int32_t child = ty_mitsuba_child(m->scene, m->node, name);
    if (child >= 0 && ty_mitsuba_is(m->scene, child, "texture"))
        ty_conversion_leave_out(m->scene->conversion, "bsdf \"%.60s\": the texture of \"%s\"",
                                ty_mitsuba_type(m->scene, m->node), name);
    return ty_mitsuba_float(m->scene, m->node, name, out);
}

/* Index of refraction by name or number. */
static ty_result read_ior(maker* m, const char* name, double* out) {
    const char* value = ty_mitsuba_string(m->scene, m->node, name);
    const int32_t child = ty_mitsuba_child(m->scene, m->node, name);
    if (value != NULL && ty_mitsuba_is(m->scene, child, "string")) {
        if (ty_named_ior(value, out)) return TY_OK;
        return ty_mitsuba_fail(m->scene, child, "the material \"%.60s\" is not known", value);
    }
    return ty_mitsuba_float(m->scene, m->node, name, out);
}

/* Ours is the square root of alpha; anisotropic ones become the geometric mean. Of microfacets a part 1 - exp(-t^2 /
 * a^2) is flatter than the slope t by Beckmann's distribution, and t^2 / (a^2 + t^2) by GGX: their medians are equal if
 * the alpha of GGX is that of Beckmann times the root of ln 2. */
static ty_result set_roughness(maker* m, const char* key, bool rough) {
    double alpha = 0.1, u = -1, v = -1;
    if (!rough) return set_number(m, key, 0);
    ty_result result = read_number(m, "alpha", &alpha);
    if (result == TY_OK) result = read_number(m, "alpha_u", &u);
    if (result == TY_OK) result = read_number(m, "alpha_v", &v);
    if (u >= 0 && v >= 0 && u != v)
        ty_conversion_approximate(m->scene->conversion, "anisotropic roughness became its geometric mean");
    if (u >= 0 && v >= 0) alpha = sqrt(u * v);
    const char* distribution = ty_mitsuba_string(m->scene, m->node, "distribution");
    if (distribution == NULL || strcmp(distribution, "ggx") != 0) {
        alpha *= sqrt(log(2));
        ty_conversion_approximate(m->scene->conversion,
                                  "microfacets of Beckmann's distribution have that of GGX with the same median slope");
    }
    return result == TY_OK ? set_number(m, key, sqrt(fmin(fmax(alpha, 0), 1))) : result;
}

/* ---- materials ---- */

static ty_result make_diffuse(maker* m) {
    return set_colour(m, "reflectance", "base_color", 0.5, 1);
}

static bool is_rough(const maker* m) {
    return strncmp(ty_mitsuba_type(m->scene, m->node), "rough", 5) == 0;
}

static ty_result read_relative_ior(maker* m, double inside, double* out) {
    double outside = 1.000277;
    *out = inside;
    ty_result result = read_ior(m, "int_ior", out);
    if (result == TY_OK) result = read_ior(m, "ext_ior", &outside);
    *out /= fmax(outside, 0.1);
    return result;
}

static ty_result make_dielectric(maker* m) {
    double ior;
    ty_result result = read_relative_ior(m, 1.5046, &ior);
    if (result != TY_OK) return result;
    if (ior < 1)
        ty_conversion_approximate(m->scene->conversion, "an index of refraction below 1 became its reciprocal");
    if (ty_mitsuba_child(m->scene, m->node, "specular_reflectance") >= 0)
        ty_conversion_leave_out(m->scene->conversion, "specular_reflectance of a dielectric");
    result = set_colour(m, "specular_transmittance", "base_color", 1, 1);
    if (result == TY_OK) result = set_roughness(m, "roughness", is_rough(m));
    if (result == TY_OK) result = set_number(m, "ior", fmin(fmax(ior < 1 ? 1 / fmax(ior, 0.01) : ior, 1), 100));
    if (result == TY_OK) result = set_number(m, "transmission", 1);
    return result == TY_OK ? set(m, "volume", json_object()) : result;
}

/* Both interfaces of a sheet, with all orders: 2 F / (1 + F), by an index that has this at normal incidence. */
static ty_result make_thin_dielectric(maker* m) {
    double ior;
    ty_result result = read_relative_ior(m, 1.5046, &ior);
    if (result != TY_OK) return result;
    const double f = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1)), root = sqrt(2 * f / (1 + f));
    ty_conversion_approximate(m->scene->conversion,
                              "bsdf \"thindielectric\" became a pane that reflects alike at normal incidence");
    result = set_colour(m, "specular_transmittance", "base_color", 1, 1);
    if (result == TY_OK) result = set_number(m, "roughness", 0);
    if (result == TY_OK) result = set_number(m, "ior", fmin((1 + root) / (1 - root), 100));
    return result == TY_OK ? set_number(m, "transmission", 1) : result;
}

static ty_result make_conductor(maker* m) {
    double eta[3] = {0, 0, 0}, k[3] = {1, 1, 1}, tint[3] = {1, 1, 1}, rgb[3];
    bool has_eta, has_k, found;
    const char* name = ty_mitsuba_string(m->scene, m->node, "material");
    ty_result result = ty_mitsuba_colour(m->scene, m->node, "eta", false, eta, &has_eta);
    if (result == TY_OK) result = ty_mitsuba_colour(m->scene, m->node, "k", false, k, &has_k);
    if (result == TY_OK) result = ty_mitsuba_colour(m->scene, m->node, "specular_reflectance", false, tint, &found);
    if (result != TY_OK) return result;
    if (name == NULL && !has_eta) name = "Cu";
    const bool mirror = name != NULL && strcmp(name, "none") == 0;
    if (name != NULL && !mirror && !ty_named_metal(name, eta, k)) {
        ty_conversion_approximate(m->scene->conversion, "the metal \"%.60s\" is not known; aluminium was taken", name);
        ty_named_metal("Al", eta, k);
    }
    for (int c = 0; c < 3; ++c) rgb[c] = tint[c] * (mirror ? 1 : ty_conductor_reflectance(eta[c], k[c]));
    result = set(m, "base_color", ty_conversion_colour(rgb, 0, 1));
    if (result == TY_OK) result = set_number(m, "metallic", 1);
    return result == TY_OK ? set_roughness(m, "roughness", is_rough(m)) : result;
}

static ty_result make_plastic(maker* m) {
    double ior;
    ty_result result = read_relative_ior(m, 1.49, &ior);
    ty_conversion_approximate(m->scene->conversion, "bsdf \"plastic\" became a diffuse base below a dielectric");
    if (result == TY_OK) result = set_colour(m, "diffuse_reflectance", "base_color", 0.5, 1);
    if (result == TY_OK) result = set_roughness(m, "roughness", is_rough(m));
    return result == TY_OK ? set_number(m, "ior", fmin(fmax(ior, 1), 100)) : result;
}

static ty_result make_principled(maker* m) {
    double roughness = 0.5, metallic = 0, through = 0, coat = 0, gloss = 0, sheen = 0, specular = 0.5, ior = 0;
    const struct {
        const char* name;
        double* value;
    } numbers[] = {{"roughness", &roughness},   {"metallic", &metallic}, {"spec_trans", &through}, {"clearcoat", &coat},
                   {"clearcoat_gloss", &gloss}, {"sheen", &sheen},       {"specular", &specular},  {"eta", &ior}};
    ty_result result = set_colour(m, "base_color", "base_color", 0.5, 1);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0] && result == TY_OK; ++i)
        result = read_number(m, numbers[i].name, numbers[i].value);
    static const char* const left[] = {"anisotropic", "flatness", "spec_tint", "sheen_tint"};
    for (size_t i = 0; i < sizeof left / sizeof left[0]; ++i)
        if (ty_mitsuba_child(m->scene, m->node, left[i]) >= 0)
            ty_conversion_leave_out(m->scene->conversion, "bsdf \"principled\": \"%s\"", left[i]);
    const double root = sqrt(0.08 * fmin(fmax(specular, 0), 1)); /* F0 = 0.08 specular */
    if (result == TY_OK) result = set_number(m, "roughness", fmin(fmax(roughness, 0), 1));
    if (result == TY_OK) result = set_number(m, "metallic", fmin(fmax(metallic, 0), 1));
    if (result == TY_OK) result = set_number(m, "ior", fmin(fmax(ior >= 1 ? ior : (1 + root) / (1 - root), 1), 100));
    if (result == TY_OK && through > 0) result = set_number(m, "transmission", fmin(through, 1));
    if (result == TY_OK && through > 0 && strcmp(ty_mitsuba_type(m->scene, m->node), "principled") == 0)
        result = set(m, "volume", json_object());
    if (result == TY_OK && coat > 0) result = set_number(m, "clearcoat", fmin(coat, 1));
    if (result == TY_OK && coat > 0) result = set_number(m, "clearcoat_roughness", sqrt(0.1 + (0.001 - 0.1) * gloss));
    if (result == TY_OK && sheen > 0) result = set_number(m, "sheen_color", fmin(sheen, 1));
    return result;
}

static ty_result make_unknown(maker* m) {
    ty_conversion_approximate(m->scene->conversion, "bsdf \"%.60s\" became diffuse, with a reflectance of 0.5",
                              ty_mitsuba_type(m->scene, m->node));
    return set_number(m, "base_color", 0.5);
}

static const struct {
    const char* type;
    ty_result (*make)(maker* m);
} makers[] = {{"diffuse", make_diffuse},
              {"roughdiffuse", make_diffuse},
              {"dielectric", make_dielectric},
              {"roughdielectric", make_dielectric},
              {"thindielectric", make_thin_dielectric},
              {"conductor", make_conductor},
              {"roughconductor", make_conductor},
              {"plastic", make_plastic},
              {"roughplastic", make_plastic},
              {"principled", make_principled},
              {"principledthin", make_principled}};

/* ---- wrappers ---- */

/* The material within twosided, mask, bumpmap, normalmap and the like; -1 for none. */
static ty_result unwrap(ty_mitsuba* scene, int32_t* node) {
    for (int depth = 0; depth < TY_MITSUBA_DEPTH_MAX; ++depth) {
        const char* type = ty_mitsuba_type(scene, *node);
        if (strcmp(type, "null") == 0) {
            *node = -1;
            return TY_OK;
        }
        if (strcmp(type, "twosided") != 0 && strcmp(type, "mask") != 0 && strcmp(type, "bumpmap") != 0 &&
            strcmp(type, "normalmap") != 0 && strcmp(type, "blendbsdf") != 0 && strcmp(type, "coating") != 0)
            return TY_OK;
        if (strcmp(type, "twosided") != 0)
            ty_conversion_approximate(scene->conversion, "bsdf \"%s\": what it wraps is taken as it is", type);
        const int32_t inner = ty_mitsuba_child_of_tag(scene, *node, "bsdf");
        if (inner < 0) return ty_mitsuba_fail(scene, *node, "the bsdf \"%s\" wraps none", type);
        *node = inner;
    }
    return ty_mitsuba_fail(scene, *node, "bsdfs are nested too deep");
}

ty_result ty_mitsuba_bsdf(ty_mitsuba* scene, int32_t node, int32_t* index) {
    *index = -1;
    ty_result result = unwrap(scene, &node);
    if (result != TY_OK || node < 0) return result;
    for (size_t i = 0; i + 1 < scene->bsdf_count; i += 2)
        if (scene->bsdfs[i] == node) {
            *index = scene->bsdfs[i + 1];
            return TY_OK;
        }
    maker m = {scene, node, {.keys = json_object(), .medium = -1}};
    if (m.material.keys == NULL) return ty_conversion_no_memory(scene->conversion);
    size_t i = 0;
    while (i < sizeof makers / sizeof makers[0] && strcmp(makers[i].type, ty_mitsuba_type(scene, node)) != 0) ++i;
    result = i < sizeof makers / sizeof makers[0] ? makers[i].make(&m) : make_unknown(&m);
    if (result != TY_OK) {
        json_decref(m.material.keys);
        return result;
    }
    result = ty_conversion_add_material(scene->conversion, &m.material, index);
    const int32_t pair[2] = {node, *index};
    for (int k = 0; k < 2 && result == TY_OK; ++k) {
        if (!ty_grow_array(scene->context, (void**)&scene->bsdfs, &scene->bsdf_capacity, scene->bsdf_count,
                           sizeof *scene->bsdfs))
            return TY_ERROR_MEMORY;
        scene->bsdfs[scene->bsdf_count++] = pair[k];
    }
    return result;
}
