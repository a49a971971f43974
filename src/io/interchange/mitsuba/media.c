/* Participating media and their volumes. */
#include "io/interchange/mitsuba/mitsuba.h"

#include "base/context.h"
#include "io/json_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A medium that is being read. */
typedef struct maker {
    ty_mitsuba* scene;
    int32_t node;
    ty_conversion_medium medium;
    double scale;
} maker;

/* Sets g, or another phase function. */
static ty_result set_phase(maker* m, json_t* entry) {
    const int32_t phase = ty_mitsuba_child_of_tag(m->scene, m->node, "phase");
    const char* type = phase < 0 ? "isotropic" : ty_mitsuba_type(m->scene, phase);
    double g = 0;
    if (strcmp(type, "hg") == 0) {
        const ty_result result = ty_mitsuba_float(m->scene, phase, "g", &g);
        if (result != TY_OK) return result;
    } else if (strcmp(type, "rayleigh") == 0) {
        return ty_conversion_set(m->scene->conversion, entry, "phase", json_pack("{s:s}", "type", "rayleigh"));
    } else if (strcmp(type, "isotropic") != 0) {
        ty_conversion_approximate(m->scene->conversion, "the phase function \"%.60s\" became isotropic", type);
    }
    return ty_conversion_set(m->scene->conversion, entry, "g", ty_json_number(fmin(fmax(g, -0.9999), 0.9999)));
}

/* Adds an entry, which is taken over. */
static ty_result add_entry(maker* m, json_t* entry) {
    const ty_result result = set_phase(m, entry);
    const bool named = json_object_set_new(entry, "name", json_string(m->medium.name)) == 0;
    return json_array_append_new(m->medium.entries, entry) == 0 && named
               ? result
               : ty_conversion_no_memory(m->scene->conversion);
}

/* A colour of the medium itself, or of a volume that is constant. */
static ty_result read_constant(maker* m, const char* name, double rgb[3], bool* found) {
    const int32_t child = ty_mitsuba_child(m->scene, m->node, name);
    if (child >= 0 && ty_mitsuba_is(m->scene, child, "volume") &&
        strcmp(ty_mitsuba_type(m->scene, child), "constvolume") == 0)
        return ty_mitsuba_colour(m->scene, child, "value", false, rgb, found);
    return ty_mitsuba_colour(m->scene, m->node, name, false, rgb, found);
}

/* sigma_t and albedo, or sigma_s and sigma_a. */
static ty_result read_homogeneous(maker* m) {
    double t[3] = {1, 1, 1}, albedo[3] = {0.75, 0.75, 0.75}, s[3] = {0, 0, 0}, a[3] = {0, 0, 0};
    bool has[4] = {false, false, false, false};
    ty_result result = read_constant(m, "sigma_t", t, &has[0]);
    if (result == TY_OK) result = read_constant(m, "albedo", albedo, &has[1]);
    if (result == TY_OK) result = read_constant(m, "sigma_s", s, &has[2]);
    if (result == TY_OK) result = read_constant(m, "sigma_a", a, &has[3]);
    if (result != TY_OK) return result;
    const char* preset = ty_mitsuba_string(m->scene, m->node, "material");
    ty_medium_def def = ty_default_medium_def();
    if (preset != NULL && ty_medium_preset(preset, &def)) {
        for (int c = 0; c < 3; ++c) { /* the same measurements, in 1/mm */
            s[c] = (double)def.sigma_s[c] / 1000;
            a[c] = (double)def.sigma_a[c] / 1000;
        }
        has[2] = true;
    } else if (preset != NULL) {
        ty_conversion_approximate(m->scene->conversion, "the medium \"%.60s\" is not known", preset);
    }
    for (int c = 0; c < 3 && !has[2] && !has[3]; ++c) {
        s[c] = t[c] * albedo[c];
        a[c] = t[c] - s[c];
    }
    for (int c = 0; c < 3; ++c) {
        s[c] *= m->scale;
        a[c] *= m->scale;
    }
    return add_entry(m, json_pack("{s:o, s:o}", "sigma_s", ty_conversion_colour(s, 0, 1e9), "sigma_a",
                                  ty_conversion_colour(a, 0, 1e9)));
}

/* ---- volumes ---- */

/* A grid from a file, and the place of its voxels. */
typedef struct volume {
    int32_t components;
    ty_grid* grids[3];
    double box[2][3]; /* in the space that to_world maps */
    ty_affine to_world;
} volume;

static void release(volume* v) {
    for (int c = 0; c < 3; ++c) ty_grid_release(v->grids[c]);
}

static ty_result read_grids(maker* m, const char* path, volume* out) {
    ty_context* context = m->scene->context;
    ty_volume_def def = ty_default_volume_def();
    ty_result result = ty_volume_components(context, path, &def, &out->components);
    if (result == TY_OK && out->components != 1 && out->components != 3)
        return ty_fail(context, TY_ERROR_INPUT, "%s: %d values a voxel, where 1 or 3 can be taken", path,
                       (int)out->components);
    for (int32_t c = 0; c < out->components && result == TY_OK; ++c) {
        def.component = c;
        result = ty_volume_read(context, path, &def, &out->grids[c]);
    }
    return result;
}

/* The volume of a gridvolume; components are 0, with a note, if its file is missing. */
static ty_result read_volume(maker* m, int32_t node, volume* out) {
    static const double unit[2][3] = {{0, 0, 0}, {1, 1, 1}};
    char location[TY_MITSUBA_LOCATION_SIZE];
    char *path = NULL, *reference = NULL;
    const char* name = ty_mitsuba_string(m->scene, node, "filename");
    if (name == NULL) return ty_mitsuba_fail(m->scene, node, "the volume has no filename");
    ty_result result = ty_mitsuba_transform(m->scene, node, "to_world", &out->to_world);
    char* found = ty_mitsuba_file_name(m->scene, name);
    if (found == NULL) return TY_ERROR_MEMORY;
    ty_mitsuba_location(m->scene, node, location);
    if (result == TY_OK) result = ty_conversion_find_file(m->scene->conversion, location, found, &path, &reference);
    if (result == TY_OK && path != NULL) result = read_grids(m, path, out);
    if (result == TY_OK && out->components > 0) {
        const ty_grid_info info = ty_grid_get_info(out->grids[0]);
        memcpy(out->box, unit, sizeof unit);
        for (int a = 0; a < 3 && ty_mitsuba_bool(m->scene, node, "use_grid_bbox", false); ++a) {
            const double* row = info.index_to_local.m + 4 * a;
            out->box[0][a] = row[3] - 0.5 * row[a];
            out->box[1][a] = row[3] + (info.size[a] - 0.5) * row[a];
        }
    }
    ty_free_text(m->scene->context, found);
    ty_free_text(m->scene->context, path);
    ty_free_text(m->scene->context, reference);
    return result;
}

/* The values of a grid with one more voxel on each side, equal to its neighbour: within the box they are clamped, as
 * Mitsuba has it; freed with ty_free_array. */
static float* pad(ty_context* context, const ty_grid* grid, int32_t size[3], size_t* count) {
    const ty_grid_info info = ty_grid_get_info(grid);
    for (int a = 0; a < 3; ++a) size[a] = info.size[a] + 2;
    *count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    float* values = ty_alloc_array(context, *count, sizeof *values, false);
    size_t at = 0;
    for (int32_t k = 0; k < size[2] && values != NULL; ++k)
        for (int32_t j = 0; j < size[1]; ++j)
            for (int32_t i = 0; i < size[0]; ++i) {
                const int32_t index[3] = {i, j, k};
                int32_t inner[3];
                for (int a = 0; a < 3; ++a) {
                    const int32_t last = info.size[a] - 1, own = index[a] - 1;
                    inner[a] = own < 0 ? 0 : own > last ? last : own;
                }
                values[at++] = ty_grid_voxel(grid, inner[0], inner[1], inner[2]);
            }
    return values;
}

/* Writes components [first, first + count) of a volume and refers to it under a key of the entry. */
static ty_result set_volume(maker* m, json_t* entry, const char* key, const volume* v, int first, int count) {
    ty_context* context = m->scene->context;
    float* planes[3] = {NULL, NULL, NULL};
    size_t voxels[3] = {0, 0, 0};
    int32_t size[3] = {1, 1, 1};
    double box[2][3];
    char* reference = NULL;
    ty_result result = TY_OK;
    for (int c = 0; c < count && result == TY_OK; ++c) {
        planes[c] = pad(context, v->grids[first + c], size, &voxels[c]);
        if (planes[c] == NULL) result = TY_ERROR_MEMORY;
    }
    for (int a = 0; a < 3; ++a) {
        const double step = (v->box[1][a] - v->box[0][a]) / (size[a] > 2 ? size[a] - 2 : 1);
        box[0][a] = v->box[0][a] - step;
        box[1][a] = v->box[1][a] + step;
    }
    const float* const values[3] = {planes[0], planes[1], planes[2]};
    if (result == TY_OK)
        result = ty_conversion_write_volume(m->scene->conversion, key, size, values, count, (const double(*)[3])box,
                                            &reference);
    for (int c = 0; c < count; ++c) ty_free_array(context, planes[c], voxels[c], sizeof(float));
    if (result != TY_OK) return result;
    json_t* value = json_pack("{s:s, s:s}", "file", reference != NULL ? reference : "", "grid", key);
    ty_free_text(context, reference);
    return ty_conversion_set(m->scene->conversion, entry, key, value);
}

/* One entry, or one for each channel of an extinction that has three: coefficients of overlapping media add up. */
static ty_result add_heterogeneous(maker* m, const volume* density, const volume* albedo, const double constant[3]) {
    ty_result result = TY_OK;
    const int entries = density->components;
    for (int e = 0; e < entries && result == TY_OK; ++e) {
        double sigma_t[3] = {m->scale, m->scale, m->scale};
        for (int c = 0; c < 3 && entries == 3; ++c) sigma_t[c] = c == e ? m->scale : 0;
        json_t* entry = json_pack("{s:o}", "sigma_t", ty_conversion_colour(sigma_t, 0, 1e9));
        result = set_volume(m, entry, "density", density, e, 1);
        if (result == TY_OK && albedo->components == 0)
            result = ty_conversion_set(m->scene->conversion, entry, "albedo", ty_conversion_colour(constant, 0, 1));
        else if (result == TY_OK && (entries == 1 || albedo->components == 1))
            result = set_volume(m, entry, "albedo", albedo, 0, albedo->components);
        else if (result == TY_OK)
            result = set_volume(m, entry, "albedo", albedo, e, 1);
        if (result == TY_OK)
            result = add_entry(m, entry);
        else
            json_decref(entry);
    }
    memcpy(m->medium.box, density->box, sizeof density->box);
    m->medium.transform = density->to_world;
    m->medium.grid = m->medium.clipped = true;
    return result;
}

static bool is_grid(const ty_mitsuba* scene, int32_t node) {
    return node >= 0 && ty_mitsuba_is(scene, node, "volume") && strcmp(ty_mitsuba_type(scene, node), "gridvolume") == 0;
}

static ty_result read_heterogeneous(maker* m) {
    int32_t extinction = ty_mitsuba_child(m->scene, m->node, "sigma_t");
    if (extinction < 0) extinction = ty_mitsuba_child(m->scene, m->node, "density");
    const int32_t scattered = ty_mitsuba_child(m->scene, m->node, "albedo");
    double constant[3] = {0.75, 0.75, 0.75};
    bool found;
    if (ty_mitsuba_child(m->scene, m->node, "emission") >= 0)
        ty_conversion_leave_out(m->scene->conversion, "emission of the medium \"%s\"", m->medium.name);
    if (!is_grid(m->scene, extinction)) {
        if (extinction >= 0 && ty_mitsuba_is(m->scene, extinction, "volume") &&
            strcmp(ty_mitsuba_type(m->scene, extinction), "constvolume") != 0) {
            ty_conversion_leave_out(m->scene->conversion, "medium \"%s\", as its volume is a \"%.60s\"", m->medium.name,
                                    ty_mitsuba_type(m->scene, extinction));
            return TY_OK;
        }
        if (is_grid(m->scene, scattered))
            ty_conversion_leave_out(m->scene->conversion, "medium \"%s\": the grid of its albedo", m->medium.name);
        /* A constant volume fills the unit cube as its to_world maps it. */
        static const double unit[2][3] = {{0, 0, 0}, {1, 1, 1}};
        memcpy(m->medium.box, unit, sizeof unit);
        m->medium.grid = m->medium.clipped = true;
        const ty_result result =
            extinction >= 0 ? ty_mitsuba_transform(m->scene, extinction, "to_world", &m->medium.transform) : TY_OK;
        return result == TY_OK ? read_homogeneous(m) : result;
    }
    volume density = {0}, albedo = {0};
    ty_result result = read_constant(m, "albedo", constant, &found);
    if (result == TY_OK) result = read_volume(m, extinction, &density);
    if (result == TY_OK && is_grid(m->scene, scattered)) result = read_volume(m, scattered, &albedo);
    if (result == TY_OK && albedo.components > 0 &&
        memcmp(albedo.to_world.m, density.to_world.m, sizeof albedo.to_world.m) != 0)
        ty_conversion_approximate(m->scene->conversion, "medium \"%s\": the albedo takes the place of the extinction",
                                  m->medium.name);
    if (result == TY_OK) result = add_heterogeneous(m, &density, &albedo, constant);
    release(&density);
    release(&albedo);
    return result;
}

ty_result ty_mitsuba_medium(ty_mitsuba* scene, int32_t node, int32_t* index) {
    const char *type = ty_mitsuba_type(scene, node), *id = ty_mitsuba_attribute(scene, node, "id");
    *index = -1;
    for (size_t i = 0; i + 1 < scene->medium_count; i += 2)
        if (scene->media[i] == node) {
            *index = scene->media[i + 1];
            return TY_OK;
        }
    maker m = {.scene = scene, .node = node, .medium = {.transform = ty_affine_identity()}, .scale = 1};
    m.medium.name = ty_copy_text(scene->context, id != NULL ? id : "medium");
    m.medium.entries = json_array();
    ty_result result =
        m.medium.name == NULL || m.medium.entries == NULL ? ty_conversion_no_memory(scene->conversion) : TY_OK;
    for (char* at = m.medium.name; result == TY_OK && *at != '\0'; ++at)
        if (*at < ' ' || *at > '~') *at = '?';
    if (result == TY_OK) result = ty_mitsuba_float(scene, node, "scale", &m.scale);
    if (result == TY_OK && strcmp(type, "homogeneous") == 0)
        result = read_homogeneous(&m);
    else if (result == TY_OK && strcmp(type, "heterogeneous") == 0)
        result = read_heterogeneous(&m);
    else if (result == TY_OK)
        ty_conversion_leave_out(scene->conversion, "the medium \"%.60s\"", type);
    if (result != TY_OK) {
        ty_free_text(scene->context, m.medium.name);
        json_decref(m.medium.entries);
        return result;
    }
    result = ty_conversion_add_medium(scene->conversion, &m.medium, index);
    const int32_t pair[2] = {node, *index};
    for (int k = 0; k < 2 && result == TY_OK; ++k) {
        if (!ty_grow_array(scene->context, (void**)&scene->media, &scene->medium_capacity, scene->medium_count,
                           sizeof *scene->media))
            return TY_ERROR_MEMORY;
        scene->media[scene->medium_count++] = pair[k];
    }
    return result;
}
