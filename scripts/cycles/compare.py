#!/usr/bin/env python3
"""Renders the same scenes with Blender Cycles and with `tyndall render`, and prints how far they agree.

usage: scripts/cycles/compare.py [options] [SCENE ...]

Needs `blender` (Debian's 3.4, and its python3-numpy), and for scenes under a sky an environment map, which is
reference/materials/env.hdr of TYNDALL_DATA unless --environment names one. Without them it says so, and what needs them
is left out. Images stay in the folder --out; docs/materials.md tells what the differences are."""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys

import scenes

HERE = pathlib.Path(__file__).resolve().parent


def options():
    known = [*scenes.SCENES, *scenes.PLASTIC_SCENES, *scenes.SOLID_SCENES]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="; ".join(known) + "; default: the first three")
    parser.add_argument("--tyndall", default=str(HERE.parents[1] / "build/release/bin/tyndall"))
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--environment", help="an equirectangular .hdr or .exr")
    parser.add_argument("--out", default="out/cycles")
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--keep", action="store_true", help="take images of Cycles that are there already")
    chosen = parser.parse_args()
    for name in chosen.scenes:
        if name not in known:
            parser.error(f"there is no scene {name}; known: {', '.join(known)}")
    return chosen


def find_environment(chosen):
    data = os.environ.get("TYNDALL_DATA")
    path = chosen.environment or (data and f"{data}/reference/materials/env.hdr")
    return pathlib.Path(path).resolve() if path and pathlib.Path(path).is_file() else None


def run(command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in command)}\n{result.stdout[-2000:]}{result.stderr[-2000:]}")
    return result.stdout


def render_cycles(chosen, scene, image, seed):
    if not (chosen.keep and image.is_file()):
        threads = ["--threads", chosen.threads] if chosen.threads else []
        run([chosen.blender, "--background", "--factory-startup", *threads, "--python-exit-code", 1, "--python",
             HERE / "render.py", "--", scene, image, chosen.spp, seed])


def difference(chosen, a, b):
    """Mean ratio and RMSE of 8x8 blocks over the mean, of all channels together."""
    return json.loads(run([chosen.tyndall, "diff", a, b, "--block", 8, "--json"]))["all"]


def compare(chosen, name, folder, environment):
    size = [int(side) for side in chosen.size.split("x")]
    scene = scenes.write(name, folder, environment, size)
    cycles = [folder / f"{name}.cycles{seed}.exr" for seed in (1, 2)]
    own = folder / f"{name}.tyndall.exr"
    for seed, image in enumerate(cycles, 1):
        render_cycles(chosen, scene, image, seed)
    run([chosen.tyndall, "render", scene, "-o", own, "--method", "path", "--spp", 2 * chosen.spp, "--threads",
         chosen.threads, "--quiet"])
    return [difference(chosen, own, image) for image in cycles], difference(chosen, *cycles)


def main():
    chosen = options()
    if shutil.which(chosen.blender) is None:
        print(f"skipped: there is no {chosen.blender}")
        return
    environment = find_environment(chosen)
    folder = pathlib.Path(chosen.out).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    print("| scene | mean ratio | 8x8 blocks, relative RMSE | noise of one Cycles image on blocks |")
    print("|---|--:|--:|--:|")
    for name in chosen.scenes or scenes.SCENES:
        if name not in ("metal_in_fog", "normal_map", *scenes.PLASTIC_SCENES) and environment is None:
            print(f"skipped: {name} needs an environment map; TYNDALL_DATA or --environment names one")
            continue
        both, noise = compare(chosen, name, folder, environment)
        ratio = sum(told["mean_ratio"] for told in both) / 2
        rmse = sum(told["relative_rmse"] for told in both) / 2
        print(f"| {name} | {ratio:.4f} | {rmse:.2%} | {noise['relative_rmse'] / 2 ** 0.5:.2%} |", flush=True)


main()
