"""The rendered viewport: the camera of the 3D view, changes of the scene, and drawing of the newest image."""
import json
import math
import os
import shutil
import tempfile

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d
from mathutils import Vector

from . import live, process
from .exporter import Export

SIDE_MAX = 960  # pixels of the image along its longer side


class Viewport:
    def __init__(self, engine, program):
        self.engine, self.program = engine, program
        self.folder = tempfile.mkdtemp(prefix="tyndall_view_")
        self.shown, self.camera, self.size, self.method = None, None, None, None
        self.exports, self.texture, self.drawn = 0, None, None

    def close(self):
        if self.shown is not None:
            self.shown.close()
            self.shown = None
        shutil.rmtree(self.folder, ignore_errors=True)

    # ---- the scene ----

    def _redraw(self):
        try:
            self.engine.tag_redraw()
        except ReferenceError:
            pass

    def update(self, context, depsgraph):
        """After a change of the scene; the first call starts the viewer."""
        if self.program is None:
            self.engine.update_stats("", f"Tyndall: {process.MISSING}")
            return
        if self.shown is not None and not _changes_scene(depsgraph):
            self._redraw()
            return
        self.exports += 1
        export = Export(depsgraph, self.folder, self.program, prefix=f"{self.exports}_")
        document = export.document()
        if self.shown is not None:
            self.shown.set_scene(document)
            return
        self.camera, self.size = _camera_of(context), _size_of(context)
        document["camera"] = {**self.camera, "resolution": list(self.size)}
        path = os.path.join(self.folder, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(document, file)
        self.method = context.scene.tyndall.method
        self.shown = live.show(self.program, path, self.size, self.method, self._redraw)

    # ---- drawing ----

    def draw(self, context, depsgraph):
        if self.shown is None:
            return
        camera, size, method = _camera_of(context), _size_of(context), context.scene.tyndall.method
        if camera != self.camera:
            self.camera = camera
            self.shown.set_camera(camera, True)
        if size != self.size or method != self.method:
            self.size, self.method = size, method
            self.shown.set_view(method=method, width=size[0], height=size[1])
        self.engine.update_stats("", f"Tyndall: {self.shown.message}")
        image = self.shown.image
        if image is None:
            return
        if image is not self.drawn:
            self.drawn, self.texture = image, _texture_of(image)
        gpu.state.blend_set("ALPHA_PREMULT")
        self.engine.bind_display_space_shader(depsgraph.scene)
        draw_texture_2d(self.texture, (0, 0), context.region.width, context.region.height)
        self.engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _changes_scene(depsgraph):
    """True for updates of anything but the camera and the scene's settings."""
    for update in depsgraph.updates:
        block = update.id
        if isinstance(block, bpy.types.Object) and block.type == "CAMERA":
            continue
        if not isinstance(block, (bpy.types.Scene, bpy.types.Camera, bpy.types.Screen, bpy.types.WindowManager)):
            return True
    return False


def _size_of(context):
    width, height = context.region.width, context.region.height
    divisor = max(1, math.ceil(max(width, height) / SIDE_MAX))
    return max(width // divisor, 1), max(height // divisor, 1)


def _camera_of(context):
    """The camera of a 3D view by its matrices, also where it looks through the scene's camera."""
    region = context.region_data
    view = region.view_matrix.inverted()
    turn, window = view.to_3x3().normalized(), region.window_matrix
    aspect = context.region.width / max(context.region.height, 1)
    position = view.translation
    if region.is_perspective:
        fov_y = 2 * math.atan(1 / window[1][1])
        shift = [window[0][2] / 2 * aspect, window[1][2] / 2]
    else:
        height = 2 / window[1][1]
        fov_y = 2 * math.atan(0.5 / 100)
        position = position + turn @ Vector((0, 0, 100 * height))
        shift = [-window[0][3] / 2 * aspect, -window[1][3] / 2]
    out = {"position": list(position), "target": list(position + turn @ Vector((0, 0, -1))),
           "up": list(turn @ Vector((0, 1, 0))), "fov_y": math.degrees(fov_y)}
    if max(abs(s) for s in shift) > 1e-6:
        out["shift"] = shift
    return out


def _texture_of(image):
    height, width = image.shape[:2]
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = image[::-1]
    data = gpu.types.Buffer("FLOAT", width * height * 4, pixels.ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
