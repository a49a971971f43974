"""A reader of the OpenEXR files that Tyndall writes: scan lines of floats and halves, uncompressed or with ZIP."""
import struct
import zlib

import numpy as np

NONE, ZIPS, ZIP = 0, 2, 3
LINES = {NONE: 1, ZIPS: 1, ZIP: 16}
KINDS = {1: np.float16, 2: np.float32}


def _text(data, at):
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def _attributes(data):
    at, found = 8, {}
    while data[at] != 0:
        name, at = _text(data, at)
        kind, at = _text(data, at)
        size = struct.unpack_from("<i", data, at)[0]
        found[name] = (kind, data[at + 4:at + 4 + size])
        at += 4 + size
    return found, at + 1


def _channels(value):
    at, found = 0, []
    while value[at] != 0:
        name, at = _text(value, at)
        found.append((name, KINDS[struct.unpack_from("<i", value, at)[0]]))
        at += 16
    return found


def _unzip(data, size):
    """ZIP of OpenEXR: bytes in two halves, even and odd ones, as differences."""
    if len(data) == size:
        return data
    deltas = np.frombuffer(zlib.decompress(data), np.uint8).astype(np.int64)
    deltas[1:] -= 128
    values = np.cumsum(deltas).astype(np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = values[:half], values[half:]
    return out.tobytes()


def read(path):
    """The channels by name as arrays of height x width, the first row at the top, and the text of the metadata by name.
    Errors: ValueError for files of another kind, OSError."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"v/1\x01" or data[5] & 0x1a:
        raise ValueError(f"{path}: no OpenEXR file of scan lines")
    attributes, at = _attributes(data)
    compression = attributes["compression"][1][0]
    if compression not in LINES:
        raise ValueError(f"{path}: its compression is not known here")
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height, channels = x1 - x0 + 1, y1 - y0 + 1, _channels(attributes["channels"][1])
    planes = {name: np.empty((height, width), np.float32) for name, _ in channels}
    step = LINES[compression]
    offsets = struct.unpack_from(f"<{(height + step - 1) // step}Q", data, at)
    row_bytes = sum(np.dtype(kind).itemsize for _, kind in channels) * width
    for offset in offsets:
        y, size = struct.unpack_from("<ii", data, offset)
        rows = min(step, y1 - y + 1)
        block = data[offset + 8:offset + 8 + size]
        block = _unzip(block, rows * row_bytes) if compression != NONE else block
        place = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in channels:
                planes[name][row] = np.frombuffer(block, kind, width, place)
                place += np.dtype(kind).itemsize * width
    metadata = {n: v[1].decode(errors="replace") for n, v in attributes.items() if v[0] == "string"}
    return planes, metadata


def stack(planes, names):
    """Channels by their names as height x width x channels; None where one is missing."""
    if any(name not in planes for name in names):
        return None
    return np.stack([planes[name] for name in names], axis=-1)
