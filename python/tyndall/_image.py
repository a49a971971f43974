"""Images of named channels."""
from __future__ import annotations

import base64
import os
import struct
import zlib
from typing import Any, Iterable, Mapping, Optional, Sequence, Tuple, Union

from . import _arrays, _core
from ._context import default_context
from ._errors import ArgumentError
from ._progress import ProgressChoice, Reporter

_CURVES = {"clip": 0, "filmic": 1}
_DENOISERS = {"regression": 0, "oidn": 1}
_EXPOSURE = "tyndall.camera.exposure"


def word(value: str, words: Mapping[str, int], what: str) -> int:
    """The number of a word, or an error that lists the known ones."""
    try:
        return words[value]
    except (KeyError, TypeError):
        raise ArgumentError(f"{what}: unknown {value!r}; known: {', '.join(words)}") from None


class Image:
    """An image of named channels, planes of float32, (height, width), row by row from the top left.

    Colour is linear Rec.709 radiance, W m^-2 sr^-1. `image["R"]` is a view of a channel, (height, width), and
    `image["single"]` or `image.rgb` one of the three channels of a layer, (height, width, 3); none of them is a copy,
    and what is written to them is in the image. Without NumPy the views are memoryviews. An Image itself is an array
    of its colours for NumPy (`numpy.asarray(image)`) and DLPack (`torch.from_dlpack(image)`).
    """

    def __init__(self, core: Any, stats: Optional[dict[str, Any]] = None, complete: bool = True,
                 exposure: float = 0.0) -> None:
        if isinstance(core, Mapping) or _arrays.is_array(core):
            core = _from_arrays(core)
        self._core = core
        self.stats: dict[str, Any] = stats if stats is not None else {}
        """Measurements of the call that made the image: seconds, spp, paths, and those of the method."""
        self.complete = complete
        """False for a partial result: a render that was interrupted or stopped."""
        self.exposure = exposure
        """Exposure for display, stops."""

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]], *, raw: bool = False,
             context: Optional[_core.Context] = None) -> "Image":
        """Reads an OpenEXR, Radiance .hdr, PNG, JPEG or WebP file.

        raw: samples of PNG and JPEG as they are, 0..1, without decoding sRGB, as for depth maps.
        """
        return cls(_core.image_read(context or default_context(), os.fspath(path), raw))

    @property
    def width(self) -> int:
        """Pixels in a row."""
        return self._core.width

    @property
    def height(self) -> int:
        """Number of rows."""
        return self._core.height

    @property
    def size(self) -> Tuple[int, int]:
        """(width, height)."""
        return self._core.width, self._core.height

    @property
    def shape(self) -> Tuple[int, int, int]:
        """(height, width, 3), that of the colours."""
        return self._core.height, self._core.width, 3

    @property
    def channels(self) -> Tuple[str, ...]:
        """Names of the channels, such as "R", "depth.Z", "variance.R"."""
        return self._core.channels

    @property
    def layers(self) -> Tuple[str, ...]:
        """Names of the layers, such as "depth" and "variance"; "" for R, G, B."""
        return tuple(dict.fromkeys(name.rpartition(".")[0] for name in self.channels))

    @property
    def frame(self) -> Tuple[int, int, int, int]:
        """x, y, width and height of the frame that the pixels lie in."""
        return self._core.frame

    @property
    def metadata(self) -> dict[str, Union[str, float]]:
        """A copy of the metadata, which EXR files hold as attributes; set_metadata() changes it."""
        return self._core.metadata

    def set_metadata(self, key: str, value: Union[str, float]) -> None:
        """Sets a text or a number in the metadata. key: 1..31 of [A-Za-z0-9_.]."""
        self._core.set_metadata(key, value)

    def __contains__(self, name: object) -> bool:
        return name in self.channels or name in self.layers

    def __getitem__(self, name: str) -> Any:
        if name in self.channels:
            return _arrays.view(self._core.channel(name))
        prefix = name + "." if name else ""
        parts = [c for c in self.channels if c.startswith(prefix) and "." not in c[len(prefix):]]
        if len(parts) == 1:
            return _arrays.view(self._core.channel(parts[0]))
        if len(parts) == 3:
            return self._three(_in_order(parts))
        raise KeyError(f"{name!r}; known: {', '.join(self.channels)}")

    def _three(self, names: Sequence[str]) -> Any:
        memory = self._core.colors(*names)
        if memory is not None:
            return _arrays.view(memory)
        if _arrays.numpy is None:
            raise ArgumentError("the channels do not lie side by side; read them one by one")
        return _arrays.numpy.stack([_arrays.view(self._core.channel(name)) for name in names], axis=-1)

    @property
    def rgb(self) -> Any:
        """R, G and B, (height, width, 3) float32, W m^-2 sr^-1, a view."""
        return self._three(self._color_names())

    def _color_names(self) -> Sequence[str]:
        if {"R", "G", "B"} <= set(self.channels):
            return ("R", "G", "B")
        if len(self.channels) > 1 and "Y" not in self.channels:
            raise ArgumentError(f"the image has no colours; its channels are {', '.join(self.channels)}")
        return (self.channels[0] if len(self.channels) == 1 else "Y",) * 3

    def _colors(self) -> Any:
        memory = self._core.colors(*self._color_names())
        if memory is None:
            raise ArgumentError("the colours of this image do not lie side by side")
        return memory

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Any:
        made = self.rgb
        if dtype is not None and made.dtype != dtype:
            return made.astype(dtype)
        return made.copy() if copy else made

    def __dlpack__(self, **keywords: Any) -> Any:
        return self._colors().__dlpack__(**keywords)

    def __dlpack_device__(self) -> Tuple[int, int]:
        return self._colors().__dlpack_device__()

    def layer(self, name: str) -> "Image":
        """A new image of one layer's channels, without the layer's name; "" takes R, G, B and their like."""
        return Image(self._core.layer(name), dict(self.stats), self.complete, self.exposure)

    def full_frame(self) -> "Image":
        """A copy that fills the frame, with 0 where the image has no pixels."""
        return Image(self._core.full_frame(), dict(self.stats), self.complete, self.exposure)

    def diff(self, reference: "Image", block: int = 1) -> dict[str, Any]:
        """The difference from a reference: mean_ratio, rmse, relative_rmse and rel_mse for R, G, B and all three.

        rmse is in W m^-2 sr^-1, relative_rmse is rmse / mean(reference). block > 1 compares means over block x block
        pixels. not_finite and differing count values that are left out and values whose bits differ.
        """
        return self._core.compare(reference._core, block)

    def denoise(self, *, features: Iterable["Image"] = (), previous: Optional["Image"] = None,
                denoiser: str = "regression", parts: bool = True, progress: ProgressChoice = None) -> "Image":
        """The image without noise: R, G, B, with their estimated standard error in the layer "error".

        It needs the channels of `render(channels=tyndall.DENOISE_CHANNELS)`. features: images without noise of the same
        scene and size, four at most, such as those of dom. previous: the image before it in a sequence, as this method
        gave it. denoiser: "regression", or "oidn" where Open Image Denoise is installed. parts: light that scattered once,
        light that did otherwise and the rest are denoised apart; False: all at once.
        """
        before = _for_sequence(previous) if previous is not None else None
        with Reporter(progress) as report:
            core, stats = _core.denoise(self._core, tuple(f._core for f in features), before,
                                        word(denoiser, _DENOISERS, "denoiser"), parts, report)
        return Image(_renamed(core, {"denoised": "", "denoised_error": "error"}), stats, self.complete, self.exposure)

    def tonemapped(self, exposure: Optional[float] = None, curve: str = "filmic") -> Any:
        """8-bit sRGB for display, (height, width, 3). exposure: stops. curve: "filmic" or "clip"."""
        data = self._core.tonemap(self._exposure(exposure), word(curve, _CURVES, "curve"))
        if _arrays.numpy is None:
            return memoryview(data).cast("B", (self.height, self.width, 3))
        return _arrays.numpy.frombuffer(data, dtype=_arrays.numpy.uint8).reshape(self.shape)

    def _exposure(self, exposure: Optional[float]) -> float:
        return self.exposure if exposure is None else float(exposure)

    def to_png(self, exposure: Optional[float] = None, curve: str = "filmic") -> bytes:
        """An 8-bit sRGB PNG file as bytes."""
        data = self._core.tonemap(self._exposure(exposure), word(curve, _CURVES, "curve"))
        return png_file(self.width, self.height, 3, data)

    def _repr_png_(self) -> bytes:
        return self.to_png()

    def _html(self) -> str:
        return f'<img src="data:image/png;base64,{base64.b64encode(self.to_png()).decode()}">'

    def save(self, path: Union[str, os.PathLike[str]], *, exposure: Optional[float] = None, curve: str = "filmic",
             channel: Optional[str] = None, scale: float = 1.0) -> None:
        """Writes the file completely or not at all: .exr (all channels, with metadata) or .png (8-bit sRGB).

        channel: one channel alone as a 16-bit PNG of value * scale, for depth and masks.
        """
        name = os.fspath(path)
        lower = name.lower()
        if channel is not None and not lower.endswith(".png"):
            raise ArgumentError(f"{name}: one channel alone is written to .png")
        if lower.endswith(".exr"):
            self._core.write_exr(name)
        elif lower.endswith(".png") and channel is not None:
            self._core.write_png16(name, channel, scale)
        elif lower.endswith(".png"):
            self._core.write_png(name, self._exposure(exposure), word(curve, _CURVES, "curve"))
        else:
            raise ArgumentError(f"{name}: the extension is not .exr or .png")

    def to_xarray(self) -> Any:
        """An xarray.Dataset: one variable per layer, with the dimensions y and x (pixel centres) and channel."""
        xarray = _arrays.xarray_or_none()
        if xarray is None:
            raise ImportError("to_xarray() needs xarray")
        numpy = _arrays.numpy
        coords = {"y": numpy.arange(self.height) + 0.5, "x": numpy.arange(self.width) + 0.5}
        variables = {}
        for layer in self.layers:
            prefix = layer + "." if layer else ""
            names = _in_order([c for c in self.channels if c.rpartition(".")[0] == layer])
            data = numpy.stack([self[name] for name in names], axis=-1)
            dim = "channel" if [n[len(prefix):] for n in names] == ["R", "G", "B"] else f"{layer}_channel"
            coords.setdefault(dim, [n[len(prefix):] for n in names])
            variables[layer or "radiance"] = (("y", "x", dim), data)
        return xarray.Dataset(variables, coords, dict(self.metadata))

    def __repr__(self) -> str:
        note = "" if self.complete else ", partial"
        return f"<tyndall.Image {self.width}x{self.height}, {', '.join(self.layers[1:]) or 'R, G, B'}{note}>"


def png_file(width: int, height: int, channels: int, data: bytes) -> bytes:
    """A PNG file of 8-bit pixels of 3 or 4 channels."""
    row = channels * width
    rows = b"".join(b"\0" + data[i:i + row] for i in range(0, len(data), row))

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"sRGB", b"\0") +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def _in_order(names: list[str]) -> list[str]:
    """Channels of a layer, colours as R, G, B: files may have them by the alphabet."""
    colors = [name for end in "RGB" for name in names if name.rpartition(".")[2] == end]
    return colors if len(colors) == len(names) else names


def _from_arrays(arrays: Any) -> Any:
    """The core image of a mapping of names to planes (height, width), or of colours (height, width, 3)."""
    numpy = _arrays.numpy
    if numpy is None:
        raise ImportError("images of arrays need NumPy")
    if not isinstance(arrays, Mapping):
        colors = numpy.asarray(arrays, dtype=numpy.float32)
        if colors.ndim != 3 or colors.shape[2] < 3:
            raise ArgumentError(f"an image of shape {colors.shape}, not (height, width, 3)")
        arrays = {name: colors[..., c] for c, name in enumerate("RGB")}
    planes = {name: numpy.asarray(plane, dtype=numpy.float32) for name, plane in arrays.items()}
    shapes = {plane.shape for plane in planes.values()}
    if len(shapes) != 1 or len(next(iter(shapes))) != 2:
        raise ArgumentError(f"channels of the shapes {sorted(shapes)}, not of one (height, width)")
    height, width = next(iter(shapes))
    core = _core.image_create(default_context(), width, height, tuple(planes))
    for name, plane in planes.items():
        _arrays.view(core.channel(name))[...] = plane
    return core


def _renamed(core: Any, layers: Mapping[str, str]) -> Any:
    """A copy of the image in which layers have other names; the same image without NumPy."""
    if _arrays.numpy is None:
        return core
    arrays = {}
    for name in core.channels:
        layer, _, channel = name.rpartition(".")
        new = layers.get(layer, layer)
        arrays[f"{new}.{channel}" if new else channel] = _arrays.view(core.channel(name))
    made = _from_arrays(arrays)
    made.set_frame(*core.frame)
    for key, value in core.metadata.items():
        made.set_metadata(key, value)
    return made


def _for_sequence(image: Image) -> Any:
    """The image before in a sequence, under the names that the library looks for."""
    return _renamed(image._core, {"": "denoised", "error": "denoised_error"})


def read(path: Union[str, os.PathLike[str]], *, raw: bool = False, context: Optional[_core.Context] = None) -> Image:
    """Reads an image file; Image.read()."""
    return Image.read(path, raw=raw, context=context)


def diff(image: Image, reference: Image, block: int = 1) -> dict[str, Any]:
    """The difference of an image from a reference; Image.diff()."""
    return image.diff(reference, block)


def denoise(image: Image, **keywords: Any) -> Image:
    """An image without noise; Image.denoise()."""
    return image.denoise(**keywords)
