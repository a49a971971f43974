"""Renders scenes by Tyndall and by Cycles in the same run, and compares means and blocks. Runs inside Blender:
blender -b --factory-startup --python compare.py -- ADDON TYNDALL FOLDER SPP [SCENE...]"""
import json
import os
import subprocess
import sys

arguments = sys.argv[sys.argv.index("--") + 1:]
addon, tyndall, folder, spp = arguments[:4]
sys.path[:0] = [addon, os.path.dirname(os.path.abspath(__file__))]

import bpy
import numpy as np
import scenes
from tyndall import exporter, operators, register

BY_ENGINE = ("moving",)  # scenes that take more than one scene file
os.environ["TYNDALL"] = tyndall
register()


def pixels_of(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    out = np.array(image.pixels[:], np.float64).reshape(image.size[1], image.size[0], -1)[..., :3]
    bpy.data.images.remove(image)
    return out


def by_cycles(path, samples, seed):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.seed, cycles.use_denoising, cycles.use_adaptive_sampling = samples, seed, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 1024
    cycles.volume_bounces, cycles.transparent_max_bounces = 1024, 1024
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    cycles.volume_step_rate = 0.25
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return pixels_of(path)


def by_tyndall(scene_file, path, samples, seed):
    subprocess.run([tyndall, "render", scene_file, "-o", path, "--method", "path", "--spp", str(samples), "--seed", str(seed),
                    "--threads", "2", "-q"], check=True)
    return pixels_of(path)


def by_engine(path, samples, seed):
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    settings = scene.tyndall
    settings.method, settings.samples, settings.seed, settings.threads, settings.motion_steps = "path", samples, seed, 2, 16
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return pixels_of(path)


def blocks_of(image, side=6):
    height, width = image.shape[0] // side * side, image.shape[1] // side * side
    return image[:height, :width].reshape(height // side, side, width // side, side, 3).mean((1, 3))


def compare(name):
    there = os.path.join(folder, name)
    os.makedirs(there, exist_ok=True)
    scenes.SCENES[name](there, tyndall)
    bpy.context.scene.cycles.volume_step_rate = 0.25
    poses = operators.poses(bpy.context.scene)
    path, report = exporter.write_scene(bpy.context.evaluated_depsgraph_get(), os.path.join(there, "export \u00e9"), poses=poses)
    images = [os.path.join(there, f"tyndall_{s}.exr") for s in (1, 2)]
    if name in BY_ENGINE:
        ours = [by_engine(image, int(spp), s) for s, image in enumerate(images)]
    else:
        ours = [by_tyndall(path, image, int(spp), s + 1) for s, image in enumerate(images)]
    theirs = [by_cycles(os.path.join(there, f"cycles_{s}.exr"), int(spp), s) for s in (1, 2)]
    mean = [np.mean(v, axis=(0, 1, 2)) for v in (ours, theirs)]
    a, b = (sum(blocks_of(v) for v in pair) / 2 for pair in (ours, theirs))
    noise = [np.sqrt(np.mean((blocks_of(v[0]) - blocks_of(v[1])) ** 2)) / 2 for v in (ours, theirs)]
    scale = b.mean()
    rmse = np.sqrt(np.mean((a - b) ** 2)) / scale
    allowed = np.sqrt(noise[0] ** 2 + noise[1] ** 2) / scale
    return {"scene": name, "ratio": (mean[0] / mean[1]).tolist(), "blocks": rmse, "noise": allowed,
            "report": report.left_out + report.approximated}


chosen = arguments[4:] or list(scenes.SCENES)
print("RESULT " + json.dumps([compare(name) for name in chosen]))
