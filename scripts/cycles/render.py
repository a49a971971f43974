"""Renders a scene file with Blender Cycles: blender --background --python render.py -- SCENE.json OUT.exr SPP SEED.

Reads the part of the format that scenes.py and noise.py use; Blender has z up, so that (x, y, z) with y up is
(x, -z, y) there. Meshes and materials come by Blender's own importer of glTF, but for dielectrics, which it does not make
solid: these are Glass BSDFs here. Prints the processor seconds of the render without the start of Blender."""
import json
import math
import pathlib
import resource
import struct
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

# Debian's importer of Blender 3.4 uses a name that its numpy 1.24 no longer has.
numpy.bool = bool


z_is_up = False


def turned(v):
    return Vector(v if z_is_up else (v[0], -v[2], v[1]))


def rgb(value):
    return list(value) if isinstance(value, list) else [value] * 3


def new_material(name):
    """An empty node tree and the output that ends it."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree.nodes.new("ShaderNodeOutputMaterial")


def add_node(tree, kind, **inputs):
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    return node


def add_object(name, points, faces, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in points], [], faces)
    mesh.materials.append(material)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


# ---- materials ----

def diffuse(color):
    material, output = new_material("diffuse")
    tree = material.node_tree
    node = add_node(tree, "ShaderNodeBsdfDiffuse", Color=(*color, 1))
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def glowing(radiance):
    """Emission of both sides."""
    material, output = new_material("glowing")
    strength = max(radiance)
    node = add_node(material.node_tree, "ShaderNodeEmission", Color=(*[c / strength for c in radiance], 1),
                    Strength=strength)
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def lamp(radiance):
    """Emission in front, black behind."""
    material, output = new_material("lamp")
    tree = material.node_tree
    strength = max(radiance)
    front = add_node(tree, "ShaderNodeEmission", Color=(*[c / strength for c in radiance], 1), Strength=strength)
    back = add_node(tree, "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1))
    mix, geometry = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeNewGeometry")
    tree.links.new(geometry.outputs["Backfacing"], mix.inputs[0])
    tree.links.new(front.outputs[0], mix.inputs[1])
    tree.links.new(back.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return material


def add_volume(material, sigma_s, sigma_a, g):
    """A homogeneous medium: colours are relative to the largest channel, which is the density."""
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    both = tree.nodes.new("ShaderNodeAddShader")
    scatter, absorb = max(sigma_s) or 1, max(sigma_a) or 1
    node = add_node(tree, "ShaderNodeVolumeScatter", Color=(*[c / scatter for c in sigma_s], 1),
                    Density=scatter if max(sigma_s) else 0, Anisotropy=g)
    tree.links.new(node.outputs[0], both.inputs[0])
    node = add_node(tree, "ShaderNodeVolumeAbsorption", Color=(*[1 - c / absorb for c in sigma_a], 1),
                    Density=absorb if max(sigma_a) else 0)
    tree.links.new(node.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Volume"])


def glass(json_material):
    """KHR_materials_volume; sigma_a = -ln(attenuationColor) / attenuationDistance."""
    extensions = json_material["extensions"]
    roughness = json_material["pbrMetallicRoughness"]["roughnessFactor"]
    material, output = new_material(json_material["name"] + " solid")
    node = add_node(material.node_tree, "ShaderNodeBsdfGlass", Color=(1, 1, 1, 1),
                    IOR=extensions["KHR_materials_ior"]["ior"], Roughness=roughness)
    node.distribution = "MULTI_GGX" if roughness > 0 else "SHARP"
    material.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    volume = extensions["KHR_materials_volume"]
    if "attenuationDistance" in volume:
        sigma_a = [-math.log(c) / volume["attenuationDistance"] for c in volume["attenuationColor"]]
        add_volume(material, [0, 0, 0], sigma_a, 0)
    return material


def lambertian(material):
    """Takes the base of a Principled BSDF as a Diffuse BSDF of the same colour and normals, without reflection."""
    tree = material.node_tree
    principled = tree.nodes["Principled BSDF"]
    node = add_node(tree, "ShaderNodeBsdfDiffuse", Color=principled.inputs["Base Color"].default_value)
    for link in principled.inputs["Normal"].links:
        tree.links.new(link.from_socket, node.inputs["Normal"])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(node.outputs[0], output.inputs["Surface"])


def read_materials(path):
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    return {material["name"]: material for material in json.loads(data[20:20 + length])["materials"]}


# ---- scene ----

def import_meshes(path):
    before = set(bpy.data.objects)
    bpy.ops.import_scene.gltf(filepath=str(path))
    made = [thing for thing in bpy.data.objects if thing not in before and thing.type == "MESH"]
    known, solids = read_materials(path), {}
    for thing in made:
        for slot in thing.material_slots:
            name = slot.material.name
            if "KHR_materials_volume" in known[name].get("extensions", {}):
                solids.setdefault(name, glass(known[name]))
                slot.material = solids[name]
            elif name == "lambert":
                lambertian(slot.material)
            else:
                principled = slot.material.node_tree.nodes["Principled BSDF"]
                principled.distribution = "MULTI_GGX"
                # The importer of 3.4 leaves this extension out.
                specular = known[name].get("extensions", {}).get("KHR_materials_specular", {})
                principled.inputs["Specular"].default_value *= specular.get("specularFactor", 1)
    return made


def add_geometry(folder, items):
    meshes = {}
    for item in items:
        if "file" in item:
            meshes[item["file"]] = import_meshes(folder / item["file"])
            continue
        given = item["material"]
        material = (glowing(rgb(given["emission"])) if "emission" in given
                    else diffuse(rgb(given["base_color"] if "base_color" in given else given["albedo"])))
        if "sphere" in item:
            add_sphere(item["sphere"], material)
        elif "quad" in item:
            origin, u, v = (turned(item["quad"][key]) for key in ("origin", "u", "v"))
            add_object("quad", [origin, origin + u, origin + u + v, origin + v], [(0, 1, 2, 3)], material)
        else:
            add_box(item["box"], material, item.get("transform"))
    return meshes


def placed(point, transform):
    """A point after a turn about the axis that is up and a translation, all that these scenes have of transforms."""
    if transform is None:
        return point
    x, y, z = point
    angle = math.radians(transform["rotate"][2])
    along = transform["translate"]
    assert z_is_up and transform["rotate"][:2] == [0, 0]
    return [x * math.cos(angle) - y * math.sin(angle) + along[0], x * math.sin(angle) + y * math.cos(angle) + along[1],
            z + along[2]]


def add_sphere(sphere, material):
    """An icosphere of 1280 triangles with smooth normals; its volume is 0.4 % less than the sphere's."""
    import bmesh
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=4, radius=sphere["radius"])
    mesh = bpy.data.meshes.new("sphere")
    shape.to_mesh(mesh)
    shape.free()
    mesh.materials.append(material)
    thing = bpy.data.objects.new("sphere", mesh)
    thing.location = turned(sphere["center"])
    bpy.context.scene.collection.objects.link(thing)


def add_box(corners, material, transform=None):
    points = [turned(placed([corners[i >> a & 1][a] for a in range(3)], transform)) for i in range(8)]
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return add_object("box", points, faces, material)


def add_media(folder, media, meshes):
    for medium in media:
        numbers = rgb(medium.get("sigma_s", 0)), rgb(medium.get("sigma_a", 0)), medium.get("g", 0)
        bounds = medium["bounds"]
        if isinstance(bounds, dict) and bounds["file"] in meshes:
            for thing in meshes[bounds["file"]]:
                add_volume(thing.active_material, *numbers)
            continue
        material, _ = new_material("medium")
        add_volume(material, *numbers)
        if isinstance(bounds, list):
            add_box(bounds, material)
            continue
        if "sphere" in bounds:
            add_sphere(bounds["sphere"], material)
            continue
        for thing in import_meshes(folder / bounds["file"]):
            thing.active_material = material


def add_lamp(light):
    """Lamps without extent: intensities in W/sr are 4 pi^2 times as many of Blender's W, irradiance is the sun's strength."""
    kind = {"point": "POINT", "spot": "SPOT", "directional": "SUN"}[light["type"]]
    data = bpy.data.lights.new(light["type"], kind)
    power = rgb(light["irradiance" if kind == "SUN" else "intensity"])
    data.color = [c / max(power) for c in power]
    data.energy = max(power) * (1 if kind == "SUN" else 4 * math.pi ** 2)
    if kind == "SUN":
        data.angle = 0
    else:
        data.shadow_soft_size = 0
    if kind == "SPOT":
        data.spot_size, data.spot_blend = math.radians(light["cone"]), light.get("penumbra", 0)
    thing = bpy.data.objects.new(light["type"], data)
    if kind != "SUN":
        thing.location = turned(light["position"])
    if kind != "POINT":
        thing.rotation_euler = turned(light["direction"]).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)


def add_lights(folder, lights):
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    for light in lights:
        if light["type"] in ("point", "spot", "directional"):
            add_lamp(light)
        elif light["type"] == "area":
            origin, u, v = (turned(light[key]) for key in ("origin", "u", "v"))
            add_object("lamp", [origin, origin + u, origin + u + v, origin + v], [(0, 1, 2, 3)],
                       lamp(rgb(light["radiance"])))
        elif "file" in light:
            node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
            node.image = bpy.data.images.load(str(folder / light["file"]))
            world.node_tree.links.new(node.outputs[0], background.inputs["Color"])
        else:
            background.inputs["Color"].default_value = (*rgb(light["radiance"]), 1)


def add_camera(camera):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle = math.radians(camera["fov_y"])
    thing = bpy.data.objects.new("camera", data)
    back = (turned(camera["position"]) - turned(camera["target"])).normalized()
    right = turned(camera.get("up", [0, 0, 1] if z_is_up else [0, 1, 0])).cross(back).normalized()
    thing.matrix_world = Matrix.Translation(turned(camera["position"])) @ Matrix(
        (right, back.cross(right), back)).transposed().to_4x4()
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def set_render(size, spp, seed, out):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(out)
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = spp, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    cycles.light_sampling_threshold = cycles.blur_glossy = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    for bounces in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{bounces}_bounces", 1024)


def main():
    global z_is_up
    scene_path, out, spp, seed = sys.argv[sys.argv.index("--") + 1:]
    scene_path = pathlib.Path(scene_path)
    scene = json.loads(scene_path.read_text())
    z_is_up = scene.get("up_axis") == "z"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    meshes = add_geometry(scene_path.parent, scene.get("geometry", []))
    add_media(scene_path.parent, scene.get("media", []), meshes)
    add_lights(scene_path.parent, scene.get("lights", []))
    add_camera(scene["camera"])
    set_render(scene["camera"]["resolution"], int(spp), int(seed), out)
    before = resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.render.render(write_still=True)
    after = resource.getrusage(resource.RUSAGE_SELF)
    print(f"processor seconds: {after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime:.3f}")


main()
