"""The world: environment lights, its volume as a box around everything, and what that does to distant light."""
import math
import os

import bpy

from .nodes import Constant, Image, behind, constant_of, number_of, output_of, socket_of, value_of
from .report import owner

FILES = (".hdr", ".exr", ".png", ".jpg", ".jpeg")


def environment_of(world, folder, report):
    """Entries of "lights" for a world."""
    if world is None:
        return []
    name = owner("world", world)
    if not world.use_nodes or world.node_tree is None:
        return _uniform(tuple(world.color))
    place = output_of(world.node_tree, "OUTPUT_WORLD", "Surface")
    if place is None:
        return []
    if place.node.type not in ("BACKGROUND", "EMISSION"):
        report.lose(name, f'shader "{place.node.name}"')
        return []
    node, groups = place.node, place.groups
    strength = number_of(socket_of(node, "Strength"), groups, report, name, 1.0)
    source = behind(socket_of(node, "Color"), groups)
    if source is not None and source.node.type == "TEX_ENVIRONMENT":
        return _map(source, strength, folder, report, name)
    if source is not None and source.node.type == "TEX_SKY":
        return _sky(source.node, strength, report, name)
    colour = constant_of(socket_of(node, "Color"), groups, report, name)
    return _uniform([strength * c for c in colour])


def _uniform(radiance):
    return [{"type": "environment", "radiance": list(radiance)}] if max(radiance) > 0 else []


def _map(source, strength, folder, report, name):
    node, image = source.node, source.node.image
    if image is None or strength <= 0:
        return []
    if node.projection != "EQUIRECTANGULAR":
        report.lose(name, "a mirror ball as the projection of its image")
        return []
    light = {"type": "environment", "file": file_of_image(image, folder), "scale": strength}
    rotation = _rotation(source, report, name)
    if rotation != 0:
        light["rotation"] = rotation
    return [light]


def _rotation(source, report, name):
    """Rotation about z of the image, degrees: that of a Mapping node turns the directions it is looked up with."""
    place = behind(source.node.inputs["Vector"], source.groups)
    if place is None or place.node.type == "TEX_COORD":
        return 0.0
    if place.node.type == "MAPPING" and place.node.vector_type in ("POINT", "VECTOR", "TEXTURE", "NORMAL"):
        angles = constant_of(place.node.inputs["Rotation"], place.groups, report, name)
        if abs(angles[0]) < 1e-6 and abs(angles[1]) < 1e-6:
            return math.degrees(angles[2]) * (1 if place.node.vector_type == "TEXTURE" else -1)
    report.lose(name, f'the mapping of its image by "{place.node.name}" but for a rotation about z')
    return 0.0


def _sky(node, strength, report, name):
    sun = node.sun_direction
    if hasattr(node, "sun_elevation") and node.sky_type not in ("PREETHAM", "HOSEK_WILKIE"):
        elevation, turn = node.sun_elevation, node.sun_rotation
        sun = (math.sin(turn) * math.cos(elevation), math.cos(turn) * math.cos(elevation), math.sin(elevation))
    report.approximate(name, "its sky texture: Tyndall's own sky with the sun at the same place")
    sky = {"sun_direction": [-v for v in sun], "sun": bool(getattr(node, "sun_disc", False))}
    return [{"type": "environment", "sky": sky, "scale": strength}]


def file_of_image(image, folder):
    """The path of an image's own file where Tyndall reads it, else of a copy in `folder`, relative to it."""
    path = bpy.path.abspath(image.filepath, library=image.library) if image.filepath else ""
    if image.source == "FILE" and image.packed_file is None and not image.is_dirty and path.lower().endswith(FILES) and os.path.isfile(path):
        return os.path.abspath(path)
    copy = "".join(c if c.isalnum() else "_" for c in image.name_full) + ".exr"
    duplicate = image.copy()
    try:
        duplicate.file_format = "OPEN_EXR"
        duplicate.filepath_raw = os.path.join(folder, copy)
        duplicate.save()
    finally:
        bpy.data.images.remove(duplicate)
    return copy


def arriving(lights, media):
    """Lights without the channels of sun and world that media without end keep away: exp(-s t) is 0 there, as in Cycles."""
    bodies = [m for m in media if "emission" not in m and m.get("scale", 1) > 0]
    passes = [all(m.get("sigma_s", (0, 0, 0))[c] + m.get("sigma_a", (0, 0, 0))[c] <= 0 for m in bodies) for c in range(3)]
    out = []
    for light in lights:
        key = {"directional": "irradiance", "environment": "radiance"}.get(light["type"])
        if key is None or all(passes):
            out.append(light)
        elif key in light and any(passes):
            out.append({**light, key: [v if p else 0 for v, p in zip(light[key], passes)]})
    return out


def box_of_air(points):
    """The box that stands for a world without end, and the distance of its faces from the scene, ten times its size."""
    lower = [min(p[a] for p in points) for a in range(3)]
    upper = [max(p[a] for p in points) for a in range(3)]
    margin = min(10 * (max(u - l for l, u in zip(lower, upper)) or 1.0), 1e6)
    return [[v - margin for v in lower], [v + margin for v in upper]], margin
