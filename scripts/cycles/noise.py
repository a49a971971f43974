#!/usr/bin/env python3
"""Renders scenes of `tyndall figure path-guide` with Blender Cycles, in about the processor time that `path` takes there.

usage: scripts/cycles/noise.py [--figures FOLDER] [SCENE ...]

Reads FOLDER/path-guide.csv, and writes pairs of images of different seeds into FOLDER/cycles, with their processor
seconds and samples per pixel; the same figure made again shows them. Scenes with densities, skies or files of
third-party meshes are left out. Needs `blender` (Debian's 3.4, and its python3-numpy)."""
import argparse
import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
# Pixels, as in tools/figures/path_guide.c.
SQUARE, WIDE = (192, 192), (192, 144)
SIZES = {"fog_cornell": SQUARE, "path_window": WIDE, "path_lamp_in_ball": SQUARE, "path_hall": WIDE,
         "path_emitters": WIDE, "path_corner": WIDE, "cube_g0": WIDE, "cube_g0.7": WIDE, "cube_g0.96": WIDE,
         "cornell_fog": SQUARE}
# Bounds of media grow by so much, so that their faces do not lie in walls.
MARGIN = 0.002


def scene_of(name):
    """The scene as render.py reads it."""
    folder = SCENES / ("tools" if name.startswith("path_") else "builtin")
    scene = json.loads((folder / f"{name}.json").read_text())
    scene["camera"]["resolution"] = SIZES[name]
    for medium in scene["media"]:
        if "sigma_t" in medium:
            albedo = medium.pop("albedo")
            sigma_t = medium.pop("sigma_t")
            medium.update(sigma_s=sigma_t * albedo, sigma_a=sigma_t * (1 - albedo))
        if isinstance(medium["bounds"], list):
            low, high = medium["bounds"]
            medium["bounds"] = [[c - MARGIN for c in low], [c + MARGIN for c in high]]
    return scene


def seconds_of_path(figures):
    """Processor seconds of `path` by scene."""
    with open(figures / "path-guide.csv", newline="") as file:
        return {row["item"].removesuffix(", path"): float(row["measured"]) for row in csv.DictReader(file)
                if row["quantity"] == "processor time" and row["item"].endswith(", path")}


def render(blender, scene, image, spp, seed):
    command = [blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", HERE / "render.py",
               "--", scene, image, spp, seed]
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    found = re.search(r"^processor seconds: (.*)$", result.stdout, re.MULTILINE)
    if result.returncode != 0 or found is None:
        sys.exit(f"{scene}\n{result.stdout[-2000:]}{result.stderr[-2000:]}")
    return float(found.group(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(SIZES) + "; default: all")
    parser.add_argument("--figures", default="out/figures", help="the folder of path-guide.csv")
    parser.add_argument("--blender", default="blender")
    chosen = parser.parse_args()
    for name in chosen.scenes:
        if name not in SIZES:
            parser.error(f"there is no scene {name}; known: {', '.join(SIZES)}")
    if shutil.which(chosen.blender) is None:
        print(f"skipped: there is no {chosen.blender}")
        return
    figures = pathlib.Path(chosen.figures).resolve()
    if not (figures / "path-guide.csv").is_file():
        parser.error(f"{figures} has no path-guide.csv: `tyndall figure path-guide -o {chosen.figures}` makes it")
    seconds = seconds_of_path(figures)
    folder = figures / "cycles"
    folder.mkdir(exist_ok=True)
    for name in chosen.scenes or SIZES:
        scene = folder / f"{name}.json"
        scene.write_text(json.dumps(scene_of(name)))
        few, more = 4, 16
        times = [render(chosen.blender, scene, folder / f"{name}.pilot.exr", spp, 3) for spp in (few, more)]
        each = max((times[1] - times[0]) / (more - few), 1e-6)
        spp = min(max(round((seconds[name] - times[0] + few * each) / each), 1), 65536)
        times = [render(chosen.blender, scene, folder / f"{name}.{seed}.exr", spp, seed) for seed in (1, 2)]
        (folder / f"{name}.pilot.exr").unlink()
        (folder / f"{name}.txt").write_text(f"{sum(times) / 2:.3f} {spp}\n")
        print(f"{name}: {spp} samples per pixel, {sum(times) / 2:.2f} s beside {seconds[name]:.2f} s", flush=True)


main()
