"""Volumes and meshes of arrays and files."""
from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Sequence, Tuple, Union

from . import _arrays, _core
from ._context import default_context
from ._errors import ArgumentError

Vector = Sequence[float]


class Volume:
    """Values on a regular grid of voxels, for the density, albedo, g or temperature of a medium.

    values: (nz, ny, nx), indexed [z, y, x], x fastest; or (nz, ny, nx, 3) of red, green and blue. float32 in C order is
    borrowed, not copied: it must not change as long as the volume, or a scene that has it, lives. Other types, orders
    and values that are not all finite are copied (NaN and infinities become 0, with a warning in the log). Taken are
    NumPy arrays, torch tensors of the host, xarray.DataArrays, and any other object with the buffer protocol or DLPack.

    spacing: distance of voxels along x, y, z, or one number for all, m (in a scene file's sense: units of
    meters_per_unit). origin: centre of the voxel [0, 0, 0] as x, y, z, m. Without spacing the volume fills the bounds of
    the medium that uses it. A DataArray with dimensions called x, y and z is put in order, and takes spacing and origin
    from its coordinates, unless they are given. transform: 12 numbers in place of both, the rows of a 3 x 4 map from
    voxel indices (i along x, j, k) to metres. background: value outside of a placed volume.
    """

    def __init__(self, values: Any, *, spacing: Union[None, float, Vector] = None, origin: Optional[Vector] = None,
                 transform: Optional[Sequence[float]] = None, background: float = 0.0,
                 context: Optional[_core.Context] = None) -> None:
        if hasattr(values, "dims") and hasattr(values, "coords"):
            values, spacing, origin = _from_xarray(values, spacing, origin)
        placement = _placement(spacing, origin, transform)
        context = context or default_context()
        axes = _arrays.axes_of(values)
        if axes == 4 and values.shape[3] == 3:
            parts = _arrays.split_channels(values)
        elif axes == 3:
            parts = [_arrays.to_input(values, "volume")]
        else:
            raise ArgumentError(f"a volume has the axes z, y, x, or these and 3 channels; this array has "
                                f"{axes} axes")
        self._grids: Tuple[Any, ...] = tuple(_core.grid_create(context, part, placement, background) for part in parts)

    @classmethod
    def _of(cls, grids: Tuple[Any, ...]) -> "Volume":
        volume = cls.__new__(cls)
        volume._grids = grids
        return volume

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]], grid: Optional[str] = None, *, component: int = 0, frame: int = 0,
             raw: Optional[dict[str, Any]] = None, series: str = "",
             effective_radius: Union[None, str, float] = None, air_density: Union[None, str, float] = None,
             meters_per_unit: float = 1.0, context: Optional[_core.Context] = None) -> "Volume":
        """Reads a file of one of the formats of docs/formats.md, or a raw file.

        grid: name of the grid in OpenVDB, NanoVDB, VTK and NetCDF files; default "density", or, in VTK and NetCDF files
        without it, the active or the only one. component: of files with several values per voxel. frame: replaces # in
        the file's name. raw: layout of a raw file, {"size": (nx, ny, nz), "type": "uint8", "big_endian": False,
        "offset": 0, "spacing": (dx, dy, dz)}. series: of a folder of DICOM files, its number, description or UID.

        effective_radius: of a NetCDF file of liquid water, which becomes the extinction of its droplets, 1/m: the name of a
        variable, or micrometres. air_density: of water per mass of air, the name of a variable, or kg m^-3. A scene's key
        `droplets` does the same and lets the medium scatter as such droplets. meters_per_unit: of NetCDF's placement.
        """
        name = os.fspath(path)
        layout = None
        if raw is not None:
            unknown = set(raw) - {"size", "type", "big_endian", "offset", "spacing"}
            if unknown or "size" not in raw:
                raise ArgumentError(f"raw: {'unknown ' + sorted(unknown)[0] if unknown else 'size is missing'}")
            layout = (tuple(raw["size"]), raw.get("type", "uint8"), bool(raw.get("big_endian", False)),
                      int(raw.get("offset", 0)), tuple(raw.get("spacing", (0.0, 0.0, 0.0))))
        more = (series, _companion(effective_radius), _companion(air_density), float(meters_per_unit))
        return cls._of((_core.volume_read(context or default_context(), name, grid, component, frame, layout, more),))

    def save(self, path: Union[str, os.PathLike[str]], grid: str = "density", *, codec: Optional[str] = None) -> None:
        """Writes .vdb, .nvdb, .nrrd, .vti, .vol, .nii or .nii.gz; of three values per voxel .vdb, .vti or .nii.

        grid: name of the grid. codec: "none", "zip" (.vdb, .nvdb, .vti), "blosc" (.vdb) or "gzip" (.nrrd); default: the
        format's compression.
        """
        write_volumes(path, {grid: self}, codec=codec)

    @property
    def info(self) -> dict[str, Any]:
        """size (nx, ny, nz), type, placed, background, min, max, mean, bytes and placement (12 numbers)."""
        return self._grids[0].info

    @property
    def values(self) -> Any:
        """The values, (nz, ny, nx), a read-only view; of volumes of three, those of red."""
        return _arrays.view(self._grids[0].values)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Any:
        made = self.values
        if dtype is not None and made.dtype != dtype:
            return made.astype(dtype)
        return made.copy() if copy else made

    def __repr__(self) -> str:
        info = self.info
        size = "x".join(str(side) for side in info["size"])
        return f"<tyndall.Volume {size}, {info['min']:g}..{info['max']:g}{', placed' if info['placed'] else ''}>"


def write_volumes(path: Union[str, os.PathLike[str]], volumes: Mapping[str, Volume], *,
                  codec: Optional[str] = None, context: Optional[_core.Context] = None) -> None:
    """Writes volumes by their names to one file: .vdb any, .vti those of one size and placement, other formats one."""
    fields = tuple((name, volume._grids) for name, volume in volumes.items())
    _core.volume_write(context or default_context(), os.fspath(path), codec, fields)


def _companion(value: Union[None, str, float]) -> Tuple[Optional[str], float]:
    """The name of a variable, or a number in its place."""
    return (value, 0.0) if value is None or isinstance(value, str) else (None, float(value))


def _step(coordinate: Any, name: str) -> float:
    numbers = [float(value) for value in coordinate]
    if len(numbers) < 2:
        raise ArgumentError(f"the coordinate {name} has one value, which gives no spacing: give it by spacing=")
    step = (numbers[-1] - numbers[0]) / (len(numbers) - 1)
    if any(abs(number - (numbers[0] + i * step)) > 1e-3 * abs(step) for i, number in enumerate(numbers)) or step == 0:
        raise ArgumentError(f"the coordinate {name} is not evenly spaced; interpolate the array first")
    return step


def _from_xarray(array: Any, spacing: Any, origin: Any) -> Tuple[Any, Any, Any]:
    """Values in the order z, y, x, with spacing and origin from the coordinates."""
    if not {"x", "y", "z"} <= set(array.dims):
        return array.values, spacing, origin
    others = [dim for dim in array.dims if dim not in ("x", "y", "z")]
    array = array.transpose("z", "y", "x", *others)
    if spacing is None and all(dim in array.coords for dim in ("x", "y", "z")):
        spacing = [_step(array.coords[dim].values, dim) for dim in ("x", "y", "z")]
        if origin is None:
            origin = [float(array.coords[dim].values[0]) for dim in ("x", "y", "z")]
    return array.values, spacing, origin


def _placement(spacing: Any, origin: Any, transform: Any) -> Optional[Tuple[float, ...]]:
    if transform is not None:
        numbers = tuple(float(v) for row in transform for v in (row if hasattr(row, "__len__") else (row,)))
        if len(numbers) != 12:
            raise ArgumentError(f"transform: {len(numbers)} numbers, not 12")
        return numbers
    if spacing is None:
        if origin is not None:
            raise ArgumentError("origin needs spacing")
        return None
    steps = tuple(spacing) if hasattr(spacing, "__len__") else (spacing,) * 3
    start = tuple(origin) if origin is not None else (0.0, 0.0, 0.0)
    if len(steps) != 3 or len(start) != 3:
        raise ArgumentError("spacing and origin are one number, or three: x, y and z")
    return tuple(float(steps[r]) if c == r else float(start[r]) if c == 3 else 0.0 for r in range(3) for c in range(4))


class Mesh:
    """Triangles, for the geometry of a scene, or the bounds of a medium if they are closed; the scene copies them.

    positions: (n, 3), m. triangles: (m, 3) indices of vertices, counter-clockwise seen from the front. normals: (n, 3),
    for smooth shading. uv: (n, 2), for lightmaps and textures. colors: (n, 4), linear R, G, B and alpha.
    """

    def __init__(self, positions: Any, triangles: Any, *, normals: Any = None, uv: Any = None, colors: Any = None) -> None:
        self.positions = _arrays.to_input(positions, "positions")
        self.triangles = _indices(triangles)
        self.normals = _arrays.to_input(normals, "normals") if normals is not None else None
        self.uv = _arrays.to_input(uv, "uv") if uv is not None else None
        self.colors = _arrays.to_input(colors, "colors") if colors is not None else None


def _indices(triangles: Any) -> Any:
    if _arrays.numpy is not None:
        return _arrays.to_input(triangles, "triangles")
    import array

    flat = _arrays.flatten(triangles, "triangles") if isinstance(triangles, (list, tuple)) else triangles
    return array.array("q", (int(value) for value in flat)) if flat is not triangles else triangles


def info(path: Union[str, os.PathLike[str]], *, context: Optional[_core.Context] = None) -> dict[str, Any]:
    """What a file holds: the grids of an OpenVDB, NanoVDB, VTK or NetCDF file, the volume of another volume file, the
    content of a mesh file, size, channels and metadata of an image, or counts, bounds and memory of a scene ("builtin:NAME",
    too).
    """
    name = os.fspath(path)
    kind = os.path.splitext(name)[1].lower()
    context = context or default_context()
    if kind in (".vdb", ".nvdb", ".vti", ".vtk", ".nc", ".cdf"):
        return {"grids": _core.volume_list(context, name)}
    if kind in (".gltf", ".glb", ".obj", ".ply"):
        return _core.mesh_list(context, name)
    if kind in (".nrrd", ".nhdr", ".nii", ".gz", ".tif", ".tiff", ".vol", ".dcm"):
        return {"grids": [Volume.read(name, context=context).info]}
    if kind in (".exr", ".hdr", ".png", ".jpg", ".jpeg", ".webp"):
        from ._image import Image

        image = Image.read(name, context=context)
        return {"size": image.size, "channels": image.channels, "metadata": image.metadata}
    if kind == ".json" or name.startswith("builtin:"):
        from ._scene import Scene

        return Scene(name, context=context).info
    raise ArgumentError(f"{name}: info() reads volumes, meshes, images and scenes")
