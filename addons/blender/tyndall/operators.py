"""Operators: export of the scene, prediction, comparison with path."""
import json
import os
import tempfile

import bpy
from bpy_extras.io_utils import ExportHelper

from . import process
from .camera import poses_of, size_of
from .engine import render_settings
from .exporter import write_scene
from .report import show_in_text_block
from .settings import program_of


def poses(scene):
    """Those of a scene that may change, whose frames are set and set back."""
    return poses_of(scene, lambda frame, part: scene.frame_set(frame, subframe=part), lambda camera: camera.matrix_world)


def export_to(context, folder, name="scene.json"):
    """Exports the scene of a context. Returns the path of the scene file and the Report."""
    scene = context.scene
    moved = poses(scene)
    path, report = write_scene(context.evaluated_depsgraph_get(), folder, name, render_settings(scene.tyndall, scene.frame_current),
                               moved, program=process.find_program(program_of(context)))
    show_in_text_block(bpy.data, report)
    return path, report


class TYNDALL_OT_export(bpy.types.Operator, ExportHelper):
    """Write the scene as a scene file of Tyndall, with its meshes beside it"""
    bl_idname = "export_scene.tyndall"
    bl_label = "Export Tyndall"
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def execute(self, context):
        folder, name = os.path.split(self.filepath)
        _, report = export_to(context, folder, name)
        self.report({"INFO"}, f"Tyndall: {report.summary()}" if len(report) else "Tyndall: everything was exported")
        return {"FINISHED"}


class TYNDALL_OT_predict(bpy.types.Operator):
    """Look at the scene, and tell the method that suits it with its expected error and time"""
    bl_idname = "tyndall.predict"
    bl_label = "Predict error and time"

    def execute(self, context):
        program = process.find_program(program_of(context))
        if program is None:
            self.report({"ERROR"}, f"Tyndall: {process.MISSING}")
            return {"CANCELLED"}
        with tempfile.TemporaryDirectory(prefix="tyndall_") as folder:
            path, _ = export_to(context, folder)
            found, reason = process.predict(program, path, size_of(context.scene))
        if found is None:
            self.report({"ERROR"}, f"Tyndall: {reason}")
            return {"CANCELLED"}
        context.scene.tyndall.expected = found
        self.report({"INFO"}, f"Tyndall: {found}")
        return {"FINISHED"}


class TYNDALL_OT_compare(bpy.types.Operator):
    """Render with the chosen method and with path, and open the report of their difference"""
    bl_idname = "tyndall.compare"
    bl_label = "Compare with path"
    seconds: bpy.props.FloatProperty(name="Seconds of the reference", default=30, min=1)
    show: bpy.props.BoolProperty(name="Open the report", default=True)

    def _start(self, context):
        program = process.find_program(program_of(context))
        if program is None:
            self.report({"ERROR"}, f"Tyndall: {process.MISSING}")
            return False
        settings = context.scene.tyndall
        self.folder = bpy.path.abspath(settings.folder) if settings.folder else tempfile.mkdtemp(prefix="tyndall_")
        path, _ = export_to(context, self.folder)
        self.method = "dom" if settings.method in ("auto", "path") else settings.method
        width, height = size_of(context.scene)
        self.run = process.Run(program, ["compare", path, "-o", os.path.join(self.folder, "report"), "--methods", self.method,
                                         "--reference-time", str(self.seconds), "--size", f"{width}x{height}"], self.folder)
        return True

    def _finish(self, context):
        if self.run.finish() != 0:
            self.report({"ERROR"}, f"Tyndall: {self.run.reason()}")
            return {"CANCELLED"}
        with open(os.path.join(self.folder, "report", "errors.json"), encoding="utf-8") as file:
            report = json.load(file)
        row = next((r for r in report["images"] if r["name"] == self.method), None)
        if row is None:
            self.report({"ERROR"}, f"Tyndall: {self.method} does not take this scene")
            return {"CANCELLED"}
        ratio, rmse = row["all"]["mean_ratio"], row["relative_rmse_without_noise"]["all"]
        text = f"{self.method}: mean {100 * (ratio - 1):+.1f} %, RMSE {100 * rmse:.1f} % of path's mean"
        context.scene.tyndall.compared = text
        self.report({"INFO"}, f"Tyndall: {text}")
        if self.show and not bpy.app.background:
            bpy.ops.wm.url_open(url="file://" + os.path.join(self.folder, "report", "report.html"))
        return {"FINISHED"}

    def execute(self, context):
        return self._finish(context) if self._start(context) else {"CANCELLED"}

    def invoke(self, context, event):
        if not self._start(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.run.cancel()
        if event.type != "TIMER" or self.run.is_running():
            context.workspace.status_text_set(f"Tyndall: {self.run.stage} {100 * self.run.fraction:.0f} % (Esc: cancel)")
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        return self._finish(context)


CLASSES = (TYNDALL_OT_export, TYNDALL_OT_predict, TYNDALL_OT_compare)


def _menu(self, context):
    self.layout.operator(TYNDALL_OT_export.bl_idname, text="Tyndall (.json)")


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
