"""Scenes as files: arrays in memory beside the document, and paths that hold from there."""
from __future__ import annotations

import array
import contextlib
import json
import os
import struct
import sys
from typing import TYPE_CHECKING, Any, Callable, Mapping, Union

from . import _arrays, _core
from ._errors import ArgumentError
from ._image import Image, png_file
from ._volume import Mesh, Volume

if TYPE_CHECKING:
    from ._scene import Scene

_COLORS = ("base_color", "emission")  # textures of colours, which files hold in sRGB
_FLOAT, _UINT = 5126, 5125  # component types of glTF


def texture_key(path: str) -> str:
    """The key of a texture of a material that a path of the document is of; "" of other paths."""
    steps = path.replace("[", ".[").split(".")
    if "material" not in steps:
        return ""
    keys = [step for step in steps[steps.index("material") + 1:] if step != "file"]
    return keys[0] if keys else ""


def texture_of(value: Any, key: str) -> Image:
    """An image of an array (height, width), or (height, width, 1, 3 or 4): integers are those of a file, sRGB for colours,
    and floats are linear, 0..1."""
    numpy = _arrays.numpy
    if numpy is None:
        raise TypeError(f"{key}: textures of arrays need NumPy")
    made = numpy.asarray(_arrays.to_input(value, key))
    if made.ndim == 2:
        made = made[..., None]
    if made.ndim != 3 or made.shape[2] not in (1, 3, 4):
        raise ArgumentError(f"{key}: a texture of shape {made.shape}, not (height, width) or (height, width, 3 or 4)")
    whole = made.dtype.kind in "ui"
    planes = made.astype(numpy.float32) / (numpy.iinfo(made.dtype).max if whole else 1)
    if planes.shape[2] == 1:
        planes = numpy.repeat(planes, 3, axis=2)
    if whole and key in _COLORS:
        colors = planes[..., :3]
        planes[..., :3] = numpy.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    return Image({name: planes[..., c] for c, name in enumerate("RGBA"[:planes.shape[2]])})


def _write_texture(image: Image, key: str, path: str) -> None:
    """A PNG file of 8 bits as the scene's own texture has."""
    numpy = _arrays.numpy
    if numpy is None:
        raise ArgumentError("textures in memory are written with NumPy")
    alpha = "A" in image.channels
    values = numpy.concatenate([image.rgb, image["A"][..., None]], axis=2) if alpha else image.rgb
    bytes8 = (255 * numpy.clip(numpy.nan_to_num(values), 0, 1) + 0.5).astype(numpy.uint8)
    if key in _COLORS:
        bytes8[..., :3] = image.tonemapped(0, "clip")
    _write(path, png_file(image.width, image.height, 4 if alpha else 3, bytes8.tobytes()))


def _write(path: str, data: bytes) -> None:
    """Writes a file completely or not at all."""
    temporary = f"{path}.{os.getpid()}.tmp"
    try:
        with open(temporary, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _flat(value: Any, code: str) -> array.array[Any]:
    """Numbers of an array of any shape."""
    if _arrays.numpy is not None:
        kind = _arrays.numpy.float32 if code == "f" else _arrays.numpy.uint32
        return array.array(code, _arrays.numpy.ascontiguousarray(value, dtype=kind).tobytes())
    return array.array(code, (int(v) if code == "I" else v for v in _arrays.flatten(value, "mesh")))


def _upright(values: array.array[Any]) -> array.array[Any]:
    """Vectors of a scene with z up as glTF has them, which is turned when it is read: (x, y, z) from (x, z, -y)."""
    made = array.array("f", values)
    made[1::3], made[2::3] = values[2::3], array.array("f", (-v for v in values[1::3]))
    return made


def _write_mesh(mesh: Mesh, z_up: bool, path: str) -> None:
    """A .glb file: the mesh with its texture coordinates as both sets."""
    turn: Callable[[Any], Any] = _upright if z_up else lambda values: values
    parts = [("POSITION", "VEC3", 3, turn(_flat(mesh.positions, "f")))]
    if mesh.normals is not None:
        parts.append(("NORMAL", "VEC3", 3, turn(_flat(mesh.normals, "f"))))
    if mesh.uv is not None:
        parts += [(f"TEXCOORD_{i}", "VEC2", 2, _flat(mesh.uv, "f")) for i in range(2)]
    if mesh.colors is not None:
        parts.append(("COLOR_0", "VEC4", 4, _flat(mesh.colors, "f")))
    corners = _flat(mesh.triangles, "I")
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    data = b""
    for _, kind, width, values in [*parts, ("", "SCALAR", 1, corners)]:
        if sys.byteorder == "big":
            values.byteswap()
        body = values.tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(body)})
        accessors.append({"bufferView": len(views) - 1, "componentType": _UINT if width == 1 else _FLOAT,
                          "count": len(values) // width, "type": kind})
        data += body
    positions = parts[0][3]
    accessors[0]["min"] = [min(positions[axis::3]) for axis in range(3)]
    accessors[0]["max"] = [max(positions[axis::3]) for axis in range(3)]
    primitive = {"attributes": {part[0]: i for i, part in enumerate(parts)}, "indices": len(parts), "material": 0}
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0, "name": "mesh"}], "meshes": [{"name": "mesh", "primitives": [primitive]}],
                "materials": [{"doubleSided": True}], "accessors": accessors, "bufferViews": views,
                "buffers": [{"byteLength": len(data)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    _write(path, struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A) + text +
           struct.pack("<II", len(data), 0x004E4942) + data)


def _write_volume(volume: Volume, path: str) -> dict[str, Any]:
    """The keys of the document for the written volume."""
    info = volume.info
    if info["placed"]:
        volume.save(path + ".vdb", "values")
        return {"file": path + ".vdb", "grid": "values"}
    if len(volume._grids) != 1:
        raise ArgumentError("a volume of three values per voxel without spacing is in no file; give it spacing")
    _write(path + ".raw", _flat(volume.values, "f").tobytes())
    return {"file": path + ".raw", "raw": {"size": list(info["size"]), "type": "float",
                                           "big_endian": sys.byteorder == "big"}}


class _Writer:
    """Walks a document, writes its arrays to a folder, and turns its paths."""

    def __init__(self, scene: "Scene", folder: str, name: str) -> None:
        self.given: Mapping[str, Any] = scene._given
        self.source = os.path.abspath(scene._folder)
        self.folder = folder
        self.name = name
        self.z_up = scene.get("up_axis", "y") == "z"
        self.written: dict[str, dict[str, Any]] = {}

    def _content(self, name: str, path: str) -> dict[str, Any]:
        """The keys that name the file of content in memory."""
        key = texture_key(path)
        if (name, key) in self.written:
            return dict(self.written[name, key])
        value = self.given[name]
        local = f"{self.name}.files/{len(self.written)}"
        target = os.path.join(self.folder, local)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        if isinstance(value, Volume):
            keys = _write_volume(value, target)
        elif isinstance(value, Mesh):
            _write_mesh(value, self.z_up, target + ".glb")
            keys = {"file": target + ".glb"}
        elif key:
            _write_texture(value, key, target + ".png")
            keys = {"file": target + ".png"}
        else:
            value.save(target + ".exr")
            keys = {"file": target + ".exr"}
        keys["file"] = local + os.path.splitext(keys["file"])[1]
        self.written[name, key] = keys
        return dict(keys)

    def _file(self, value: str) -> str:
        if os.path.isabs(value) or os.path.abspath(self.folder) == self.source:
            return value
        whole = os.path.join(self.source, value)
        inside = os.path.relpath(whole, self.folder)
        return whole if inside.startswith("..") else inside

    def walk(self, value: Any, path: str) -> Any:
        if isinstance(value, list):
            return [self.walk(part, f"{path}[{i}]") for i, part in enumerate(value)]
        if not isinstance(value, dict):
            return value
        file = value.get("file")
        made = {key: self.walk(part, f"{path}.{key}") for key, part in value.items()}
        if not isinstance(file, str):
            return made
        if not file.startswith("memory:"):
            return {**made, "file": self._file(file)}
        made.update(self._content(file[len("memory:"):], path))
        if path.startswith(".geometry[") and path.endswith("]"):
            made.setdefault("material", {"base_color": 0.5})  # that of a mesh in memory
        return made


def save_scene(scene: "Scene", path: Union[str, os.PathLike[str]]) -> None:
    """Writes the document as a scene file and its arrays to the folder NAME.files beside it."""
    whole = os.fspath(path)
    folder, base = os.path.split(os.path.abspath(whole))
    document = _Writer(scene, folder, os.path.splitext(base)[0]).walk(scene.document, "")
    _write(whole, (json.dumps(document, indent=2) + "\n").encode())
