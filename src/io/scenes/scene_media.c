/* Media of a scene file. */
#include "io/scenes/scene_reader.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define NOISE_VOXELS_MAX 2147483648.0

/* ---- density ---- */

static ty_result read_noise(ty_scene_reader* reader, const json_t* noise, const ty_json_path* path, ty_grid** out) {
    ty_noise_def def = ty_default_noise_def();
    const char* kind = json_string_value(json_object_get(noise, "kind"));
    if (kind != NULL)
        def.kind = strcmp(kind, "constant") == 0 ? TY_NOISE_CONSTANT
                   : strcmp(kind, "fbm") == 0    ? TY_NOISE_FBM
                   : strcmp(kind, "nebula") == 0 ? TY_NOISE_NEBULA
                                                 : TY_NOISE_CLOUD;
    double size[3] = {def.size[0], def.size[1], def.size[2]};
    ty_read_numbers(noise, "resolution", size);
    if (size[0] * size[1] * size[2] > NOISE_VOXELS_MAX) {
        const ty_json_path json_path = ty_json_path_key(path, "resolution");
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "more than 2^31 voxels in all");
    }
    for (int a = 0; a < 3; ++a) def.size[a] = (int32_t)size[a];
    double seed = def.seed;
    ty_read_number(noise, "seed", &seed);
    def.seed = (uint32_t)seed;
    def.up_axis = reader->up_axis;
    ty_read_float(noise, "frequency", &def.frequency);
    ty_read_int(noise, "octaves", &def.octaves);
    ty_read_float(noise, "gain", &def.gain);
    ty_read_float(noise, "lacunarity", &def.lacunarity);
    ty_read_float(noise, "coverage", &def.coverage);
    ty_read_float(noise, "sharpness", &def.sharpness);
    return ty_make_noise(reader, path, &def, out);
}

/* Density over the heights of the bounds, which are a box; lengths of the file times factor. */
static ty_result read_exponential(ty_scene_reader* reader, const json_t* exponential, const ty_json_path* path,
                                  double factor, ty_medium_def* def) {
    const int up = reader->up_axis;
    double base = def->box_min[up] / factor, scale_height = 1;
    ty_read_number(exponential, "base", &base);
    ty_read_number(exponential, "scale_height", &scale_height);
    const ty_exponential_density shape = {.low = def->box_min[up] - base * factor,
                                          .high = def->box_max[up] - base * factor,
                                          .scale_height = scale_height * factor};
    return ty_make_exponential(reader, path, &shape, &def->density_grid);
}

/* Droplets scatter as those of their mean diameter, unless the medium says otherwise. */
static void scatter_as_droplets(const json_t* medium, double radius, ty_medium_def* def) {
    static const char* const keys[] = {"g", "phase", "preset"};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i)
        if (json_object_get(medium, keys[i]) != NULL) return;
    if (!(radius > 0)) return;
    const double diameter = fmin(fmax(2 * radius, TY_PHASE_DIAMETER_MIN), TY_PHASE_DIAMETER_MAX);
    def->phase_count = 1;
    def->phase[0] = (ty_phase_lobe){.kind = TY_PHASE_MIE, .weight = {1, 1, 1}, .diameter = diameter};
}

/* Sets scale or density_grid. Lengths are in `unit` meters. */
static ty_result read_density(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, double unit,
                              ty_medium_def* def) {
    double scale = 1;
    ty_read_number(medium, "scale", &scale);
    const json_t* density = json_object_get(medium, "density");
    const ty_json_path json_path = ty_json_path_key(path, "density");
    if (json_is_number(density)) scale *= json_number_value(density);
    def->scale = (float)scale;
    if (!json_is_object(density)) return TY_OK;
    if (json_object_get(density, "file") != NULL) {
        double radius = 0;
        const ty_result result = ty_read_droplets(reader, density, &json_path, "density", def->bounds == TY_BOUNDS_BOX,
                                                  &radius, &def->density_grid);
        scatter_as_droplets(medium, radius, def);
        return result;
    }
    const json_t* exponential = json_object_get(density, "exponential");
    if (exponential != NULL) {
        const ty_json_path exponential_path = ty_json_path_key(&json_path, "exponential");
        return read_exponential(reader, exponential, &exponential_path, reader->unit / unit, def);
    }
    const ty_json_path noise_path = ty_json_path_key(&json_path, "noise");
    return read_noise(reader, json_object_get(density, "noise"), &noise_path, &def->density_grid);
}

/* ---- bounds ---- */

/* A closed mesh; lengths are in `unit` meters. */
static ty_result read_shell(ty_scene_reader* reader, const json_t* bounds, const ty_json_path* path, double unit,
                            ty_medium_def* def) {
    def->bounds = TY_BOUNDS_SHELL;
    ty_mesh_file_def file = ty_default_mesh_file_def();
    const ty_json_path json_path = ty_json_path_key(path, "file");
    const ty_asset_file* found = NULL;
    ty_result result =
        ty_find_mesh_file(reader, &json_path, json_string_value(json_object_get(bounds, "file")), &found);
    if (result == TY_OK) result = ty_read_mesh_placement(reader, bounds, path, unit, &file);
    return result == TY_OK ? ty_read_shell(reader, &json_path, found, &file, &def->shell) : result;
}

/* Bounds in `unit` meters. Fails if the density needs bounds and there are none. */
static ty_result read_bounds(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path, double unit,
                             ty_medium_def* def) {
    const json_t* bounds = json_object_get(medium, "bounds");
    const json_t* density = json_object_get(medium, "density");
    const ty_json_path json_path = ty_json_path_key(path, "bounds");
    const double factor = reader->unit / unit;
    if (json_is_array(bounds)) {
        def->bounds = TY_BOUNDS_BOX;
        return ty_read_box(reader, medium, path, "bounds", factor, def->box_min, def->box_max);
    }
    if (json_object_get(density, "noise") != NULL || json_object_get(density, "exponential") != NULL)
        return ty_reader_fail(reader, bounds != NULL ? &json_path : path, TY_ERROR_INPUT,
                              "%s needs bounds that are a box, [[x,y,z],[x,y,z]]",
                              json_object_get(density, "noise") != NULL ? "noise" : "exponential density");
    if (bounds == NULL && json_object_get(density, "file") != NULL) return TY_OK;
    if (bounds == NULL)
        return ty_reader_fail(reader, path, TY_ERROR_INPUT, "a homogeneous medium needs the key \"bounds\"");
    if (json_object_get(bounds, "file") != NULL) return read_shell(reader, bounds, &json_path, unit, def);
    const json_t* sphere = json_object_get(bounds, "sphere");
    def->bounds = TY_BOUNDS_SPHERE;
    ty_read_vector(sphere, "center", factor, def->sphere_center);
    ty_read_number(sphere, "radius", &def->sphere_radius);
    def->sphere_radius *= factor;
    return TY_OK;
}

/* ---- media ---- */

static bool is_file(const json_t* object, const char* key) {
    return json_object_get(json_object_get(object, key), "file") != NULL;
}

static ty_result read_medium(ty_scene_reader* reader, const json_t* medium, const ty_json_path* path) {
    ty_medium_def def = ty_default_medium_def();
    const char* name = json_string_value(json_object_get(medium, "name"));
    if (name != NULL) def.name = name;
    /* Volumes from files are placed in the file's units, so bounds use these too, and the transform converts all to
     * meters; without files all lengths are in meters before the transform. */
    const bool files = is_file(medium, "density") || is_file(medium, "albedo") || is_file(medium, "g") ||
                       is_file(json_object_get(medium, "emission"), "temperature");
    const double unit = files ? reader->unit : 1;
    ty_transfer_point points[TY_TRANSFER_MAX];
    ty_phase_table table;
    ty_result result = ty_read_coefficients(reader, medium, path, &def, &table);
    if (result == TY_OK) result = read_bounds(reader, medium, path, unit, &def);
    if (result == TY_OK) result = ty_read_transform(reader, medium, path, unit, 1, &def.transform);
    if (result == TY_OK) result = ty_read_fields(reader, medium, path, &def, points);
    if (result == TY_OK) result = read_density(reader, medium, path, unit, &def);
    return result == TY_OK ? ty_reader_prefix_error(reader, path, ty_scene_add_medium(reader->scene, &def)) : result;
}

ty_result ty_read_media(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path media = ty_json_path_key(&root, "media");
    size_t i;
    json_t* medium;
    json_array_foreach(json_object_get(reader->root, "media"), i, medium) {
        const ty_json_path path = ty_json_path_index(&media, i);
        const ty_result result = read_medium(reader, medium, &path);
        if (result != TY_OK) return result;
    }
    return ty_read_sky_air(reader);
}
