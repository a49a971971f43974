"""The render engine: F12 and animations by `tyndall render` as a process, with the image as it converges."""
import json
import os
import tempfile
import time

import bpy

from . import chain, passes, process
from .camera import crop_of, size_of
from .exporter import write_scene
from .instants import instants_of
from .report import show_in_text_block
from .settings import program_of


def later(function):
    """Runs a function where data blocks may change: now without windows, else soon."""
    if bpy.app.background:
        function()
    else:
        bpy.app.timers.register(function, first_interval=0.1)


def samples_of(settings, instant=None):
    """Samples of one instant of the shutter's time."""
    return -(-settings.samples // instant.count) if instant is not None else settings.samples


def render_settings(settings, frame, instant=None):
    """The "render" of a scene file."""
    seed = max(settings.seed + (frame if settings.animate_seed else 0), 0)
    if instant is not None:
        seed = seed * instant.count + instant.number
    return {"method": settings.method, "spp": samples_of(settings, instant), "seed": seed}


class TyndallEngine(bpy.types.RenderEngine):
    bl_idname = "TYNDALL"
    bl_label = "Tyndall"
    bl_use_preview = False
    bl_use_eevee_viewport = True

    viewport = None

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name, channels, kind, _, _ in passes.wanted(scene.tyndall, renderlayer):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    # ---- final images ----

    def render(self, depsgraph):
        try:
            self._render(depsgraph)
        except (OSError, ValueError) as failure:
            self._fail(str(failure))

    def _fail(self, sentence):
        self.report({"ERROR"}, f"Tyndall: {sentence}")
        self.error_set(f"Tyndall: {sentence}")

    def _render(self, depsgraph):
        scene = depsgraph.scene
        settings, frame = scene.tyndall, scene.frame_current
        program = process.find_program(program_of(bpy.context))
        if program is None:
            self._fail(process.MISSING)
            return
        with tempfile.TemporaryDirectory(prefix="tyndall_") as temporary:
            folder = bpy.path.abspath(settings.folder) if settings.folder else temporary
            self.update_stats("", "Tyndall: exporting")
            instants = instants_of(scene, depsgraph, self.frame_set, lambda camera: camera.evaluated_get(depsgraph).matrix_world,
                                   settings.motion_steps)
            mean, going = passes.Mean(), True
            for instant in instants:
                if not going:
                    continue  # the frame is set back at the end
                path, report = write_scene(depsgraph, folder, settings=render_settings(settings, frame, instant),
                                           poses=instant.poses, program=program, instants=instant.count)
                if len(report) and instant.number == 0:
                    self.report({"INFO"}, f"Tyndall: {report.summary()}")
                if instant.number == 0:
                    later(lambda kept=report: show_in_text_block(bpy.data, kept))
                going = self._run(depsgraph, program, path, folder, instant, mean)

    def _options(self, depsgraph, crop, instant):
        """Options of the program but for names of files, and the entries of passes."""
        settings = depsgraph.scene.tyndall
        entries = passes.wanted(settings, depsgraph.view_layer_eval)
        width, height = size_of(depsgraph.scene)
        arguments = ["--method", settings.method, "--size", f"{width}x{height}", "--threads", str(settings.threads)]
        if settings.method == "path":
            arguments += ["--spp", str(samples_of(settings, instant))]
            if settings.seconds > 0:
                arguments += ["--time", str(settings.seconds / instant.count)]
            if settings.error > 0:
                arguments += ["--error", str(settings.error / 100 * instant.count ** 0.5)]
        if crop:
            arguments += ["--crop", "{0},{1},{2}x{3}".format(*crop)]
            if settings.method != "path":
                arguments += ["--method", "path", "--spp", str(samples_of(settings, instant))]
                self.report({"INFO"}, "Tyndall: render regions are of method path")
        if settings.denoise and settings.method == "path":
            arguments.append("--denoise")
        names = [aov for _, _, _, aov, _ in entries]
        if names:
            arguments += ["--aov", ",".join(names)]
        return arguments, entries

    def _run(self, depsgraph, program, path, folder, instant, mean):
        """Renders one instant, and shows the mean; True if it went well."""
        crop, image = crop_of(depsgraph.scene), os.path.join(folder, "image.exr")
        with open(path, encoding="utf-8") as file:
            camera = json.load(file).get("camera")
        if camera is None:
            self._fail("the scene has no camera")
            return False
        stats = os.path.join(folder, "stats.json")
        options, entries = self._options(depsgraph, crop, instant)
        frames = chain.begin(program, options, "path" if crop else depsgraph.scene.tyndall.method, (path, image, stats))
        try:
            if os.path.exists(image):
                os.remove(image)
            width, height = crop[2:] if crop else size_of(depsgraph.scene)
            result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer_eval.name)
            run = frames.image(path, image, stats, folder)
            self._follow(run, frames.receiver, result, width, height, instant)
            status = run.finish()
            if os.path.exists(image):
                mean.add(image)
                self._show(result, mean, entries, camera, crop, run)
            self.end_result(result)
            if status != 0 and not run.cancelled:
                self._fail(run.reason())
            return status == 0 and not run.cancelled
        finally:
            frames.end()

    def _show(self, result, mean, entries, camera, crop, run):
        metadata = mean.metadata
        passes.show(result.layers[0], mean, entries, bpy.context.scene.tyndall.denoise, camera, crop)
        self.add_stamp(result, metadata)
        chosen = next((line for line in run.lines if line.startswith("method: ")), None)
        self.update_stats("", "Tyndall: " + (chosen[len("method: "):] if chosen else metadata.get("tyndall.method", "")))

    @staticmethod
    def add_stamp(result, metadata):
        for key, value in metadata.items():
            if key.startswith("tyndall.") and hasattr(result, "stamp_data_add_field"):
                result.stamp_data_add_field(key, value)

    def _follow(self, run, receiver, result, width, height, instant):
        """Shows progress and the image until the run ends; Esc makes it write what it has."""
        while run.is_running():
            if self.test_break():
                run.cancel()
            self.update_progress((instant.number + run.fraction) / instant.count)
            left = "" if run.remaining is None else f", {run.remaining:.0f} s left"
            self.update_stats("", f"Tyndall: {run.stage} {100 * run.fraction:.0f} %{left}")
            image = receiver.take()
            if image is not None and image.shape[:2] == (height, width):
                passes.set_combined(result.layers[0], image)
                self.update_result(result)
            time.sleep(0.05)

    # ---- the viewport ----

    def view_update(self, context, depsgraph):
        from .viewport import Viewport
        if self.viewport is None:
            self.viewport = Viewport(self, process.find_program(program_of(context)))
        self.viewport.update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        if self.viewport is not None:
            self.viewport.draw(context, depsgraph)

    def __del__(self):
        viewport = self.__dict__.get("viewport") if hasattr(self, "__dict__") else None
        if viewport is not None:
            viewport.close()
        inherited = getattr(super(), "__del__", None)  # Blender 4.4 and later
        if inherited is not None:
            inherited()


def register():
    bpy.utils.register_class(TyndallEngine)


def unregister():
    bpy.utils.unregister_class(TyndallEngine)
