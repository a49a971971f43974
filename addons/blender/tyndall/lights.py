"""Lights in the units of scene files. Blender's watts are, by Cycles and as tests/test_blender.py measures:

point, spot: intensity = P / (4 pi), W sr^-1, with a radius r the radiance P / (4 pi^2 r^2);  area: radiance = P / (4 A), W m^-2 sr^-1;  sun: irradiance = strength, W m^-2.
A spot falls off by a smoothstep of the cosine from that of its cone to cos + (1 - cos) blend, and before Blender 3.5 by the
cosine besides, which the mean over the cone stands for.
"""
import math

import bpy
from mathutils import Vector

from .report import owner

SPOT_HAS_COSINE = bpy.app.version < (3, 5, 0)


def lights_of(instance, report, soft=True):
    """Entries of "lights" for an instance of a light of a depsgraph. soft: with the radius of point lights and spots."""
    light, matrix = instance.object.data, instance.matrix_world.copy()
    name = owner("light", light)
    colour, strength = _emission_of(light, report, name)
    power = [light.energy * strength * c for c in colour]
    if max(power) <= 0:
        return []
    if light.type == "SUN":
        if light.angle > 0:
            report.approximate(name, f"the sun's angle of {math.degrees(light.angle):.3g} degrees: shadows are sharp")
        return [{"type": "directional", "direction": _axis(matrix), "irradiance": power}]
    if light.type == "AREA":
        return [_area(light, matrix, power, report, name)]
    out = {"type": "point", "position": list(matrix.translation), "intensity": [p / (4 * math.pi) for p in power]}
    if light.type == "SPOT":
        _spot(out, light, matrix, report, name)
    _soften(out, light, report, name, soft)
    return [out]


def _emission_of(light, report, name):
    """Colour and strength, of the light's own and of the Emission node of its shader."""
    colour, strength = list(light.color), 1.0
    if light.use_nodes and light.node_tree is not None:
        from .nodes import constant_of, number_of, output_of, socket_of
        place = output_of(light.node_tree, "OUTPUT_LIGHT", "Surface")
        if place is None or place.node.type != "EMISSION":
            report.lose(name, "its shader, which is no Emission node")
            return colour, strength
        tint = constant_of(socket_of(place.node, "Color"), place.groups, report, name, (1, 1, 1))
        strength = number_of(socket_of(place.node, "Strength"), place.groups, report, name, 1.0)
        colour = [c * t for c, t in zip(colour, tint)]
    exposure = getattr(light, "exposure", 0.0)  # Blender 4.5 and later
    if getattr(light, "use_temperature", False):
        colour = [c * t for c, t in zip(colour, light.temperature_color)]
    return colour, strength * 2 ** exposure


def _soften(out, light, report, name, soft):
    """The radius of a point light or spot: Cycles' is a disc that faces each point, or a ball from Blender 4.0 on without
    soft falloff."""
    radius = light.shadow_soft_size
    if radius <= 0:
        return
    if not soft:
        report.approximate(name, f"its radius of {radius:.3g} m: the light is a point")
        return
    out["radius"] = radius
    report.approximate(name, f"its radius of {radius:.3g} m: a ball that is seen by the camera, and casts shadows")
    if getattr(light, "use_soft_falloff", True):
        report.approximate(name, "its soft falloff: within five radii it is up to 4 % brighter on what faces it")


def _axis(matrix):
    return list((matrix.to_3x3() @ Vector((0, 0, -1))).normalized())


def _spot(out, light, matrix, report, name):
    half = light.spot_size / 2
    if half > math.pi / 2:
        report.approximate(name, "a cone wider than a half space: 180 degrees")
        half = math.pi / 2
    cosine = math.cos(half)
    inner = math.acos(min(cosine + (1 - cosine) * light.spot_blend, 1))
    out.update({"type": "spot", "direction": _axis(matrix), "cone": math.degrees(2 * half), "penumbra": 1 - inner / half})
    if SPOT_HAS_COSINE:
        factor = (1 + cosine) / 2
        out["intensity"] = [factor * v for v in out["intensity"]]
        report.approximate(name, "the cosine of this version of Blender within the cone: its mean is taken")
    scale = matrix.to_scale()
    if max(scale) > 1.001 * min(scale):
        report.approximate(name, "a cone that is scaled differently along its axes: a round one")


def _area(light, matrix, power, report, name):
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    u = matrix.to_3x3() @ Vector((width, 0, 0))
    v = matrix.to_3x3() @ Vector((0, height, 0))
    if light.shape in ("DISK", "ELLIPSE"):
        shrink = math.sqrt(math.pi) / 2
        u, v = u * shrink, v * shrink
        report.approximate(name, "a round area: a rectangle of the same area")
    if getattr(light, "spread", math.pi) < math.pi - 1e-3:
        report.lose(name, "spread")
    if getattr(getattr(light, "cycles", None), "is_portal", False):
        report.lose(name, "a portal, which is a light here")
    report.approximate(name, "an area light is seen by the camera, too")
    area = u.cross(v).length
    corner = matrix.translation - (u + v) / 2
    # u x v is along the object's z; the light leaves along -z.
    return {"type": "area", "origin": list(corner), "u": list(v), "v": list(u), "radiance": [p / (4 * area) for p in power]}
