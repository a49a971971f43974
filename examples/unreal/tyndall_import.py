"""Applies a bake to the open level of Unreal Engine 5: lightmaps as textures of unlit materials, the box of the probes, and their
coefficients.

In the editor, with the Python Editor Script Plugin: py "tyndall_import.py" FOLDER, where FOLDER is of `tyndall export --for unreal`.
Actors are found by the names of the meshes. docs/engines.md explains the conventions."""
import json
import os
import sys

import unreal

DESTINATION = "/Game/Tyndall"
BLOCKED = 0.5  # probes of which more rays met backs of surfaces are inside of walls


def import_texture(path):
    """A lightmap: linear, half floats, no mipmaps."""
    task = unreal.AssetImportTask()
    task.set_editor_property("filename", path)
    task.set_editor_property("destination_path", DESTINATION)
    task.set_editor_property("automated", True)
    task.set_editor_property("replace_existing", True)
    task.set_editor_property("save", True)
    unreal.AssetToolsHelpers.get_asset_tools().import_asset_tasks([task])
    texture = unreal.load_asset(task.get_editor_property("imported_object_paths")[0])
    texture.set_editor_property("srgb", False)
    texture.set_editor_property("compression_settings", unreal.TextureCompressionSettings.TC_HDR)
    texture.set_editor_property("mip_gen_settings", unreal.TextureMipGenSettings.TMGS_NO_MIPMAPS)
    texture.set_editor_property("address_x", unreal.TextureAddress.TA_CLAMP)
    texture.set_editor_property("address_y", unreal.TextureAddress.TA_CLAMP)
    return texture


def make_material():
    """Unlit: emission is the base colour times the lightmap (irradiance over pi) at the second texture coordinates."""
    path = f"{DESTINATION}/M_TyndallLightmap"
    if unreal.EditorAssetLibrary.does_asset_exist(path):
        return unreal.load_asset(path)
    library = unreal.MaterialEditingLibrary
    material = unreal.AssetToolsHelpers.get_asset_tools().create_asset("M_TyndallLightmap", DESTINATION, unreal.Material,
                                                                       unreal.MaterialFactoryNew())
    material.set_editor_property("shading_model", unreal.MaterialShadingModel.MSM_UNLIT)
    color = library.create_material_expression(material, unreal.MaterialExpressionVectorParameter, -600, 0)
    color.set_editor_property("parameter_name", "BaseColor")
    color.set_editor_property("default_value", unreal.LinearColor(1, 1, 1, 1))
    uv = library.create_material_expression(material, unreal.MaterialExpressionTextureCoordinate, -900, 200)
    uv.set_editor_property("coordinate_index", 1)
    light = library.create_material_expression(material, unreal.MaterialExpressionTextureSampleParameter2D, -600, 200)
    light.set_editor_property("parameter_name", "Lightmap")
    product = library.create_material_expression(material, unreal.MaterialExpressionMultiply, -300, 100)
    library.connect_material_expressions(uv, "", light, "UVs")
    library.connect_material_expressions(color, "", product, "A")
    library.connect_material_expressions(light, "RGB", product, "B")
    library.connect_material_property(product, "", unreal.MaterialProperty.MP_EMISSIVE_COLOR)
    library.recompile_material(material)
    return material


def base_color(material):
    """The base colour of a glTF material that Unreal imported; white where it has none."""
    if isinstance(material, unreal.MaterialInstance):
        return unreal.MaterialEditingLibrary.get_material_instance_vector_parameter_value(material, "BaseColorFactor")
    return unreal.LinearColor(1, 1, 1, 1)


def make_instance(name, parent, color, texture):
    """A material instance as an asset, so that it is saved with the level."""
    path = f"{DESTINATION}/{name}"
    if unreal.EditorAssetLibrary.does_asset_exist(path):
        instance = unreal.load_asset(path)
    else:
        instance = unreal.AssetToolsHelpers.get_asset_tools().create_asset(name, DESTINATION, unreal.MaterialInstanceConstant,
                                                                           unreal.MaterialInstanceConstantFactoryNew())
    library = unreal.MaterialEditingLibrary
    library.set_material_instance_parent(instance, parent)
    library.set_material_instance_vector_parameter_value(instance, "BaseColor", color)
    library.set_material_instance_texture_parameter_value(instance, "Lightmap", texture)
    return instance


def apply_lightmaps(folder, export):
    parent, actors = make_material(), unreal.EditorLevelLibrary.get_all_level_actors()
    for lightmap in export["lightmaps"]:
        texture = import_texture(os.path.join(folder, lightmap["file"]))
        for mesh in lightmap["meshes"]:
            for actor in actors:
                component = actor.get_component_by_class(unreal.StaticMeshComponent)
                if component is None or mesh["name"] not in (actor.get_actor_label(), component.static_mesh.get_name()):
                    continue
                slot = mesh["primitive"]
                color = base_color(component.get_material(slot))
                name = f"MI_{mesh['name']}_{slot}"
                component.set_material(slot, make_instance(name, parent, color, texture))


def add_importance_volume(probes):
    """A Lightmass importance volume around the probes."""
    axes = [[p["position"][a] for p in probes] for a in range(3)]
    center = unreal.Vector(*(0.5 * (min(v) + max(v)) for v in axes))
    volume = unreal.EditorLevelLibrary.spawn_actor_from_class(unreal.LightmassImportanceVolume, center)
    volume.set_actor_scale3d(unreal.Vector(*(max((max(v) - min(v)) / 200, 0.5) for v in axes)))  # its brush has 200 cm


def irradiance(coefficients, normal):
    """E of a probe by its nine terms of radiance, with Unreal's basis and cosine lobe (TSHVector.CalcDiffuseTransfer)."""
    x, y, z = normal
    basis = [0.282095, -0.488603 * y, 0.488603 * z, -0.488603 * x, 1.092548 * x * y, -1.092548 * y * z,
             0.315392 * (3 * z * z - 1), -1.092548 * x * z, 0.546274 * (x * x - y * y)]
    lobe = [3.14159265] + 3 * [2.09439510] + 5 * [0.78539816]
    return [sum(lobe[t] * basis[t] * coefficients[3 * t + c] for t in range(9)) for c in range(3)]


def main(folder):
    with open(os.path.join(folder, "export.json"), encoding="utf-8") as file:
        export = json.load(file)
    if export["engine"] != "unreal":
        raise ValueError(f"{folder}: not an export for Unreal")
    apply_lightmaps(folder, export)
    for key in ("grid", "probes"):
        if key not in export:
            continue
        with open(os.path.join(folder, export[key]), encoding="utf-8") as file:
            probes = [p for p in json.load(file)["probes"] if p["blocked"] <= BLOCKED]
        add_importance_volume(probes)
        up = [sum(channel) for channel in zip(*(irradiance(p["coefficients"], (0, 0, 1)) for p in probes))]
        unreal.log(f"Tyndall: {len(probes)} probes, irradiance from above {[v / len(probes) for v in up]}")


main(sys.argv[1])
