"""Media of volume shaders: coefficients by the formulas of Cycles, as entries of a scene file's "media".

Principled Volume (Cycles): sigma_s = density color, sigma_a = density max(1 - color, 0) max(1 - sqrt(absorption color), 0);
Volume Scatter: sigma_s = density color; Volume Absorption: sigma_a = density (1 - color). Emission is radiance per metre,
independent of the density.
"""
from . import fire
from .nodes import Constant, Field, Image, Ramp, behind, constant_of, number_of, socket_of, value_of

THIN = 0.02  # optical thickness of the media that stand for emission alone
FAR = 1e4    # extent of a linear function of a grid, beyond which it stays constant


class Component:
    """One medium: coefficients at density 1, 1/m; density: a value of nodes.py; emission: W m^-3 sr^-1, times emits."""

    def __init__(self, sigma_s=(0, 0, 0), sigma_a=(0, 0, 0), g=0.0, density=None, emission=None, emits=None, label=""):
        self.sigma_s, self.sigma_a, self.g = tuple(sigma_s), tuple(sigma_a), g
        self.density = density if density is not None else Constant((1, 1, 1))
        self.emission, self.emits, self.label = emission, emits, label
        self.albedo_grid = None
        self.black_body = None

    def weighted(self, weight):
        self.sigma_s = tuple(weight * v for v in self.sigma_s)
        self.sigma_a = tuple(weight * v for v in self.sigma_a)
        if self.emission is not None:
            self.emission = tuple(weight * v for v in self.emission)
        return self


class Domain:
    """Where a medium is. grids: the volume (a dict of the scene file) of each grid by name; extent: m; factor: multiplies
    densities, as Cycles does for scaled volumes; maximum_of: a function from a grid's name to its maximum, or None."""

    def __init__(self, bounds=None, transform=None, grids=None, extent=1.0, factor=1.0, maximum_of=None):
        self.bounds, self.transform, self.grids = bounds, transform, grids or {}
        self.extent, self.factor = extent, factor
        self.maximum_of = maximum_of or (lambda name: None)


# ---- nodes ----

def components_of(place, report, owner):
    """The components of a volume shader behind a socket of an output node."""
    if place is None:
        return []
    node, groups = place.node, place.groups
    if node.type == "ADD_SHADER":
        parts = [components_of(behind(s, groups), report, owner) for s in node.inputs]
        return parts[0] + parts[1]
    if node.type == "MIX_SHADER":
        factor = number_of(node.inputs[0], groups, report, owner, 0.5)
        parts = [components_of(behind(s, groups), report, owner) for s in node.inputs[1:3]]
        return [c.weighted(w) for part, w in zip(parts, (1 - factor, factor)) for c in part if w > 0]
    makers = {"PRINCIPLED_VOLUME": _principled, "VOLUME_SCATTER": _scatter, "VOLUME_ABSORPTION": _absorption,
              "VOLUME_COEFFICIENTS": _coefficients, "EMISSION": _emission}
    if node.type in makers:
        return makers[node.type](node, groups, report, owner)
    report.lose(owner, f'volume shader "{node.name}"')
    return []


def _g_of(node, groups, report, owner):
    if getattr(node, "phase", "HENYEY_GREENSTEIN") != "HENYEY_GREENSTEIN":
        report.lose(owner, f'phase function {node.phase} of "{node.name}"; Henyey and Greenstein\'s is taken')
    g = number_of(socket_of(node, "Anisotropy"), groups, report, owner)
    return min(max(g, -0.999), 0.999)


def _colour_of(node, groups, report, owner):
    """The colour, and the name of a grid of it, or None."""
    value = value_of(socket_of(node, "Color"), groups, report, owner)
    if isinstance(value, Field) and value.offset == (0, 0, 0):
        return value.scale, value.name
    if isinstance(value, Constant):
        return value.value, None
    return constant_of(socket_of(node, "Color"), groups, report, owner), None


def _density_of(node, groups, report, owner):
    density = value_of(socket_of(node, "Density"), groups, report, owner)
    if isinstance(density, Image):
        report.lose(owner, f'image behind the density of "{node.name}"')
        return Constant((1, 1, 1))
    return density


def _times_grid(density, name, report, owner):
    """density times a grid, where it has a name."""
    if not name or not isinstance(density, (Constant, Field, Ramp)):
        return density
    if isinstance(density, Constant):
        return Field(name, density.value)
    report.lose(owner, f'density attribute "{name}": the density varies by another grid already')
    return density


def _principled(node, groups, report, owner):
    colour, grid = _colour_of(node, groups, report, owner)
    absorption = constant_of(socket_of(node, "Absorption Color"), groups, report, owner)
    sigma_a = [max(1 - c, 0) * max(1 - max(a, 0) ** 0.5, 0) for c, a in zip(colour, absorption)]
    density = _density_of(node, groups, report, owner)
    name = _text_of(node, "Density Attribute")
    body = Component([max(c, 0) for c in colour], sigma_a, _g_of(node, groups, report, owner), density)
    body.optional_grid = name
    body.albedo_grid = grid or _text_of(node, "Color Attribute") or None
    found = [body]
    strength = value_of(socket_of(node, "Emission Strength"), groups, report, owner)
    colour = constant_of(socket_of(node, "Emission Color"), groups, report, owner, (1, 1, 1))
    if not isinstance(strength, Constant) or strength.value[0] > 0:
        emits = None if isinstance(strength, Constant) else strength
        scale = strength.value if emits is None else (1, 1, 1)
        found.append(Component(emission=[s * c for s, c in zip(scale, colour)], emits=emits, label="emission"))
    black = number_of(socket_of(node, "Blackbody Intensity"), groups, report, owner)
    if black > 1e-3:
        found.append(_black_body(node, groups, black, report, owner))
    return found


def _black_body(node, groups, intensity, report, owner):
    fire_part = Component(label="black body")
    tint = constant_of(socket_of(node, "Blackbody Tint"), groups, report, owner, (1, 1, 1))
    kelvin = value_of(socket_of(node, "Temperature"), groups, report, owner)
    name = _text_of(node, "Temperature Attribute")
    fire_part.black_body = (min(intensity, 1.0), tint, kelvin, name)
    return fire_part


def _text_of(node, name):
    socket = socket_of(node, name)
    return socket.default_value if socket is not None else ""


def _scatter(node, groups, report, owner):
    colour, grid = _colour_of(node, groups, report, owner)
    if grid is not None:
        report.lose(owner, f'the grid "{grid}" of the colour of "{node.name}"')
    density = _density_of(node, groups, report, owner)
    return [Component(colour, g=_g_of(node, groups, report, owner), density=density)]


def _absorption(node, groups, report, owner):
    colour = constant_of(socket_of(node, "Color"), groups, report, owner)
    density = _density_of(node, groups, report, owner)
    return [Component(sigma_a=[max(1 - c, 0) for c in colour], density=density)]


def _coefficients(node, groups, report, owner):
    """Volume Coefficients, of Blender 4.5 and later."""
    absorbed = constant_of(socket_of(node, "Absorption Coefficients"), groups, report, owner)
    scattered = constant_of(socket_of(node, "Scatter Coefficients"), groups, report, owner)
    emitted = constant_of(socket_of(node, "Emission Coefficients"), groups, report, owner)
    body = Component(scattered, absorbed, _g_of(node, groups, report, owner))
    return [body] + ([Component(emission=emitted, label="emission")] if max(emitted) > 0 else [])


def _emission(node, groups, report, owner):
    strength = value_of(socket_of(node, "Strength"), groups, report, owner)
    colour = constant_of(socket_of(node, "Color"), groups, report, owner, (1, 1, 1))
    constant = isinstance(strength, Constant)
    emission = [s * c for s, c in zip(strength.value if constant else (1, 1, 1), colour)]
    return [Component(emission=emission, emits=None if constant else strength, label="emission")]


# ---- entries of the scene file ----

def _transfer_of(points, factor=1.0):
    return [{"value": v, "density": max(c[0], 0) * factor} for v, c in points]


def _density_keys(density, domain, report, owner):
    """The keys `density`, `scale` and `transfer` of a medium; None where the medium is empty."""
    if isinstance(density, Constant):
        scale = density.value[0] * domain.factor
        return {"scale": scale} if scale > 0 else None
    volume = domain.grids.get(density.name)
    if volume is None:
        if isinstance(density, Field) and density.offset[0] > 0:
            return {"scale": density.offset[0] * domain.factor}
        report.lose(owner, f'grid "{density.name}", which is not there: its values are 0')
        return None
    keys = {"density": volume}
    if isinstance(density, Ramp):
        keys["transfer"] = _transfer_of(density.points)
        keys["scale"] = domain.factor
        return keys
    scale, offset = density.scale[0], density.offset[0]
    if scale > 0 and offset == 0:
        keys["scale"] = scale * domain.factor
        return keys
    if scale == 0:
        return {"scale": offset * domain.factor} if offset > 0 else None
    zero = -offset / scale
    ends = [(zero, (0,)), (zero + FAR, (FAR * scale,))] if scale > 0 else [(zero - FAR, (-FAR * scale,)), (zero, (0,))]
    keys["transfer"] = _transfer_of(ends)
    keys["scale"] = domain.factor
    return keys


def _placed(name, domain, keys):
    medium = {"name": name, **keys}
    if domain.bounds is not None:
        medium["bounds"] = domain.bounds
    if domain.transform is not None and "density" in keys:
        medium["transform"] = domain.transform
    return medium


def _body(component, name, domain, report, owner):
    density = component.density
    grid = getattr(component, "optional_grid", "")
    if grid and grid in domain.grids:
        density = _times_grid(density, grid, report, owner)
    keys = _density_keys(density, domain, report, owner)
    if keys is None or max(component.sigma_s + component.sigma_a) <= 0:
        return []
    if component.albedo_grid in domain.grids:
        if component.sigma_s == (1, 1, 1) and max(component.sigma_a) == 0:
            keys.update({"sigma_t": 1.0, "albedo": domain.grids[component.albedo_grid]})
            return [_placed(name, domain, {**keys, "g": component.g})]
        report.lose(owner, f'grid "{component.albedo_grid}" of the colour, which is shown where the colour is white')
    keys.update({"sigma_s": list(component.sigma_s), "sigma_a": list(component.sigma_a), "g": component.g})
    return [_placed(name, domain, keys)]


def _emitting(component, name, domain, report, owner):
    """Emission that does not depend on the density: media so thin that they hardly absorb."""
    if max(component.emission) <= 0:
        return []
    unscaled = Domain(domain.bounds, domain.transform, domain.grids, domain.extent)
    emits = component.emits if component.emits is not None else Constant((1, 1, 1))
    keys = _density_keys(emits, unscaled, report, owner)
    if keys is None:
        return []
    sigma_a = THIN / domain.extent
    keys.update({"sigma_a": sigma_a, "emission": {"radiance": [e / sigma_a for e in component.emission]}})
    report.approximate(owner, f"emission without absorption: it has an optical thickness of {THIN:g}")
    return [_placed(name, domain, keys)]


def _glowing(component, name, domain, report, owner):
    """Black bodies by the formula of Cycles: of each channel a medium whose density is its emission."""
    intensity, tint, kelvin, grid = component.black_body
    if isinstance(kelvin, Constant) and grid in domain.grids:
        kelvin = Field(grid, kelvin.value)
    if isinstance(kelvin, Constant):
        colour = fire.emission(kelvin.value[0], intensity)
        part = Component(emission=[c * t for c, t in zip(colour, tint)], label="black body")
        return _emitting(part, name, domain, report, owner)
    if not isinstance(kelvin, Field) or kelvin.scale[0] <= 0 or kelvin.name not in domain.grids:
        report.lose(owner, "black body: its temperature is no grid times a number")
        return []
    report.approximate(owner, f"black body without absorption: it has an optical thickness of {THIN:g}")
    media, curves = [], fire.curves(kelvin, intensity, domain.maximum_of(kelvin.name))
    for c, (channel, curve) in enumerate(zip(("red", "green", "blue"), curves)):
        peak = max(v for _, v in curve)
        if peak * tint[c] <= 0:
            continue
        sigma_a = [0.0, 0.0, 0.0]
        sigma_a[c] = THIN / domain.extent
        keys = {"density": domain.grids[kelvin.name], "sigma_a": sigma_a,
                "transfer": [{"value": t, "density": v / peak} for t, v in curve],
                "emission": {"radiance": peak * tint[c] / sigma_a[c]}}
        media.append(_placed(f"{name}, {channel}", domain, keys))
    return media


def media_of(components, name, domain, report, owner):
    """Entries of "media" for the components of a shader in a domain."""
    media = []
    for component in components:
        label = f"{name}, {component.label}" if component.label else name
        if component.black_body is not None:
            media += _glowing(component, label, domain, report, owner)
        elif component.emission is not None:
            media += _emitting(component, label, domain, report, owner)
        else:
            media += _body(component, label, domain, report, owner)
    return media
