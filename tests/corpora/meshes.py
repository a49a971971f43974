"""Triangle counts and bounds of mesh files, by the formats' specifications: another reader than tyndall's own."""
import base64
import itertools
import json
import math
import os
import re
import struct
import urllib.parse

FORMATS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
PLY_TYPES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d",
             "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f",
             "float64": "d"}


class Unread(Exception):
    """The file is of a kind that is not read here."""


def single(value):
    """The nearest float of single precision."""
    return struct.unpack("f", struct.pack("f", value))[0]


class Box:
    def __init__(self):
        self.lower, self.upper = [math.inf] * 3, [-math.inf] * 3

    def add(self, point):
        for axis in range(3):
            self.lower[axis] = min(self.lower[axis], point[axis])
            self.upper[axis] = max(self.upper[axis], point[axis])


def read(path):
    """Number of triangles, lower and upper corner, and whether the corners are bounds only."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] == b"glTF" or path.lower().endswith(".gltf"):
        return Gltf(path, data).read()
    return read_ply(data) if data[:3] == b"ply" else read_obj(data)


# ---- glTF ----

IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]  # column by column, as in the file


def multiply(a, b):
    return [sum(a[4 * k + r] * b[4 * c + k] for k in range(4)) for c in range(4) for r in range(4)]


def transform(m, p):
    return [m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r] for r in range(3)]


def determinant(m):
    return (m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
            m[8] * (m[1] * m[6] - m[5] * m[2]))


def local(node):
    if "matrix" in node:
        return node["matrix"]
    t, (x, y, z, w), s = node.get("translation", [0] * 3), node.get("rotation", [0, 0, 0, 1]), node.get("scale", [1] * 3)
    k = 2 / (x * x + y * y + z * z + w * w)
    columns = [[1 - k * (y * y + z * z), k * (x * y + z * w), k * (x * z - y * w)],
               [k * (x * y - z * w), 1 - k * (x * x + z * z), k * (y * z + x * w)],
               [k * (x * z + y * w), k * (y * z - x * w), 1 - k * (x * x + y * y)]]
    return [v for c in range(3) for v in [s[c] * e for e in columns[c]] + [0]] + list(t) + [1]


class Gltf:
    def __init__(self, path, data):
        self.path, self.chunk, self.triangles, self.box, self.world = path, None, 0, Box(), {}
        self.loose = False  # the bounds are those of rotated boxes, which are larger than those of what they hold
        if data[:4] == b"glTF":
            at, text = 12, None
            while at + 8 <= len(data):
                size, kind = struct.unpack_from("<II", data, at)
                if kind == 0x4E4F534A and text is None:
                    text = data[at + 8:at + 8 + size]
                elif kind == 0x004E4942 and self.chunk is None:
                    self.chunk = data[at + 8:at + 8 + size]
                at += 8 + size
            data = text
        self.root = json.loads(data.decode("utf-8-sig"))
        self.buffers = {}

    def items(self, name):
        return self.root.get(name, [])

    def buffer(self, index):
        if index not in self.buffers:
            uri = self.items("buffers")[index].get("uri")
            if uri is None:
                self.buffers[index] = self.chunk
            elif uri.startswith("data:"):
                self.buffers[index] = base64.b64decode(uri.split(",", 1)[1] + "==")
            else:
                with open(os.path.join(os.path.dirname(self.path), urllib.parse.unquote(uri)), "rb") as file:
                    self.buffers[index] = file.read()
        return self.buffers[index]

    def elements(self, view, offset, count, kind, width):
        view = self.items("bufferViews")[view]
        if "EXT_meshopt_compression" in view.get("extensions", {}) or "KHR_meshopt_compression" in view.get("extensions", {}):
            raise Unread("compressed by meshoptimizer")
        layout = struct.Struct("<" + FORMATS[kind] * width)
        stride = view.get("byteStride", layout.size)
        data = self.buffer(view["buffer"])
        start = view.get("byteOffset", 0) + offset
        return [layout.unpack_from(data, start + i * stride) for i in range(count)]

    def accessor(self, index):
        a = self.items("accessors")[index]
        kind, width, count = a["componentType"], WIDTHS[a["type"]], a["count"]
        if count > 3_000_000:
            raise Unread("too large for Python")
        values = [(0,) * width] * count
        if "bufferView" in a:
            values = self.elements(a["bufferView"], a.get("byteOffset", 0), count, kind, width)
        if "sparse" in a:
            s = a["sparse"]
            i, v = s["indices"], s["values"]
            places = self.elements(i["bufferView"], i.get("byteOffset", 0), s["count"], i["componentType"], 1)
            for (place,), value in zip(places, self.elements(v["bufferView"], v.get("byteOffset", 0), s["count"], kind, width)):
                values[place] = value
        if a.get("normalized"):
            most = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}[kind]
            values = [tuple(max(c / most, -1) for c in value) for value in values]
        return values

    def stated_corners(self, index):
        """Corners of the bounds that the accessor states, for positions that cannot be decoded here."""
        a = self.items("accessors")[index]
        scale = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}[a["componentType"]] if a.get("normalized") else 1
        if "min" not in a:
            raise Unread("compressed positions without bounds")
        return [[c / scale for c in corner] for corner in itertools.product(*zip(a["min"], a["max"]))]

    def joints(self, skin):
        skin = self.items("skins")[skin]
        inverse = [IDENTITY] * len(skin["joints"])
        if "inverseBindMatrices" in skin:
            inverse = self.accessor(skin["inverseBindMatrices"])
        return [multiply(self.world.get(j, IDENTITY), m) for j, m in zip(skin["joints"], inverse)]

    def positions(self, primitive, weights):
        values = self.accessor(primitive["attributes"]["POSITION"])
        for weight, target in zip(weights, primitive.get("targets", [])):
            if weight and "POSITION" in target:
                moved = self.accessor(target["POSITION"])
                values = [tuple(a + weight * b for a, b in zip(v, d)) for v, d in zip(values, moved)]
        return values

    def skinned(self, primitive, values, matrices):
        """Positions by the blended joints, or by the first joint without weights; None without joints."""
        attributes = primitive["attributes"]
        if "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
            return None
        sums = [[0.0] * 16 for _ in values]
        total = [0.0] * len(values)
        first = [joints[0] for joints in self.accessor(attributes["JOINTS_0"])]
        for k in itertools.count():
            if f"JOINTS_{k}" not in attributes or f"WEIGHTS_{k}" not in attributes:
                break
            for i, (joints, weights) in enumerate(zip(self.accessor(attributes[f"JOINTS_{k}"]),
                                                      self.accessor(attributes[f"WEIGHTS_{k}"]))):
                for joint, weight in zip(joints, weights):
                    total[i] += weight
                    if weight:
                        sums[i] = [a + weight * b for a, b in zip(sums[i], matrices[joint])]
        return [transform([m / t for m in s] if t else matrices[f], v) for s, t, f, v in zip(sums, total, first, values)]

    def add(self, primitive, matrix, matrices, weights):
        mode = primitive.get("mode", 4)
        where = primitive["attributes"].get("POSITION")
        if mode < 4 or where is None:
            return
        packed = "KHR_draco_mesh_compression" in primitive.get("extensions", {})
        number = primitive.get("indices")
        corners = self.items("accessors")[where if number is None else number]["count"]
        count = corners // 3 if mode == 4 else max(corners - 2, 0)
        if count == 0:
            return
        try:
            if packed:
                raise Unread("compressed by Draco")
            values = self.positions(primitive, weights)
            used = values if number is None else [values[i] for i, in set(self.accessor(number))]
            if matrices:
                skinned = self.skinned(primitive, values, matrices)
                values, matrix = (skinned, IDENTITY) if skinned else (values, matrix)
                used = values if number is None else [values[i] for i, in set(self.accessor(number))]
        except Unread:
            if matrices or any(weights):
                raise
            self.loose = self.loose or sum(abs(matrix[4 * c + r]) > 1e-12 for c in range(3) for r in range(3)) > 3
            used = self.stated_corners(where)
        if determinant(matrix) == 0:
            return
        self.triangles += count
        for value in used:
            self.box.add(transform(matrix, value))

    def instances(self, node):
        attributes = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        names = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
        columns = {names[key]: self.accessor(index) for key, index in attributes.items() if key in names}
        rows = [dict(zip(columns, row)) for row in zip(*columns.values())]
        return [local(row) for row in rows] or [IDENTITY]

    def place(self, index, parent):
        node = self.items("nodes")[index]
        self.world[index] = multiply(parent, local(node))
        for child in node.get("children", []):
            self.place(child, self.world[index])

    def read(self):
        children = {child for node in self.items("nodes") for child in node.get("children", [])}
        for index in range(len(self.items("nodes"))):
            if index not in children:
                self.place(index, IDENTITY)
        scenes = self.items("scenes")
        queue = [i for i in range(len(self.items("nodes"))) if i not in children]
        if scenes:
            queue = list(scenes[self.root.get("scene", 0)].get("nodes", []))
        while queue:
            index = queue.pop()
            node = self.items("nodes")[index]
            queue += node.get("children", [])
            if "mesh" in node:
                mesh = self.items("meshes")[node["mesh"]]
                matrices = self.joints(node["skin"]) if "skin" in node else None
                for place in self.instances(node):
                    for primitive in mesh["primitives"]:
                        self.add(primitive, multiply(self.world[index], place), matrices,
                                 node.get("weights", mesh.get("weights", [])))
        return self.triangles, self.box.lower, self.box.upper, self.loose


# ---- OBJ ----

def read_obj(data):
    positions, triangles, box = [], 0, Box()
    for line in re.sub(r"\\\r?\n", " ", data.decode("latin-1")).splitlines():
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            positions.append([single(float(word)) for word in words[1:4]])
        elif words[:1] == ["f"] or words[:1] == ["fo"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            if len(corners) > 2:
                triangles += len(corners) - 2
                for corner in corners:
                    box.add(positions[corner - 1 if corner > 0 else corner])
    return triangles, box.lower, box.upper, False


# ---- PLY ----

def ply_rows(data):
    """Elements of a PLY file: name, and one dictionary per row."""
    end = re.search(rb"end_header[^\n\r]*(\r\n|\n|\r)", data)
    elements, form = [], None
    for line in re.split(r"\r\n|\n|\r", data[:end.start()].decode("latin-1")):
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    words, at = None, end.end()
    if form == "ascii":
        words = iter(data[at:].split())
    order = ">" if form == "binary_big_endian" else "<"

    def take(kind):
        nonlocal at
        if words is not None:
            word = next(words)
            return float(word) if PLY_TYPES[kind] in "fd" else int(word)
        (value,) = struct.unpack_from(order + PLY_TYPES[kind], data, at)
        at += struct.calcsize(order + PLY_TYPES[kind])
        return value

    for name, count, properties in elements:
        for _ in range(count):
            yield name, {p[-1]: [take(p[2]) for _ in range(take(p[1]))] if p[0] == "list" else take(p[0]) for p in properties}


def strip_triangles(strip):
    """Triangles of strips that are parted by -1."""
    for _, run in itertools.groupby(strip, lambda index: index < 0):
        run = list(run)
        if run[0] >= 0:
            for i in range(len(run) - 2):
                yield run[i:i + 3]


def read_ply(data):
    positions, triangles, box = [], 0, Box()
    try:
        rows = list(ply_rows(data))
    except (struct.error, StopIteration, RuntimeError):
        raise Unread("cut short") from None
    for name, row in rows:
        if name == "vertex":
            positions.append([single(row[axis]) for axis in "xyz"])
    for point in positions:
        box.add(point)
    for name, row in rows:
        if name == "face":
            corners = row.get("vertex_indices", row.get("vertex_index"))
            triangles += max(len(corners) - 2, 0)
        elif name == "tristrips":
            triangles += sum(len(set(t)) == 3 for t in strip_triangles(row["vertex_indices"]))
    return triangles, box.lower, box.upper, False
