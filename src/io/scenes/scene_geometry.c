/* Surfaces of a scene file. */
#include "io/scenes/scene_reader.h"

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
    const json_t* material = json_object_get(item, "material");
    ty_read_rgb(material, "albedo", def.albedo);
    ty_read_rgb(material, "emission", def.emission);
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
    ty_read_number(item, "light_scale", &def.light_scale);
    ty_read_number(item, "emission_scale", &def.emission_scale);
    const json_t* material = json_object_get(item, "material");
    ty_material_def plain = ty_default_material_def();
    ty_read_rgb(material, "albedo", plain.albedo);
    ty_read_rgb(material, "emission", plain.emission);
    if (material != NULL) def.material = &plain;
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
