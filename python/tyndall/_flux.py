"""Fluxes through levels, by columns of a scene."""
from __future__ import annotations

from typing import Any, Optional, Tuple

from . import _arrays


class Flux:
    """Fluxes of Scene.flux(): means over columns, W m^-2, with standard errors.

    up, down_diffuse, down_direct: (levels, ny, nx, 3); down is the sum of the latter two. absorbed: power that the media
    of each column absorb over its area, (ny, nx, 3). radiance: of each view, (views, ny, nx, 3), W m^-2 sr^-1. errors:
    the standard errors of these by their names. x, y stand for the two horizontal axes (x and z where y is up).
    """

    def __init__(self, levels: Tuple[float, ...], parts: Tuple[Any, ...]) -> None:
        names = ("up", "down_diffuse", "down_direct", "absorbed", "radiance")
        values = {name: _arrays.view(part[0]) for name, part in zip(names, parts) if part is not None}
        self.levels = levels
        """Heights, m."""
        self.up, self.down_diffuse, self.down_direct = values["up"], values["down_diffuse"], values["down_direct"]
        self.absorbed = values["absorbed"][0]
        self.radiance: Optional[Any] = values.get("radiance")
        self.errors: dict[str, Any] = {name: _arrays.view(part[1]) for name, part in zip(names, parts) if part is not None}
        self.errors["absorbed"] = self.errors["absorbed"][0]

    @property
    def down(self) -> Any:
        """All light that sinks through the levels, (levels, ny, nx, 3)."""
        return self.down_diffuse + self.down_direct

    def __repr__(self) -> str:
        return f"<tyndall.Flux, {len(self.levels)} levels, {self.up.shape[2]}x{self.up.shape[1]} columns>"
