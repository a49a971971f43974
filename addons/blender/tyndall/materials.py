"""Surface shaders as materials of glTF 2.0: Principled BSDF by the metallic-roughness model, and simple shaders."""
import os
import tempfile

import numpy as np

from .nodes import Constant, Image, behind, constant_of, number_of, output_of, socket_of, value_of
from .report import owner


class Materials:
    """Materials and images that are in a glb.Writer already, by Blender's names."""

    def __init__(self, writer, report):
        self.writer, self.report = writer, report
        self.known, self.images = {}, {}

    def index(self, material):
        """The index of a material in the file; None: Blender's default surface."""
        key = material.name_full if material is not None else ""
        if key not in self.known:
            self.known[key] = self.writer.add_material(self._make(material))
        return self.known[key]

    def _make(self, material):
        if material is None:
            return plain((0.8, 0.8, 0.8))
        name = owner("material", material)
        if not material.use_nodes or material.node_tree is None:
            return {**plain(tuple(material.diffuse_color)[:3]), "name": material.name}
        place = output_of(material.node_tree, "OUTPUT_MATERIAL", "Surface")
        if output_of(material.node_tree, "OUTPUT_MATERIAL", "Displacement") is not None:
            self.report.lose(name, "displacement")
        out = plain((0, 0, 0)) if place is None else self._shader(place, name)
        out["name"] = material.name
        return out

    # ---- shaders ----

    def _shader(self, place, name):
        node, groups = place.node, place.groups
        if node.type == "BSDF_PRINCIPLED":
            return self._principled(node, groups, name)
        if node.type in ("MIX_SHADER", "ADD_SHADER"):
            return self._mix(node, groups, name)
        colour = constant_of(socket_of(node, "Color"), groups, self.report, name, (0.8, 0.8, 0.8))
        roughness = number_of(socket_of(node, "Roughness"), groups, self.report, name)
        if node.type == "BSDF_DIFFUSE":
            if roughness > 0:
                self.report.approximate(name, "roughness of the diffuse surface (Oren and Nayar)")
            out = plain(colour)
            self._texture(out["pbrMetallicRoughness"], "baseColorTexture", "baseColorFactor", node, "Color", groups, name)
            return out
        if node.type == "BSDF_GLOSSY":
            return {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 1, "roughnessFactor": roughness}}
        if node.type in ("BSDF_GLASS", "BSDF_REFRACTION"):
            if node.type == "BSDF_REFRACTION":
                self.report.approximate(name, "refraction without reflection: glass is taken")
            ior = number_of(socket_of(node, "IOR"), groups, self.report, name, 1.45)
            return _glass(colour, roughness, ior)
        if node.type == "EMISSION":
            strength = number_of(socket_of(node, "Strength"), groups, self.report, name, 1.0)
            out = plain((0, 0, 0))
            self._emission(out, [strength * c for c in colour], name)
            return out
        if node.type == "BSDF_TRANSPARENT":
            return {**plain(colour), "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0]}}
        self.report.lose(name, f'surface shader "{node.name}"; a diffuse one of its colour is taken')
        return plain(colour)

    def _mix(self, node, groups, name):
        sockets = node.inputs[1:3] if node.type == "MIX_SHADER" else node.inputs[:2]
        parts = [p for p in (behind(s, groups) for s in sockets)]
        if node.type == "MIX_SHADER" and any(p is not None and p.node.type == "BSDF_TRANSPARENT" for p in parts):
            clear = 0 if parts[0] is not None and parts[0].node.type == "BSDF_TRANSPARENT" else 1
            factor = number_of(node.inputs[0], groups, self.report, name, 0.5)
            if parts[1 - clear] is not None:
                out = self._shader(parts[1 - clear], name)
                base = out.setdefault("pbrMetallicRoughness", {})
                colour = base.get("baseColorFactor", [1, 1, 1, 1])
                base["baseColorFactor"] = [*colour[:3], factor if clear == 0 else 1 - factor]
                return {**out, "alphaMode": "BLEND"}
        self.report.lose(name, f'"{node.name}": all but the first of its shaders')
        present = [p for p in parts if p is not None]
        return self._shader(present[0], name) if present else plain((0, 0, 0))

    def _principled(self, node, groups, name):
        number = lambda *names, fallback=0.0: number_of(socket_of(node, *names), groups, self.report, name, fallback)
        base = {"baseColorFactor": [*self._plain_colour(node, groups, name, "Base Color"), number_or_one(node, groups)]}
        base["metallicFactor"], base["roughnessFactor"] = 0.0, 0.0
        out = {"pbrMetallicRoughness": base, "extensions": {}}
        self._texture(base, "baseColorTexture", "baseColorFactor", node, "Base Color", groups, name)
        self._metallic_roughness(base, node, groups, name)
        if base["baseColorFactor"][3] < 1 or "baseColorTexture" in base and socket_of(node, "Alpha").is_linked:
            out["alphaMode"] = "BLEND"
        extensions = out["extensions"]
        ior = number("IOR", fallback=1.5)
        old = socket_of(node, "Specular") is not None
        level = number("Specular", "Specular IOR Level", fallback=0.5)
        transmission = number("Transmission", "Transmission Weight")
        extensions["KHR_materials_ior"] = {"ior": 1.5 if old and transmission == 0 else max(ior, 1)}
        if level != 0.5 and transmission < 1:
            extensions["KHR_materials_specular"] = {"specularFactor": 1.0, "specularColorFactor": [2 * level] * 3}
        if transmission > 0:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": transmission}
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
        coat = number("Clearcoat", "Coat Weight")
        if coat > 0:
            roughness = number("Clearcoat Roughness", "Coat Roughness")
            extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": coat, "clearcoatRoughnessFactor": roughness}
        self._sheen(extensions, node, groups, name)
        strength = number("Emission Strength", fallback=1.0)
        glow = constant_of(socket_of(node, "Emission", "Emission Color"), groups, self.report, name)
        self._emission(out, [strength * c for c in glow], name)
        self._normal(out, node, groups, name)
        for lost, sockets in (("subsurface scattering", ("Subsurface", "Subsurface Weight")), ("anisotropy", ("Anisotropic",)),
                              ("thin film", ("Thin Film Thickness",))):
            if socket_of(node, *sockets) is not None and number(*sockets) > 0:
                self.report.lose(name, lost)
        return out

    def _plain_colour(self, node, groups, name, socket):
        value = value_of(socket_of(node, socket), groups, self.report, name)
        return value.value if isinstance(value, Constant) else getattr(value, "factor", (0.8, 0.8, 0.8))

    def _sheen(self, extensions, node, groups, name):
        sheen = number_of(socket_of(node, "Sheen", "Sheen Weight"), groups, self.report, name)
        if sheen > 0:
            roughness = number_of(socket_of(node, "Sheen Roughness"), groups, self.report, name, 0.5)
            extensions["KHR_materials_sheen"] = {"sheenColorFactor": [min(sheen, 1)] * 3, "sheenRoughnessFactor": roughness}
            self.report.approximate(name, "sheen: another model of fibres")

    def _emission(self, out, radiance, name):
        peak = max(radiance)
        if peak <= 0:
            return
        out["emissiveFactor"] = [v / peak for v in radiance]
        out.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {"emissiveStrength": peak}
        self.report.approximate(name, "emission leaves the front of faces alone")

    # ---- textures ----

    def _texture(self, target, key, factor, node, socket, groups, name):
        value = value_of(socket_of(node, socket), groups, self.report, name)
        if not isinstance(value, Image):
            return
        texture = self._texture_of(value, name)
        if texture is not None:
            target[key] = {"index": texture}
            target[factor] = [*value.factor, target.get(factor, [1, 1, 1, 1])[3]]

    def _texture_of(self, value, name):
        image = value.node.image
        if image is None:
            return None
        if image.source not in ("FILE", "GENERATED"):
            self.report.lose(name, f'image "{image.name}" of kind {image.source}')
            return None
        if value.node.projection != "FLAT" or value.node.inputs["Vector"].is_linked:
            self.report.approximate(name, f'image "{image.name}" is placed by the active UV map alone')
        key = image.name_full
        if key not in self.images:
            self.images[key] = self.writer.add_image(*_bytes_of(image))
        return self.writer.add_texture(self.images[key], value.node.extension == "REPEAT")

    def _metallic_roughness(self, base, node, groups, name):
        values = [value_of(socket_of(node, s), groups, self.report, name) for s in ("Roughness", "Metallic")]
        for value, key in zip(values, ("roughnessFactor", "metallicFactor")):
            if isinstance(value, Constant):
                base[key] = min(max(value.value[0], 0.0), 1.0)
        images = [v for v in values if isinstance(v, Image) and v.node.image is not None]
        if not images:
            return
        planes = [_plane_of(v) if isinstance(v, Image) else None for v in values]
        shape = next(p.shape for p in planes if p is not None)
        if any(p is not None and p.shape != shape for p in planes):
            self.report.lose(name, "the image of metal, of another size than that of roughness")
            planes[1] = None
        pixels = np.zeros((*shape, 4), np.float32)
        pixels[..., 3] = 1
        for plane, channel, key, value in zip(planes, (1, 2), ("roughnessFactor", "metallicFactor"), values):
            pixels[..., channel] = plane if plane is not None else 1
            if plane is not None:
                base[key] = min(value.factor[0], 1.0)
        image = self.writer.add_image(_png_of(pixels), "image/png")
        base["metallicRoughnessTexture"] = {"index": self.writer.add_texture(image, images[0].node.extension == "REPEAT")}

    def _normal(self, out, node, groups, name):
        place = behind(socket_of(node, "Normal"), groups)
        if place is None:
            return
        if place.node.type != "NORMAL_MAP" or place.node.space != "TANGENT":
            self.report.lose(name, f'normals by node "{place.node.name}"')
            return
        value = value_of(socket_of(place.node, "Color"), place.groups, self.report, name)
        texture = self._texture_of(value, name) if isinstance(value, Image) else None
        if texture is not None:
            scale = number_of(socket_of(place.node, "Strength"), place.groups, self.report, name, 1.0)
            out["normalTexture"] = {"index": texture, "scale": scale}


def plain(colour):
    """A diffuse material: glTF's dielectric without its reflection."""
    return {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}


def _glass(colour, roughness, ior):
    return {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0, "roughnessFactor": roughness},
            "extensions": {"KHR_materials_ior": {"ior": max(ior, 1)},
                           "KHR_materials_transmission": {"transmissionFactor": 1},
                           "KHR_materials_volume": {"thicknessFactor": 1}}}


def number_or_one(node, groups):
    """The alpha of Principled BSDF where it is a number; an image of it comes with that of the colour."""
    socket = socket_of(node, "Alpha")
    return 1.0 if socket is None or behind(socket, groups) is not None else min(max(socket.default_value, 0.0), 1.0)


def _bytes_of(image):
    """The bytes and the MIME type of an image: its own file where that is a PNG or JPEG, else a PNG of its pixels."""
    data = b""
    if image.packed_file is not None:
        data = bytes(image.packed_file.data)
    elif image.source == "FILE" and image.filepath:
        path = _absolute(image)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                data = file.read()
    if not image.is_dirty and data[:8] == b"\x89PNG\r\n\x1a\n":
        return data, "image/png"
    if not image.is_dirty and data[:2] == b"\xff\xd8":
        return data, "image/jpeg"
    return _png_of(_pixels_of(image)), "image/png"


def _absolute(image):
    import bpy
    return bpy.path.abspath(image.filepath, library=image.library)


def _pixels_of(image):
    """Height x width x 4, the first row at the bottom."""
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], -1)


def _plane_of(value):
    pixels = _pixels_of(value.node.image)
    if value.channel == "Alpha":
        return pixels[..., 3]
    if value.channel in ("R", "G", "B"):
        return pixels[..., "RGB".index(value.channel)]
    return pixels[..., :3].mean(-1)


def _png_of(pixels):
    """A PNG of pixels (rows from the bottom), which it stores as they are."""
    import struct
    import zlib
    values = (np.clip(pixels[::-1], 0, 1) * 255 + 0.5).astype(np.uint8)
    height, width, channels = values.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = values.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    head = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")
