/* Surfaces of a scene file. */
#include "io/scenes/memory_files.h"
#include "io/scenes/scene_reader.h"

#include <string.h>

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
    ty_material_def material = ty_default_material_def();
    if (result == TY_OK) result = ty_read_material(reader, item, path, &material);
    if (result == TY_OK && material.emission_texture != NULL) {
        const ty_json_path json_path = ty_json_path_key(path, "material");
        const ty_json_path emission = ty_json_path_key(&json_path, "emission");
        result = ty_reader_fail(reader, &emission, TY_ERROR_INPUT,
                                "shapes have no textures of emission; the meshes of a \"file\" have");
    }
    memcpy(def.albedo, material.albedo, sizeof def.albedo);
    memcpy(def.emission, material.emission, sizeof def.emission);
    memcpy(def.albedo_texture.map, material.albedo_map, sizeof material.albedo_map);
    def.albedo_texture.texture = material.albedo_texture;
    def.gloss = material.gloss;
    if (result == TY_OK) result = ty_reader_prefix_error(reader, path, ty_scene_add_shape(reader->scene, &def));
    ty_release_material(&material);
    return result;
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
    result = ty_read_material(reader, item, path, &own);
    if (json_object_get(item, "material") != NULL) def.material = &own;
    if (result == TY_OK) {
        result = file->memory != NULL ? ty_memory_add_mesh(reader->assets, file, &def, reader->scene)
                                      : ty_scene_add_mesh_file(reader->scene, file->path, &def);
        result = ty_reader_prefix_error(reader, &json_path, result);
    }
    ty_release_material(&own);
    return result;
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
