"""Render passes from the channels of Tyndall's images."""
import numpy as np

from . import exr

RGB, VECTOR = ("R", "G", "B"), ("X", "Y", "Z")
# Passes beside Combined: name, Blender's channels and kind, the name of the AOV, its channels in the file.
PASSES = (("Depth", "Z", "VALUE", "depth", ("depth.Z",)),
          ("Normal", "XYZ", "VECTOR", "normal", tuple(f"normal.{c}" for c in VECTOR)),
          ("Single Scattering", "RGB", "COLOR", "single", tuple(f"single.{c}" for c in RGB)),
          ("Multiple Scattering", "RGB", "COLOR", "multiple", tuple(f"multiple.{c}" for c in RGB)),
          ("Transmittance", "RGB", "COLOR", "transmittance", tuple(f"transmittance.{c}" for c in RGB)),
          ("Albedo", "RGB", "COLOR", "albedo", tuple(f"albedo.{c}" for c in RGB)),
          ("Variance", "RGB", "COLOR", "variance", tuple(f"variance.{c}" for c in RGB)))


def wanted(settings, view_layer):
    """The entries of PASSES that a view layer has."""
    chosen = {"Depth": view_layer.use_pass_z, "Normal": view_layer.use_pass_normal, "Single Scattering": settings.components,
              "Multiple Scattering": settings.components, "Transmittance": settings.transmittance, "Albedo": settings.albedo,
              "Variance": settings.variance and settings.method == "path"}
    return [p for p in PASSES if chosen[p[0]]]


def planar(depth, camera, crop):
    """Depths along the camera's axis from distances along rays; far away where there is no surface."""
    height, width = depth.shape
    full_width, full_height = camera["resolution"]
    x0, y0 = crop[:2] if crop else (0, 0)
    shift = camera.get("shift", (0, 0))
    tangent = 2 * np.tan(np.radians(camera["fov_y"]) / 2) / full_height
    x = (np.arange(width) + 0.5 + x0 - full_width / 2 + shift[0] * full_height) * tangent
    y = (np.arange(height) + 0.5 + y0 - full_height / 2 - shift[1] * full_height) * tangent
    cosine = 1 / np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    return np.where(depth > 0, depth * cosine, np.float32(1e10)).astype(np.float32)


def set_rect(render_pass, values):
    """Sets a pass from height x width x channels, the first row at the top."""
    flat = np.ascontiguousarray(values[::-1], np.float32).reshape(-1, values.shape[-1])
    rect = render_pass.rect
    if hasattr(rect, "foreach_set"):
        rect.foreach_set(flat.ravel() if len(rect) == flat.size else flat)
    else:
        render_pass.rect = flat.tolist()


def set_combined(layer, image):
    """Sets the combined pass of a layer from linear colours; alpha is 1."""
    set_rect(layer.passes["Combined"], np.concatenate([image, np.ones((*image.shape[:2], 1), np.float32)], axis=-1))


class Mean:
    """The mean of the images of several instants, by channel; the variance is that of the mean."""

    def __init__(self):
        self.count, self.sums, self.metadata = 0, {}, {}

    def add(self, path):
        planes, self.metadata = exr.read(path)
        self.count += 1
        for name, plane in planes.items():
            self.sums[name] = self.sums.get(name, 0) + plane

    def planes(self):
        return {name: total / self.count ** (2 if name.startswith("variance.") else 1) for name, total in self.sums.items()}


def show(layer, mean, entries, denoised, camera, crop):
    """Sets the passes of a layer from a Mean."""
    planes = mean.planes()
    image = exr.stack(planes, [f"denoised.{c}" for c in RGB]) if denoised else None
    set_combined(layer, image if image is not None else exr.stack(planes, RGB))
    for name, _, _, _, channels in entries:
        values = exr.stack(planes, channels)
        if values is None or name not in layer.passes:
            continue
        set_rect(layer.passes[name], planar(values[..., 0], camera, crop)[..., None] if name == "Depth" else values)
