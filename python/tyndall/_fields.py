"""Light in a scene's media: solved once, read as fields and rendered from any camera."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Iterable, NamedTuple, Optional, Sequence, Tuple, Union

from . import _arrays
from ._errors import ArgumentError
from ._image import Image
from ._progress import ProgressChoice, Reporter
from ._volume import Volume, write_volumes

if TYPE_CHECKING:
    from ._gradient import Gradient
    from ._scene import Scene

Vector = Sequence[float]


class Box(NamedTuple):
    """Cells of equal size: lower and upper corner, m, and their number along x, y, z."""

    lower: Tuple[float, float, float]
    upper: Tuple[float, float, float]
    size: Tuple[int, int, int]

    def centers(self, axis: int) -> list[float]:
        """Coordinates of the cells' centres along an axis, m."""
        low, high, count = self.lower[axis], self.upper[axis], self.size[axis]
        return [low + (high - low) * (i + 0.5) / count for i in range(count)]


class Field:
    """Means of a quantity over the cells of a box.

    values: (nz, ny, nx, 3), indexed [z, y, x, channel]; fluxes (nz, ny, nx, 3, 3) have the axes x, y, z behind the
    channels. x, y, z: centres of the cells, m. An array for NumPy.
    """

    def __init__(self, name: str, unit: str, box: Box, memory: Any) -> None:
        self.name = name
        """Such as "fluence"."""
        self.unit = unit
        """Such as "W m^-2"."""
        self.box = box
        """Where the cells are."""
        values = _arrays.view(memory)
        if name == "flux" and _arrays.numpy is not None:
            values = values.reshape(*reversed(box.size), 3, 3)
        self.values = values

    def _axis(self, axis: int) -> Any:
        made = self.box.centers(axis)
        return _arrays.numpy.array(made) if _arrays.numpy is not None else made

    @property
    def x(self) -> Any:
        """Centres of the cells along x, m."""
        return self._axis(0)

    @property
    def y(self) -> Any:
        """Centres of the cells along y, m."""
        return self._axis(1)

    @property
    def z(self) -> Any:
        """Centres of the cells along z, m."""
        return self._axis(2)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Any:
        if dtype is not None and self.values.dtype != dtype:
            return self.values.astype(dtype)
        return self.values.copy() if copy else self.values

    def to_xarray(self) -> Any:
        """An xarray.DataArray with the dimensions z, y, x, channel (and axis), and coordinates in metres."""
        xarray = _arrays.xarray_or_none()
        if xarray is None:
            raise ImportError("to_xarray() needs xarray")
        coords = {"z": self.z, "y": self.y, "x": self.x, "channel": list("RGB")}
        dims = ["z", "y", "x", "channel"]
        if self.name == "flux":
            dims.append("axis")
            coords["axis"] = list("xyz")
        made = xarray.DataArray(self.values, coords, dims, name=self.name, attrs={"units": self.unit})
        for axis in "xyz":
            made[axis].attrs["units"] = "m"
        return made

    def __repr__(self) -> str:
        size = "x".join(str(side) for side in self.box.size)
        return f"<tyndall.Field {self.name}, {size} cells, {self.unit}>"


class Fields:
    """What a box of cells holds.

    fluence: the integral of radiance over all directions, W m^-2. uncollided: its part that did not scatter since a
    light or a surface sent it (with delta scaling, light that scattered nearly straight on counts), or None. flux: the
    net flux vector, W m^-2, of fld alone. variance: variance of fluence, of path alone.
    """

    def __init__(self, box: Box, fluence: Any, uncollided: Any, flux: Any, variance: Any) -> None:
        def field(name: str, unit: str, memory: Any) -> Optional[Field]:
            return Field(name, unit, box, memory) if memory is not None else None

        self.box = box
        self.fluence: Field = Field("fluence", "W m^-2", box, fluence)
        self.uncollided = field("uncollided", "W m^-2", uncollided)
        self.flux = field("flux", "W m^-2", flux)
        self.variance = field("variance", "W^2 m^-4", variance)

    def to_xarray(self) -> Any:
        """An xarray.Dataset of all fields."""
        xarray = _arrays.xarray_or_none()
        if xarray is None:
            raise ImportError("to_xarray() needs xarray")
        parts = (self.fluence, self.uncollided, self.flux, self.variance)
        return xarray.Dataset({part.name: part.to_xarray() for part in parts if part is not None})

    def save(self, path: Union[str, os.PathLike[str]], *, codec: Optional[str] = None) -> None:
        """Writes fluence and uncollided as vectors of red, green and blue, placed in metres, as `tyndall fluence`.

        path: .vti (ParaView) or .vdb. codec: "zip" or "none", of .vdb also "blosc". Needs NumPy.
        """
        spacing = [(high - low) / count for low, high, count in zip(*self.box)]
        if min(spacing) <= 0:
            raise ArgumentError("cells without extent are no voxels")
        origin = [low + step / 2 for low, step in zip(self.box.lower, spacing)]
        parts = (self.fluence, self.uncollided)
        write_volumes(path, {part.name: Volume(part.values, spacing=spacing, origin=origin)
                             for part in parts if part is not None}, codec=codec)

    def __repr__(self) -> str:
        parts = (self.fluence, self.uncollided, self.flux, self.variance)
        return f"<tyndall.Fields {', '.join(part.name for part in parts if part is not None)}>"


def rays_of(points: Any, directions: Any) -> Any:
    """Pairs of points and directions as rows of six numbers."""
    if _arrays.numpy is not None:
        numpy = _arrays.numpy
        where = numpy.atleast_2d(numpy.asarray(points, dtype=numpy.float64))
        along = numpy.atleast_2d(numpy.asarray(directions, dtype=numpy.float64))
        where, along = numpy.broadcast_arrays(where, along)
        if where.shape[-1] != 3:
            raise ArgumentError(f"points of shape {where.shape}, not (count, 3)")
        return numpy.ascontiguousarray(numpy.concatenate([where, along], axis=-1).reshape(-1, 6))
    rows = [list(p) + list(d) for p, d in zip(points, directions)]
    return _arrays.flatten(rows, "rays")


class Light:
    """The light in a scene's media, solved once by Scene.solve(); it outlives changes of the scene.

    method: the method's name. stats: seconds, size (cells), and of the method: converged, iterations or sweeps, emitted,
    absorbed and leaving power (W, per channel).
    """

    def __init__(self, core: Any, scene: "Scene", method: str, stats: dict[str, Any], box: Box, spp: int,
                 seed: int, options: Optional[dict[str, Any]] = None) -> None:
        self._core = core
        self._scene = scene
        self.method = method
        self.stats = stats
        self.box = box
        """The cells of fields() for which no box is given: those of the solve around the scene's bounds."""
        self._spp = spp
        self._seed = seed
        self._options = options or {}

    def fields(self, lower: Optional[Vector] = None, upper: Optional[Vector] = None,
               size: Union[None, int, Sequence[int]] = None, *, progress: ProgressChoice = None) -> Fields:
        """Fluence and the like, means over the cells of a box from lower to upper, m.

        size: cells along x, y, z, or along the longest side. A box without extent along an axis gives means on that
        plane, line or point. By default the box is that of the scene, with cells like those of the solve. By path
        tracing, the scene must not have changed since.
        """
        box = box_of(self.box, lower, upper, size)
        if self._core is not None:
            fluence, uncollided, flux = self._core.fluence(*box)
            return Fields(box, fluence, uncollided, flux, None)
        with Reporter(progress) as report:
            fluence, uncollided, variance = self._scene._core.fluence(*box, self._spp, self._seed, report)
        return Fields(box, fluence, uncollided, None, variance)

    def fluence(self, lower: Optional[Vector] = None, upper: Optional[Vector] = None,
                size: Union[None, int, Sequence[int]] = None, *, progress: ProgressChoice = None) -> Field:
        """The fluence alone, (nz, ny, nx, 3), W m^-2; otherwise as fields()."""
        return self.fields(lower, upper, size, progress=progress).fluence

    def radiance(self, points: Any, directions: Any) -> Any:
        """Radiance at points along directions in which the light travels, (count, 3), W m^-2 sr^-1.

        points: (count, 3), m. directions: (count, 3), of any length; one of the two may be a single one. dom and pop:
        light that scattered at least once. path: all light.
        """
        rays = rays_of(points, directions)
        made = (self._core.radiance(rays) if self._core is not None else
                self._scene._core.radiance(rays, self._spp, self._seed, None))
        return _arrays.view(made[0])

    def gradient(self, weights: Any, lower: Optional[Vector] = None, upper: Optional[Vector] = None,
                 size: Union[None, int, Sequence[int]] = None, *, progress: ProgressChoice = None) -> "Gradient":
        """Derivatives of a loss by densities, coefficients and lights, for the cost of two or three more solves (fld, dom).

        weights: the derivatives of the loss by the values of fluence(lower, upper, size), (nz, ny, nx, 3), or (nz, ny,
        nx) for the sum of the channels. The scene must be the one that was solved. Its light should have converged well:
        solve("fld", tolerance=1e-5), or solve("dom", differentiable=True, tolerance=1e-5). Not for scenes with surfaces, point and area lights, and media that emit
        (docs/gradients.md).
        """
        from ._gradient import Gradient

        if self._core is None:
            raise ArgumentError("gradients are of fld and dom, not of path")
        box = box_of(self.box, lower, upper, size)
        numpy = _arrays.numpy
        given = numpy.asarray(weights, dtype=numpy.float64)
        if given.ndim == 3:
            given = numpy.repeat(given[..., None], 3, axis=-1)
        if given.shape != (*reversed(box.size), 3):
            raise ArgumentError(f"weights of shape {given.shape}, not {(*reversed(box.size), 3)}")
        with self._scene._temporary(self._options):
            with Reporter(progress) as report:
                return Gradient(self._core.gradient(self._scene._core, *box, numpy.ascontiguousarray(given), report))

    def render(self, size: Optional[Tuple[int, int]] = None, *, camera: Optional[dict[str, Any]] = None,
               channels: Union[str, Iterable[str]] = (), spp: Optional[int] = None, seed: Optional[int] = None,
               progress: ProgressChoice = None) -> Image:
        """An image of this light through the scene's camera, or one that replaces keys of it for this call.

        size: (width, height), pixels. spp: samples of surfaces. Media inside dielectrics are not in it; Scene.render()
        has them. The scene must be the one that was solved, or one like it except for its camera.
        """
        scene = self._scene
        if self._core is None:
            return scene.render("path", size=size, camera=camera, channels=channels, spp=spp or self._spp,
                                seed=self._seed if seed is None else seed, progress=progress)
        with scene._temporary({f"camera.{key}": value for key, value in (camera or {}).items()}):
            with Reporter(progress) as report:
                core = self._core.view(scene._core, size or (0, 0), spp or scene.settings["spp"],
                                       self._seed if seed is None else seed, scene._flags(channels), report)
            return Image(core, {"method": self.method}, True, scene._core.camera["exposure"])

    def __repr__(self) -> str:
        return f"<tyndall.Light by {self.method}, {'x'.join(str(side) for side in self.box.size)} cells>"


def box_of(default: Box, lower: Any, upper: Any, size: Any) -> Box:
    """The cells that are asked for."""
    low = tuple(float(v) for v in (default.lower if lower is None else lower))
    high = tuple(float(v) for v in (default.upper if upper is None else upper))
    if len(low) != 3 or len(high) != 3:
        raise ArgumentError("lower and upper have three numbers: x, y and z")
    if size is None and lower is None and upper is None:
        return default
    if size is None:
        size = max(default.size)
    if not hasattr(size, "__len__"):
        sides = [b - a for a, b in zip(low, high)]
        longest = max(sides)
        size = [max(1, round(int(size) * side / longest)) if longest > 0 else 1 for side in sides]
    return Box(low, high, tuple(int(n) for n in size))  # type: ignore
