"""A writer of binary glTF 2.0: meshes with materials and textures, from arrays."""
import json
import struct

import numpy as np

FLOAT, UINT32 = 5126, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def y_up(points):
    """Points or directions of Blender, z upwards, as glTF has them: (x, z, -y)."""
    out = np.array(points, np.float32)
    return np.stack([out[..., 0], out[..., 2], -out[..., 1]], axis=-1)


class Writer:
    """Collects meshes, and writes them as one file. Every mesh is a node, placed by its vertices."""

    def __init__(self):
        self.chunks, self.length = [], 0
        self.document = {"asset": {"version": "2.0", "generator": "Tyndall for Blender"}, "scene": 0,
                         "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [], "textures": [],
                         "images": [], "samplers": [], "accessors": [], "bufferViews": [], "extensionsUsed": []}

    def __len__(self):
        return len(self.document["meshes"])

    def _view(self, data, target=None):
        view = {"buffer": 0, "byteOffset": self.length, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.document["bufferViews"].append(view)
        padding = -len(data) % 4
        self.chunks.append(data + b"\0" * padding)
        self.length += len(data) + padding
        return len(self.document["bufferViews"]) - 1

    def _accessor(self, array, kind, target, bounds=False):
        width = 1 if array.ndim == 1 else array.shape[1]
        accessor = {"bufferView": self._view(array.tobytes(), target), "componentType": kind, "count": len(array),
                    "type": TYPES[width]}
        if bounds:
            accessor["min"], accessor["max"] = array.min(0).tolist(), array.max(0).tolist()
        self.document["accessors"].append(accessor)
        return len(self.document["accessors"]) - 1

    def add_image(self, data, kind):
        """The index of a texture of the bytes of a PNG or JPEG file; kind: its MIME type."""
        self.document["images"].append({"bufferView": self._view(data), "mimeType": kind})
        return len(self.document["images"]) - 1

    def add_texture(self, image, repeats=True):
        """The index of a texture of an image, repeating or clamped."""
        wrap = 10497 if repeats else 33071
        sampler = {"wrapS": wrap, "wrapT": wrap}
        if sampler not in self.document["samplers"]:
            self.document["samplers"].append(sampler)
        texture = {"source": image, "sampler": self.document["samplers"].index(sampler)}
        if texture not in self.document["textures"]:
            self.document["textures"].append(texture)
        return self.document["textures"].index(texture)

    def add_material(self, material):
        for extension in material.get("extensions", {}):
            if extension not in self.document["extensionsUsed"]:
                self.document["extensionsUsed"].append(extension)
        self.document["materials"].append(material)
        return len(self.document["materials"]) - 1

    def add_mesh(self, name, primitives):
        """primitives: dicts of positions (n x 3), triangles (m x 3), and perhaps normals, uvs and material."""
        parts = []
        for p in primitives:
            attributes = {"POSITION": self._accessor(p["positions"].astype(np.float32), FLOAT, ARRAY_BUFFER, True)}
            if p.get("normals") is not None:
                attributes["NORMAL"] = self._accessor(p["normals"].astype(np.float32), FLOAT, ARRAY_BUFFER)
            if p.get("uvs") is not None:
                attributes["TEXCOORD_0"] = self._accessor(p["uvs"].astype(np.float32), FLOAT, ARRAY_BUFFER)
            indices = self._accessor(p["triangles"].astype(np.uint32).ravel(), UINT32, ELEMENT_ARRAY_BUFFER)
            part = {"attributes": attributes, "indices": indices}
            if p.get("material") is not None:
                part["material"] = p["material"]
            parts.append(part)
        self.document["meshes"].append({"name": name, "primitives": parts})
        self.document["nodes"].append({"name": name, "mesh": len(self.document["meshes"]) - 1})
        self.document["scenes"][0]["nodes"].append(len(self.document["nodes"]) - 1)

    def write(self, path):
        document = {key: value for key, value in self.document.items() if value != []}
        document["buffers"] = [{"byteLength": self.length}]
        text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + self.length
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, total))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", self.length, b"BIN\0"))
            for chunk in self.chunks:
                file.write(chunk)
