"""Tyndall: light in fog, smoke, clouds, milk and water.

    import tyndall
    scene = tyndall.Scene("builtin:cloud_sun")
    scene["media[0].g"] = 0.5
    scene.render("dom", size=(320, 240)).save("cloud.exr")

Units: metres, W m^-2 (irradiance, fluence), W sr^-1 (intensity), W m^-2 sr^-1 (radiance), 1/m (coefficients). Colour is
linear Rec.709. Directions are those in which the light travels. docs/python.md is the guide.
"""
from ._context import default_context, set_default
from ._core import Context, blackbody, presets
from ._core import version as __version__
from ._compare import Comparison, compare, medium, screen
from ._errors import ArgumentError, Cancelled, Error, FileError, InputError, OutOfMemory, Unsupported
from ._fields import Box, Field, Fields, Light
from ._flux import Flux
from ._gradient import Gradient
from ._image import Image, denoise, diff, read
from ._progress import Progress
from ._scene import CHANNELS, DENOISE_CHANNELS, Scene, method_options, methods, schema
from ._tool import View, bench, convert, export, figure, merge, run, tool, unwrap, view
from ._volume import Mesh, Volume, info, write_volumes

__all__ = [
    "ArgumentError", "Box", "CHANNELS", "Cancelled", "Comparison", "Context", "DENOISE_CHANNELS", "Error", "Field",
    "Fields", "FileError", "Flux", "Gradient", "Image", "InputError", "Light", "Mesh", "OutOfMemory", "Progress", "Scene",
    "Unsupported", "View", "Volume", "bench", "blackbody", "compare", "convert", "default_context", "denoise", "diff",
    "export", "figure", "info", "medium", "merge", "method_options", "methods", "presets", "read", "run", "schema",
    "screen", "set_default", "tool", "unwrap", "view", "write_volumes",
]
