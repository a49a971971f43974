#!/usr/bin/env python3
"""Renders Khronos' sample models of glTF with `path` and puts them beside the screenshots published with them.

usage: scripts/khronos/compare.py MODELS [options] [NAME ...]

MODELS is the folder Models of the repository KhronosGroup/glTF-Sample-Assets. Needs python3-numpy, and an environment map:
--environment names one, or else it is hdri/kiara_1_dawn_1k.hdr of TYNDALL_DATA. Scenes, images and sheet.png, the published
picture left of ours, stay in the folder --out. docs/materials.md tells what there is to see."""
import argparse
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import zlib

import numpy

HERE = pathlib.Path(__file__).resolve().parent
HEIGHT, GAP, PAIRS = 240, 8, 2  # pixels of a picture and between them; pairs in a row of the sheet


class View:
    """A camera that sees the whole model: degrees of azimuth from +z towards +x, of elevation and of the field of view;
    zoom 1 touches the borders. The environment is turned by `turn` degrees and multiplied by `sky`."""

    def __init__(self, azimuth=0, elevation=0, fov=30, zoom=1.0, turn=0, sky=1.0, exposure=0.0, shift=(0, 0, 0)):
        self.azimuth, self.elevation, self.fov, self.zoom = azimuth, elevation, fov, zoom
        self.turn, self.sky, self.exposure, self.shift = turn, sky, exposure, shift


VIEWS = {
    "MetalRoughSpheresNoTextures": View(sky=0.5),
    "DamagedHelmet": View(35, 5, zoom=1.25, sky=0.7),
    "NormalTangentTest": View(sky=0.5),
    "NormalTangentMirrorTest": View(sky=0.5),
    "TextureSettingsTest": View(sky=0.5),
    "TextureTransformMultiTest": View(20, 5, sky=0.5),
    "AlphaBlendModeTest": View(elevation=5, sky=0.5),
    "VertexColorTest": View(sky=0.5),
    "SpecularTest": View(sky=0.5),
    "ClearCoatTest": View(25, zoom=1.05, sky=0.5, shift=(0.05, 0, 0)),
    "SheenChair": View(0, 5, sky=0.7),
    "TransmissionTest": View(0, 4, zoom=4.5, sky=0.5, shift=(0, 0, 0)),
    "TransmissionRoughnessTest": View(0, 5, zoom=1.35, sky=0.5, shift=(0, 0.05, 0)),
    "AttenuationTest": View(0, 0, fov=20, zoom=1.1, sky=0.5),
    "EmissiveStrengthTest": View(-15, 10, sky=0.1, shift=(0, 0.1, 0)),
    "ToyCar": View(-45, 12, zoom=2.6, sky=0.7, shift=(0, 0.25, 0)),
}


# ---- pictures ----

def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_png(path, rgb):
    height, width, _ = rgb.shape
    rows = b"".join(b"\0" + row.tobytes() for row in rgb)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def predict(kind, left, up, corner):
    if kind < 3:
        return (0, left, up)[kind]
    if kind == 3:
        return (left + up) // 2
    near = [abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)]
    return (left, up, corner)[near.index(min(near))]


def read_png(path):
    """An RGB array of an 8-bit PNG of red, green and blue, with or without alpha, as `tyndall` writes them."""
    data = path.read_bytes()
    at, packed, width, height, channels = 8, b"", 0, 0, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
            channels = {2: 3, 6: 4}[color] if depth == 8 else 0
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    if channels == 0:
        sys.exit(f"{path}: not an 8-bit RGB image")
    rows, stride = zlib.decompress(packed), width * channels
    before, out = bytearray(stride), []
    for y in range(height):
        kind, row = rows[y * (stride + 1)], bytearray(rows[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left, corner = (row[i - channels], before[i - channels]) if i >= channels else (0, 0)
            row[i] = (row[i] + predict(kind, left, before[i], corner)) & 255
        before = row
        out.append(numpy.frombuffer(bytes(row), numpy.uint8).reshape(width, channels)[:, :3])
    return numpy.stack(out)


def fit(rgb, height):
    """The picture with another height, each pixel the mean of those that it covers, or the nearest."""
    step = rgb.shape[0] / height
    width = round(rgb.shape[1] / step)
    edges = [numpy.round(numpy.arange(count + 1) * size / count).astype(int)
             for count, size in ((height, rgb.shape[0]), (width, rgb.shape[1]))]
    out = numpy.zeros((height, width, 3), numpy.uint8)
    for y in range(height):
        band = rgb[edges[0][y]:max(edges[0][y] + 1, edges[0][y + 1])].mean(axis=0)
        for x in range(width):
            out[y, x] = band[edges[1][x]:max(edges[1][x] + 1, edges[1][x + 1])].mean(axis=0)
    return out


def sheet(pairs):
    rows = []
    for i in range(0, len(pairs), PAIRS):
        row = numpy.full((HEIGHT, 0, 3), 255, numpy.uint8)
        for pair in pairs[i:i + PAIRS]:
            for picture in pair:
                gap = numpy.full((HEIGHT, GAP, 3), 255, numpy.uint8)
                row = numpy.concatenate([row, picture, gap], axis=1)
        rows.append(row)
    width = max(row.shape[1] for row in rows)
    filled = [numpy.pad(row, ((0, GAP), (0, width - row.shape[1]), (0, 0)), constant_values=255) for row in rows]
    return numpy.concatenate(filled)


# ---- models ----

def run(command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in command)}\n{result.stdout[-2000:]}{result.stderr[-2000:]}")
    return result.stdout


def find_model(folder, name):
    candidates = [folder / name / kind / f"{name}{ending}"
                  for kind, ending in (("glTF-Binary", ".glb"), ("glTF", ".gltf"))]
    for path in candidates:
        if path.is_file():
            return path
    return None


def find_screenshot(folder, name):
    for ending in ("jpg", "png"):
        path = folder / name / "screenshot" / f"screenshot.{ending}"
        if path.is_file():
            return path
    return None


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def place_camera(view, bounds, aspect):
    """Position and target from which the corners of the bounds fit into the picture."""
    lower, upper = bounds
    target = [(lower[a] + upper[a]) / 2 + view.shift[a] * (upper[a] - lower[a]) for a in range(3)]
    azimuth, elevation = math.radians(view.azimuth), math.radians(view.elevation)
    back = [math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation)]
    right = [math.cos(azimuth), 0, -math.sin(azimuth)]
    up = cross(back, right)
    tangent = math.tan(math.radians(view.fov) / 2) * view.zoom
    distance = 0
    for i in range(8):
        corner = [(upper if i >> a & 1 else lower)[a] - target[a] for a in range(3)]
        x, y = (abs(sum(p * q for p, q in zip(corner, axis))) for axis in (right, up))
        z = sum(p * q for p, q in zip(corner, back))
        distance = max(distance, z + y / tangent, z + x / (tangent * aspect))
    return [target[a] + distance * back[a] for a in range(3)], target


def render(chosen, name, model, aspect):
    view = VIEWS[name]
    bounds = json.loads(run([chosen.tyndall, "info", model, "--json"]))["bounds"]
    position, target = place_camera(view, bounds, aspect)
    scene = {"tyndall": 1,
             "camera": {"position": position, "target": target, "fov_y": view.fov, "exposure": view.exposure,
                        "resolution": [round(HEIGHT * aspect), HEIGHT]},
             "lights": [{"type": "environment", "file": str(chosen.environment), "scale": view.sky,
                         "rotation": view.turn}],
             "geometry": [{"file": str(model)}]}
    path = chosen.out / f"{name}.json"
    path.write_text(json.dumps(scene, indent=1))
    image = chosen.out / f"{name}.png"
    run([chosen.tyndall, "render", path, "-o", image.with_suffix(".exr"), "--png", image, "--method", "path", "--spp",
         chosen.spp, "--threads", chosen.threads, "--quiet"])
    return read_png(image)


def options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", type=pathlib.Path, metavar="MODELS")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"default: all of {', '.join(VIEWS)}")
    parser.add_argument("--tyndall", default=str(HERE.parents[1] / "build/release/bin/tyndall"))
    parser.add_argument("--environment", type=pathlib.Path, help="an equirectangular .hdr or .exr")
    parser.add_argument("--out", default="out/khronos", type=pathlib.Path)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--threads", type=int, default=0)
    chosen = parser.parse_intermixed_args()
    for name in chosen.names:
        if name not in VIEWS:
            parser.error(f"there is no view of {name}; known: {', '.join(VIEWS)}")
    data = os.environ.get("TYNDALL_DATA")
    if chosen.environment is None and data:
        chosen.environment = pathlib.Path(data) / "hdri/kiara_1_dawn_1k.hdr"
    if chosen.environment is None or not chosen.environment.is_file():
        parser.error("--environment names no file")
    chosen.environment = chosen.environment.resolve()
    return chosen


def main():
    chosen = options()
    chosen.out.mkdir(parents=True, exist_ok=True)
    pairs = []
    for name in chosen.names or VIEWS:
        model, screenshot = find_model(chosen.models, name), find_screenshot(chosen.models, name)
        if model is None or screenshot is None:
            print(f"skipped: {name} is not in {chosen.models}")
            continue
        published = chosen.out / f"{name}.published.png"
        run([chosen.tyndall, "convert", screenshot, published])
        left = fit(read_png(published), HEIGHT)
        pairs.append((left, render(chosen, name, model.resolve(), left.shape[1] / HEIGHT)))
        print(name, flush=True)
    if pairs:
        write_png(chosen.out / "sheet.png", sheet(pairs))


main()
