#!/usr/bin/env python3
"""Writes a small level as glTF: a room with a table and a ball, a lamp and a camera, for docs/tutorial.md.
Walls and table have second texture coordinates (UV2), so that they can have lightmaps; the ball has many vertices instead.
usage: make_room.py room.glb"""
import json
import math
import struct
import sys

WALL, RED, GREEN, WOOD = (0.7, 0.68, 0.64), (0.6, 0.12, 0.08), (0.15, 0.45, 0.12), (0.5, 0.3, 0.15)
ROOM, HEIGHT = 2.5, 2.6  # half of its sides and its height, m

data = bytearray()
gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
        "accessors": [], "bufferViews": [], "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"]}


def accessor(values, kind, code):
    """An array of floats ("f") or indices ("I") as an accessor; its number."""
    flat = [v for value in values for v in (value if kind != "SCALAR" else (value,))]
    gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": 4 * len(flat)})
    data.extend(struct.pack(f"<{len(flat)}{code}", *flat))
    entry = {"bufferView": len(gltf["bufferViews"]) - 1, "componentType": 5126 if code == "f" else 5125, "type": kind,
             "count": len(values)}
    if kind == "VEC3":
        entry["min"], entry["max"] = [[f(v[a] for v in values) for a in range(3)] for f in (min, max)]
    gltf["accessors"].append(entry)
    return len(gltf["accessors"]) - 1


def node(name, **keys):
    gltf["nodes"].append({"name": name, **keys})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)


def mesh(name, color, points, normals, triangles, uv=None):
    gltf["materials"].append({"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0},
                              "extensions": {"KHR_materials_specular": {"specularFactor": 0}}})  # plaster: diffuse alone
    attributes = {"POSITION": accessor(points, "VEC3", "f"), "NORMAL": accessor(normals, "VEC3", "f")}
    if uv:
        attributes["TEXCOORD_0"] = attributes["TEXCOORD_1"] = accessor(uv, "VEC2", "f")
    primitive = {"attributes": attributes, "indices": accessor(triangles, "SCALAR", "I"),
                 "material": len(gltf["materials"]) - 1}
    gltf["meshes"].append({"name": name, "primitives": [primitive]})
    node(name, mesh=len(gltf["meshes"]) - 1)


def quads(name, color, corners):
    """Parallelograms (corner, edge, edge; their front is where edge x edge points), each with a part of UV2 of its own."""
    points, normals, triangles, uv = [], [], [], []
    columns = math.ceil(math.sqrt(len(corners)))
    for i, (p, a, b) in enumerate(corners):
        n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
            points.append([p[k] + s * a[k] + t * b[k] for k in range(3)])
            normals.append([v / math.hypot(*n) for v in n])
            uv.append([(i % columns + 0.05 + 0.9 * s) / columns, (i // columns + 0.05 + 0.9 * t) / columns])
        triangles += [4 * i + k for k in (0, 1, 2, 0, 2, 3)]
    mesh(name, color, points, normals, triangles, uv)


def box(low, high):
    (x, y, z), (u, v, w) = low, [high[k] - low[k] for k in range(3)]
    return [((x, y, z), (0, v, 0), (u, 0, 0)), ((x, y, z + w), (u, 0, 0), (0, v, 0)),
            ((x, y, z), (u, 0, 0), (0, 0, w)), ((x, y + v, z), (0, 0, w), (u, 0, 0)),
            ((x, y, z), (0, 0, w), (0, v, 0)), ((x + u, y, z), (0, v, 0), (0, 0, w))]


def ball(name, color, center, radius, rings=24):
    points, normals, triangles = [], [], []
    for i in range(rings + 1):
        for j in range(2 * rings + 1):
            theta, phi = math.pi * i / rings, math.pi * j / rings
            n = [math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi)]
            normals.append(n)
            points.append([center[k] + radius * n[k] for k in range(3)])
            k = i * (2 * rings + 1) + j
            if i < rings and j < 2 * rings:
                below = k + 2 * rings + 1
                triangles += ([k, below, below + 1] if i < rings - 1 else []) + ([k, below + 1, k + 1] if i > 0 else [])
    mesh(name, color, points, normals, triangles)


R, H = ROOM, HEIGHT
quads("walls", WALL, [((-R, 0, R), (2 * R, 0, 0), (0, 0, -2 * R)), ((-R, H, -R), (2 * R, 0, 0), (0, 0, 2 * R)),
                      ((-R, 0, -R), (2 * R, 0, 0), (0, H, 0)), ((R, 0, R), (-2 * R, 0, 0), (0, H, 0))])
quads("left", RED, [((-R, 0, R), (0, 0, -2 * R), (0, H, 0))])
quads("right", GREEN, [((R, 0, -R), (0, 0, 2 * R), (0, H, 0))])
quads("table", WOOD, box((-0.9, 0.7, -1.3), (0.9, 0.78, -0.3)) + [
    side for x in (-0.85, 0.75) for z in (-1.25, -0.45) for side in box((x, 0, z), (x + 0.1, 0.7, z + 0.1))[:2] +
    box((x, 0, z), (x + 0.1, 0.7, z + 0.1))[4:]])
ball("ball", (0.75, 0.75, 0.75), (0.2, 1.1, -0.8), 0.32)
gltf["extensions"] = {"KHR_lights_punctual": {"lights": [
    {"type": "spot", "color": [1, 0.85, 0.6], "intensity": 14, "spot": {"outerConeAngle": 0.75, "innerConeAngle": 0.6}}]}}
node("lamp", translation=[-0.5, 2.5, -0.6], rotation=[-math.sqrt(0.5), 0, 0, math.sqrt(0.5)],
     extensions={"KHR_lights_punctual": {"light": 0}})
gltf["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.95, "znear": 0.1}}]
node("camera", camera=0, translation=[0, 1.3, 2.45])

gltf["buffers"] = [{"byteLength": len(data)}]
text = json.dumps(gltf).encode()
text += b" " * (-len(text) % 4)
with open(sys.argv[1], "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
    file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)
