"""Methods against a reference, and fog over a photograph."""
from __future__ import annotations

import html
import json
import math
import os
from typing import Any, Iterable, Iterator, Mapping, Optional, Sequence, Tuple, Union

from . import _arrays, _core
from ._context import default_context
from ._errors import ArgumentError, Error
from ._image import Image, word
from ._progress import ProgressChoice, Reporter
from ._scene import Scene

_VARIANTS = {"scatter": 0, "gather": 1, "reference": 2, "naive": 3, "published": 4}
_SPREADS = {"small_angle": 0, "gaussian": 1}
_MASKS = {"none": 0, "step": 1, "smooth": 2}
_LEVELS = {"auto": -1, "all": -2}


class Comparison(Sequence[dict]):
    """A table of methods: a list of rows, each a dict; shown as a table with images in notebooks.

    Columns: method, seconds, mean_ratio (1 is right), relative_rmse, without_noise, rel_mse, and error, a sentence where a
    method refused the scene. without_noise: the relative RMSE without the reference's noise, sqrt(error^2 - noise^2), or
    None where the noise is not known: where the reference has no channel of variance, or blocks were compared. images:
    by method; reference: the reference image; noise: its relative noise, or None.
    """

    def __init__(self, rows: list[dict[str, Any]], images: dict[str, Image], reference: Image,
                 noise: Optional[float] = None) -> None:
        self.rows = rows
        self.images = images
        self.reference = reference
        self.noise = noise

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, index: Any) -> Any:
        return self.rows[index]

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def _cells(self) -> list[list[str]]:
        def number(value: Any) -> str:
            return "" if value is None else f"{value:.3g}"

        return [[row["method"], number(row["seconds"]), number(row["mean_ratio"]), number(row["relative_rmse"]),
                 number(row["without_noise"]), number(row["rel_mse"]), row["error"] or ""] for row in self.rows]

    _HEAD = ("method", "seconds", "mean ratio", "relative RMSE", "without noise", "relMSE", "")

    def save(self, folder: Union[str, os.PathLike[str]], *, exposure: Optional[float] = None) -> None:
        """Writes the folder of `tyndall compare`: report.html, a page by itself, errors.json, table.md and pictures.

        The images are beside them as reference.exr and NAME.exr. exposure: of what is shown, stops.
        """
        from ._tool import run

        os.makedirs(folder, exist_ok=True)
        paths = [os.path.join(folder, f"{name}.exr") for name in ("reference", *self.images)]
        for path, image in zip(paths, (self.reference, *self.images.values())):
            image.save(path)
        run("compare", *paths, output=folder, exposure=self.reference.exposure if exposure is None else exposure)

    def __repr__(self) -> str:
        table = [list(self._HEAD)] + self._cells()
        widths = [max(len(row[i]) for row in table) for i in range(len(self._HEAD))]
        return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in table)

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in (*self._HEAD, "image"))
        body = []
        for row, cells in zip(self.rows, self._cells()):
            image = self.images.get(row["method"])
            picture = image._html() if image is not None else ""
            body.append("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + f"<td>{picture}</td></tr>")
        return f"<table><tr>{head}</tr>{''.join(body)}</table><p>reference</p>{self.reference._html()}"


def compare(scene: Scene, methods: Optional[Iterable[str]] = None, *, reference: Union[str, Image] = "path",
            size: Optional[Tuple[int, int]] = None, spp: Optional[int] = None, reference_spp: Optional[int] = None,
            seed: Optional[int] = None, block: int = 1, options: Optional[Mapping[str, Mapping[str, Any]]] = None,
            progress: ProgressChoice = None) -> Comparison:
    """Renders a scene by several methods, and compares each with a reference.

    methods: default all but the reference. reference: a method, or an image of the same size. spp: samples of the
    methods; reference_spp: of the reference, default 4 times as many, with another seed, so that the method of the
    reference can be compared, too. block > 1 compares means over block x block pixels, which noise changes less.
    options: those of each method, {"dom": {"directions": 48}}. The noise of a path-traced reference is known, and the
    column without_noise has the errors without it. comparison.save(folder) writes the page of `tyndall compare`.
    """
    samples = spp if spp is not None else scene.settings["spp"]
    start = int(scene.settings["seed"] if seed is None else seed)
    given = dict(options or {})
    if isinstance(reference, Image):
        truth = reference
    else:
        truth = scene.render(reference, size=size, spp=reference_spp or 4 * samples, seed=start + 1, progress=progress,
                             channels="variance" if reference in ("path", "auto") else (), **given.get(reference, {}))
    noise = _noise(truth) if block == 1 else None
    names = list(methods) if methods is not None else [name for name in _core.methods() if name != reference]
    rows: list[dict[str, Any]] = []
    images: dict[str, Image] = {}
    for name in names:
        row: dict[str, Any] = dict.fromkeys(("method", "seconds", "mean_ratio", "relative_rmse", "without_noise",
                                             "rel_mse", "error"))
        row["method"] = name
        try:
            image = scene.render(name, size=size or truth.size, spp=samples, seed=start, progress=progress,
                                 **given.get(name, {}))
            row.update({key: values[3] for key, values in image.diff(truth, block).items()
                        if key in ("mean_ratio", "relative_rmse", "rel_mse")})
            if noise is not None:
                row["without_noise"] = math.sqrt(max(row["relative_rmse"] ** 2 - noise ** 2, 0))
            row["seconds"] = image.stats["seconds"]
            images[name] = image
        except Error as refusal:
            row["error"] = str(refusal)
        rows.append(row)
    return Comparison(rows, images, truth, noise)


def _noise(image: Image) -> Optional[float]:
    """The relative noise of an image with a channel of variance: the root of its mean variance over the mean."""
    if _arrays.numpy is None or "variance" not in image.layers:
        return None
    numpy = _arrays.numpy
    mean = float(numpy.mean(image.rgb, dtype=numpy.float64))
    variance = float(numpy.mean(image["variance"], dtype=numpy.float64))
    return math.sqrt(max(variance, 0)) / mean if mean > 0 else 0.0


def _levels(levels: Union[int, str]) -> int:
    return word(levels, _LEVELS, "levels") if isinstance(levels, str) else int(levels)


def screen(image: Any, depth: Any, medium: Union[str, Mapping[str, Any]] = "fog:50", *, fov_y: float = 40.0,
           focal: Union[None, float, Sequence[float]] = None, center: Sequence[float] = (-1.0, -1.0),
           distance: str = "ray", environment: Union[float, Sequence[float]] = 0.0, balance: bool = True,
           variant: str = "scatter", spread: str = "small_angle", filter: int = 4, levels: Union[int, str] = "auto",
           missing_depth: float = 1e6, fill: bool = False, window: Optional[int] = None, mask: Optional[str] = None,
           mask_width: Optional[float] = None, level_scale: Optional[float] = None,
           luminance_weights: Optional[bool] = None, blurred_distance: Optional[bool] = None,
           normalise: Optional[bool] = None, context: Optional[_core.Context] = None,
           progress: ProgressChoice = None) -> Image:
    """Fog, smoke or water over one image and its distances (docs/method/screen.md).

    image: an Image, or (height, width, 3 or 4) float32, linear radiance; read where it lies. depth: (height, width)
    float32, m; 0, negative and infinite distances are missing and count as missing_depth, or with fill
    as those around them. medium: a preset, "fog:50" (50
    m of visibility), "wholemilk:1000", or coefficients, {"sigma_s": 0.1, "sigma_a": 0.01, "g": 0.9} (1/m). fov_y:
    vertical angle of view, degrees, or focal: focal length in pixels, one number or x and y. center: principal point,
    pixels. distance: "ray", along the rays, or "axis", a depth buffer. environment: radiance that arrives at the medium
    from all around, W m^-2 sr^-1; balance: it takes the place of what is scattered backwards. variant: "scatter",
    "gather" (the paper's, with masks normalised), "naive", "published" (the paper's to the letter) or "reference" (exact and
    slow). spread: "small_angle" or "gaussian".

    window: of "reference", pixels that light reaches. Of "gather": mask, "none", "step" or "smooth", with mask_width
    (epsilon of Eq. 7) and level_scale (pixels of spread at level 0); luminance_weights; blurred_distance: levels come
    from a distance blurred by its own level; normalise: masks take no light away.
    """
    context = context or default_context()
    colors = image._colors() if isinstance(image, Image) else _arrays.to_float32(image)
    distances = _arrays.to_float32(depth)
    shape = getattr(colors, "shape", None)
    if shape is None or len(shape) != 3:
        raise ArgumentError("image: expected (height, width, 3)")
    if focal is None:
        focal = 0.5 * shape[0] / math.tan(math.radians(fov_y) / 2)
    lengths = tuple(focal) if hasattr(focal, "__len__") else (focal, focal)  # type: ignore
    around = tuple(environment) if hasattr(environment, "__len__") else (environment,) * 3  # type: ignore
    text = medium if isinstance(medium, str) else json.dumps(medium)
    given = {"window": window, "mask": None if mask is None else word(mask, _MASKS, "mask"), "mask_width": mask_width,
             "level_scale": level_scale, "luminance_weights": luminance_weights, "blurred_distance": blurred_distance,
             "normalise": normalise}
    gathering = {key: value for key, value in given.items() if value is not None}
    with Reporter(progress) as report:
        core, stats = _core.screen(context, colors, distances, text, lengths, tuple(center),
                                   word(distance, {"ray": 0, "axis": 1}, "distance"), around, balance,
                                   word(variant, _VARIANTS, "variant"), word(spread, _SPREADS, "spread"), filter,
                                   _levels(levels), missing_depth, fill, gathering, report)
    return Image(core, stats, True, image.exposure if isinstance(image, Image) else 0.0)


def medium(text: Union[str, Mapping[str, Any]]) -> dict[str, Tuple[float, float, float]]:
    """sigma_s and sigma_a, 1/m, and g, per channel, of a preset ("fog:50", "wholemilk") or of coefficients."""
    return _core.parse_medium(default_context(), text if isinstance(text, str) else json.dumps(text))
