"""Small scenes of Blender, made by script: each function builds one in an empty file. They run inside Blender."""
import math
import os
import subprocess

import bpy
import numpy as np

SIZE = 48, 36


def start(position, target, lens=50.0):
    """An empty file with a camera."""
    from mathutils import Vector
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    camera = add("Camera", bpy.data.cameras.new("Camera"), position)
    camera.data.lens = lens
    direction = Vector(target) - Vector(position)
    camera.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()
    scene = bpy.context.scene
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background(0, 0, 0)
    return scene


def background(r, g, b, strength=1.0):
    node = bpy.context.scene.world.node_tree.nodes["Background"]
    node.inputs["Color"].default_value = (r, g, b, 1)
    node.inputs["Strength"].default_value = strength


def add(name, data, position=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    target = bpy.data.objects.new(name, data)
    target.location, target.rotation_euler, target.scale = position, rotation, scale
    bpy.context.scene.collection.objects.link(target)
    return target


def light(kind, name, energy, position, rotation=(0, 0, 0), **settings):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in {"shadow_soft_size": 0.0, "angle": 0.0, **settings}.items():
        if hasattr(data, key):
            setattr(data, key, value)
    return add(name, data, position, rotation)


def material(name, kind, socket="Surface", **inputs):
    """A material of one node; inputs by the names of sockets, _ for spaces."""
    out = bpy.data.materials.new(name)
    out.use_nodes = True
    tree = out.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for key, value in inputs.items():
        found = next((s for s in node.inputs if s.name == key.replace("_", " ") and s.enabled), None)
        found.default_value = value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[socket])
    return out


def diffuse(name, r, g, b):
    return material(name, "ShaderNodeBsdfDiffuse", Color=(r, g, b, 1))


def shape(kind, name, surface, position=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    """A plane, cube or sphere (of 2 units across) with a material."""
    import bmesh
    mesh, builder = bpy.data.meshes.new(name), bmesh.new()
    if kind == "plane":
        bmesh.ops.create_grid(builder, x_segments=1, y_segments=1, size=1)
    elif kind == "cube":
        bmesh.ops.create_cube(builder, size=2)
    else:
        bmesh.ops.create_uvsphere(builder, u_segments=48, v_segments=24, radius=1)
    builder.to_mesh(mesh)
    builder.free()
    mesh.materials.append(surface)
    return add(name, mesh, position, rotation, scale)


# ---- the scenes ----

def lamps(folder, tyndall):
    """Point, spot, sun and area light over a floor; a shifted camera."""
    scene = start((0, -7, 4.5), (0, 0, 0.4))
    scene.camera.data.shift_x, scene.camera.data.shift_y = 0.08, -0.05
    shape("plane", "Floor", diffuse("Grey", 0.6, 0.6, 0.6), scale=(8, 8, 1))
    shape("cube", "Block", diffuse("Red", 0.7, 0.2, 0.1), (0.8, 0.4, 0.5), (0, 0, 0.5), (0.5, 0.5, 0.5))
    light("POINT", "Bulb", 120, (-1.5, -1, 1.6), color=(1, 0.8, 0.5))
    light("SPOT", "Spot", 300, (2, -2, 3.5), (0.35, 0.25, 0), spot_size=0.6, spot_blend=0.4)
    light("SUN", "Sun", 0.7, (0, 0, 5), (0.6, 0.3, 0))
    light("AREA", "Panel", 90, (-1, 3, 6), (-0.5, 0, 0.3), shape="RECTANGLE", size=1.2, size_y=0.6)


def soft(folder, tyndall):
    """A point light and a spot of some radius, above the view, which throw soft shadows."""
    start((0, -7, 4.5), (0, 0, 0.4))
    shape("plane", "Floor", diffuse("Grey", 0.6, 0.6, 0.6), scale=(8, 8, 1))
    shape("cube", "Block", diffuse("Red", 0.7, 0.2, 0.1), (0.8, 0.4, 0.5), (0, 0, 0.5), (0.5, 0.5, 0.5))
    shape("cube", "Post", diffuse("Blue", 0.2, 0.3, 0.7), (-1, 0.5, 0.6), scale=(0.15, 0.15, 0.6))
    light("POINT", "Bulb", 250, (-2.2, -0.5, 3.6), color=(1, 0.8, 0.5), shadow_soft_size=0.3)
    light("SPOT", "Spot", 400, (2, -2, 4.2), (0.35, 0.25, 0), spot_size=0.6, spot_blend=0.4, shadow_soft_size=0.35)


def air(folder, tyndall):
    """Fog of the world, through which no light of the sky and of the sun arrives, around a lamp."""
    scene = start((0, -6, 1.8), (0, 0, 0.5))
    background(1, 1, 1)
    shape("plane", "Floor", diffuse("Grey", 0.5, 0.5, 0.5), scale=(5, 5, 1))
    light("POINT", "Lamp", 100, (1, -1, 2))
    light("SUN", "Sun", 1, (0, 0, 5), (0.5, 0.3, 0))
    tree = scene.world.node_tree
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = 0.05
    tree.links.new(scatter.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_WORLD").inputs["Volume"])


def fog(folder, tyndall):
    """A box of forward-scattering fog with absorption, over a floor, under a lamp and a sky."""
    start((0.3, -5.5, 1.6), (0, 0, 0.8))
    background(0.5, 0.6, 0.8, 0.6)
    shape("plane", "Floor", diffuse("Grey", 0.5, 0.5, 0.5), scale=(6, 6, 1))
    volume = material("Fog", "ShaderNodeVolumePrincipled", "Volume", Color=(0.8, 0.7, 0.5, 1), Density=0.9, Anisotropy=0.4,
                      Absorption_Color=(0.1, 0.3, 0.6, 1))
    shape("cube", "Fog", volume, (0, 0, 1), scale=(1.2, 1.2, 0.9))
    light("POINT", "Lamp", 150, (1.2, -1.4, 3.2))


def ball(folder, tyndall):
    """Scattering, absorption and emission added up in a closed mesh, under an image of the world, turned."""
    scene = start((0, -4.5, 0.3), (0, 0, 0))
    image = bpy.data.images.new("Sky, \u00fc", 64, 32, float_buffer=True)
    y, x = np.mgrid[0:32, 0:64] / np.array([32, 64]).reshape(2, 1, 1)
    pixels = np.ones((32, 64, 4), np.float32)
    pixels[..., 0], pixels[..., 1], pixels[..., 2] = 0.2 + x, 0.3 + y, 1 - 0.6 * x * y
    image.pixels.foreach_set(pixels.ravel())
    image.file_format, image.filepath_raw = "OPEN_EXR", os.path.join(folder, "sky '1' \u00fc.exr")
    image.save()
    tree = scene.world.node_tree
    sky, turn = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    sky.image, sky.interpolation = bpy.data.images.load(image.filepath_raw), "Linear"
    turn.inputs["Rotation"].default_value = (0, 0, 0.8)
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs[0], sky.inputs["Vector"])
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    cloud = material("Haze", "ShaderNodeVolumeScatter", "Volume", Color=(0.6, 0.7, 0.9, 1), Density=1.5, Anisotropy=-0.3)
    nodes, links = cloud.node_tree.nodes, cloud.node_tree.links
    scatter = next(n for n in nodes if n.type == "VOLUME_SCATTER")
    absorb, glow = nodes.new("ShaderNodeVolumeAbsorption"), nodes.new("ShaderNodeEmission")
    absorb.inputs["Color"].default_value, absorb.inputs["Density"].default_value = (0.9, 0.6, 0.4, 1), 0.8
    glow.inputs["Color"].default_value, glow.inputs["Strength"].default_value = (1, 0.5, 0.2, 1), 0.15
    first, second = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeAddShader")
    links.new(scatter.outputs[0], first.inputs[0])
    links.new(absorb.outputs[0], first.inputs[1])
    links.new(first.outputs[0], second.inputs[0])
    links.new(glow.outputs[0], second.inputs[1])
    links.new(second.outputs[0], next(n for n in nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])
    shape("sphere", "Ball \"\u03b2\"", cloud, scale=(1.1, 1.1, 0.9), rotation=(0.2, 0.3, 0))


def write_vdb(folder, tyndall, name="blob.vdb"):
    """A density of a soft ball, 16 cells a side and 2 m across around the origin."""
    axis = (np.arange(16) + 0.5) / 8 - 1
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    density = np.clip(1.3 - 1.4 * np.sqrt(x * x + y * y + z * z) + 0.25 * np.sin(5 * x) * np.sin(4 * y + 1), 0, 1)
    raw, path = os.path.join(folder, "blob.raw"), os.path.join(folder, name)
    density.astype(np.float32).tofile(raw)
    subprocess.run([tyndall, "convert", raw, path, "--raw-size", "16,16,16", "--raw-type", "float", "--raw-spacing",
                    "0.125,0.125,0.125"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return path


def cloud(folder, tyndall):
    """An OpenVDB volume, scaled and turned, its density through a Math node."""
    start((0, -5, 0.5), (0, 0, 0))
    background(0.4, 0.5, 0.7)
    light("SUN", "Sun", 2.5, (0, 0, 5), (0.7, 0.5, 0))
    data = bpy.data.volumes.new("Blob")
    data.filepath = write_vdb(folder, tyndall, "blob & \u4e91.vdb")
    shader = material("Cloud", "ShaderNodeVolumePrincipled", "Volume", Color=(0.9, 0.9, 0.9, 1), Density=2.0, Anisotropy=0.5)
    nodes, links = shader.node_tree.nodes, shader.node_tree.links
    principled = next(n for n in nodes if n.type == "PRINCIPLED_VOLUME")
    principled.inputs["Density Attribute"].default_value = ""
    attribute, times = nodes.new("ShaderNodeVolumeInfo"), nodes.new("ShaderNodeMath")
    times.operation = "MULTIPLY"
    times.inputs[1].default_value = 9.0
    links.new(attribute.outputs["Density"], times.inputs[0])
    links.new(times.outputs[0], principled.inputs["Density"])
    data.materials.append(shader)
    add("Cloud", data, (-1.1, -1.0, -0.7), (0.1, 0.2, 0.3), (1.2, 0.9, 0.8))


def smoke(folder, tyndall):
    """Smoke and fire of a domain, six frames into the simulation."""
    scene = start((0.4, -5.5, 1.6), (0, 0, 1.1))
    background(0.3, 0.3, 0.4)
    light("POINT", "Lamp", 120, (2, -2, 3))
    shader = material("Smoke", "ShaderNodeVolumePrincipled", "Volume", Color=(0.5, 0.5, 0.5, 1), Density=8.0,
                      Blackbody_Intensity=0.7)
    principled = next(n for n in shader.node_tree.nodes if n.type == "PRINCIPLED_VOLUME")
    principled.inputs["Temperature"].default_value = 900
    domain = shape("cube", "Domain", shader, (0, 0, 1.5), (0, 0, 0.3), (0.9, 0.9, 1.5))
    source = shape("sphere", "Source", shader, (0, 0, 0.6), scale=(0.35, 0.35, 0.35))
    source.hide_render = True
    domain.modifiers.new("Fluid", "FLUID").fluid_type = "DOMAIN"
    settings = domain.modifiers[0].domain_settings
    settings.domain_type, settings.resolution_max = "GAS", 20
    settings.cache_directory, settings.cache_data_format = os.path.join(folder, "cache"), "OPENVDB"
    settings.cache_frame_start, settings.cache_frame_end = 1, 6
    source.modifiers.new("Fluid", "FLUID").fluid_type = "FLOW"
    flow = source.modifiers[0].flow_settings
    flow.flow_type, flow.flow_behavior = "BOTH", "INFLOW"
    for frame in range(1, 7):
        scene.frame_set(frame)


def surfaces(folder, tyndall):
    """Metal, plastic with an image, glass, and thin fog of the world; a lens."""
    scene = start((0, -6, 1.8), (0, 0, 0.7))
    scene.camera.data.dof.use_dof = True
    scene.camera.data.dof.focus_distance, scene.camera.data.dof.aperture_fstop = 6.2, 0.4
    background(0.6, 0.7, 0.9)
    image = bpy.data.images.new("Squares", 16, 16)
    squares = np.ones((16, 16, 4), np.float32)
    squares[..., 0] = (np.indices((16, 16)).sum(0) // 4 % 2) * 0.6 + 0.3
    squares[..., 1], squares[..., 2] = 0.5, 0.35
    image.pixels.foreach_set(squares.ravel())
    image.pack()
    floor = material("Floor", "ShaderNodeBsdfPrincipled", Roughness=0.6)
    next(s for s in floor.node_tree.nodes["Principled BSDF"].inputs if s.name.startswith("Specular")).default_value = 0.2
    texture = floor.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    principled = next(n for n in floor.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    floor.node_tree.links.new(texture.outputs["Color"], principled.inputs["Base Color"])
    target = shape("plane", "Floor", floor, scale=(5, 5, 1))
    uvs = target.data.uv_layers.new(name="UVMap")
    for loop in target.data.loops:
        uvs.data[loop.index].uv = [(c + 1) / 2 for c in target.data.vertices[loop.vertex_index].co.xy]
    metal = material("Gold", "ShaderNodeBsdfPrincipled", Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=0.35)
    for polygon in shape("sphere", "Gold", metal, (-1.2, 0, 0.8), scale=(0.8, 0.8, 0.8)).data.polygons:
        polygon.use_smooth = True
    shape("cube", "Glow", material("Glow", "ShaderNodeEmission", Color=(1, 0.6, 0.3, 1), Strength=4), (1.2, 1.5, 0.4), (0, 0, 0.4), (0.4,) * 3)
    light("SUN", "Sun", 1.5, (0, 0, 5), (0.5, 0.4, 0))
    shape("cube", "Mist", material("Mist", "ShaderNodeVolumeScatter", "Volume", Density=0.12), (0, 0.5, 1), scale=(2.5, 2.5, 0.95))


def glass(folder, tyndall):
    """A ball of glass and a half transparent cube on a floor."""
    start((0, -6, 1.8), (0, 0, 0.7))
    background(0.6, 0.7, 0.9)
    shape("plane", "Floor", diffuse("Grey", 0.5, 0.3, 0.3), scale=(5, 5, 1))
    clear = material("Glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.4, Color=(0.9, 1, 0.9, 1))
    for polygon in shape("sphere", "Ball", clear, (0, 0, 1)).data.polygons:
        polygon.use_smooth = True
    half = diffuse("Half", 0.2, 0.4, 0.8)
    nodes, links = half.node_tree.nodes, half.node_tree.links
    mix = nodes.new("ShaderNodeMixShader")
    links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    links.new(next(n for n in nodes if n.type == "BSDF_DIFFUSE").outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], next(n for n in nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
    shape("cube", "Cube", half, (1.8, 1, 0.5), scale=(0.5, 0.5, 0.5))


def motion(folder, tyndall):
    """A camera that moves while its shutter is open."""
    scene = start((0, -6, 1.8), (0, 0, 0.7))
    background(0.6, 0.7, 0.9)
    shape("plane", "Floor", diffuse("Grey", 0.5, 0.3, 0.3), scale=(5, 5, 1))
    shape("cube", "Block", diffuse("Red", 0.8, 0.2, 0.2), (0, 0, 0.7), scale=(0.4, 0.4, 0.7))
    scene.camera.keyframe_insert("location", frame=0)
    scene.camera.location.x += 1.5
    scene.camera.keyframe_insert("location", frame=2)
    for curve in scene.camera.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)


def moving(folder, tyndall):
    """A block and a lamp that move, and one that turns, while the shutter is open."""
    scene = start((0, -6, 1.8), (0, 0, 0.7))
    background(0.3, 0.4, 0.5)
    shape("plane", "Floor", diffuse("Grey", 0.5, 0.5, 0.5), scale=(5, 5, 1))
    block = shape("cube", "Block", diffuse("Red", 0.8, 0.2, 0.2), (-1.4, 0, 0.7), scale=(0.4, 0.4, 0.7))
    turning = shape("cube", "Turning", diffuse("Blue", 0.2, 0.3, 0.8), (1.2, 0.5, 0.8), scale=(0.9, 0.3, 0.6))
    lamp = light("POINT", "Lamp", 200, (0, -2, 3))
    for target, path, change in ((block, "location", (1.2, 0, 0)), (turning, "rotation_euler", (0, 0, 0.8)), (lamp, "location", (0.5, 0, 0))):
        target.keyframe_insert(path, frame=0)
        setattr(target, path, [v + c for v, c in zip(getattr(target, path), change)])
        target.keyframe_insert(path, frame=2)
        for curve in target.animation_data.action.fcurves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(1)


SCENES = {f.__name__: f for f in (lamps, soft, air, fog, ball, cloud, smoke, surfaces, glass, motion, moving)}
