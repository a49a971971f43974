"""Scenes for compare.py: GLB files of meshes and materials, and scene files that both renderers read.

Everything is made here but the environment map, which is a file of the caller's."""
import json
import math
import pathlib
import struct
import zlib


# ---- files ----

def png(width, height, texel):
    """An RGB PNG; texel(x, y) gives three bytes, row 0 at the top."""
    rows = b"".join(b"\0" + bytes(value for x in range(width) for value in texel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


class Model:
    """A glTF binary under construction."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                     "materials": [], "accessors": [], "bufferViews": [], "extensionsUsed": []}
        self.data = b""

    def view(self, data):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, width, index=False):
        code, component = ("I", 5125) if index else ("f", 5126)
        accessor = {"bufferView": self.view(struct.pack(f"<{len(values)}{code}", *values)), "componentType": component,
                    "count": len(values) // width, "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[width]}
        if width == 3:
            accessor["min"] = [min(values[i::3]) for i in range(3)]
            accessor["max"] = [max(values[i::3]) for i in range(3)]
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def image(self, data):
        self.json.setdefault("images", []).append({"bufferView": self.view(data), "mimeType": "image/png"})
        self.json.setdefault("textures", []).append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1

    def material(self, name, base_color, metallic=0.0, roughness=1.0, **more):
        extensions = more.pop("extensions", {})
        self.json["extensionsUsed"] = sorted({*self.json["extensionsUsed"], *extensions})
        self.json["materials"].append({
            "name": name, "extensions": extensions,
            "pbrMetallicRoughness": {"baseColorFactor": [*base_color, 1], "metallicFactor": metallic,
                                     "roughnessFactor": roughness}, **more})
        return len(self.json["materials"]) - 1

    def mesh(self, arrays):
        """arrays: attributes by their names, and indices. Returns attributes that primitives may share."""
        widths = {"POSITION": 3, "NORMAL": 3, "TEXCOORD_0": 2, "TANGENT": 4}
        return {"attributes": {name: self.accessor(arrays[name], widths[name]) for name in widths if name in arrays},
                "indices": self.accessor(arrays["indices"], 1, True)}

    def place(self, name, mesh, material, translation=(0, 0, 0), scale=1.0):
        self.json["meshes"].append({"name": name, "primitives": [{**mesh, "material": material}]})
        self.json["nodes"].append({"name": name, "mesh": len(self.json["meshes"]) - 1,
                                   "translation": list(translation), "scale": [scale] * 3})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        if not self.json["extensionsUsed"]:
            del self.json["extensionsUsed"]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        total = 12 + 8 + len(text) + 8 + len(data)
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, total) + struct.pack("<II", len(text), 0x4E4F534A) + text
                         + struct.pack("<II", len(data), 0x004E4942) + data)


# ---- meshes ----

def sphere(around=96, down=48):
    """A unit sphere with smooth normals; the triangles at the poles are single ones."""
    points, indices = [], []
    for j in range(down + 1):
        for i in range(around):
            polar, azimuth = math.pi * j / down, 2 * math.pi * i / around
            points += [math.sin(polar) * math.cos(azimuth), math.cos(polar), math.sin(polar) * math.sin(azimuth)]
    for j in range(down):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            c, d = a + around, b + around
            if j > 0:
                indices += [a, b, c]
            if j + 1 < down:
                indices += [b, d, c]
    return {"POSITION": points, "NORMAL": points, "indices": indices}


def block(lower, upper):
    """A closed box, its normals outwards, without smooth normals."""
    corner = [[upper[a] if i >> a & 1 else lower[a] for a in range(3)] for i in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    points, indices = [], []
    for quad in quads:
        first = len(points) // 3
        for i in quad:
            points += corner[i]
        indices += [first, first + 1, first + 2, first, first + 2, first + 3]
    return {"POSITION": points, "indices": indices}


def square(side):
    """A horizontal square that faces up, u along +x and v along +z."""
    h = side / 2
    return {"POSITION": [-h, 0, -h, h, 0, -h, h, 0, h, -h, 0, h], "NORMAL": [0, 1, 0] * 4,
            "TEXCOORD_0": [0, 0, 1, 0, 1, 1, 0, 1], "TANGENT": [1, 0, 0, 1] * 4, "indices": [0, 2, 1, 0, 3, 2]}


def bumps(x, y, side=128):
    """Normals of crossed waves, whose largest slope is 0.3."""
    def slope(t):
        return 0.3 * math.cos(2 * math.pi * 4 * (t + 0.5) / side)
    normal = [-slope(x), slope(y), 1]
    length = math.sqrt(sum(value * value for value in normal))
    return [round(255 * (0.5 + 0.5 * value / length)) for value in normal]


# ---- scenes ----

GOLD, SILVER, COPPER, PLASTIC = (1, 0.766, 0.336), (0.972, 0.96, 0.915), (0.955, 0.638, 0.538), (0.6, 0.15, 0.1)


def solid(ior, color=(1, 1, 1), distance=None):
    """Extensions of a solid dielectric."""
    volume = {"thicknessFactor": 1}
    if distance is not None:
        volume.update(attenuationDistance=distance, attenuationColor=list(color))
    return {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": ior},
            "KHR_materials_volume": volume}


def scene(camera, lights, **more):
    position, target, fov_y = camera
    return {"tyndall": 1, "camera": {"position": position, "target": target, "up": [0, 1, 0], "fov_y": fov_y},
            "lights": lights, "geometry": [], **more}


def floor(albedo, side=12):
    h = side / 2
    return {"quad": {"origin": [-h, 0, h], "u": [side, 0, 0], "v": [0, 0, -side]}, "material": {"base_color": albedo}}


def sky(environment):
    return [{"type": "environment", "file": str(environment)}]


def spheres(folder, environment):
    """Five balls of gold and behind them five of plastic, of roughness .05 to 1."""
    model, out = Model(), scene(([0, 3.2, 6.8], [0, 0.3, -0.1], 34), sky(environment))
    ball = model.mesh(sphere())
    for i, roughness in enumerate((0.05, 0.2, 0.4, 0.7, 1)):
        gold = model.material(f"gold {roughness}", GOLD, 1, roughness)
        plastic = model.material(f"plastic {roughness}", PLASTIC, 0, roughness)
        model.place(f"gold {i}", ball, gold, (1.1 * (i - 2), 0.5, 0.6), 0.5)
        model.place(f"plastic {i}", ball, plastic, (1.1 * (i - 2), 0.5, -0.8), 0.5)
    model.write(folder / "spheres.glb")
    out["geometry"] = [{"file": "spheres.glb"}, floor(0.5)]
    return out


def metal_in_fog(folder, _):
    model = Model()
    lights = [{"type": "area", "origin": [-0.2, 3, 0.4], "u": [0.4, 0, 0], "v": [0, 0, 0.4], "radiance": 40},
              {"type": "environment", "radiance": 0.15}]
    out = scene(([0, 1.6, 6.5], [0, 0.7, 0], 28), lights)
    ball = model.mesh(sphere())
    model.place("gold", ball, model.material("gold", GOLD, 1, 0.3), (-0.75, 0.6, 0), 0.6)
    model.place("silver", ball, model.material("silver", SILVER, 1, 0.1), (0.75, 0.6, 0), 0.6)
    model.write(folder / "metal_in_fog.glb")
    out["geometry"] = [{"file": "metal_in_fog.glb"}, floor(0.4)]
    out["media"] = [{"name": "fog", "bounds": [[-3, -0.05, -3], [3, 3.5, 3]], "sigma_s": 0.3, "g": 0.5}]
    return out


def mapped_square(folder, name, color, metallic, bumpy=True, specular=1.0):
    """A square of roughness 0.4 under a lamp, by a map of normals or flat. What is named "lambert" is a Diffuse BSDF in Cycles."""
    model = Model()
    lights = [{"type": "area", "origin": [-0.3, 2.2, -1.1], "u": [0.6, 0, 0], "v": [0, 0, 0.6], "radiance": 20}]
    out = scene(([0, 2.9, 1.7], [0, 0, 0.02], 34), lights)
    more = {"normalTexture": {"index": model.image(png(128, 128, bumps))}} if bumpy else {}
    if specular < 1:
        more["extensions"] = {"KHR_materials_specular": {"specularFactor": specular}}
    material = model.material(name, color, metallic, 0.4, **more)
    model.place("square", model.mesh(square(2)), material)
    model.write(folder / f"{name}.glb")
    out["geometry"] = [{"file": f"{name}.glb"}]
    return out


def normal_map(folder, _):
    return mapped_square(folder, "normal_map", COPPER, 1)


def plastic(folder, _):
    """The parts of plastic, one by one: both, without the map, the reflection alone, the base alone as Principled has it and as
    Lambert has it."""
    return mapped_square(folder, "plastic", PLASTIC, 0)


def plastic_flat(folder, _):
    return mapped_square(folder, "plastic_flat", PLASTIC, 0, bumpy=False)


def plastic_reflection(folder, _):
    return mapped_square(folder, "plastic_reflection", (0, 0, 0), 0)


def plastic_base(folder, _):
    return mapped_square(folder, "plastic_base", PLASTIC, 0, specular=0)


def lambert(folder, _):
    return mapped_square(folder, "lambert", PLASTIC, 0, specular=0)


def glass_balls(folder, environment):
    """Smooth and rough glass, and in front a small ball that absorbs."""
    model, out = Model(), scene(([0, 1.7, 5], [0, 0.45, 0], 32), sky(environment))
    ball = model.mesh(sphere())
    for name, roughness, place, scale, more in (("smooth", 0, (-0.65, 0.55, 0), 0.5, {}),
                                                ("rough", 0.3, (0.65, 0.55, 0), 0.5, {}),
                                                ("tinted", 0, (0, 0.28, 1), 0.25,
                                                 {"color": (0.85, 0.35, 0.15), "distance": 0.25})):
        glass = model.material(f"glass {name}", (1, 1, 1), 0, roughness, extensions=solid(1.5, **more))
        model.place(name, ball, glass, place, scale)
    model.write(folder / "glass_balls.glb")
    out["geometry"] = [{"file": "glass_balls.glb"}, floor(0.4)]
    return out


def milk(folder, environment, boundary=True):
    """A ball of milk, in a dielectric or without one. The two differ in their scene file alone."""
    model, out = Model(), scene(([0, 1.3, 4], [0, 0.45, 0], 24), sky(environment))
    glass = model.material("glass milk", (1, 1, 1), 0, 0, extensions=solid(1.33))
    model.place("milk", model.mesh(sphere()), glass, (0, 0.55, 0), 0.5)
    model.write(folder / "milk.glb")
    out["geometry"] = [{"file": "milk.glb"}, floor(0.4)] if boundary else [floor(0.4)]
    out["media"] = [{"name": "milk", "bounds": {"file": "milk.glb"}, "sigma_s": 20, "sigma_a": [0.02, 0.06, 0.2],
                     "g": 0.7}]
    return out


def milk_index_matched(folder, environment):
    return milk(folder, environment, boundary=False)


def pool(folder, environment):
    """Water in a basin, whose diffuse walls enclose the sides and the bottom of the water's mesh."""
    model, out = Model(), scene(([0, 3, 4.5], [0, -0.2, 0], 32), sky(environment))
    water = model.material("glass water", (1, 1, 1), 0, 0, extensions=solid(1.33))
    model.place("water", model.mesh(block([-1.5, -0.8, -1.5], [1.5, 0, 1.5])), water)
    model.write(folder / "pool.glb")
    gray = {"base_color": [0.5, 0.55, 0.6]}
    # No two faces coincide, because Cycles shadows both then.
    walls = [[[-1.55, -0.85, -1.55], [1.55, -0.7, 1.55]], [[-1.6, -0.9, -1.4], [-1.4, 0.03, 1.4]],
             [[1.4, -0.9, -1.4], [1.6, 0.03, 1.4]], [[-1.6, -0.9, -1.6], [1.6, 0.03, -1.4]],
             [[-1.6, -0.9, 1.4], [1.6, 0.03, 1.6]]]
    out["geometry"] = [{"file": "pool.glb"}] + [{"box": box, "material": gray} for box in walls]
    out["media"] = [{"name": "water", "bounds": {"file": "pool.glb"}, "sigma_s": 0.1, "sigma_a": [0.3, 0.07, 0.03],
                     "g": 0.9}]
    return out


SCENES = {"spheres": spheres, "metal_in_fog": metal_in_fog, "normal_map": normal_map}
PLASTIC_SCENES = {"plastic": plastic, "plastic_flat": plastic_flat, "plastic_reflection": plastic_reflection,
                  "plastic_base": plastic_base, "lambert": lambert}
SOLID_SCENES = {"glass_balls": glass_balls, "milk": milk, "milk_index_matched": milk_index_matched, "pool": pool}


def write(name, folder, environment, size):
    """Writes NAME.json and its meshes into a folder; returns the path of the scene."""
    folder = pathlib.Path(folder)
    out = {**SCENES, **PLASTIC_SCENES, **SOLID_SCENES}[name](folder, environment)
    out["camera"]["resolution"] = list(size)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(out, indent=1))
    return path
