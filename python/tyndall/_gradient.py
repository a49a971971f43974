"""Gradients of a loss on fluence by the media and lights of a scene."""
from __future__ import annotations

from typing import Any, Tuple, Union

from . import _arrays
from ._errors import ArgumentError
from ._fields import Box


class Gradient:
    """Derivatives of a loss on the fluence of fld or dom, made by Light.gradient() (docs/gradients.md).

    box: the cells of extinction, albedo and g. extinction: by sigma_t of each cell at constant albedo and g, m; albedo:
    by sigma_s / sigma_t at constant sigma_t; g: by the mean cosine. Each is (nz, ny, nx) where the media are gray, and
    else (nz, ny, nx, 3). lights: by a factor of each light's radiance, (lights, 3). stats: converged, iterations,
    residual, imbalance, seconds. Needs NumPy.
    """

    def __init__(self, made: Tuple[Any, ...]) -> None:
        stats, box, coefficients, lights, media = made
        self.stats: dict[str, Any] = stats
        self.box = Box(*box)
        self.extinction, self.albedo, self.g = (self._channels_last(part) for part in coefficients)
        self.lights = _arrays.view(lights)
        self._media = media

    @staticmethod
    def _channels_last(part: Any) -> Any:
        values = _arrays.view(part)
        return values[0] if values.shape[0] == 1 else _arrays.numpy.moveaxis(values, 0, -1)

    def density(self, medium: int = 0) -> Any:
        """Derivatives by the voxels of a medium's density, (nz, ny, nx), as the array that the scene was given."""
        voxels = self._media[medium][0]
        if voxels is None:
            raise ArgumentError(f"media[{medium}].density: there are derivatives of voxels along the axes of the scene "
                                "alone, without a transfer function and fields of albedo or g")
        return _arrays.view(voxels)

    def medium(self, medium: int = 0) -> dict[str, Union[float, Tuple[float, ...]]]:
        """Derivatives by sigma_s (at constant sigma_a), sigma_a and g of a medium: numbers where all media are gray, and
        else one per channel."""
        parts = self._media[medium][1:]
        if parts[0] is None:
            raise ArgumentError(f"media[{medium}]: its albedo or g varies in space; there are derivatives of cells alone")
        return {key: part[0] if len(part) == 1 else part for key, part in zip(("sigma_s", "sigma_a", "g"), parts)}

    def __repr__(self) -> str:
        return f"<tyndall.Gradient, {'x'.join(str(side) for side in self.box.size)} cells>"
