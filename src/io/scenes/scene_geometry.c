/* Surfaces of a scene file. */
#include "io/scenes/scene_reader.h"

/* Surfaces with any of these keys are glossy. */
static const char* const gloss_keys[] = {"metallic",       "roughness",      "ior",          "specular",
                                         "specular_color", "clearcoat",      "transmission", "clearcoat_roughness",
                                         "sheen_color",    "sheen_roughness"};

static void read_gloss(const json_t* material, ty_gloss_def* gloss) {
    bool glossy = false;
    for (size_t i = 0; i < sizeof gloss_keys / sizeof *gloss_keys; ++i)
        glossy = glossy || json_object_get(material, gloss_keys[i]) != NULL;
    if (!glossy) return;
    gloss->specular = 1;
    ty_read_float(material, "metallic", &gloss->metallic);
    ty_read_float(material, "roughness", &gloss->roughness);
    ty_read_float(material, "ior", &gloss->ior);
    ty_read_float(material, "specular", &gloss->specular);
    ty_read_rgb(material, "specular_color", gloss->specular_color);
    ty_read_float(material, "transmission", &gloss->transmission);
    ty_read_float(material, "clearcoat", &gloss->clearcoat);
    ty_read_float(material, "clearcoat_roughness", &gloss->clearcoat_roughness);
    ty_read_rgb(material, "sheen_color", gloss->sheen_color);
    ty_read_float(material, "sheen_roughness", &gloss->sheen_roughness);
}

/* The solid that the surface bounds. */
static ty_result read_volume(const ty_scene_reader* reader, const json_t* material, const ty_json_path* path,
                             ty_gloss_def* gloss) {
    const json_t* volume = json_object_get(material, "volume");
    const ty_json_path json_path = ty_json_path_key(path, "volume");
    if (volume == NULL) return TY_OK;
    if (!(gloss->transmission > 0))
        return ty_reader_fail(reader, &json_path, TY_ERROR_INPUT, "needs the key \"transmission\" above 0 beside it");
    gloss->solid = true;
    ty_read_int(volume, "priority", &gloss->priority);
    ty_read_rgb(volume, "attenuation_color", gloss->attenuation_color);
    ty_read_float(volume, "attenuation_distance", &gloss->attenuation_distance);
    return TY_OK;
}

/* The object under "material", if there is one. */
static ty_result read_material(const ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                               float albedo[3], float emission[3], ty_gloss_def* gloss) {
    const json_t* material = json_object_get(item, "material");
    const ty_json_path json_path = ty_json_path_key(path, "material");
    const ty_json_path old_name = ty_json_path_key(&json_path, "albedo");
    if (json_object_get(material, "albedo") != NULL && json_object_get(material, "base_color") != NULL)
        return ty_reader_fail(reader, &old_name, TY_ERROR_INPUT, "is the old name of base_color; give one of them");
    ty_read_rgb(material, "albedo", albedo);
    ty_read_rgb(material, "base_color", albedo);
    ty_read_rgb(material, "emission", emission);
    read_gloss(material, gloss);
    return read_volume(reader, material, &json_path, gloss);
}

static ty_result read_shape(ty_scene_reader* reader, const json_t* item, const ty_json_path* path) {
    ty_shape_def def = ty_default_shape_def();
    const json_t* quad = json_object_get(item, "quad");
    const json_t* sphere = json_object_get(item, "sphere");
    ty_result result = TY_OK;
    if (quad != NULL) {
        def.kind = TY_SHAPE_QUAD;
        const ty_json_path json_path = ty_json_path_key(path, "quad");
        result = ty_read_edges(reader, quad, &json_path, def.origin, def.u, def.v);
    } else if (sphere != NULL) {
        def.kind = TY_SHAPE_SPHERE;
        ty_read_vector(sphere, "center", reader->unit, def.origin);
        ty_read_number(sphere, "radius", &def.radius);
        def.radius *= reader->unit;
    } else {
        def.kind = TY_SHAPE_BOX;
        result = ty_read_box(reader, item, path, "box", reader->unit, def.origin, def.u);
    }
    if (result == TY_OK) result = ty_read_transform(reader, item, path, 1, 1, &def.transform);
    if (result == TY_OK) result = read_material(reader, item, path, def.albedo, def.emission, &def.gloss);
    return result == TY_OK ? ty_reader_prefix_error(reader, path, ty_scene_add_shape(reader->scene, &def)) : result;
}

ty_result ty_read_mesh_placement(const ty_scene_reader* reader, const json_t* item, const ty_json_path* path,
                                 double to_unit, ty_mesh_file_def* def) {
    const bool gltf = ty_has_extension(json_string_value(json_object_get(item, "file")), ty_gltf_extensions);
    def->to_z_up = gltf && reader->up_axis == TY_AXIS_Z;
    return ty_read_transform(reader, item, path, reader->unit, to_unit, &def->transform);
}

static ty_result read_mesh_file(ty_scene_reader* reader, const json_t* item, const ty_json_path* path) {
    ty_mesh_file_def def = ty_default_mesh_file_def();
    const ty_json_path json_path = ty_json_path_key(path, "file");
    const ty_asset_file* file = NULL;
    ty_result result = ty_find_mesh_file(reader, &json_path, json_string_value(json_object_get(item, "file")), &file);
    if (result == TY_OK) result = ty_read_mesh_placement(reader, item, path, 1, &def);
    if (result != TY_OK) return result;
    ty_read_bool(item, "meshes", &def.meshes);
    ty_read_bool(item, "lights", &def.lights);
    ty_read_bool(item, "gloss", &def.gloss);
    ty_read_number(item, "light_scale", &def.light_scale);
    ty_read_number(item, "emission_scale", &def.emission_scale);
    ty_material_def own = ty_default_material_def();
    result = read_material(reader, item, path, own.albedo, own.emission, &own.gloss);
    if (result != TY_OK) return result;
    if (json_object_get(item, "material") != NULL) def.material = &own;
    return ty_reader_prefix_error(reader, &json_path, ty_scene_add_mesh_file(reader->scene, file->path, &def));
}

ty_result ty_read_geometry(ty_scene_reader* reader) {
    const ty_json_path root = {.depth = 0};
    const ty_json_path geometry = ty_json_path_key(&root, "geometry");
    size_t i;
    json_t* item;
    json_array_foreach(json_object_get(reader->root, "geometry"), i, item) {
        const ty_json_path path = ty_json_path_index(&geometry, i);
        const bool file = json_object_get(item, "file") != NULL;
        const ty_result result = file ? read_mesh_file(reader, item, &path) : read_shape(reader, item, &path);
        if (result != TY_OK) return result;
    }
    return TY_OK;
}
