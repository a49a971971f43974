"""Reads shader node trees: what is behind a socket, through reroutes, muted nodes and groups, and its value.

A value is a Constant, a Field (a grid of a volume by a linear function), a Ramp (a grid by a piecewise linear one) or an Image.
"""


class Constant:
    def __init__(self, value):
        self.value = tuple(float(v) for v in value)


class Field:
    """offset + scale * the grid `name`, by channel."""

    def __init__(self, name, scale=(1.0, 1.0, 1.0), offset=(0.0, 0.0, 0.0)):
        self.name, self.scale, self.offset = name, tuple(scale), tuple(offset)


class Ramp:
    """A piecewise linear function of the grid `name`: (value of the grid, colour) in ascending order."""

    def __init__(self, name, points):
        self.name, self.points = name, points


class Image:
    """An image texture node, times a factor by channel; channel: 'Color', 'Alpha', 'R', 'G' or 'B'."""

    def __init__(self, node, factor=(1.0, 1.0, 1.0), channel="Color"):
        self.node, self.factor, self.channel = node, tuple(factor), channel


class Place:
    """A node, its output that was followed, and the groups around it."""

    def __init__(self, node, output, groups):
        self.node, self.output, self.groups = node, output, groups


def socket_of(node, *names):
    """The first input of a node with one of these names: Blender renames sockets between versions."""
    for name in names:
        for socket in node.inputs:
            if socket.name == name and socket.enabled:
                return socket
    return None


def _by_identifier(sockets, identifier):
    return next((s for s in sockets if s.identifier == identifier), None)


def _active_output(tree, kind):
    outputs = [n for n in tree.nodes if n.type == kind]
    return next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)


def output_of(tree, kind, socket_name):
    """The Place behind an input of a tree's active output node, such as ('OUTPUT_MATERIAL', 'Volume'); None: nothing."""
    targets = [n for n in tree.nodes if n.type == kind and getattr(n, "target", "ALL") == "CYCLES" and n.is_active_output]
    output = targets[0] if targets else _active_output(tree, kind)
    return behind(output.inputs.get(socket_name), ()) if output is not None else None


def behind(socket, groups):
    """The Place that a socket is linked to; None where it is not."""
    place, _ = _resolve(socket, groups)
    return place


def _resolve(socket, groups):
    """The Place behind a socket, or None and the unlinked socket that holds its value."""
    while socket is not None and socket.is_linked and socket.links:
        node, output = socket.links[0].from_node, socket.links[0].from_socket
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute:
            inner = next((link.from_socket for link in node.internal_links if link.to_socket == output), None)
            if inner is None:
                return None, None
            socket = inner
        elif node.type == "GROUP" and node.node_tree is not None:
            end = _active_output(node.node_tree, "GROUP_OUTPUT")
            groups = groups + (node,)
            socket = _by_identifier(end.inputs, output.identifier) if end is not None else None
        elif node.type == "GROUP_INPUT" and groups:
            socket = _by_identifier(groups[-1].inputs, output.identifier)
            groups = groups[:-1]
        else:
            return Place(node, output, groups), None
    return None, socket


def _default(socket):
    value = getattr(socket, "default_value", 0.0)
    if hasattr(value, "__len__"):
        return Constant(tuple(value)[:3])
    return Constant((value,) * 3)


def _combine(operation, a, b):
    """Constant or Field of an operation, channel by channel; None where it is not linear."""
    if isinstance(a, Constant) and isinstance(b, Constant):
        try:
            return Constant([_arithmetic(operation, x, y) for x, y in zip(a.value, b.value)])
        except (ArithmeticError, KeyError, ValueError):
            return None
    if isinstance(a, Constant) and operation in ("MULTIPLY", "ADD"):
        a, b = b, a
    if not isinstance(b, Constant):
        return None
    if isinstance(a, Image):
        if operation == "MULTIPLY":
            return Image(a.node, [f * v for f, v in zip(a.factor, b.value)], a.channel)
        return None
    if not isinstance(a, Field):
        return None
    if operation == "DIVIDE" and 0.0 not in b.value:
        operation, b = "MULTIPLY", Constant([1 / v for v in b.value])
    if operation == "SUBTRACT":
        operation, b = "ADD", Constant([-v for v in b.value])
    if operation == "MULTIPLY":
        return Field(a.name, [s * v for s, v in zip(a.scale, b.value)], [o * v for o, v in zip(a.offset, b.value)])
    if operation == "ADD":
        return Field(a.name, a.scale, [o + v for o, v in zip(a.offset, b.value)])
    return None


def _arithmetic(operation, a, b):
    return {"ADD": lambda: a + b, "SUBTRACT": lambda: a - b, "MULTIPLY": lambda: a * b, "DIVIDE": lambda: a / b,
            "POWER": lambda: a ** b, "MINIMUM": lambda: min(a, b), "MAXIMUM": lambda: max(a, b)}[operation]()


def _ramp_points(node, field):
    elements = node.color_ramp.elements
    scale, offset = field.scale[0], field.offset[0]
    if scale <= 0 or node.color_ramp.interpolation not in ("LINEAR", "CONSTANT"):
        return None
    points = []
    for i, element in enumerate(elements):
        value, colour = (element.position - offset) / scale, tuple(element.color)[:3]
        if node.color_ramp.interpolation == "CONSTANT" and i > 0:
            points.append((value - 1e-6 / scale, points[-1][1]))
        points.append((value, colour))
    return points


def _node_value(place, report, owner):
    """The value of a node's output; None where the node is not known."""
    node, groups = place.node, place.groups

    def take(index):
        return value_of(node.inputs[index], groups, report, owner)

    if node.type in ("VALUE", "RGB"):
        return _default(node.outputs[0])
    if node.type == "BLACKBODY":
        return None
    if node.type == "VOLUME_INFO":
        return Field(place.output.name.lower())
    if node.type == "ATTRIBUTE":
        return Field(node.attribute_name)
    if node.type == "TEX_IMAGE":
        return Image(node, channel=place.output.name)
    if node.type in ("SEPRGB", "SEPARATE_COLOR", "SEPARATE_RGB"):
        inner = take(0)
        if isinstance(inner, Image):
            return Image(inner.node, inner.factor, {"Red": "R", "Green": "G", "Blue": "B"}.get(place.output.name, "R"))
        return None
    if node.type == "MATH":
        return _combine(node.operation, take(0), take(1))
    if node.type == "VECT_MATH" and node.operation in ("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE"):
        return _combine(node.operation, take(0), take(1))
    if node.type in ("MIX_RGB", "MIX"):
        return _mix_value(node, groups, report, owner)
    if node.type == "VALTORGB":
        inner = take(0)
        points = _ramp_points(node, inner) if isinstance(inner, Field) else None
        if points is not None:
            return Ramp(inner.name, points)
        if isinstance(inner, Constant):
            return Constant(tuple(node.color_ramp.evaluate(inner.value[0]))[:3])
    if node.type == "MAP_RANGE" and getattr(node, "interpolation_type", "LINEAR") == "LINEAR":
        return _map_range(node, groups, report, owner)
    if node.type == "GAMMA" or node.type == "INVERT":
        return None
    return None


def _mix_value(node, groups, report, owner):
    """Mix nodes of constants, and products by a constant."""
    kind = getattr(node, "data_type", "RGBA")
    inputs = [s for s in node.inputs if s.enabled]
    if kind not in ("RGBA", "FLOAT") or len(inputs) < 3:
        return None
    factor, a, b = (value_of(s, groups, report, owner) for s in inputs[:3])
    blend = getattr(node, "blend_type", "MIX")
    if not isinstance(factor, Constant):
        return None
    f = factor.value[0]
    if blend == "MIX" and f in (0.0, 1.0):
        return b if f == 1.0 else a
    if blend == "MIX" and isinstance(a, Constant) and isinstance(b, Constant):
        return Constant([x + (y - x) * f for x, y in zip(a.value, b.value)])
    if blend == "MULTIPLY" and isinstance(b, Constant):
        return _combine("MULTIPLY", a, Constant([1 + (v - 1) * f for v in b.value]))
    if blend == "MULTIPLY" and f == 1.0:
        return _combine("MULTIPLY", a, b)
    return None


def _map_range(node, groups, report, owner):
    inner = value_of(socket_of(node, "Value"), groups, report, owner)
    bounds = [value_of(socket_of(node, n), groups, report, owner) for n in ("From Min", "From Max", "To Min", "To Max")]
    if not all(isinstance(v, Constant) for v in bounds):
        return None
    low, high, to_low, to_high = (v.value[0] for v in bounds)
    if high == low:
        return None
    slope = (to_high - to_low) / (high - low)
    if isinstance(inner, Field) and node.clamp and inner.scale[0] > 0:
        ends = sorted(((v - inner.offset[0]) / inner.scale[0], (to,) * 3) for v, to in ((low, to_low), (high, to_high)))
        return Ramp(inner.name, ends)
    scaled = _combine("MULTIPLY", inner, Constant((slope,) * 3))
    return _combine("ADD", scaled, Constant((to_low - slope * low,) * 3)) if scaled is not None else None


def value_of(socket, groups, report, owner):
    """The value of an input socket. Where the nodes behind it are not known, its own default, and a line in the report."""
    if socket is None:
        return Constant((0.0, 0.0, 0.0))
    place, unlinked = _resolve(socket, groups)
    if place is None:
        return _default(unlinked if unlinked is not None else socket)
    value = _node_value(place, report, owner)
    if value is None:
        report.lose(owner, f'node "{place.node.name}" behind "{socket.name}"; the socket\'s own value is taken')
        return _default(socket)
    return value


def constant_of(socket, groups, report, owner, fallback=(0.0, 0.0, 0.0)):
    """The value of a socket as three numbers; of other values `fallback`, and a line in the report."""
    if socket is None:
        return fallback
    value = value_of(socket, groups, report, owner)
    if isinstance(value, Constant):
        return value.value
    report.lose(owner, f'"{socket.name}" varies in space; its own value is taken')
    return _default(socket).value


def number_of(socket, groups, report, owner, fallback=0.0):
    """The value of a socket as one number."""
    return constant_of(socket, groups, report, owner, (fallback,) * 3)[0]
