"""Scenes: documents with media, lights, surfaces and a camera, and what can be made of them."""
from __future__ import annotations

import contextlib
import itertools
import json
import os
import re
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Sequence, Tuple, Union

from . import _arrays, _core
from ._context import default_context
from ._errors import ArgumentError, InputError, OutOfMemory, Unsupported
from ._fields import Box, Light
from ._flux import Flux
from ._image import Image, word
from ._progress import ProgressChoice, Reporter
from ._saved import save_scene, texture_key, texture_of
from ._volume import Mesh, Volume

CHANNELS = {"variance": 1, "transmittance": 2, "depth": 4, "normal": 8, "albedo": 16, "single": 32, "multiple": 64,
            "samples": 128, "surface_albedo": 512, "half": 256, "all": 255 | 512}
"""Layers that render() adds to R, G, B, and their flags in the C API."""

DENOISE_CHANNELS = ("variance", "transmittance", "depth", "normal", "albedo", "single", "multiple", "surface_albedo",
                    "half")
"""The channels that Image.denoise() uses."""

_SPP_MAX = 1 << 24
_ASK_CROP, _ASK_TIME, _ASK_ERROR, _ASK_RESUME, _ASK_SAMPLES = 1, 2, 4, 8, 16
_BAKE_METHODS = {"cache": 0, "impulse": 1, "attenuation": 2, "surfaces": 3, "path": 4}
_STEP = re.compile(r"([A-Za-z_]\w*)|\[(\d+)\]")
_MEMORY = re.compile(r'"memory:([\w.-]+)"')
_numbers = itertools.count(1)


def _steps(path: str) -> list[Union[str, int]]:
    """The keys and indices of "media[0].g"."""
    steps: list[Union[str, int]] = []
    at = 0
    while at < len(path):
        if steps and path[at] == ".":
            at += 1
        found = _STEP.match(path, at)
        if not found:
            raise ArgumentError(f"{path}: expected a path such as media[0].g")
        steps.append(found[1] if found[1] else int(found[2]))
        at = found.end()
    return steps


class Scene:
    """A scene: a document as docs/scene.md describes it, and what it names.

    source: path of a scene file, "builtin:NAME", or a document as a dict; None: an empty scene. Values of a dict, and
    those that are set later, may be arrays, Volumes, Meshes and Images wherever the document may name a file. overrides:
    values to set before the document is checked, {"media[0].g": 0.5} or ["media[0].g=0.5"]. folder: where relative paths
    of a dict begin; default the current folder.

        scene = tyndall.Scene("builtin:cloud_sun")
        scene["media[0].g"] = 0.5                 # reads nothing again but what depends on it
        scene["media[0].density"] = array         # (nz, ny, nx), borrowed
        image = scene.render("dom", size=(320, 240))

    A scene is used by one thread at a time, except that several may render it at once; changes while it is rendered are
    refused.
    """

    def __init__(self, source: Union[None, str, os.PathLike[str], Mapping[str, Any]] = None, *,
                 overrides: Union[None, Mapping[str, Any], Sequence[str]] = None,
                 folder: Union[None, str, os.PathLike[str]] = None, context: Optional[_core.Context] = None) -> None:
        self.context = context or default_context()
        """The threads and the device that it is rendered with."""
        self._given: dict[str, Any] = {}  # content in memory by its name
        self._folder = os.fspath(folder) if folder is not None else ""
        if source is None or isinstance(source, Mapping):
            self._core = _core.Scene(self.context, None, '{"tyndall":1}', "scene", self._folder, ())
            document = dict(source or {})
            document.pop("tyndall", None)
            changes = dict(document)
            changes.update(_override_items(overrides))
            if changes:
                self.update(changes)
            return
        if folder is not None:
            raise ArgumentError("folder is for documents; files have their own")
        items = tuple(f"{key}={json.dumps(value)}" for key, value in _override_items(overrides).items())
        path = os.fspath(source)
        self._core = _core.Scene(self.context, path, None, None, None, items)
        self._folder = "" if path.startswith("builtin:") else os.path.dirname(path)

    def copy(self) -> "Scene":
        """Another scene with the same document, which shares the arrays: for threads that change theirs, and sweeps."""
        made = Scene(None, folder=self._folder, context=self.context)
        for name, value in self._given.items():
            made._set_memory(name, value)
        made._given = dict(self._given)
        document = self.document
        document.pop("tyndall", None)
        made._apply([(key, json.dumps(value)) for key, value in document.items()])
        return made

    # ---- the document ----

    @property
    def document(self) -> dict[str, Any]:
        """A copy of the document, as loaded from JSON."""
        return json.loads(self._core.text)

    def __getitem__(self, path: str) -> Any:
        value: Any = self.document
        for step in _steps(path):
            try:
                value = value[step]
            except (KeyError, IndexError, TypeError):
                raise KeyError(path) from None
        return value

    def __contains__(self, path: object) -> bool:
        try:
            self[str(path)]
        except KeyError:
            return False
        return True

    def __setitem__(self, path: str, value: Any) -> None:
        self.update({path: value})

    def __delitem__(self, path: str) -> None:
        self[path]
        self._apply([(path, None)])

    def get(self, path: str, default: Any = None) -> Any:
        """The value at a path, or a default."""
        try:
            return self[path]
        except KeyError:
            return default

    def update(self, changes: Mapping[str, Any]) -> None:
        """Sets many values, in their order, or none: after an error the scene is as before."""
        given: dict[str, Any] = {}
        try:
            self._apply([(path, json.dumps(self._plain(value, path, given))) for path, value in changes.items()])
        finally:
            self._drop_unused(given)

    def _apply(self, changes: Sequence[Tuple[str, Optional[str]]]) -> int:
        return self._core.apply(tuple(part if part is not None else "null" for change in changes for part in change))

    def _drop_unused(self, given: Mapping[str, Any]) -> None:
        """Forgets arrays that the document does not name any more."""
        named = set(_MEMORY.findall(self._core.text))
        kept = {**self._given, **given}
        for name in set(kept) - named:
            self._core.drop(name)
        self._given = {name: value for name, value in kept.items() if name in named}

    def _set_memory(self, name: str, value: Union[Volume, Mesh, Image]) -> None:
        if isinstance(value, Volume):
            self._core.set_volume(name, value._grids)
        elif isinstance(value, Mesh):
            self._core.set_mesh(name, value.positions, value.triangles, value.normals, value.uv, value.colors)
        else:
            self._core.set_image(name, value._core)

    def _give(self, value: Any, path: str, given: dict[str, Any]) -> Optional[str]:
        """Hands arrays, volumes, meshes and images over; "memory:NAME", or None for other values."""
        if not isinstance(value, (Volume, Mesh, Image)):
            texture = texture_key(path)
            if not (_arrays.is_array(value) and _arrays.axes_of(value) >= (2 if texture else 3)):
                return None
            value = texture_of(value, texture) if texture else Volume(value, context=self.context)
        name = f"array{next(_numbers)}"
        self._set_memory(name, value)
        given[name] = value
        return f"memory:{name}"

    def _plain(self, value: Any, path: str, given: dict[str, Any]) -> Any:
        """The value as JSON has it."""
        name = self._give(value, path, given)
        if name is not None:
            return name if path.endswith("file") else {"file": name}
        if isinstance(value, Mapping):
            return {key: self._plain(part, f"{path}.{key}", given) for key, part in value.items()}
        if isinstance(value, (list, tuple)):
            return [self._plain(part, path, given) for part in value]
        if value is None or isinstance(value, (str, bool, int, float)):
            return value
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        plain = _arrays.to_plain(value)
        if plain is None:
            raise TypeError(f"{path}: a {type(value).__name__} is no value of a scene")
        return plain

    @contextlib.contextmanager
    def _temporary(self, values: Mapping[str, Any]) -> Iterator[None]:
        """Values of the document for one call, which is not in use by others meanwhile."""
        if not values:
            yield
            return
        missing = object()
        roots = {path.split(".")[0] for path in values}
        whole = {root: self.get(root, missing) for root in roots}
        self.update(values)
        try:
            yield
        finally:
            self._apply([(root, None if old is missing else json.dumps(old)) for root, old in whole.items()])

    def add_medium(self, **keys: Any) -> str:
        """Adds a medium; its path, such as "media[0]". keys: those of docs/scene.md (density, bounds, sigma_t, ...)."""
        return self._append("media", keys)

    def add_light(self, type: str, **keys: Any) -> str:
        """Adds a light; its path. type: "directional", "point", "spot", "area" or "environment"."""
        return self._append("lights", {"type": type, **keys})

    def add_geometry(self, mesh: Union[None, Mesh, str, os.PathLike[str]] = None, **keys: Any) -> str:
        """Adds a mesh, or with keys quad, box or sphere a shape; its path."""
        return self._append("geometry", {"file": mesh, **keys} if mesh is not None else keys)

    def _append(self, section: str, item: Mapping[str, Any]) -> str:
        path = f"{section}[{len(self.get(section, []))}]"
        self[path] = item
        return path

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the document as a scene file, completely or not at all.

        Arrays in memory are written to the folder NAME.files beside it: volumes as .vdb, or .raw without spacing, meshes
        as .glb, textures as .png and maps of environments as .exr. Relative paths are turned to hold from there.
        """
        save_scene(self, path)

    # ---- facts ----

    @property
    def info(self) -> dict[str, Any]:
        """Counts of media, lights, shapes, meshes and triangles; lower and upper corner, m; bytes of memory."""
        return self._core.info

    @property
    def camera(self) -> dict[str, Any]:
        """position, target, up (m), fov_y (degrees), resolution (pixels) and exposure (stops)."""
        return self._core.camera

    @property
    def settings(self) -> dict[str, Any]:
        """method, spp and seed that the document asks for."""
        return self._core.settings

    @property
    def hash(self) -> str:
        """Hash of the document and the content of all that it names, as EXR files have it."""
        return self._core.hash

    def __repr__(self) -> str:
        info = self.info
        return f"<tyndall.Scene {info['media']} media, {info['lights']} lights, {info['shapes'] + info['meshes']} surfaces>"

    # ---- rendering ----

    @staticmethod
    def _flags(channels: Union[str, Iterable[str]]) -> int:
        names = channels.split(",") if isinstance(channels, str) else channels
        flags = 0
        for name in names:
            flags |= word(name.strip(), CHANNELS, "channels")
        return flags

    def choose(self, *, size: Optional[Tuple[int, int]] = None, spp: Optional[int] = None,
               channels: Union[str, Iterable[str]] = (), seconds: float = 0, error: float = 0,
               crop: Optional[Sequence[int]] = None, state: bool = False) -> dict[str, Any]:
        """The method that `auto` takes: method, reason, expected relative error, and seconds (of one thread)."""
        asks = ((_ASK_CROP if crop else 0) | (_ASK_TIME if seconds else 0) | (_ASK_ERROR if error else 0) |
                (_ASK_RESUME if state else 0) | (_ASK_SAMPLES if spp is not None else 0))
        samples = spp if spp is not None else _SPP_MAX if seconds or error else self.settings["spp"]
        made = self._core.choose(asks, self._flags(channels), size or (0, 0), samples)
        return dict(zip(("method", "reason", "error", "seconds"), made))

    def render(self, method: Optional[str] = None, *, size: Optional[Tuple[int, int]] = None, spp: Optional[int] = None,
               seed: Optional[int] = None, seconds: float = 0.0, error: float = 0.0,
               crop: Optional[Sequence[int]] = None, channels: Union[str, Iterable[str]] = (),
               camera: Optional[Mapping[str, Any]] = None, frame: Optional[int] = None, state: Union[None, str, os.PathLike[str]] = None,
               partial: Optional[Callable[[Image], Any]] = None, progress: ProgressChoice = None,
               on_interrupt: str = "raise", **options: Any) -> Image:
        """Renders the scene through its camera: radiance, W m^-2 sr^-1, and the channels that are asked for.

        method: "path", "dom", "fld", "cda", "pop", "lpv", "octaves", "screen", or "auto", which chooses; default that of
        the document. size: (width, height), pixels. spp: samples per pixel (of methods other than path: of surfaces).
        seed: of random numbers. seconds, error: path stops at this time, s, or relative error. crop: (x, y, width,
        height). channels: layers such as "depth" and "variance" (tyndall.CHANNELS). camera: keys of the camera for this
        call alone, such as {"position": (0, 1, 5)}. frame: the number that stands for #s in the names of volumes, for this
        call alone. options: those of the method, as docs/method lists them, for this
        call alone: render("dom", directions=48).

        state: a file of path to go on from, if it is there, and to keep up to date: the same call goes on where the last
        one was interrupted, and ends with the same image. `tyndall render --resume` has the same file beside its image,
        IMAGE.state. It adds the channel samples.N.

        partial: a function that receives images so far of path, about once a second, whose answer False stops the work.
        progress: a function of tyndall.Progress, whose answer False stops the work; True or False: a bar or none;
        default: a bar in terminals and notebooks. Ctrl-C, or "interrupt" in a notebook, cancels: the KeyboardInterrupt
        has the partial image of path as its attribute `image` (None of methods without one), as has an exception of these
        functions; with on_interrupt="return" an interrupt returns that image instead. A partial image has complete ==
        False.
        """
        if on_interrupt not in ("raise", "return"):
            raise ArgumentError(f"on_interrupt: {on_interrupt!r} is not \"raise\" or \"return\"")
        settings = self.settings
        name = method or settings["method"]
        samples = spp if spp is not None else _SPP_MAX if seconds or error else settings["spp"]
        given = int(settings["seed"] if seed is None else seed)
        flags = self._flags(channels) | (CHANNELS["samples"] if state is not None else 0)
        changes = {f"camera.{key}": value for key, value in (camera or {}).items()}
        if frame is not None:
            changes["frame"] = int(frame)
        if options and name == "auto":
            raise ArgumentError(f"{next(iter(options))}: options are those of one method: name it")
        changes.update({f"render.{options_of(name)}.{key}": value for key, value in options.items()})
        with self._temporary(changes):
            choice: dict[str, Any] = {}
            if name == "auto":
                choice = self.choose(size=size, spp=spp if method is None else None, channels=channels, seconds=seconds,
                                     error=error, crop=crop, state=state is not None)
                name = choice["method"]

            show = None if partial is None else lambda core: partial(Image(core, {}, False, self._core.camera["exposure"]))

            def run(by: str) -> Image:
                with Reporter(progress) as report:
                    made = self._core.render(by, samples, given, float(seconds), float(error), size or (0, 0),
                                             tuple(crop or (0, 0, 0, 0)), flags,
                                             os.fspath(state) if state is not None else None, show, report)
                return self._image(by, given, choice, made)

            try:
                try:
                    return run(name)
                except InputError as wrong:  # what a state holds
                    if state is None or wrong.file is not None:
                        raise
                    raise InputError(f"{os.fspath(state)}: {wrong}; remove it to start again", wrong.code) from None
                except (ArgumentError, Unsupported, OutOfMemory) as refusal:
                    if not choice or name == "path":
                        raise
                    choice = {"reason": f"{name} refused: {refusal}"}
                    return run("path")
            except BaseException as stop:
                made = getattr(stop, "image", None)
                image = self._image(name, given, choice, made) if isinstance(made, tuple) else None
                interrupted = isinstance(stop, KeyboardInterrupt)
                if interrupted or image is not None:
                    stop.image = image  # type: ignore[attr-defined]
                if interrupted and on_interrupt == "return" and image is not None:
                    return image
                raise

    def frames(self, numbers: Iterable[int], method: Optional[str] = None,
               **keywords: Any) -> Iterator[Tuple[int, Image]]:
        """Renders a sequence: pairs of a frame's number and its image, one after the other.

        The scene's volumes have #s in the names of their files, which the number takes the place of. keywords: those of
        render(). Each frame is solved from nothing; `tyndall render --frames` (tyndall.run("render", scene,
        output="plume_####.exr", frames="1-240")) starts dom from the frame before, keeps what is finished, and divides
        the frames among machines.
        """
        for number in numbers:
            yield number, self.render(method, frame=number, **keywords)

    def _image(self, method: str, seed: int, choice: Mapping[str, Any], made: Tuple[Any, dict[str, Any], int]) -> Image:
        """The image of a call, with the metadata of `tyndall render`."""
        core, stats, complete = made
        camera = self._core.camera
        texts = {"tyndall.version": _core.version, "tyndall.method": method, "tyndall.scene": self.hash,
                 "tyndall.seed": str(seed)}
        numbers = {f"tyndall.{key}": stats[key] for key in ("spp", "seconds", "own_seconds", "error", "error_pixels")}
        numbers["tyndall.complete"] = float(complete)
        for key, value in {**texts, **numbers}.items():
            core.set_metadata(key, value)
        if choice:
            core.set_metadata("tyndall.choice", choice["reason"])
            if choice.get("seconds"):
                core.set_metadata("tyndall.expected_error", choice["error"])
                core.set_metadata("tyndall.expected_seconds", choice["seconds"] / self.context.threads)
        core.set_metadata("tyndall.camera.fov_y", camera["fov_y"])
        return Image(core, {"method": method, **({"choice": choice["reason"]} if choice else {}), **stats},
                     bool(complete), camera["exposure"])

    # ---- light ----

    def solve(self, method: str = "dom", *, spp: Optional[int] = None, seed: Optional[int] = None,
              progress: ProgressChoice = None, **options: Any) -> Light:
        """Solves for the light in the media once, for fluence in cells, radiance along rays, and images.

        method: "dom", "fld", "pop", "lpv", "octaves" (images alone), or "path", by which each later call traces paths.
        spp: samples of path per cell or ray. options: those of the method, as for render().
        """
        settings = self.settings
        samples = spp if spp is not None else settings["spp"]
        given = int(settings["seed"] if seed is None else seed)
        info = self.info
        lower, upper = tuple(info["lower"]), tuple(info["upper"])
        if method == "path":
            if options:
                raise ArgumentError(f"{next(iter(options))}: set options of path in the scene, render.path.KEY")
            sides = [b - a for a, b in zip(lower, upper)]
            longest = max(sides) or 1.0
            size = tuple(max(1, round(32 * side / longest)) for side in sides)
            return Light(None, self, method, {}, Box(lower, upper, size), samples, given)  # type: ignore
        changes = {f"render.{method}.{key}": value for key, value in options.items()}
        with self._temporary(changes):
            with Reporter(progress) as report:
                core, stats = self._core.solve(method, given, report)
        box = Box(lower, upper, tuple(stats["size"]))  # type: ignore
        return Light(core, self, method, stats, box, samples, given, changes)

    def flux(self, levels: Any, *, columns: Tuple[int, int] = (1, 1), views: Any = None,
             area: Optional[Sequence[float]] = None, spp: Optional[int] = None, seed: Optional[int] = None,
             progress: ProgressChoice = None) -> Flux:
        """Upward and downward fluxes through levels, absorbed power and radiance, by columns (docs/atmosphere.md).

        levels: heights, m, ascending. columns: along both horizontal axes. views: rows of zenith and azimuth, degrees.
        area: lower and upper corner of all columns, four numbers, m; by default the periodic cell, or the box around the
        media. spp: samples for each number. By path tracing.
        """
        settings = self.settings
        with Reporter(progress) as report:
            parts = self._core.flux(_arrays.to_input(levels, "levels"),
                                    None if views is None else _arrays.to_input(views, "views"), tuple(columns),
                                    None if area is None else tuple(area),
                                    spp if spp is not None else settings["spp"],
                                    int(settings["seed"] if seed is None else seed), report)
        return Flux(tuple(float(level) for level in levels), parts)

    def transmittance(self, start: Sequence[float], end: Sequence[float], *, spp: int = 64,
                      seed: int = 0) -> Tuple[float, float, float]:
        """Transmittance of the media between two points (m), per channel, without surfaces."""
        return self._core.transmittance(tuple(start), tuple(end), spp, seed)

    # ---- baking ----

    def bake(self, target: str = "lightmap", *, mesh: int = 0, positions: Any = None, grid: Optional[Box] = None,
             terms: int = 9, method: Optional[str] = None, spp: Optional[int] = None, error: Optional[float] = None,
             bounces: Optional[int] = None, scatterings: Optional[int] = None, back_scattering: Optional[bool] = None,
             cells: Optional[int] = None, cell_paths: Optional[int] = None, seed: Optional[int] = None, width: int = 0,
             height: int = 0, density: float = 8.0, padding: int = 4, close_seams: bool = True,
             progress: ProgressChoice = None) -> Image:
        """Light on surfaces or at probes, as an image of irradiance, W m^-2, with its layers (docs/bake.md).

        target: "lightmap": texels of the second texture coordinates of a mesh, by its index; width and height in texels,
        or density in texels per metre, padding in texels. "vertices": one pixel per vertex of a mesh. "probes": light
        from all directions at positions (count, 3), m, or at the centres of the cells of a Box, as `terms` (9 or 25)
        spherical harmonics.

        method: "cache", "impulse", "attenuation", "surfaces" or "path". spp: paths per receiver. error: relative, at
        which a receiver is done. bounces, scatterings: largest numbers. cells, cell_paths: of the cache. Defaults are the
        library's. Ctrl-C cancels; the KeyboardInterrupt has the partial image as `image`.
        """
        options = (None if method is None else word(method, _BAKE_METHODS, "method"), spp, error, bounces, scatterings,
                   back_scattering, cells, cell_paths, seed)
        if target == "lightmap":
            call: Callable[[Any], Any] = lambda report: self._core.bake_lightmap(
                mesh, options, (width, height, float(density), padding, close_seams), report)
        elif target == "vertices":
            call = lambda report: self._core.bake_vertices(mesh, options, report)
        elif target == "probes":
            if terms not in (9, 25):
                raise ArgumentError(f"terms: {terms} is neither 9 nor 25")
            points, size = _probe_points(positions, grid)
            call = lambda report: self._core.bake_probes(points, size, terms, options, report)
        else:
            raise ArgumentError(f"target: unknown {target!r}; known: lightmap, vertices, probes")
        try:
            with Reporter(progress) as report:
                core, complete = call(report)
        except BaseException as stop:
            made = getattr(stop, "image", None)
            if isinstance(made, tuple):
                stop.image = Image(made[0], {}, False)  # type: ignore[attr-defined]
            elif isinstance(stop, KeyboardInterrupt):
                stop.image = None  # type: ignore[attr-defined]
            raise
        return Image(core, {}, complete)


    def bake_files(self, folder: Union[str, os.PathLike[str]], *, progress: ProgressChoice = None,
                   **options: Any) -> dict[str, Any]:
        """Bakes all meshes, and probes, to a folder of files, as `tyndall bake` (docs/bake.md); the content of bake.json.

        Lightmaps are .exr and .png, light at vertices a .glb of the level, and bake.json says what is where and in which
        units. options: those of the command: quality="high", spp=, error=, lightmaps=True, vertices=True, grid=(16, 4,
        16), probes=FILE, denoise=True, method=. resume=True goes on from what an interrupted call into the folder
        finished. The scene is written to it, too, as scene.json.
        """
        from ._tool import bake_files

        return bake_files(self, folder, progress=progress, **options)

    def view(self, **options: Any) -> Any:
        """Shows the scene in the browser, live; tyndall.view()."""
        from ._tool import view

        return view(self, **options)


def _probe_points(positions: Any, grid: Optional[Box]) -> Tuple[Any, Tuple[int, int, int]]:
    if (positions is None) == (grid is None):
        raise ArgumentError("probes are at positions, or in the cells of a grid: give one of the two")
    if grid is not None:
        xs, ys, zs = (grid.centers(axis) for axis in range(3))
        points = [(x, y, z) for z in zs for y in ys for x in xs]
        return _arrays.to_input(_arrays.flatten(points, "positions"), "positions"), tuple(grid.size)  # type: ignore
    count = len(positions)
    return _arrays.to_input(positions, "positions"), (count, 1, 1)


def options_of(method: str) -> str:
    """The key in `render` of a document under which the options of a method are."""
    return method if method in _render_schema() else "fld" if method == "cda" else method


def _resolve(entry: dict[str, Any]) -> dict[str, Any]:
    """What a part of the schema refers to."""
    while "$ref" in entry:
        target: Any = schema()
        for part in entry["$ref"].lstrip("#/").split("/"):
            target = target[part]
        entry = target
    return entry


def _render_schema() -> dict[str, Any]:
    return _resolve(schema()["properties"]["render"])["properties"]


_schema: dict[str, Any] = {}


def schema() -> dict[str, Any]:
    """The JSON Schema of scene files."""
    if not _schema:
        _schema.update(json.loads(_core.schema()))
    return _schema


def methods() -> Tuple[str, ...]:
    """Names of the methods that render scenes."""
    return _core.methods()


def method_options(method: str) -> dict[str, dict[str, Any]]:
    """The options of a method, with type, range, default and a sentence for each, as JSON Schema has them."""
    render = _render_schema()
    key = options_of(method)
    if key not in render or "properties" not in _resolve(render[key]):
        raise ArgumentError(f"there is no method {method} with options")
    return {name: _resolve(option) for name, option in _resolve(render[key])["properties"].items()}


def _override_items(overrides: Union[None, Mapping[str, Any], Sequence[str]]) -> dict[str, Any]:
    if overrides is None:
        return {}
    if isinstance(overrides, Mapping):
        return dict(overrides)
    items: dict[str, Any] = {}
    for text in overrides:
        key, equals, value = text.partition("=")
        if not equals:
            raise ArgumentError(f"override {text!r}: expected PATH=VALUE, such as media[0].g=0.5")
        try:
            items[key] = json.loads(value)
        except json.JSONDecodeError:
            items[key] = value
    return items
